//! A crowd's data on the GPU, and the buffers of a frame: sizes checked before anything is allocated.

use super::FillBudget;
use super::allocate::{buffer_or_error, texture_or_error};
use super::impostor_textures::ImpostorTextures;
use super::kernel::fetches_from_storage;
use crate::dispatch::BLOCK_SIZE;
use crate::{
    BucketCounts, BucketRecord, Buckets, CrowdData, CullRecord, DiscreteConfig, DrawConfig, Error, FillState,
    FrameConfig, FrameTotals, InstanceRecord, LodChoice, MOST_POINTS, PointRecord, PoseCounts, Result, WeightSums,
    discrete_config, dot_corners, dot_reach, surface_points,
};
use crowd_pack::Texel;
use std::mem::{offset_of, size_of};
use std::ops::Range;
use wgpu::BufferUsages as Usage;

/// Width of the animation texture's layers, texels; `shaders/shared/frames.wgsl` has the same.
pub const ANIMATION_WIDTH: u32 = 4096;
/// Height of the animation texture's layers, texels: 4 MiB a layer. `shaders/shared/frames.wgsl` has the same.
pub const ANIMATION_HEIGHT: u32 = 64;

/// Makes buffers and textures, counts their bytes, refuses what the device's limits do not allow.
pub(crate) struct Uploader<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) bytes: u64,
}

