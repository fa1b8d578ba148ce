//! What most techniques share: culling, Eq. 1 and the budget, from the instances to one level for each.

use super::kernel::is_software;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers};
use super::{CullInstances, FillBudget, FitBudget, SelectLod, SumWeights};
use crate::{DrawOptions, Fit, FrameConfig, Levels, Weight};

/// From so many instances on most of a picture's are dots, and are counted first; smaller crowds would be gone over twice for little.
const MANY: u32 = 1 << 16;

/// The shared stages with their buffers bound.
pub(crate) struct Selection {
    cull_instances: (CullInstances, wgpu::BindGroup),
    sum_weights: (SumWeights, wgpu::BindGroup),
    select_lod: (SelectLod, wgpu::BindGroup),
    fill_budget: FillBudget,
    fill_continuous: wgpu::BindGroup,
    fill_quantized: wgpu::BindGroup,
    fill_by_error: wgpu::BindGroup,
    fit_budget: FitBudget,
    fit_continuous: wgpu::BindGroup,
    fit_quantized: wgpu::BindGroup,
}

impl Selection {
    pub(crate) fn new(device: &wgpu::Device, c: &CrowdBuffers, f: &FrameBuffers) -> Self {
        let cull = CullInstances::new(device);
        let sum = SumWeights::new(device);
        let select = SelectLod::new(device);
        let fit = FitBudget::new(device);
        let config = &f.config;
        let cull_bound = cull.bind(device, config, &f.instances, &c.characters, &c.clips, &f.culled);
        let sum_bound = sum.bind(device, config, &c.characters, &f.culled, &f.block_sums, &f.sums);
        let select_bound = select.bind(device, config, &f.instances, &c.characters, &f.culled, &f.sums, &f.wanted);
        let fit_to = |lods| {
            let (blocks, choices) = (&f.block_wanted, &f.choices);
            fit.bind(device, config, &f.instances, &c.characters, lods, &f.wanted, blocks, &f.sums, choices)
        };
        let (fit_continuous, fit_quantized) = (fit_to(&c.lods), fit_to(&c.quantized_lods));
        let fill = match is_software(device) {
            true => FillBudget::with_dots(device, c.dot_reach),
            false => FillBudget::new(device),
        };
        let fill_to = |lods| {
            let (characters, counts) = (&c.characters, &f.block_counts);
            fill.bind(device, config, characters, lods, &f.culled, counts, &f.fill, &f.sums, &f.choices)
        };
        let (fill_continuous, fill_quantized) = (fill_to(&c.lods), fill_to(&c.quantized_lods));
        let fill_by_error = fill_to(&c.error_lods);
        Self {
            cull_instances: (cull, cull_bound),
            sum_weights: (sum, sum_bound),
            select_lod: (select, select_bound),
            fill_budget: fill,
            fill_continuous,
            fill_quantized,
            fill_by_error,
            fit_budget: fit,
            fit_continuous,
            fit_quantized,
        }
    }

    /// Visibility and weights of all instances.
    pub(crate) fn record_culling(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        recorder.stage("cull_instances", |pass| self.cull_instances.0.record(pass, &self.cull_instances.1, count));
    }

    /// Everything up to one level for each instance.
    pub(crate) fn record(&self, recorder: &mut StageRecorder<'_>, config: &FrameConfig, options: &DrawOptions) {
        self.record_culling(recorder, config.instance_count);
        self.record_levels(recorder, config, options);
    }

    /// The same after culling.
    pub(crate) fn record_levels(&self, recorder: &mut StageRecorder<'_>, config: &FrameConfig, options: &DrawOptions) {
        let count = config.instance_count;
        let by_error = config.weight == Weight::Error as u32;
        recorder.stage("sum_weights", |pass| self.sum_weights.0.record(pass, &self.sum_weights.1, count));
        let (fill, fit) = match options.levels() {
            Levels::Continuous => (&self.fill_continuous, &self.fit_continuous),
            Levels::Quantized => (&self.fill_quantized, &self.fit_quantized),
        };
        if options.fit == Fit::Fill || by_error {
            let has_dots = options.levels() == Levels::Quantized && !by_error && count >= MANY;
            let bound = if by_error { &self.fill_by_error } else { fill };
            recorder.stage("fill_budget", |pass| match has_dots {
                true => self.fill_budget.record_of_dots(pass, bound, config, count),
                false => self.fill_budget.record(pass, bound, config, count),
            });
            return;
        }
        recorder.stage("select_lod", |pass| self.select_lod.0.record(pass, &self.select_lod.1, count));
        recorder.stage("fit_budget", |pass| self.fit_budget.record(pass, fit, count));
    }
}
