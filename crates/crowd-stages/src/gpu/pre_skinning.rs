//! Palettes blended and vertices skinned before the draw: each once, however many passes read them.

use super::bucket_draws::{BucketDraws, Lists};
use super::renderer::RendererOptions;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use super::{BlendPalettes, PlaceBuckets, SkinVertices};
use crate::{Capacities, DispatchArgs, Result, SkinnedVertex};
use wgpu::BufferUsages as Usage;

/// Palettes and skinned vertices of a frame, and the stages that write them.
pub(crate) struct PreSkinning {
    pub(crate) palettes: wgpu::Buffer,
    pub(crate) skinned: wgpu::Buffer,
    dispatch: wgpu::Buffer,
    place_buckets: (PlaceBuckets, wgpu::BindGroup),
    blend_palettes: (BlendPalettes, wgpu::BindGroup),
    skin_vertices: (SkinVertices, wgpu::BindGroup),
    palette_rows: u32,
}

impl PreSkinning {
    /// Room for the palettes of all instances and for as many vertices as the renderer may draw.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] where one of the two is larger than the device can bind.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        options: &RendererOptions,
        draws: &BucketDraws,
    ) -> Result<Self> {
        let remedy = "use --skinning vertex";
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let counts = &c.tables.bucket_counts;
        let palette_rows = c.tables.counts.palette_rows;
        let rows = u64::from(options.max_instances) * u64::from(palette_rows);
        let vertex_count = options.max_vertices;
        let palettes = up.empty::<[f32; 4]>("bytes of palettes", rows, written, remedy)?;
        let skinned = up.empty::<SkinnedVertex>("bytes of skinned vertices", vertex_count.into(), written, remedy)?;
        let dispatch = up.empty::<DispatchArgs>("groups that skin", 1, written | Usage::INDIRECT, remedy)?;
        let capacities = Capacities { vertex_count, triangle_count: options.max_triangles, ..Default::default() };
        let capacities = up.filled("capacities", &[capacities], Usage::UNIFORM, remedy)?;

        let Lists { sorted_keys, drawn, ranges, places } = draws.lists();
        let place = PlaceBuckets::new(up.device);
        let buckets = &c.tables.buckets;
        let place_bound = place.bind(up.device, counts, &capacities, buckets, ranges, places, &dispatch, &f.totals);
        let blend = BlendPalettes::new(up.device, c.joint_storages);
        let blend_bound = blend.bind(up.device, &f.config, counts, sorted_keys, drawn, &c.animation, &palettes);
        let skin = SkinVertices::new(up.device);
        let skin_bound = skin.bind(up.device, counts, places, drawn, &c.vertices, &c.origins, &palettes, &skinned);
        Ok(Self {
            palettes,
            skinned,
            dispatch,
            place_buckets: (place, place_bound),
            blend_palettes: (blend, blend_bound),
            skin_vertices: (skin, skin_bound),
            palette_rows,
        })
    }

    /// After the draw arguments: what vertices need to know of those who are drawn, their palettes and, if asked for, their
    /// vertices.
    pub(crate) fn record(
        &self,
        recorder: &mut StageRecorder<'_>,
        draws: &BucketDraws,
        count: u32,
        with_vertices: bool,
    ) {
        let (place, place_bound) = &self.place_buckets;
        if with_vertices {
            recorder.stage("place_buckets", |pass| place.record(pass, place_bound));
        }
        draws.record_drawn(recorder, count);
        let (blend, blend_bound) = &self.blend_palettes;
        recorder.stage("blend_palettes", |pass| blend.record(pass, blend_bound, count, self.palette_rows));
        let (skin, skin_bound) = &self.skin_vertices;
        if with_vertices {
            recorder.stage("skin_vertices", |pass| skin.record(pass, skin_bound, &self.dispatch));
        }
    }

    pub(crate) fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "palettes" => Some(&self.palettes),
            "skinned" => Some(&self.skinned),
            _ => None,
        }
    }
}