impl Uploader<'_> {
    /// A buffer with contents; never empty, so that it can be bound.
    pub(crate) fn filled<T: bytemuck::NoUninit>(
        &mut self,
        what: &'static str,
        contents: &[T],
        usage: Usage,
        remedy: &'static str,
    ) -> Result<wgpu::Buffer> {
        if contents.is_empty() {
            return self.empty::<T>(what, 0, usage, remedy);
        }
        let buffer = self.empty::<T>(what, contents.len() as u64, usage | Usage::COPY_DST, remedy)?;
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(contents));
        Ok(buffer)
    }

    /// A buffer of zeros; never empty, so that it can be bound.
    pub(crate) fn empty<T>(
        &mut self,
        what: &'static str,
        count: u64,
        usage: Usage,
        remedy: &'static str,
    ) -> Result<wgpu::Buffer> {
        let limits = self.device.limits();
        // Only what shaders bind as storage has to fit a binding.
        let allowed = if usage.contains(Usage::STORAGE) { self.largest_binding() } else { limits.max_buffer_size };
        self.allocate::<T>(what, count, usage, remedy, allowed)
    }

    /// A buffer of zeros that shaders are bound to in parts: it may be larger than a binding.
    pub(crate) fn in_parts<T>(
        &mut self,
        what: &'static str,
        count: u64,
        usage: Usage,
        remedy: &'static str,
    ) -> Result<wgpu::Buffer> {
        self.allocate::<T>(what, count, usage, remedy, self.device.limits().max_buffer_size)
    }

    /// Bytes of storage that a shader can be bound to.
    pub(crate) fn largest_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    fn allocate<T>(
        &mut self,
        what: &'static str,
        count: u64,
        usage: Usage,
        remedy: &'static str,
        allowed: u64,
    ) -> Result<wgpu::Buffer> {
        let needed = count.max(1) * size_of::<T>() as u64;
        if needed > allowed {
            return Err(Error::Limit { what, needed, allowed, remedy });
        }
        let size = needed;
        let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        let buffer = buffer_or_error(self.device, what, remedy, &descriptor)?;
        self.bytes += size;
        Ok(buffer)
    }

    /// Stored joints as one texture, addressed by one number (see `animation_texel` in `shaders/shared/frames.wgsl`).
    fn animation_texture(&mut self, texels: &[Texel]) -> Result<wgpu::TextureView> {
        let rows = texels.len().div_ceil(ANIMATION_WIDTH as usize).max(1) as u32;
        let layer_count = array_layers(rows.div_ceil(ANIMATION_HEIGHT), false);
        let height = rows.min(ANIMATION_HEIGHT);
        let limits = self.device.limits();
        if layer_count > limits.max_texture_array_layers || ANIMATION_WIDTH > limits.max_texture_dimension_2d {
            let width = if ANIMATION_WIDTH > limits.max_texture_dimension_2d { 0 } else { ANIMATION_WIDTH };
            return Err(Error::Limit {
                what: "texels of the animation texture",
                needed: texels.len() as u64,
                allowed: u64::from(width * ANIMATION_HEIGHT) * u64::from(limits.max_texture_array_layers),
                remedy: "bake fewer clips or a lower --fps",
            });
        }
        let bytes = u64::from(layer_count * height) * u64::from(ANIMATION_WIDTH) * 16;
        let stored = match fetches_from_storage(self.device) {
            true => wgpu::TextureUsages::STORAGE_BINDING,
            false => wgpu::TextureUsages::empty(),
        };
        let descriptor = wgpu::TextureDescriptor {
            label: Some("animation"),
            size: wgpu::Extent3d { width: ANIMATION_WIDTH, height, depth_or_array_layers: layer_count },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | stored,
            view_formats: &[],
        };
        let fewer = "bake fewer clips or a lower --fps";
        let texture = texture_or_error(self.device, "animation texture", bytes, fewer, &descriptor)?;
        self.bytes += bytes;
        for (layer, texels) in texels.chunks((ANIMATION_WIDTH * ANIMATION_HEIGHT) as usize).enumerate() {
            let whole = texels.len() / ANIMATION_WIDTH as usize;
            let (rows, rest) = texels.split_at(whole * ANIMATION_WIDTH as usize);
            self.write_rows(&texture, layer as u32, 0, ANIMATION_WIDTH, whole as u32, rows);
            self.write_rows(&texture, layer as u32, whole as u32, rest.len() as u32, 1, rest);
        }
        Ok(texture.create_view(&array_view("animation")))
    }

    fn write_rows(&self, texture: &wgpu::Texture, layer: u32, y: u32, width: u32, height: u32, texels: &[Texel]) {
        if texels.is_empty() {
            return;
        }
        self.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y, z: layer },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 16), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    /// All images as layers of one texture; one white texel when there are none.
    fn layer_texture(&mut self, data: &CrowdData) -> Result<wgpu::TextureView> {
        let layer_count = array_layers(data.layers.len() as u32, true);
        let side = if data.layers.is_empty() { 1 } else { data.layer_side };
        let limits = self.device.limits();
        if layer_count > limits.max_texture_array_layers {
            return Err(Error::Limit {
                what: "images of the pack",
                needed: u64::from(layer_count),
                allowed: u64::from(limits.max_texture_array_layers),
                remedy: "put fewer characters into one pack, or let them share images",
            });
        }
        if side > limits.max_texture_dimension_2d {
            return Err(Error::Limit {
                what: "side of a texture layer",
                needed: u64::from(side),
                allowed: u64::from(limits.max_texture_dimension_2d),
                remedy: "unpack with a smaller texture size",
            });
        }
        let descriptor = wgpu::TextureDescriptor {
            label: Some("layers"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layer_count },
            mip_level_count: side.ilog2() + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        };
        // Mip levels add a third.
        let bytes = u64::from(side) * u64::from(side) * 4 * u64::from(layer_count) * 4 / 3;
        let smaller = "unpack with a smaller texture size";
        let texture = texture_or_error(self.device, "images of the pack", bytes, smaller, &descriptor)?;
        // Also those that only make it an array.
        let of_layer: u64 = (0..=side.ilog2()).map(|level| u64::from((side >> level).max(1)).pow(2) * 4).sum();
        self.bytes += of_layer * u64::from(layer_count);
        let white = crate::TextureLayer { mips: vec![vec![[255; 4]]] };
        let layers = if data.layers.is_empty() { std::slice::from_ref(&white) } else { &data.layers };
        for (z, layer) in layers.iter().enumerate() {
            for (level, texels) in layer.mips.iter().enumerate() {
                let side = (side >> level).max(1);
                self.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &texture,
                        mip_level: level as u32,
                        origin: wgpu::Origin3d { x: 0, y: 0, z: z as u32 },
                        aspect: wgpu::TextureAspect::All,
                    },
                    bytemuck::cast_slice(texels),
                    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 4), rows_per_image: None },
                    wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
                );
            }
        }
        Ok(texture.create_view(&array_view("layers")))
    }
}

/// Layers to ask for so that OpenGL sees an array: there, wgpu takes one layer for no array at all, and square layers in sixes
/// for a cube, and reads from them give zeros.
pub(crate) fn array_layers(count: u32, is_square: bool) -> u32 {
    let count = count.max(2);
    count + u32::from(is_square && count.is_multiple_of(6))
}

