//! Dispatches of water filling: the search in rounds, then the steps' prefix sums and the levels.

use super::kernel::{Gate, Groups, Kernel, Use, blocks, stage_source};
use crate::dispatch::{FILL_CHUNKS, FILL_TRIED};
use crate::{FrameConfig, Weight};

/// Rounds of the search. The first looks around a guess. Of the 4,335 heights that may be left, eight cut ninths: 4334, 481, 53, 5, none.
/// Where the first has left at most 130, the second tries eight neighbours, and two more do: 122, 13, 1, none.
const FILL_ROUNDS: u32 = 5;

/// Shader: `shaders/stages/fill_budget.wgsl`. Twin: [`crate::cpu::fill_budget`].
pub struct FillBudget {
    kernel: Kernel,
    /// What looks at everyone, for frames without impostors that are not by error: `sum_heights`, `choose_levels`.
    plain: Kernel,
    /// The same where many are dots, see [`Self::with_dots`]: `sum_heights_of_dots`, `choose_levels_of_dots`.
    dotted: Option<Kernel>,
}

impl FillBudget {
    const USES: [Use; 8] =
        [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write, Use::Write];

    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[
                include_str!("../../../../shaders/shared/scan.wgsl"),
                include_str!("../../../../shaders/shared/dot_count.wgsl"),
            ],
            include_str!("../../../../shaders/stages/fill_budget.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = Self::USES;
        let entry_points = [
            "begin",
            "sum_heights",
            "narrow",
            "sum_steps",
            "scan_steps",
            "scan_counts",
            "choose_levels",
            "choose_edge",
        ];
        let plain = [("IS_PLAIN", 1.0)];
        let looks = ["sum_heights", "choose_levels"];
        Self {
            kernel: Kernel::new(device, "fill_budget", Self::source(), &entry_points, &uses),
            plain: Kernel::with_constants(device, "fill_budget", Self::source(), &looks, &uses, &plain),
            dotted: None,
        }
    }

    /// The same that goes twice over those who are not dots and once over those who are, for adapters that are processors: see [`Self::record_of_dots`].
    /// `reach`: of [`crate::dot_reach`].
    pub fn with_dots(device: &wgpu::Device, reach: u32) -> Self {
        let constants = [("IS_PLAIN", 1.0), ("DOT_REACH", f64::from(reach))];
        let looks = ["sum_heights_of_dots", "choose_levels_of_dots"];
        let dotted = || Kernel::with_constants(device, "fill_budget", Self::source(), &looks, &Self::USES, &constants);
        Self { dotted: (reach > 0).then(dotted), ..Self::new(device) }
    }

    /// Words of `block_counts` for that many instances.
    pub fn block_count_words(instance_count: u32) -> u64 {
        let tried = u64::from(FILL_ROUNDS * FILL_TRIED);
        u64::from(chunks(instance_count)) * (1 + tried) + 1
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        lods: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        block_counts: &wgpu::Buffer,
        fill: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        choices: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, characters, lods, culled, block_counts, fill, sums, choices])
    }

    /// Records the dispatches of a frame for that many instances, which may be more than it has.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        config: &FrameConfig,
        instance_count: u32,
    ) {
        let (sum_heights, choose_levels) = match is_plain(config) {
            true => ((&self.plain, 0), (&self.plain, 1)),
            false => ((&self.kernel, 1), (&self.kernel, 6)),
        };
        self.record_with(pass, bound, sum_heights, (choose_levels, blocks(instance_count)), instance_count);
    }

    /// The same of quantised levels with dots ([`crate::Buckets::quantized_lods`]), where many are.
    pub fn record_of_dots(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        config: &FrameConfig,
        instance_count: u32,
    ) {
        match self.dotted.as_ref().filter(|_| is_plain(config) && config.dot_area_px2 > 0.0) {
            Some(dotted) => {
                let choose_levels = ((dotted, 1), chunks(instance_count));
                self.record_with(pass, bound, (dotted, 0), choose_levels, instance_count);
            }
            None => self.record(pass, bound, config, instance_count),
        }
    }

    fn record_with(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        sum_heights: (&Kernel, usize),
        (choose_levels, groups): ((&Kernel, usize), u32),
        instance_count: u32,
    ) {
        self.kernel.dispatch(pass, 0, bound, 1);
        for _ in 0..FILL_ROUNDS {
            sum_heights.0.dispatch(pass, sum_heights.1, bound, chunks(instance_count));
            self.kernel.dispatch(pass, 2, bound, 1);
        }
        self.kernel.dispatch(pass, 5, bound, 1);
        choose_levels.0.dispatch(pass, choose_levels.1, bound, groups);
        self.kernel.dispatch(pass, 7, bound, 1);
    }

    /// Records the last part alone: between the two heights that the state has, the first instances take the step.
    pub fn record_steps(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.record_gated_steps(pass, bound, instance_count, None);
    }

    pub(crate) fn record_gated_steps(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        instance_count: u32,
        gate: Gate<'_>,
    ) {
        // A gate lets through as many groups as there are blocks: those beyond the chunks have nothing to do.
        self.kernel.dispatch_gated(pass, 3, bound, (Groups::Blocks, chunks(instance_count)), gate);
        self.kernel.dispatch_gated(pass, 4, bound, (Groups::One, 1), gate);
        self.kernel.dispatch_gated(pass, 6, bound, (Groups::Blocks, blocks(instance_count)), gate);
        self.kernel.dispatch_gated(pass, 7, bound, (Groups::One, 1), gate);
    }
}

/// Nobody is an impostor, and levels are not by error.
fn is_plain(config: &FrameConfig) -> bool {
    config.impostor_area_px2 <= 0.0 && config.weight != Weight::Error as u32
}

/// Groups for as many chunks as there are of that many instances, or of fewer: a frame's own count may be less than what it is recorded for.
fn chunks(instance_count: u32) -> u32 {
    blocks(instance_count).min(FILL_CHUNKS)
}
