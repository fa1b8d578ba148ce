//! Instances sorted into buckets and drawn with one indirect draw each: what the instanced techniques share.

use super::kernel::{Gate, is_software};
use super::renderer::RendererOptions;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, LevelTables, Uploader};
use super::vertex_inputs::{MESH_LAYOUT, ORIGIN_LAYOUT, OWNER_LAYOUT};
use super::{GatherDrawn, KeyInstances, SortAtOnce, SortInstances, WriteBucketArgs};
use crate::{BucketPlace, BucketRange, DrawArgs, DrawCounts, DrawnInstance, MorphRecord, Result, SortPass};
use std::mem::size_of;
use std::ops::Range;
use wgpu::BufferUsages as Usage;

/// Stages from levels to draw arguments, and the draws.
pub(crate) struct BucketDraws {
    keys: wgpu::Buffer,
    morphs: wgpu::Buffer,
    sorted_keys: wgpu::Buffer,
    sorted: wgpu::Buffer,
    drawn: wgpu::Buffer,
    ranges: wgpu::Buffer,
    places: wgpu::Buffer,
    draw_args: wgpu::Buffer,
    draw_counts: wgpu::Buffer,
    key_instances: (KeyInstances, wgpu::BindGroup),
    sort: Sort,
    write_bucket_args: (WriteBucketArgs, wgpu::BindGroup),
    gather_drawn: (GatherDrawn, wgpu::BindGroup),
    /// The same in the order of the instances, where the sort says who stands where.
    scattered: Option<wgpu::BindGroup>,
    tables: LevelTables,
    /// The adapter takes the number of draws from a buffer.
    counts_draws: bool,
}

/// How they are sorted.
enum Sort {
    /// Digit after digit.
    ByDigits { stage: SortInstances, passes: Vec<(SortPass, wgpu::BindGroup)> },
    /// In one pass; it says who stands where, so those drawn may be gathered in the order of the instances.
    AtOnce { stage: SortAtOnce, bound: wgpu::BindGroup, entries: wgpu::Buffer },
}

impl Sort {
    /// With the buffers of the sorted keys and of the sorted instances.
    fn new(
        up: &mut Uploader<'_>,
        f: &FrameBuffers,
        tables: &LevelTables,
        max_instances: u32,
        keys: &wgpu::Buffer,
        ranges: &wgpu::Buffer,
    ) -> Result<(Self, wgpu::Buffer, wgpu::Buffer)> {
        let device = up.device;
        let fewer = "draw fewer instances";
        let bucket_count = tables.counts.bucket_count;
        let mut words = |what, count| up.empty::<u32>(what, count, Usage::STORAGE | Usage::COPY_SRC, fewer);
        let n = u64::from(max_instances);
        let (sorted_keys, sorted) = (words("sorted keys", n)?, words("sorted", n)?);
        if SortAtOnce::suits(is_software(device), bucket_count) {
            let entries = words("places in the sorted list", n)?;
            let counts = words("counts of keys", SortAtOnce::count_words(max_instances, bucket_count))?;
            let stage = SortAtOnce::new(device);
            let (config, buckets) = (&f.config, &tables.bucket_counts);
            let bound = stage.bind(device, config, buckets, keys, &counts, &sorted_keys, &sorted, &entries, ranges);
            return Ok((Self::AtOnce { stage, bound, entries }, sorted_keys, sorted));
        }
        // One pair of buffers for each pass but the first, which reads the keys: two are enough.
        let other = (words("sorted keys", n)?, words("sorted", n)?);
        let counts = words("counts of digits", SortInstances::digit_count_words(max_instances))?;
        let last = (sorted_keys, sorted);
        let stage = SortInstances::new(device);
        let sort_passes = SortInstances::passes(bucket_count);
        let count = sort_passes.len();
        let mut passes = Vec::new();
        for (number, pass) in sort_passes.into_iter().enumerate() {
            let uniform = up.filled("sort pass", &[pass], Usage::UNIFORM, fewer)?;
            let ((from_keys, from), into) = if (count - number) % 2 == 1 { (&other, &last) } else { (&last, &other) };
            let from_keys = if number == 0 { keys } else { from_keys };
            let bound = stage.bind(device, &f.config, &uniform, from_keys, from, &counts, &into.0, &into.1);
            passes.push((pass, bound));
        }
        Ok((Self::ByDigits { stage, passes }, last.0, last.1))
    }
}