pub(crate) fn array_view(label: &'static str) -> wgpu::TextureViewDescriptor<'static> {
    wgpu::TextureViewDescriptor {
        label: Some(label),
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }
}

/// A crowd's data as it lies on the GPU; does not change.
pub(crate) struct CrowdBuffers {
    pub(crate) characters: wgpu::Buffer,
    pub(crate) vertices: wgpu::Buffer,
    /// Where they come from when a level comes.
    pub(crate) origins: wgpu::Buffer,
    pub(crate) triangles: wgpu::Buffer,
    pub(crate) collapse_map: wgpu::Buffer,
    pub(crate) lods: wgpu::Buffer,
    /// The same of quantised levels and dots.
    pub(crate) quantized_lods: wgpu::Buffer,
    /// Below so many vertices everyone is dots.
    pub(crate) dot_reach: u32,
    /// Of quantised levels by their errors.
    pub(crate) error_lods: wgpu::Buffer,
    pub(crate) tables: LevelTables,
    pub(crate) points: PointTables,
    pub(crate) clips: wgpu::Buffer,
    /// How fast each is; beyond all measure where nobody has measured it.
    pub(crate) clip_speeds: wgpu::Buffer,
    /// Numbers of poses; `None` where they do not fit.
    pub(crate) poses: Option<(PoseCounts, Vec<u32>)>,
    pub(crate) materials: wgpu::Buffer,
    /// Something of somebody is cut out.
    pub(crate) has_cutouts: bool,
    pub(crate) animation: wgpu::TextureView,
    /// How joints are stored: the shaders' constant of that name.
    pub(crate) joint_storages: u32,
    pub(crate) layers: wgpu::TextureView,
    /// Bytes of the former texture.
    pub(crate) animation_bytes: u64,
    /// Bytes of the latter.
    pub(crate) layer_bytes: u64,
    /// Where the crowd has them.
    pub(crate) impostors: Option<ImpostorTextures>,
    /// Bytes of all that.
    pub(crate) impostor_bytes: u64,
}

impl CrowdBuffers {
    pub(crate) fn new(up: &mut Uploader<'_>, data: &CrowdData) -> Result<Self> {
        let fewer = "put fewer characters into one pack";
        let buckets = Buckets::of(data)?.with_palettes_in(up.largest_binding());
        let quantized_lods = buckets.quantized_lods(data);
        let before = up.bytes;
        let animation = up.animation_texture(&data.animation)?;
        let animation_bytes = up.bytes - before;
        let layers = up.layer_texture(data)?;
        let layer_bytes = up.bytes - before - animation_bytes;
        let before = up.bytes;
        let impostors = ImpostorTextures::new(up, data)?;
        let impostor_bytes = up.bytes - before;
        let unknown = || vec![f32::MAX; data.clips.len()];
        let clip_speeds = if data.clip_speeds.is_empty() { unknown() } else { data.clip_speeds.clone() };
        Ok(Self {
            characters: up.filled("characters", &data.characters, Usage::STORAGE, fewer)?,
            vertices: up.filled("bytes of vertices", &data.vertices, Usage::STORAGE | Usage::VERTEX, fewer)?,
            origins: up.filled(
                "bytes of the vertices' origins",
                &buckets.origins(data),
                Usage::STORAGE | Usage::VERTEX,
                fewer,
            )?,
            triangles: up.filled("bytes of triangles", &data.triangles, Usage::STORAGE | Usage::INDEX, fewer)?,
            collapse_map: up.filled("bytes of the collapse map", &data.collapse_map, Usage::STORAGE, fewer)?,
            lods: up.filled("bytes of the LOD tables", &data.lods, Usage::STORAGE, fewer)?,
            quantized_lods: up.filled("bytes of the quantised LOD tables", &quantized_lods, Usage::STORAGE, fewer)?,
            error_lods: up.filled("bytes of the error tables", &buckets.error_lods(), Usage::STORAGE, fewer)?,
            dot_reach: dot_reach(&data.characters),
            tables: LevelTables::new(up, data, &buckets)?,
            points: PointTables::new(data)?,
            clip_speeds: up.filled("speeds of clips", &clip_speeds, Usage::STORAGE, fewer)?,
            poses: PoseCounts::of(data, &buckets),
            clips: up.filled("bytes of clips", &data.clips, Usage::STORAGE, fewer)?,
            has_cutouts: data.materials.iter().any(|material| material.alpha_cutoff > 0.0),
            materials: up.filled("bytes of materials", &data.materials, Usage::STORAGE, fewer)?,
            animation,
            joint_storages: data.joint_storages(),
            layers,
            animation_bytes,
            layer_bytes,
            impostors,
            impostor_bytes,
        })
    }
}

/// What points need on the GPU once somebody draws them.
pub(crate) struct PointTables {
    records: Vec<BucketRecord>,
    counts: BucketCounts,
    indices_32: Vec<u32>,
    points: Vec<PointRecord>,
}

impl PointTables {
    fn new(data: &CrowdData) -> Result<Self> {
        let points = surface_points(data);
        let buckets = Buckets::with_points(data, &points)?;
        let all = |points: Option<Vec<PointRecord>>| {
            points.unwrap_or_else(|| vec![PointRecord::default(); MOST_POINTS as usize])
        };
        Ok(Self {
            counts: buckets.counts(),
            records: buckets.records,
            indices_32: buckets.indices_32,
            points: points.into_iter().flat_map(all).collect(),
        })
    }
}

/// Index tables of all quantised levels.
#[derive(Clone)]
pub(crate) struct LevelTables {
    pub(crate) bucket_sets: wgpu::Buffer,
    pub(crate) buckets: wgpu::Buffer,
    pub(crate) bucket_counts: wgpu::Buffer,
    pub(crate) counts: BucketCounts,
    /// Buckets of each character's three discrete levels.
    pub(crate) discrete_levels: Vec<u32>,
    pub(crate) discrete: DiscreteConfig,
    /// Of each character at full detail: its indices, whether they have 16 bits, and its first vertex.
    pub(crate) full_detail: Vec<(Range<u32>, bool, i32)>,
    /// What is drawn in the place of far characters, a vertex buffer: corners of dots, or points.
    pub(crate) stand_ins: wgpu::Buffer,
    indices_16: wgpu::Buffer,
    indices_32: wgpu::Buffer,
}

impl LevelTables {
    fn new(up: &mut Uploader<'_>, data: &CrowdData, buckets: &Buckets) -> Result<Self> {
        let fewer = "put fewer characters into one pack";
        let storage = Usage::STORAGE;
        // Copies go in steps of four bytes.
        let mut indices_16 = buckets.indices_16.clone();
        indices_16.resize(indices_16.len().next_multiple_of(2), 0);
        let full_detail = (0..buckets.sets.len() as u32).map(|character| {
            let bucket = buckets.at(character, buckets.sets[character as usize].level_count - 1);
            let record = &buckets.records[bucket as usize];
            let indices = record.first_index..record.first_index + record.triangle_count * 3;
            (indices, bucket < buckets.count_16, record.vertex_offset as i32)
        });
        Ok(Self {
            bucket_sets: up.filled("bytes of the characters' buckets", &buckets.sets, storage, fewer)?,
            buckets: up.filled("bytes of buckets", &buckets.records, storage, fewer)?,
            bucket_counts: up.filled("bucket counts", &[buckets.counts()], Usage::UNIFORM, fewer)?,
            counts: buckets.counts(),
            discrete_levels: buckets.discrete_levels(),
            discrete: discrete_config(&data.characters),
            full_detail: full_detail.collect(),
            stand_ins: up.filled("bytes of dots", &dot_corners(data), Usage::VERTEX, fewer)?,
            indices_16: up.filled("bytes of 16-bit indices", &indices_16, Usage::INDEX, fewer)?,
            indices_32: up.filled("bytes of 32-bit indices", &buckets.indices_32, Usage::INDEX, fewer)?,
        })
    }

    /// The same with levels of points in the place of those of dots.
    pub(crate) fn with_points(&self, up: &mut Uploader<'_>, points: &PointTables) -> Result<Self> {
        let fewer = "put fewer characters into one pack";
        let storage = Usage::STORAGE;
        Ok(Self {
            buckets: up.filled("bytes of buckets with points", &points.records, storage, fewer)?,
            bucket_counts: up.filled("bucket counts with points", &[points.counts], Usage::UNIFORM, fewer)?,
            counts: points.counts,
            stand_ins: up.filled("bytes of points", &points.points, Usage::VERTEX, fewer)?,
            indices_32: up.filled("bytes of 32-bit indices", &points.indices_32, Usage::INDEX, fewer)?,
            ..self.clone()
        })
    }

    /// Bytes of the 32-bit indices.
    pub(crate) fn indices_32_bytes(&self) -> u64 {
        self.indices_32.size()
    }

    /// Sets the index buffer of 16-bit or of 32-bit indices.
    pub(crate) fn set_indices(&self, pass: &mut wgpu::RenderPass<'_>, is_narrow: bool) {
        match is_narrow {
            true => pass.set_index_buffer(self.indices_16.slice(..), wgpu::IndexFormat::Uint16),
            false => pass.set_index_buffer(self.indices_32.slice(..), wgpu::IndexFormat::Uint32),
        }
    }
}

/// More than one element of any array that a shader may be bound to and not read.
const WORDS_OF_NOTHING: u64 = 16;

/// What all techniques share of a frame.
#[derive(Clone)]
pub(crate) struct FrameBuffers {
    pub(crate) config: wgpu::Buffer,
    pub(crate) draw_config: wgpu::Buffer,
    pub(crate) instances: wgpu::Buffer,
    pub(crate) culled: wgpu::Buffer,
    pub(crate) block_sums: wgpu::Buffer,
    pub(crate) sums: wgpu::Buffer,
    pub(crate) wanted: wgpu::Buffer,
    pub(crate) block_wanted: wgpu::Buffer,
    /// Of `fill_budget`.
    pub(crate) block_counts: wgpu::Buffer,
    pub(crate) fill: wgpu::Buffer,
    pub(crate) choices: wgpu::Buffer,
    /// Zeros for bindings that a pipeline has and does not read: one element of any of them.
    pub(crate) nothing: wgpu::Buffer,
    pub(crate) totals: wgpu::Buffer,
}

impl FrameBuffers {
    pub(crate) fn new(up: &mut Uploader<'_>, max_instances: u32) -> Result<Self> {
        let fewer = "draw fewer instances";
        let n = u64::from(max_instances);
        let blocks = u64::from(max_instances.div_ceil(BLOCK_SIZE));
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let written = Usage::STORAGE | Usage::COPY_SRC;
        Ok(Self {
            config: up.empty::<FrameConfig>("frame config", 1, uniform, fewer)?,
            draw_config: up.empty::<DrawConfig>("draw config", 1, uniform, fewer)?,
            instances: up.empty::<InstanceRecord>("bytes of instances", n, Usage::STORAGE | Usage::COPY_DST, fewer)?,
            culled: up.empty::<CullRecord>("bytes of culling results", n, written, fewer)?,
            block_sums: up.empty::<WeightSums>("sums of blocks", blocks, written, fewer)?,
            sums: up.empty::<WeightSums>("sums", 1, written, fewer)?,
            wanted: up.empty::<u32>("wanted counts", n, written, fewer)?,
            block_wanted: up.empty::<u32>("wanted counts of blocks", blocks, written, fewer)?,
            block_counts: up.empty::<u32>(
                "counts of candidates",
                FillBudget::block_count_words(max_instances),
                written,
                fewer,
            )?,
            fill: up.empty::<FillState>("fill state", 1, written, fewer)?,
            choices: up.empty::<LodChoice>("choices", n, written, fewer)?,
            nothing: up.empty::<u32>("nothing", WORDS_OF_NOTHING, written, fewer)?,
            totals: up.empty::<FrameTotals>("totals", 1, written | Usage::COPY_DST, fewer)?,
        })
    }

    /// Tells the frame how high the water was in the one before, where it may stay and the caller has not said so.
    pub(crate) fn recall_water(&self, encoder: &mut wgpu::CommandEncoder, config: &FrameConfig) {
        if config.slack > 0 && config.water_before_bits == 0 {
            let (from, to) =
                (offset_of!(FillState, smooth_bits) as u64, offset_of!(FrameConfig, water_before_bits) as u64);
            encoder.copy_buffer_to_buffer(&self.fill, from, &self.config, to, 4);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_neither_single_layers_nor_cubes() {
        let square: Vec<u32> = [0, 1, 2, 5, 6, 7, 12].map(|count| array_layers(count, true)).to_vec();
        assert_eq!(square, [2, 2, 2, 5, 7, 7, 13]);
        assert_eq!(array_layers(6, false), 6);
    }
}
