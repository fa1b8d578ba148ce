//! Two-phase occlusion culling: who was not hidden in the last frame is drawn first; its depth becomes a pyramid, and of the
//! others who is not hidden by that is drawn after. So nothing visible is missed, whatever moved since.

use super::kernel::Gate;
use super::selection::Selection;
use super::stage_recorder::StageRecorder;
use super::targets::DepthWay;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use super::{BoundPyramid, BuildPyramid, FillBudget, JoinPhases, RecallSeen, SumWeights, TestOcclusion};
use crate::dispatch::BLOCK_SIZE;
use crate::{DrawOptions, FillState, FrameConfig, FrameTotals, PyramidConfig, Result, SightTally, Weight, WeightSums};
use wgpu::BufferUsages as Usage;

/// The stages of both phases around the technique's own, and what is remembered from frame to frame.
pub(crate) struct Occlusion {
    /// The number of instances it is valid for, then a word for each.
    seen: wgpu::Buffer,
    tally: wgpu::Buffer,
    /// Arguments of the second phase's dispatches, zeros where nobody waits for it.
    gate: wgpu::Buffer,
    /// What the second phase writes only if somebody waits.
    second_sums: wgpu::Buffer,
    /// What the first phase came to, and of the newest phase.
    first_totals: wgpu::Buffer,
    totals: wgpu::Buffer,
    recall: (RecallSeen, wgpu::BindGroup),
    /// The shared selection with what is left of the budget.
    first: Selection,
    build: BuildPyramid,
    test: TestOcclusion,
    sum: (SumWeights, wgpu::BindGroup),
    join: (JoinPhases, wgpu::BindGroup),
    fill: FillBudget,
    fill_quantized: wgpu::BindGroup,
    fill_by_error: wgpu::BindGroup,
    pyramid: Option<Pyramid>,
}

/// What depends on the picture's size.
struct Pyramid {
    depth: wgpu::TextureView,
    config: PyramidConfig,
    uniform: wgpu::Buffer,
    build: BoundPyramid,
    test: wgpu::BindGroup,
    farthest: wgpu::Buffer,
}

impl Occlusion {
    pub(crate) fn new(up: &mut Uploader<'_>, c: &CrowdBuffers, f: &FrameBuffers, max_instances: u32) -> Result<Self> {
        let fewer = "draw fewer instances";
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let device = up.device;
        let seen = up.empty::<u32>("who was seen", u64::from(max_instances) + 1, written, fewer)?;
        let tally = up.empty::<SightTally>("sight tally", 1, written, fewer)?;
        let blocks = max_instances.div_ceil(BLOCK_SIZE).into();
        let tallies = up.empty::<SightTally>("sight tallies of blocks", blocks, written, fewer)?;
        let first_config = up.empty::<FrameConfig>("first frame config", 1, written | Usage::UNIFORM, fewer)?;
        let cleared = written | Usage::COPY_DST;
        let gate = up.empty::<u32>("gate of the second phase", 9, written | Usage::INDIRECT, fewer)?;
        let second_sums = up.empty::<WeightSums>("second sums", 1, cleared, fewer)?;
        let second_fill = up.empty::<FillState>("second fill state", 1, written, fewer)?;
        let first_totals = up.empty::<FrameTotals>("first totals", 1, cleared, fewer)?;

        let recall = RecallSeen::new(device);
        let recall_bound = recall.bind(
            device,
            &f.config,
            &f.instances,
            &c.characters,
            &seen,
            &f.culled,
            &tallies,
            &tally,
            &first_config,
            &gate,
        );
        let sum = SumWeights::new(device);
        let sum_bound = sum.bind(device, &f.config, &c.characters, &f.culled, &f.block_sums, &second_sums);
        let join = JoinPhases::new(device);
        let join_bound = join.bind(
            device,
            &f.config,
            &f.sums,
            &second_sums,
            &f.fill,
            &tally,
            &second_fill,
            &first_totals,
            &f.totals,
        );
        let fill = FillBudget::new(device);
        let fill_to = |lods| {
            let (config, counts) = (&f.config, &f.block_counts);
            let (fill_state, sums) = (&second_fill, &second_sums);
            let characters = &c.characters;
            fill.bind(device, config, characters, lods, &f.culled, counts, fill_state, sums, &f.choices)
        };
        let [fill_quantized, fill_by_error] = [&c.quantized_lods, &c.error_lods].map(fill_to);
        let first = Selection::new(device, c, &FrameBuffers { config: first_config, ..f.clone() });
        Ok(Self {
            seen,
            tally,
            gate,
            second_sums,
            first_totals,
            totals: f.totals.clone(),
            recall: (recall, recall_bound),
            first,
            build: BuildPyramid::new(device),
            test: TestOcclusion::new(device),
            sum: (sum, sum_bound),
            join: (join, join_bound),
            fill,
            fill_quantized,
            fill_by_error,
            pyramid: None,
        })
    }

