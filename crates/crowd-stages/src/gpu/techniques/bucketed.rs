//! Ours: instances sorted by character and quantised level, one indirect draw a bucket from the level's index table.

use super::{FrameContext, Painter, Workshop};
use crate::Result;
use crate::gpu::bucket_draws::BucketDraws;
use crate::gpu::stage_recorder::StageRecorder;

/// The buckets' draws, keyed by the levels that the budget allows.
pub(crate) struct Bucketed {
    draws: BucketDraws,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
}

impl Bucketed {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let draws = BucketDraws::new(up, crowd, frame, options, &frame.sums)?;
        let bound = draw.bind(crowd, frame, draws.sorted(), &frame.bases_of_none);
        Ok(Self { draws, pipeline: draw.pipeline("bucketed"), bound })
    }
}

impl Painter for Bucketed {
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        context.selection.record(recorder, count, &context.options);
        self.draws.record_keys(recorder, count);
        self.draws.record_sort(recorder, count);
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bound, &[]);
        self.draws.draw(pass, context.crowd);
    }

    fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.draws.buffer(name)
    }
}