/// What stages between the sorted list and the draws read and write.
#[derive(Clone, Copy)]
pub(crate) struct Lists<'a> {
    pub(crate) keys: &'a wgpu::Buffer,
    pub(crate) morphs: &'a wgpu::Buffer,
    pub(crate) sorted_keys: &'a wgpu::Buffer,
    pub(crate) sorted: &'a wgpu::Buffer,
    pub(crate) drawn: &'a wgpu::Buffer,
    pub(crate) ranges: &'a wgpu::Buffer,
    pub(crate) places: &'a wgpu::Buffer,
}

impl BucketDraws {
    /// Vertex buffers of the entry point `bucketed`.
    pub(crate) const INPUTS: [Option<wgpu::VertexBufferLayout<'static>>; 3] =
        [Some(MESH_LAYOUT), None, Some(OWNER_LAYOUT)];
    /// The same of `bucketed_morphing`.
    pub(crate) const MORPHING_INPUTS: [Option<wgpu::VertexBufferLayout<'static>>; 3] =
        [Some(MESH_LAYOUT), Some(ORIGIN_LAYOUT), Some(OWNER_LAYOUT)];

    /// `sums`: of the budget's stages, or zeros where there is no budget.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        options: &RendererOptions,
        sums: &wgpu::Buffer,
    ) -> Result<Self> {
        Self::of_tables(up, c, c.tables.clone(), f, options, sums)
    }

    /// The same for other tables than the crowd's own.
    pub(crate) fn of_tables(
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        tables: LevelTables,
        f: &FrameBuffers,
        options: &RendererOptions,
        sums: &wgpu::Buffer,
    ) -> Result<Self> {
        let fewer = "draw fewer instances";
        let n = u64::from(options.max_instances);
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let indirect = written | Usage::INDIRECT | Usage::COPY_DST;
        let bucket_count = tables.counts.bucket_count;
        let keys = up.empty::<u32>("keys", n, written, fewer)?;
        let morphs = up.empty::<MorphRecord>("morphs", n, written, fewer)?;
        let ranges = up.empty::<BucketRange>("ranges of buckets", bucket_count.into(), written, fewer)?;
        let draw_args = up.empty::<DrawArgs>("draw arguments", bucket_count.into(), indirect, fewer)?;
        let draw_counts = up.empty::<DrawCounts>("counts of draws", 1, indirect, fewer)?;
        let places = up.empty::<BucketPlace>("places of buckets", u64::from(bucket_count) + 1, written, fewer)?;

        let (sort, sorted_keys, sorted) = Sort::new(up, f, &tables, options.max_instances, &keys, &ranges)?;
        let key = match is_software(up.device) {
            true => KeyInstances::with_dots(up.device, c.dot_reach),
            false => KeyInstances::new(up.device),
        };
        let key_bound = key.bind(
            up.device,
            &f.config,
            &tables.bucket_counts,
            &f.instances,
            &tables.bucket_sets,
            &tables.buckets,
            &f.culled,
            &f.choices,
            &f.fill,
            &keys,
            &morphs,
        );
        let write = WriteBucketArgs::new(up.device);
        let write_bound = write.bind(
            up.device,
            &f.config,
            &tables.bucket_counts,
            sums,
            &tables.buckets,
            &sorted_keys,
            &ranges,
            &draw_args,
            &draw_counts,
            &f.totals,
        );
        let drawn = up.empty::<DrawnInstance>("drawn instances", n, written | Usage::VERTEX, fewer)?;
        let gather = GatherDrawn::new(up.device);
        let gather_bound = |listed_keys, listed| {
            let (device, counts) = (up.device, &tables.bucket_counts);
            let (characters, clips, morphs) = (&c.characters, &c.clips, &morphs);
            let (config, instances) = (&f.config, &f.instances);
            gather.bind(
                device,
                config,
                counts,
                instances,
                characters,
                clips,
                morphs,
                listed_keys,
                listed,
                &places,
                &drawn,
            )
        };
        let listed = gather_bound(&sorted_keys, &sorted);
        let scattered = match &sort {
            Sort::AtOnce { entries, .. } => Some(gather_bound(&keys, entries)),
            Sort::ByDigits { .. } => None,
        };
        Ok(Self {
            keys,
            morphs,
            sorted_keys,
            sorted,
            drawn,
            ranges,
            places,
            draw_args,
            draw_counts,
            key_instances: (key, key_bound),
            sort,
            scattered,
            write_bucket_args: (write, write_bound),
            gather_drawn: (gather, listed),
            tables,
            counts_draws: up.device.features().contains(wgpu::Features::MULTI_DRAW_INDIRECT_COUNT),
        })
    }

    /// For stages that go on from the sorted list.
    pub(crate) fn lists(&self) -> Lists<'_> {
        let Self { keys, morphs, sorted_keys, sorted, drawn, ranges, places, .. } = self;
        Lists { keys, morphs, sorted_keys, sorted, drawn, ranges, places }
    }

