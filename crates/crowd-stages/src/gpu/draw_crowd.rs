//! The draw: sky and ground, then the crowd, into a colour view with the renderer's own depth; or the crowd alone into an engine's.

use super::allocate::texture_or_error;
use super::kernel::{Use, buffer_entry, fetches_from_storage, lit_source, with_stored_frames, with_stored_maps};
use super::lit::{Lit, has_shadows};
use super::renderer::RendererOptions;
use super::shadows::light_layout;
use super::stage_recorder::DrawStamps;
use super::targets::{Attachments, DepthWay};
use super::upload::{CrowdBuffers, FrameBuffers};
use crate::Result;

pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

const RECORDS: &str = include_str!("../../../../shaders/shared/records.wgsl");
const PLACE: &str = include_str!("../../../../shaders/shared/place.wgsl");
const POSE: &str = include_str!("../../../../shaders/shared/pose.wgsl");
const FRAMES: &str = include_str!("../../../../shaders/shared/frames.wgsl");
const SKIN: &str = include_str!("../../../../shaders/shared/skin.wgsl");
const LIGHT: &str = include_str!("../../../../shaders/shared/light.wgsl");
const SHADOW: &str = include_str!("../../../../shaders/shared/shadow.wgsl");
const BACKDROP: &str = include_str!("../../../../shaders/draw/backdrop.wgsl");
const CROWD: &str = include_str!("../../../../shaders/draw/crowd.wgsl");
const DOTS: &str = include_str!("../../../../shaders/draw/dots.wgsl");
const IMPOSTORS: &str = include_str!("../../../../shaders/draw/impostors.wgsl");
const POINTS: &str = include_str!("../../../../shaders/draw/points.wgsl");

/// The WGSL of sky and ground as it is compiled.
pub fn backdrop_source() -> String {
    [RECORDS, LIGHT, SHADOW, BACKDROP].concat()
}

/// The WGSL of the crowd's draw as it is compiled.
pub fn crowd_source() -> String {
    [RECORDS, PLACE, POSE, FRAMES, SKIN, LIGHT, SHADOW, CROWD, DOTS, POINTS, IMPOSTORS].concat()
}

/// The same for software adapters, which fetch frames in another way.
pub fn crowd_source_of_software() -> String {
    with_stored_maps(&with_stored_frames(&crowd_source()))
}

/// What every technique draws with: targets, backdrop, the crowd's shader and its layout.
pub(crate) struct DrawCrowd {
    device: wgpu::Device,
    backdrop: Lit,
    backdrop_bound: wgpu::BindGroup,
    crowd_module: wgpu::ShaderModule,
    layouts: Layouts,
    /// Constant of the crowd's shader, see [`CrowdBuffers::joint_storages`].
    joint_storages: f64,
    color_format: wgpu::TextureFormat,
    sample_count: u32,
    depth: DepthWay,
    targets: Option<OwnTargets>,
}

/// Which passes a frame is drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// One pass.
    Only,
    /// The first of two: what it drew, depth too, is kept.
    First,
    /// The second of two.
    Last,
}

/// Textures of the picture's size.
struct OwnTargets {
    size: (u32, u32),
    reads_depth: bool,
    depth: wgpu::TextureView,
    multisampled: Option<wgpu::TextureView>,
}

impl DrawCrowd {
    pub(crate) fn new(
        device: &wgpu::Device,
        frame: &FrameBuffers,
        joint_storages: u32,
        options: &RendererOptions,
    ) -> Self {
        let layouts = Layouts::new(device);
        let RendererOptions { color_format, sample_count, .. } = *options;
        let depth = DepthWay::of(options);
        let shape = Shape { color_format: Some(color_format), sample_count, depth, ..Shape::of(device) };
        Self {
            device: device.clone(),
            backdrop: lit_backdrop(&shape, [layouts.backdrop.clone(), layouts.light.clone()]),
            backdrop_bound: bind_backdrop(device, &layouts.backdrop, frame),
            crowd_module: shape.module(
                "crowd",
                if fetches_from_storage(device) { crowd_source_of_software() } else { crowd_source() },
            ),
            layouts,
            joint_storages: joint_storages.into(),
            color_format,
            sample_count,
            depth,
            targets: None,
        }
    }

