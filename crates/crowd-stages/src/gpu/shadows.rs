//! The sun's shadow maps: for each cascade casters are selected, sorted into buckets and drawn as depth alone.
//!
//! Casters go through the same buckets and vertex shader as the crowd, so whatever feeds that can feed the maps.

use super::allocate::{buffer_or_error, texture_or_error};
use super::bucket_draws::BucketDraws;
use super::draw_crowd::{DEPTH, DrawCrowd};
use super::draw_scenery::DrawScenery;
use super::feed::BoundFeed;
use super::kernel::{Use, buffer_entry, fetches_from_storage};
use super::lending::{Lender, Lending};
use super::renderer::RendererOptions;
use super::select_casters::SelectCasters;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::dispatch::MAX_CASCADES;
use crate::{CascadeStep, FrameConfig, FrameTotals, LodChoice, Result, ShadowConfig, WeightSums};
use wgpu::BufferUsages as Usage;

/// Of the maps' copies that are read as storage textures.
const COPY: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// All that is done for the maps, as one stage in the times.
pub(crate) const SHADOWS: &str = "shadows";
/// Time stamps of a cascade.
pub(crate) const STAMPS_A_CASCADE: u32 = 7;
/// Against acne on what the sun grazes; the normal's offset in `shadow.wgsl` does the rest.
const SLOPE_BIAS: f32 = 1.5;

/// The bind group that says how the sun is shaded: number 1 of everything that is drawn.
pub(crate) fn light_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let fragment = wgpu::ShaderStages::FRAGMENT;
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: fragment, ty, count: None };
    let map = match fetches_from_storage(device) {
        true => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::ReadOnly,
            format: COPY,
            view_dimension: wgpu::TextureViewDimension::D2Array,
        },
        false => wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        },
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("light"),
        entries: &[buffer_entry(0, fragment, Use::Uniform, None), entry(1, map)],
    })
}

/// Maps that can be read, and how they lie.
pub(crate) struct Light {
    config: wgpu::Buffer,
    map: wgpu::Texture,
    copied: Option<Copied>,
    bound: wgpu::BindGroup,
}

/// The maps once more where a storage texture is read faster, and what they go through: depths cannot be copied from texture to texture.
struct Copied {
    numbers: wgpu::Buffer,
    map: wgpu::Texture,
}

impl Light {
    /// `side`: texels of a map.
    ///
    /// # Errors
    /// [`crate::Error::OutOfMemory`] where the device has no room.
    pub(crate) fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, side: u32, maps: u32) -> Result<Self> {
        // One layer alone would be no array on OpenGL.
        let layers = maps.max(2);
        let bytes = u64::from(side) * u64::from(side) * 4 * u64::from(layers);
        let is_copied = fetches_from_storage(device);
        let descriptor = wgpu::TextureDescriptor {
            label: Some("shadow maps"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | if is_copied { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::TEXTURE_BINDING },
            view_formats: &[],
        };
        let map = texture_or_error(device, "shadow maps", bytes, "draw without shadows", &descriptor)?;
        let config = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("shadow config"),
            size: size_of::<ShadowConfig>() as u64,
            usage: Usage::UNIFORM | Usage::COPY_DST,
            mapped_at_creation: false,
        });
        let copied = is_copied
            .then(|| {
                let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::STORAGE_BINDING;
                let descriptor = wgpu::TextureDescriptor { format: COPY, usage, ..descriptor };
                let map =
                    texture_or_error(device, "copies of shadow maps", bytes, "draw without shadows", &descriptor)?;
                let descriptor = wgpu::BufferDescriptor {
                    label: Some("numbers of a shadow map"),
                    size: u64::from(side) * u64::from(side) * 4,
                    usage: Usage::COPY_SRC | Usage::COPY_DST,
                    mapped_at_creation: false,
                };
                let numbers = buffer_or_error(device, "numbers of a shadow map", "draw without shadows", &descriptor)?;
                Ok(Copied { numbers, map })
            })
            .transpose()?;
        let view = copied.as_ref().map_or(&map, |copied| &copied.map).create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let bound = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("light"),
            layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: config.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&view) },
            ],
        });
        Ok(Self { config, map, copied, bound })
    }

    pub(crate) fn bound(&self) -> &wgpu::BindGroup {
        &self.bound
    }

    /// After a map is drawn: makes it ready to be read.
    fn record_copy(&self, encoder: &mut wgpu::CommandEncoder, number: u32) {
        let Some(Copied { numbers, map }) = &self.copied else { return };
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..self.map.size() };
        let origin = wgpu::Origin3d { z: number, ..Default::default() };
        let layer = |texture, aspect| wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin, aspect };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size.width), rows_per_image: None };
        let numbers = wgpu::TexelCopyBufferInfo { buffer: numbers, layout };
        encoder.copy_texture_to_buffer(layer(&self.map, wgpu::TextureAspect::DepthOnly), numbers, size);
        encoder.copy_buffer_to_texture(numbers, layer(map, wgpu::TextureAspect::All), size);
    }

    pub(crate) fn bytes(&self) -> u64 {
        let size = self.map.size();
        let maps = u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers) * 4;
        self.config.size() + maps + self.copied.as_ref().map_or(0, |copied| maps + copied.numbers.size())
    }

    /// Whether the maps are read from copies.
    pub(crate) fn is_copied(&self) -> bool {
        self.copied.is_some()
    }
}

