//! Palettes blended and vertices skinned before the draw: each once, however many passes read them.

use super::bucket_draws::{BucketDraws, Lists};
use super::pose_sharing::PoseSharing;
use super::renderer::RendererOptions;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use super::{BlendPalettes, PlaceBuckets, SkinVertices};
use crate::{BucketCounts, Capacities, DispatchArgs, Result, SkinnedVertex};
use wgpu::BufferUsages as Usage;

/// Palettes and skinned vertices of a frame, and the stages that write them.
pub(crate) struct PreSkinning {
    pub(crate) palettes: wgpu::Buffer,
    pub(crate) skinned: wgpu::Buffer,
    dispatch: wgpu::Buffer,
    capacities: wgpu::Buffer,
    place_buckets: (PlaceBuckets, wgpu::BindGroup),
    blend_palettes: (BlendPalettes, wgpu::BindGroup),
    skin_vertices: (SkinVertices, wgpu::BindGroup),
    palette_rows: u32,
    /// Palettes there is room for.
    palette_slots: u32,
    /// Somebody may have none.
    pub(crate) lacks_palettes: bool,
    /// Somebody's vertices may have no place though there are no more than the renderer may draw.
    pub(crate) lacks_places: bool,
    shared: Option<Shared>,
}

/// Vertices there is room for, of those that the renderer may draw, where shaders bind that many bytes.
pub(crate) fn skinned_room(max_vertices: u32, largest_binding: u64) -> u32 {
    u32::try_from(largest_binding / size_of::<SkinnedVertex>() as u64).unwrap_or(u32::MAX).min(max_vertices)
}

/// The same stages where poses are shared.
struct Shared {
    sharing: PoseSharing,
    place_buckets: wgpu::BindGroup,
    blend_palettes: wgpu::BindGroup,
    skin_vertices: wgpu::BindGroup,
}

impl PreSkinning {
    /// Room for the palettes of all instances and for as many vertices as the renderer may draw, as far as the device binds them: the vertex
    /// shader does the rest.
    ///
    /// # Errors
    /// [`crate::Error::OutOfMemory`] where the device has no room.
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
        let BucketCounts { palette_rows, palette_slots, .. } = c.tables.counts;
        let palette_slots = palette_slots.min(options.max_instances);
        let rows = u64::from(palette_slots) * u64::from(palette_rows);
        let vertex_count = skinned_room(options.max_vertices, up.largest_binding());
        let lacks_palettes = palette_slots < options.max_instances;
        let lacks_places = lacks_palettes || vertex_count < options.max_vertices;
        let palettes = up.empty::<[f32; 4]>("bytes of palettes", rows, written, remedy)?;
        let skinned = up.empty::<SkinnedVertex>("bytes of skinned vertices", vertex_count.into(), written, remedy)?;
        let dispatch = up.empty::<DispatchArgs>("groups that skin", 1, written | Usage::INDIRECT, remedy)?;
        let capacities = Capacities { vertex_count, triangle_count: options.max_triangles, ..Default::default() };
        let capacities = up.filled("capacities", &[capacities], Usage::UNIFORM, remedy)?;