    /// A pipeline of the crowd's shader with that vertex entry point.
    pub(crate) fn pipeline(&self, vertex: &'static str) -> Lit {
        self.pipeline_with(vertex, &[])
    }

    /// The same with vertex buffers.
    pub(crate) fn pipeline_with(
        &self,
        vertex: &'static str,
        buffers: &[Option<wgpu::VertexBufferLayout<'static>>],
    ) -> Lit {
        self.pipeline_of(vertex, buffers, &[])
    }

    /// The same with constants of the shader.
    pub(crate) fn pipeline_of(
        &self,
        vertex: &'static str,
        buffers: &[Option<wgpu::VertexBufferLayout<'static>>],
        constants: &[(&'static str, f64)],
    ) -> Lit {
        self.lit(vertex, "shade", buffers, constants, None, wgpu::PrimitiveTopology::TriangleList)
    }

    /// The same with another fragment entry point, a layout of bind group 2 and another topology.
    fn lit(
        &self,
        vertex: &'static str,
        fragment: &'static str,
        buffers: &[Option<wgpu::VertexBufferLayout<'static>>],
        constants: &[(&'static str, f64)],
        more: Option<&wgpu::BindGroupLayout>,
        topology: wgpu::PrimitiveTopology,
    ) -> Lit {
        let layouts: Vec<wgpu::BindGroupLayout> =
            [&self.layouts.crowd, &self.layouts.light].into_iter().chain(more).cloned().collect();
        let constants = [constants, &[self.storages()]].concat();
        let (device, module, buffers) = (self.device.clone(), self.crowd_module.clone(), buffers.to_vec());
        let (color_format, sample_count, depth) = (Some(self.color_format), self.sample_count, self.depth);
        Lit::new(move |shows_shadows| {
            let shape = Shape { color_format, sample_count, depth, topology, ..Shape::of(&device) };
            let layouts: Vec<&wgpu::BindGroupLayout> = layouts.iter().collect();
            let constants = [&constants[..], &[has_shadows(shows_shadows)]].concat();
            shape.pipeline(&layouts, &module, vertex, Some(fragment), depth.nearer(), &buffers, &constants)
        })
    }

    /// A pipeline of the crowd's shader that draws depth alone, into a texture of one sample a pixel. `mask`: the fragment entry
    /// point that leaves out what is cut out; none where nothing is.
    pub(crate) fn caster_pipeline(
        &self,
        vertex: &str,
        mask: Option<&str>,
        buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
        bias: wgpu::DepthBiasState,
    ) -> wgpu::RenderPipeline {
        let shape = Shape { bias, ..Shape::of(&self.device) };
        let less = wgpu::CompareFunction::Less;
        let constants = [self.storages()];
        shape.pipeline(&[&self.layouts.crowd], &self.crowd_module, vertex, mask, less, buffers, &constants)
    }

    /// The constant that says how joints are stored.
    fn storages(&self) -> (&'static str, f64) {
        ("JOINT_STORAGES", self.joint_storages)
    }

    fn shape(&self) -> Shape<'_> {
        let Self { device, color_format, sample_count, depth, .. } = self;
        Shape { color_format: Some(*color_format), sample_count: *sample_count, depth: *depth, ..Shape::of(device) }
    }

    /// The layout of bind group 1.
    pub(crate) fn light_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layouts.light
    }

    /// The pipeline of dots.
    pub(crate) fn dots_pipeline(&self, buffers: &[Option<wgpu::VertexBufferLayout<'_>>]) -> wgpu::RenderPipeline {
        let layouts = [&self.layouts.crowd, &self.layouts.light];
        self.shape().pipeline(
            &layouts,
            &self.crowd_module,
            "dots",
            Some("shade_dot"),
            self.depth.nearer(),
            buffers,
            &[self.storages()],
        )
    }

    /// The pipelines of impostors and of those who cross over to them. `textures`: layout of bind group 2.
    pub(crate) fn impostor_pipelines(
        &self,
        textures: &wgpu::BindGroupLayout,
        buffers: &[Option<wgpu::VertexBufferLayout<'static>>],
    ) -> [Lit; 2] {
        let (triangles, samples) = (wgpu::PrimitiveTopology::TriangleList, [("SAMPLES", self.sample_count.into())]);
        [("impostors", "shade_impostor"), ("fading", "shade_fading")]
            .map(|(vertex, fragment)| self.lit(vertex, fragment, buffers, &samples, Some(textures), triangles))
    }

    /// The pipeline of points.
    pub(crate) fn points_pipeline(&self, buffers: &[Option<wgpu::VertexBufferLayout<'static>>]) -> Lit {
        self.lit("points", "shade_point", buffers, &[], None, wgpu::PrimitiveTopology::PointList)
    }

    /// The crowd's bind group with a technique's own list of owners and their bases.
    pub(crate) fn bind(
        &self,
        crowd: &CrowdBuffers,
        frame: &FrameBuffers,
        slot_instances: &wgpu::Buffer,
        bases: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let none = &frame.nothing;
        bind_crowd(&self.device, &self.layouts.crowd, crowd, frame, [slot_instances, bases, none, none])
    }

    /// The same for buckets, with palettes and vertices that were skinned beforehand.
    pub(crate) fn bind_skinned(
        &self,
        crowd: &CrowdBuffers,
        frame: &FrameBuffers,
        palettes: &wgpu::Buffer,
        skinned: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let none = &frame.nothing;
        bind_crowd(&self.device, &self.layouts.crowd, crowd, frame, [none, none, palettes, skinned])
    }

    /// The renderer's own depth texture.
    pub(crate) fn own_depth(&self) -> &wgpu::TextureView {
        &self.targets.as_ref().expect("fit_targets comes first").depth
    }

    /// The renderer's own targets with a `color` of the size that [`Self::fit_targets`] was given last.
    pub(crate) fn own_attachments<'a>(&'a self, color: &'a wgpu::TextureView) -> Attachments<'a> {
        let OwnTargets { depth, multisampled, .. } = self.targets.as_ref().expect("fit_targets comes first");
        match multisampled {
            Some(samples) => Attachments { color: samples, resolve: Some(color), depth, are_hosts: false },
            None => Attachments { color, resolve: None, depth, are_hosts: false },
        }
    }

    /// Begins the pass, and draws the backdrop into the renderer's own targets.
    /// `light`: of [`super::shadows::Light`]; `shows_shadows`: it has maps. `part`: one that is not the first goes on where the one before ended, without a backdrop.
    pub(crate) fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        into: &Attachments<'_>,
        stamps: Option<DrawStamps>,
        part: Part,
        light: &wgpu::BindGroup,
        shows_shadows: bool,
    ) -> wgpu::RenderPass<'e> {
        let goes_on = part == Part::First;
        let begins = part != Part::Last && !into.are_hosts;
        let resolve_target = into.resolve.filter(|_| !goes_on);
        let (color_load, depth_load) = match begins {
            false => (wgpu::LoadOp::Load, wgpu::LoadOp::Load),
            true => (wgpu::LoadOp::Clear(wgpu::Color::BLACK), wgpu::LoadOp::Clear(self.depth.farthest())),
        };
        let keeps = |is_wanted: bool| if is_wanted { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
        let store = keeps(into.are_hosts || resolve_target.is_none());
        let depth_store = keeps(into.are_hosts || goes_on);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("draw"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: into.color,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: color_load, store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: into.depth,
                depth_ops: Some(wgpu::Operations { load: depth_load, store: depth_store }),
                stencil_ops: None,
            }),
            timestamp_writes: stamps.as_ref().map(|(query_set, start, end)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(*start),
                end_of_pass_write_index: *end,
            }),
            ..Default::default()
        });
        pass.set_bind_group(1, light, &[]);
        if begins {
            pass.set_pipeline(self.backdrop.of(shows_shadows));
            pass.set_bind_group(0, &self.backdrop_bound, &[]);
            pass.draw(0..3, 0..1);
        }
        pass
    }

    /// Makes the textures of the picture's size, unless they are there. `reads_depth`: a later stage will.
    pub(crate) fn fit_targets(&mut self, device: &wgpu::Device, size: (u32, u32), reads_depth: bool) -> Result<()> {
        let size = (size.0.max(1), size.1.max(1));
        if self.targets.as_ref().is_some_and(|targets| targets.size == size && (targets.reads_depth || !reads_depth)) {
            return Ok(());
        }
        // The old ones go first: two sets may not fit where one does.
        self.targets = None;
        let samples = u64::from(size.0) * u64::from(size.1) * u64::from(self.sample_count);
        let texture = |label, format: wgpu::TextureFormat| {
            let is_depth = format == self.depth.format;
            let bytes =
                samples * if is_depth { self.depth.bytes() } else { format.block_copy_size(None).unwrap_or(4).into() };
            let descriptor = wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: self.sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | if is_depth && reads_depth {
                        wgpu::TextureUsages::TEXTURE_BINDING
                    } else {
                        wgpu::TextureUsages::empty()
                    },
                view_formats: &[],
            };
            let texture = texture_or_error(device, label, bytes, "draw a smaller picture", &descriptor)?;
            Ok(texture.create_view(&Default::default()))
        };
        let multisampled = (self.sample_count > 1).then(|| texture("multisampled", self.color_format)).transpose()?;
        let depth = texture("depth", self.depth.format)?;
        self.targets = Some(OwnTargets { size, reads_depth, depth, multisampled });
        Ok(())
    }

    /// Bytes of the textures of the picture's size.
    pub(crate) fn target_bytes(&self) -> u64 {
        let Some(targets) = &self.targets else { return 0 };
        let samples = u64::from(targets.size.0) * u64::from(targets.size.1) * u64::from(self.sample_count);
        let color_bytes = u64::from(self.color_format.block_copy_size(None).unwrap_or(4));
        samples * (self.depth.bytes() + if self.sample_count > 1 { color_bytes } else { 0 })
    }
}

struct Layouts {
    light: wgpu::BindGroupLayout,
    backdrop: wgpu::BindGroupLayout,
    crowd: wgpu::BindGroupLayout,
}

impl Layouts {
    fn new(device: &wgpu::Device) -> Self {
        let vertex = wgpu::ShaderStages::VERTEX;
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let layers = wgpu::BindGroupLayoutEntry {
            binding: 10,
            visibility: fragment,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            },
            count: None,
        };
        let frames = if fetches_from_storage(device) { Use::StoredFrames } else { Use::Frames };
        let layout = |label, entries: &[_]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        Self {
            light: light_layout(device),
            backdrop: layout(
                "backdrop",
                &[buffer_entry(0, fragment, Use::Uniform, None), buffer_entry(1, fragment, Use::Uniform, None)],
            ),
            crowd: layout(
                "crowd",
                &[
                    buffer_entry(0, vertex | fragment, Use::Uniform, None),
                    buffer_entry(1, vertex | fragment, Use::Uniform, None),
                    buffer_entry(2, vertex, Use::Read, None),
                    buffer_entry(3, vertex, Use::Read, None),
                    buffer_entry(4, vertex, Use::Read, None),
                    buffer_entry(5, vertex, Use::Read, None),
                    buffer_entry(6, vertex, Use::Read, None),
                    buffer_entry(7, vertex, Use::Read, None),
                    buffer_entry(8, fragment, Use::Read, None),
                    buffer_entry(9, vertex, frames, None),
                    layers,
                    wgpu::BindGroupLayoutEntry {
                        binding: 11,
                        visibility: fragment,
                        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                        count: None,
                    },
                    buffer_entry(12, vertex, Use::Read, None),
                    buffer_entry(13, vertex, Use::Read, None),
                ],
            ),
        }
    }
}

fn lit_backdrop(shape: &Shape<'_>, layouts: [wgpu::BindGroupLayout; 2]) -> Lit {
    let module = shape.module("backdrop", lit_source(shape.device, backdrop_source()));
    let Shape { color_format, sample_count, depth, .. } = *shape;
    let device = shape.device.clone();
    Lit::new(move |shows_shadows| {
        let shape = Shape { color_format, sample_count, depth, ..Shape::of(&device) };
        let always = wgpu::CompareFunction::Always;
        let constants = [has_shadows(shows_shadows), ("REVERSED", u8::from(depth.reversed).into())];
        shape.pipeline(&layouts.each_ref(), &module, "cover", Some("backdrop"), always, &[], &constants)
    })
}

fn bind_backdrop(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, frame: &FrameBuffers) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("backdrop"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: frame.config.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: frame.draw_config.as_entire_binding() },
        ],
    })
}