    /// For a stage that writes the keys itself.
    pub(crate) fn keys(&self) -> &wgpu::Buffer {
        &self.keys
    }

    /// Keys of full detail.
    pub(crate) fn record_full_detail_keys(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (key, bound) = &self.key_instances;
        recorder.stage("key_instances", |pass| key.record_full_detail(pass, bound, count));
    }

    /// Keys from the levels chosen.
    pub(crate) fn record_keys(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (key, bound) = &self.key_instances;
        recorder.stage("key_instances", |pass| key.record(pass, bound, count));
    }

    /// Whether [`Self::record_gated`] can be used: sorting by digits has dispatches that no gate knows.
    pub(crate) fn can_be_gated(&self) -> bool {
        matches!(self.sort, Sort::AtOnce { .. })
    }

    /// Everything from keys to what vertices need to know, as far as the gate lets through; behind a shut one nothing is drawn.
    pub(crate) fn record_gated(&self, recorder: &mut StageRecorder<'_>, count: u32, gate: Gate<'_>) {
        let Sort::AtOnce { stage: sort, bound: sort_bound, .. } = &self.sort else { return };
        let Some(gather_bound) = &self.scattered else { return };
        let nothing = if self.counts_draws { &self.draw_counts } else { &self.draw_args };
        recorder.encoder.clear_buffer(nothing, 0, None);
        let (key, key_bound) = &self.key_instances;
        recorder.stage("key_instances", |pass| key.record_gated(pass, key_bound, count, gate));
        recorder.stage("sort_at_once", |pass| sort.record_gated(pass, sort_bound, count, gate));
        let (write, write_bound) = &self.write_bucket_args;
        recorder.stage("write_bucket_args", |pass| write.record_gated_args(pass, write_bound, gate));
        recorder.stage("gather_drawn", |pass| self.gather_drawn.0.record_gated(pass, gather_bound, count, gate));
    }

    /// From keys to draw arguments.
    pub(crate) fn record_sort(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        match &self.sort {
            Sort::ByDigits { stage, passes } => {
                recorder.stage("sort_instances", |compute| {
                    for (pass, bound) in passes {
                        stage.record(compute, bound, pass, count);
                    }
                });
                self.record_arguments(recorder, count);
            }
            Sort::AtOnce { stage, bound, .. } => {
                recorder.stage("sort_at_once", |pass| stage.record(pass, bound, count));
                let (write, bound) = &self.write_bucket_args;
                recorder.stage("write_bucket_args", |pass| write.record_args(pass, bound));
            }
        }
    }