/// What draws the maps.
pub(crate) struct Shadows {
    /// Texels a side of the maps.
    pub(crate) side: u32,
    /// Bytes asked for.
    pub(crate) bytes: u64,
    pub(crate) light: Light,
    select: SelectCasters,
    cascades: Vec<CascadeDraw>,
    draws: BucketDraws,
    meshes: wgpu::RenderPipeline,
    dots: wgpu::RenderPipeline,
    lending: Lending,
}

/// What differs from map to map.
struct CascadeDraw {
    /// The frame as the sun sees it, for the vertex shader.
    config: wgpu::Buffer,
    step: wgpu::Buffer,
    select: wgpu::BindGroup,
    crowd: wgpu::BindGroup,
    target: wgpu::TextureView,
}

impl Shadows {
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        draw: &DrawCrowd,
        options: &RendererOptions,
        side: u32,
    ) -> Result<Self> {
        let fewer = "draw fewer instances, or without shadows";
        let device = up.device;
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let light = Light::new(device, draw.light_layout(), side, MAX_CASCADES)?;
        up.bytes += light.bytes();
        let casters = up.empty::<LodChoice>("casters", options.max_instances.into(), written, fewer)?;
        let totals = up.empty::<FrameTotals>("caster totals", 1, written, fewer)?;
        let no_sums = up.empty::<WeightSums>("no sums", 1, written, fewer)?;
        let select = SelectCasters::new(device);
        let mut cascades = Vec::new();
        for number in 0..MAX_CASCADES {
            let config = up.empty::<FrameConfig>("caster config", 1, uniform, fewer)?;
            let step = up.empty::<CascadeStep>("cascade step", 1, uniform, fewer)?;
            let (shadow, lods) = (&light.config, &c.error_lods);
            let (sets, buckets) = (&c.tables.bucket_sets, &c.tables.buckets);
            let bound = select.bind(
                device,
                &f.config,
                shadow,
                &step,
                &f.instances,
                &c.clips,
                lods,
                &f.choices,
                &casters,
                sets,
                buckets,
            );
            let frame = FrameBuffers { config: config.clone(), ..f.clone() };
            cascades.push(CascadeDraw {
                config,
                step,
                select: bound,
                crowd: draw.bind(c, &frame, &f.choices, &f.nothing),
                target: light.map.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: number,
                    array_layer_count: Some(1),
                    ..Default::default()
                }),
            });
        }
        let frame = FrameBuffers { config: cascades[0].config.clone(), choices: casters, totals, ..f.clone() };
        let draws = BucketDraws::new(up, c, &frame, options, &no_sums)?;
        let inputs = &BucketDraws::INPUTS;
        let meshes = match c.has_cutouts {
            true => draw.caster_pipeline("bucketed", Some("mask"), inputs, caster_bias()),
            false => draw.caster_pipeline("bucketed_caster", None, inputs, caster_bias()),
        };
        let dots = draw.caster_pipeline("dots_caster", None, inputs, caster_bias());
        let lent = up.empty::<u32>("lent vertices", options.max_instances.into(), written, fewer)?;
        let lending = Lending::new(device, c, f, lent, draws.lists());
        Ok(Self { side, bytes: up.bytes, light, select, cascades, draws, meshes, dots, lending })
    }

    /// Lets casters have the vertices of `lender`, or skin them by themselves.
    pub(crate) fn fit_lending(
        &mut self,
        device: &wgpu::Device,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        draw: &DrawCrowd,
        lender: Option<Lender<'_>>,
    ) {
        let configs = self.cascades.iter().map(|cascade| &cascade.config);
        self.lending.fit(device, c, f, draw, configs, lender);
    }

    /// Lets go of buffers of who lent vertices, for those are going.
    pub(crate) fn forget_lender(&mut self) {
        self.lending.forget();
    }

    /// Draws the maps. `feed`: of a simulator, whose count the GPU alone knows. `has_choices`: the levels that the camera sees are in the
    /// frame's buffers.
    pub(crate) fn record(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        recorder: &mut StageRecorder<'_>,
        crowd: &CrowdBuffers,
        scenery: Option<&DrawScenery>,
        feed: Option<&BoundFeed>,
        config: &FrameConfig,
        shadow: &ShadowConfig,
        has_choices: bool,
    ) {
        queue.write_buffer(&self.light.config, 0, bytemuck::bytes_of(shadow));
        if let Some(feed) = feed {
            // The lists of all maps go by the first one's. Casters beyond the count are left from an earlier frame.
            feed.record_count(recorder.encoder, &self.cascades[0].config);
        }
        recorder.group = Some(SHADOWS);
        self.lending.record_lend(recorder, config.instance_count);
        let cascades = self.cascades.iter().zip(&shadow.cascades).take(shadow.cascade_count as usize);
        for (number, (cascade, place)) in cascades.enumerate() {
            // Levels by error do not morph; the key's stage would look for water.
            // Whoever is an impostor throws the shadow of the coarsest mesh.
            let from_sun =
                FrameConfig { clip_from_world: place.clip_from_world, morph: 0, impostor_area_px2: 0.0, ..*config };
            let step = CascadeStep { cascade: number as u32, has_choices: has_choices.into(), ..Default::default() };
            queue.write_buffer(&cascade.config, 0, bytemuck::bytes_of(&from_sun));
            queue.write_buffer(&cascade.step, 0, bytemuck::bytes_of(&step));
            let count = config.instance_count;
            recorder.stage("select_casters", |pass| self.select.record(pass, &cascade.select, count));
            self.draws.record_keys(recorder, count);
            self.draws.record_sort(recorder, count);
            self.draws.record_drawn(recorder, count);
            self.lending.record_borrow(recorder, count);
            let stamps = recorder.draw_stamps("cast", false);
            let mut pass = recorder.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("cast"),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &cascade.target,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                timestamp_writes: stamps.as_ref().map(|(query_set, start, end)| wgpu::RenderPassTimestampWrites {
                    query_set,
                    beginning_of_pass_write_index: Some(*start),
                    end_of_pass_write_index: *end,
                }),
                ..Default::default()
            });
            if let Some(scenery) = scenery {
                scenery.cast(device, &mut pass, &cascade.config);
            }
            let (meshes, crowd_bound) = self.lending.draws_with(number).unwrap_or((&self.meshes, &cascade.crowd));
            pass.set_pipeline(meshes);
            pass.set_bind_group(0, crowd_bound, &[]);
            self.draws.draw(&mut pass, crowd);
            if config.dot_area_px2 > 0.0 {
                pass.set_pipeline(&self.dots);
                self.draws.draw_stand_ins(&mut pass);
            }
            drop(pass);
            self.light.record_copy(recorder.encoder, number as u32);
        }
        recorder.group = None;
    }

    /// A buffer of the last cascade drawn.
    pub(crate) fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.draws.buffer(name)
    }
}

/// Of everything that is drawn into the maps.
pub(crate) fn caster_bias() -> wgpu::DepthBiasState {
    wgpu::DepthBiasState { constant: 0, slope_scale: SLOPE_BIAS, clamp: 0.0 }
}