fn bind_crowd(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    crowd: &CrowdBuffers,
    frame: &FrameBuffers,
    [slot_instances, bases, palettes, skinned]: [&wgpu::Buffer; 4],
) -> wgpu::BindGroup {
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("layers"),
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    });
    let buffers = [
        &frame.config,
        &frame.draw_config,
        &frame.instances,
        &crowd.characters,
        &crowd.clips,
        &crowd.vertices,
        slot_instances,
        bases,
        &crowd.materials,
    ];
    let mut entries: Vec<_> = buffers
        .iter()
        .enumerate()
        .map(|(i, buffer)| wgpu::BindGroupEntry { binding: i as u32, resource: buffer.as_entire_binding() })
        .collect();
    entries.push(wgpu::BindGroupEntry { binding: 9, resource: wgpu::BindingResource::TextureView(&crowd.animation) });
    entries.push(wgpu::BindGroupEntry { binding: 10, resource: wgpu::BindingResource::TextureView(&crowd.layers) });
    entries.push(wgpu::BindGroupEntry { binding: 11, resource: wgpu::BindingResource::Sampler(&sampler) });
    entries.push(wgpu::BindGroupEntry { binding: 12, resource: palettes.as_entire_binding() });
    entries.push(wgpu::BindGroupEntry { binding: 13, resource: skinned.as_entire_binding() });
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("crowd"), layout, entries: &entries })
}