        let Lists { sorted_keys, drawn, ranges, places, .. } = draws.lists();
        let place = PlaceBuckets::new(up.device, lacks_places);
        let buckets = &c.tables.buckets;
        let place_bound = place.bind(up.device, counts, &capacities, buckets, ranges, places, &dispatch, &f.totals);
        let blend = BlendPalettes::new(up.device, c.joint_storages);
        let blend_bound = blend.bind(up.device, &f.config, counts, sorted_keys, drawn, &c.animation, &palettes, None);
        let skin = SkinVertices::new(up.device);
        let skin_bound =
            skin.bind(up.device, counts, places, drawn, &c.vertices, &c.origins, &palettes, &skinned, None);
        Ok(Self {
            palettes,
            skinned,
            dispatch,
            place_buckets: (place, place_bound),
            blend_palettes: (blend, blend_bound),
            skin_vertices: (skin, skin_bound),
            palette_rows,
            palette_slots,
            lacks_palettes,
            lacks_places,
            shared: None,
            capacities,
        })
    }

    /// Sets up what sharing poses needs, unless it is.
    ///
    /// # Errors
    /// Those of [`PoseSharing::new`].
    pub(crate) fn prepare_sharing(
        &mut self,
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        max_instances: u32,
        draws: &BucketDraws,
    ) -> Result<()> {
        if self.shared.is_some() {
            return Ok(());
        }
        let sharing = PoseSharing::new(up, c, f, max_instances, draws)?;
        let Lists { sorted_keys, drawn, places, .. } = draws.lists();
        let Self { palettes, skinned, dispatch, capacities, .. } = &*self;
        let (counts, buckets) = (&c.tables.bucket_counts, &c.tables.buckets);
        let (place, ranges) = (&self.place_buckets.0, &sharing.leader_ranges);
        let place_buckets = place.bind(up.device, counts, capacities, buckets, ranges, places, dispatch, &f.totals);
        let (blend, leaders) = (&self.blend_palettes.0, Some([&sharing.leaders, &sharing.leader_end]));
        let blend_palettes =
            blend.bind(up.device, &f.config, counts, sorted_keys, drawn, &c.animation, palettes, leaders);
        let (skin, leaders) = (&self.skin_vertices.0, Some(&sharing.leaders));
        let skin_vertices =
            skin.bind(up.device, counts, places, drawn, &c.vertices, &c.origins, palettes, skinned, leaders);
        self.shared = Some(Shared { sharing, place_buckets, blend_palettes, skin_vertices });
        Ok(())
    }

    /// After the buckets' keys: everything up to the vertices, each pose once.
    pub(crate) fn record_shared(
        &self,
        recorder: &mut StageRecorder<'_>,
        draws: &BucketDraws,
        count: u32,
        with_vertices: bool,
    ) {
        let shared = self.shared.as_ref().expect("prepared before the frame");
        shared.sharing.record_sort(recorder, count);
        draws.record_arguments(recorder, count);
        shared.sharing.record_ranges(recorder, count);
        if with_vertices {
            let place = &self.place_buckets.0;
            recorder.stage("place_buckets", |pass| place.record(pass, &shared.place_buckets));
        }
        draws.record_listed(recorder, count);
        shared.sharing.record_followers(recorder, count);
        let (blend, slots) = (&self.blend_palettes.0, count.min(self.palette_slots));
        let blend_bound = &shared.blend_palettes;
        recorder.stage("blend_palettes", |pass| blend.record_leaders(pass, blend_bound, slots, self.palette_rows));
        if with_vertices {
            let skin = &self.skin_vertices.0;
            recorder.stage("skin_vertices", |pass| skin.record_leaders(pass, &shared.skin_vertices, &self.dispatch));
        }
    }

    /// After the draw arguments: what vertices need to know of those who are drawn, as `record_drawn` has it, their palettes and, if asked
    /// for, their vertices.
    pub(crate) fn record(
        &self,
        recorder: &mut StageRecorder<'_>,
        record_drawn: impl FnOnce(&mut StageRecorder<'_>),
        count: u32,
        with_vertices: bool,
    ) {
        let (place, place_bound) = &self.place_buckets;
        if with_vertices {
            recorder.stage("place_buckets", |pass| place.record(pass, place_bound));
        }
        record_drawn(recorder);
        let ((blend, blend_bound), slots) = (&self.blend_palettes, count.min(self.palette_slots));
        recorder.stage("blend_palettes", |pass| blend.record(pass, blend_bound, slots, self.palette_rows));
        let (skin, skin_bound) = &self.skin_vertices;
        if with_vertices {
            recorder.stage("skin_vertices", |pass| skin.record(pass, skin_bound, &self.dispatch));
        }
    }

    pub(crate) fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "palettes" => Some(&self.palettes),
            "skinned" => Some(&self.skinned),
            "leaders" => self.shared.as_ref().map(|shared| &shared.sharing.leaders),
            "leader_end" => self.shared.as_ref().map(|shared| &shared.sharing.leader_end),
            _ => None,
        }
    }
}