    /// Makes the pyramid of a depth texture, unless it is there. Engines may make views anew each frame: of the same size they cost
    /// one bind group.
    pub(crate) fn fit(
        &mut self,
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        (depth, way): (&wgpu::TextureView, DepthWay),
        (width, height): (u32, u32),
        sample_count: u32,
    ) -> Result<()> {
        let reversed = way.reversed.into();
        let config = PyramidConfig { reversed, ..PyramidConfig::new(width, height, sample_count) };
        if let Some(pyramid) = self.pyramid.as_mut().filter(|pyramid| pyramid.config == config) {
            if pyramid.depth != *depth {
                let readable = way.readable(depth);
                self.build.rebind_depth(up.device, &mut pyramid.build, &pyramid.uniform, &pyramid.farthest, &readable);
                pyramid.depth = depth.clone();
            }
            return Ok(());
        }
        self.pyramid = None;
        let smaller = "draw a smaller picture";
        let uniform = up.filled("pyramid config", &[config], Usage::UNIFORM, smaller)?;
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let farthest = up.empty::<f32>("bytes of the depth pyramid", config.number_count().into(), written, smaller)?;
        let build = self.build.bind(up.device, config, &uniform, &farthest, &way.readable(depth));
        let test = self.test.bind(
            up.device,
            &f.config,
            &uniform,
            &f.instances,
            &c.characters,
            &c.clips,
            &farthest,
            &f.culled,
            &self.seen,
        );
        self.pyramid = Some(Pyramid { depth: depth.clone(), config, uniform, build, test, farthest });
        Ok(())
    }

    /// Levels of all in the frustum but those who were hidden.
    pub(crate) fn record_first(
        &self,
        recorder: &mut StageRecorder<'_>,
        culling: &Selection,
        config: &FrameConfig,
        options: &DrawOptions,
    ) {
        let count = config.instance_count;
        culling.record_culling(recorder, count);
        recorder.stage("recall_seen", |pass| self.recall.0.record(pass, &self.recall.1, count));
        self.first.record_levels(recorder, config, options);
    }

    /// After the first phase is drawn: levels of those who come into sight. `is_gated`: everything between the test and the draw goes by the gate, so it
    /// takes no time where nobody waits.
    pub(crate) fn record_second(&self, recorder: &mut StageRecorder<'_>, config: &FrameConfig, is_gated: bool) {
        let count = config.instance_count;
        let pyramid = self.pyramid.as_ref().expect("fit comes first");
        // What is left as it is if nobody waits.
        let encoder = &mut *recorder.encoder;
        encoder.copy_buffer_to_buffer(&self.totals, 0, &self.first_totals, 0, size_of::<FrameTotals>() as u64);
        for buffer in [&self.totals, &self.second_sums] {
            encoder.clear_buffer(buffer, 0, None);
        }
        let gate = self.gate().filter(|_| is_gated);
        recorder.stage("build_pyramid", |pass| self.build.record(pass, &pyramid.build));
        recorder.stage("test_occlusion", |pass| self.test.record(pass, &pyramid.test, count));
        recorder.stage("sum_weights", |pass| self.sum.0.record_gated(pass, &self.sum.1, count, gate));
        recorder.stage("join_phases", |pass| self.join.0.record_gated_begin(pass, &self.join.1, gate));
        let by_error = config.weight == Weight::Error as u32;
        let bound = if by_error { &self.fill_by_error } else { &self.fill_quantized };
        recorder.stage("fill_budget", |pass| self.fill.record_gated_steps(pass, bound, count, gate));
    }

    /// What the second phase's dispatches may go by.
    pub(crate) fn gate(&self) -> Gate<'_> {
        Some(&self.gate)
    }

    /// What both phases came to.
    pub(crate) fn record_join(&self, recorder: &mut StageRecorder<'_>) {
        recorder.stage("join_phases", |pass| self.join.0.record_join(pass, &self.join.1));
    }

    /// Bytes of what depends on the picture's size.
    pub(crate) fn pyramid_bytes(&self) -> u64 {
        self.pyramid.as_ref().map_or(0, |pyramid| size_of::<PyramidConfig>() as u64 + pyramid.farthest.size())
    }

    pub(crate) fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "seen" => Some(&self.seen),
            "tally" => Some(&self.tally),
            "farthest" => Some(&self.pyramid.as_ref()?.farthest),
            _ => None,
        }
    }
}