/// What all pipelines of the draw share.
struct Shape<'a> {
    device: &'a wgpu::Device,
    /// `None` draws depth alone.
    color_format: Option<wgpu::TextureFormat>,
    sample_count: u32,
    depth: DepthWay,
    bias: wgpu::DepthBiasState,
    topology: wgpu::PrimitiveTopology,
}

impl<'a> Shape<'a> {
    /// Depth of triangles, one sample a pixel.
    fn of(device: &'a wgpu::Device) -> Self {
        let topology = wgpu::PrimitiveTopology::TriangleList;
        let depth = DepthWay::OF_MAPS;
        Self { device, color_format: None, sample_count: 1, depth, bias: Default::default(), topology }
    }

    fn module(&self, label: &str, source: String) -> wgpu::ShaderModule {
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        })
    }

    fn pipeline(
        &self,
        layouts: &[&wgpu::BindGroupLayout],
        module: &wgpu::ShaderModule,
        vertex: &str,
        fragment: Option<&str>,
        depth_compare: wgpu::CompareFunction,
        buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
        constants: &[(&str, f64)],
    ) -> wgpu::RenderPipeline {
        let layouts: Vec<_> = layouts.iter().copied().map(Some).collect();
        let target = self.color_format.map(|format| Some(format.into()));
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(vertex),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                buffers,
            },
            // No culling by the hardware: whether a back face is drawn differs from material to material.
            primitive: wgpu::PrimitiveState { topology: self.topology, cull_mode: None, ..Default::default() },
            depth_stencil: Some(self.depth.state(depth_compare, self.bias)),
            multisample: wgpu::MultisampleState { count: self.sample_count, ..Default::default() },
            fragment: fragment.map(|entry_point| wgpu::FragmentState {
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                targets: target.as_slice(),
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