    /// Draw arguments of a sorted list.
    pub(crate) fn record_arguments(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (write, bound) = &self.write_bucket_args;
        recorder.stage("write_bucket_args", |pass| write.record(pass, bound, count, self.tables.counts.bucket_count));
    }

    /// What vertices need to know of those who are drawn, after the sort.
    pub(crate) fn record_drawn(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        match &self.scattered {
            Some(bound) => {
                recorder.stage("gather_drawn", |pass| self.gather_drawn.0.record_scattered(pass, bound, count));
            }
            None => self.record_listed(recorder, count),
        }
    }

    /// The same for a list that is there already, or that others have written.
    pub(crate) fn record_listed(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (gather, bound) = &self.gather_drawn;
        recorder.stage("gather_drawn", |pass| gather.record(pass, bound, count));
    }

    /// One multi-draw of meshes for each width of indices. Pipeline and bind group are set.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, crowd: &CrowdBuffers) {
        pass.set_vertex_buffer(0, crowd.vertices.slice(..));
        pass.set_vertex_buffer(1, crowd.origins.slice(..));
        pass.set_vertex_buffer(2, self.drawn.slice(..));
        let counts = &self.tables.counts;
        self.tables.set_indices(pass, true);
        self.draw_kind(pass, 0..counts.count_16, 0);
        self.tables.set_indices(pass, false);
        self.draw_kind(pass, counts.count_16..counts.mesh_count, 4);
    }

    /// One multi-draw for dots or points. Pipeline and bind group are set.
    pub(crate) fn draw_stand_ins(&self, pass: &mut wgpu::RenderPass<'_>) {
        let counts = &self.tables.counts;
        pass.set_vertex_buffer(0, self.tables.stand_ins.slice(..));
        pass.set_vertex_buffer(2, self.drawn.slice(..));
        self.tables.set_indices(pass, false);
        self.draw_kind(pass, counts.mesh_count..counts.first_impostor, 8);
    }

    /// One multi-draw for impostors and one for those who cross over to them, each with its pipeline. Bind groups are set.
    pub(crate) fn draw_impostors(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        vertices: &wgpu::Buffer,
        [alone, fading]: [&wgpu::RenderPipeline; 2],
    ) {
        let counts = &self.tables.counts;
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_vertex_buffer(2, self.drawn.slice(..));
        self.tables.set_indices(pass, false);
        pass.set_pipeline(alone);
        self.draw_kind(pass, counts.first_impostor..counts.first_fade, 12);
        pass.set_pipeline(fading);
        self.draw_kind(pass, counts.first_fade..counts.bucket_count, 16);
    }

    /// `count_offset`: of how many of them draw anything, in the counts of draws.
    fn draw_kind(&self, pass: &mut wgpu::RenderPass<'_>, buckets: Range<u32>, count_offset: u64) {
        let most = buckets.end - buckets.start;
        if most == 0 {
            return;
        }
        let offset = u64::from(buckets.start) * size_of::<DrawArgs>() as u64;
        if self.counts_draws {
            let (args, counts) = (&self.draw_args, &self.draw_counts);
            pass.multi_draw_indexed_indirect_count(args, offset, counts, count_offset, most);
        } else {
            pass.multi_draw_indexed_indirect(&self.draw_args, offset, most);
        }
    }

    pub(crate) fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "keys" => Some(&self.keys),
            "morphs" => Some(&self.morphs),
            "sorted_keys" => Some(&self.sorted_keys),
            "sorted_values" => Some(&self.sorted),
            "ranges" => Some(&self.ranges),
            "places" => Some(&self.places),
            "drawn" => Some(&self.drawn),
            "draw_args" => Some(&self.draw_args),
            "draw_counts" => Some(&self.draw_counts),
            _ => None,
        }
    }
}
