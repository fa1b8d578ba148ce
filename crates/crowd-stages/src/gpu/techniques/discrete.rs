//! B2: three discrete levels by depth, culling by a widened frustum, one instanced draw a level and character (Park & Han 2009).

use super::{FrameContext, Painter, Workshop};
use crate::gpu::CullByDepth;
use crate::gpu::bucket_draws::BucketDraws;
use crate::gpu::lit::Lit;
use crate::gpu::stage_recorder::StageRecorder;
use crate::{Result, WeightSums};
use wgpu::BufferUsages as Usage;

/// The buckets' draws, keyed by depth.
pub(crate) struct Discrete {
    draws: BucketDraws,
    cull_by_depth: (CullByDepth, wgpu::BindGroup),
    pipeline: Lit,
    bound: wgpu::BindGroup,
}

impl Discrete {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let fewer = "draw fewer instances";
        let no_sums = up.empty::<WeightSums>("no sums", 1, Usage::STORAGE, fewer)?;
        let draws = BucketDraws::new(up, crowd, frame, options, &no_sums)?;
        let tables = &crowd.tables;
        let discrete = up.filled("discrete config", &[tables.discrete], Usage::UNIFORM, fewer)?;
        let levels = up.filled("discrete levels", &tables.discrete_levels, Usage::STORAGE, fewer)?;
        let cull = CullByDepth::new(up.device);
        let cull_bound = cull.bind(
            up.device,
            &frame.config,
            &tables.bucket_counts,
            &discrete,
            &frame.instances,
            &crowd.characters,
            &levels,
            draws.keys(),
        );
        let bound = draw.bind(crowd, frame, &frame.choices, &frame.nothing);
        Ok(Self {
            draws,
            cull_by_depth: (cull, cull_bound),
            pipeline: draw.pipeline_with("bucketed", &BucketDraws::INPUTS),
            bound,
        })
    }
}

impl Painter for Discrete {
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        let (cull, bound) = &self.cull_by_depth;
        recorder.stage("cull_by_depth", |pass| cull.record(pass, bound, count));
        self.draws.record_sort(recorder, count);
        self.draws.record_drawn(recorder, count);
    }

    fn record_frozen(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        self.draws.record_listed(recorder, context.config.instance_count);
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        pass.set_pipeline(self.pipeline.of(context.options.shadows > 0));
        pass.set_bind_group(0, &self.bound, &[]);
        self.draws.draw(pass, context.crowd);
    }

    fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.draws.buffer(name)
    }
}
