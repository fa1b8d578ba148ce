//! B1: instances culled by the frustum, all at full detail, one instanced draw a character.

use super::{FrameContext, Painter, Workshop};
use crate::gpu::bucket_draws::BucketDraws;
use crate::gpu::lit::Lit;
use crate::gpu::stage_recorder::StageRecorder;
use crate::{Result, WeightSums};
use wgpu::BufferUsages as Usage;

/// The buckets' draws, keyed by full detail.
pub(crate) struct Instanced {
    draws: BucketDraws,
    pipeline: Lit,
    bound: wgpu::BindGroup,
}

impl Instanced {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let no_sums = up.empty::<WeightSums>("no sums", 1, Usage::STORAGE, "draw fewer instances")?;
        let draws = BucketDraws::new(up, crowd, frame, options, &no_sums)?;
        let bound = draw.bind(crowd, frame, &frame.choices, &frame.nothing);
        Ok(Self { draws, pipeline: draw.pipeline_with("bucketed", &BucketDraws::INPUTS), bound })
    }
}

impl Painter for Instanced {
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        context.selection.record_culling(recorder, count);
        self.draws.record_full_detail_keys(recorder, count);
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
