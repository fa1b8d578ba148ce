//! Ours: instances sorted by character and quantised level, one indirect draw a bucket from the level's index table.

use super::{FrameContext, Painter, Workshop};
use crate::Result;
use crate::gpu::bucket_draws::BucketDraws;
use crate::gpu::stage_recorder::StageRecorder;

/// The buckets' draws, keyed by the levels that the budget allows; their vertices may move between levels.
pub(crate) struct Bucketed {
    draws: BucketDraws,
    pipeline: wgpu::RenderPipeline,
    morphing: wgpu::RenderPipeline,
    dots: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
}

impl Bucketed {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let draws = BucketDraws::new(up, crowd, frame, options, &frame.sums)?;
        let bound = draw.bind(crowd, frame, &frame.choices, &frame.bases_of_none);
        let pipeline = draw.pipeline_with("bucketed", &BucketDraws::INPUTS);
        let morphing = draw.pipeline_with("bucketed_morphing", &BucketDraws::MORPHING_INPUTS);
        let dots = draw.dots_pipeline(&BucketDraws::INPUTS);
        Ok(Self { draws, pipeline, morphing, dots, bound })
    }
}

impl Painter for Bucketed {
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        match context.occlusion {
            Some(occlusion) => occlusion.record_first(recorder, context.selection, context.config, &context.options),
            None => context.selection.record(recorder, context.config, &context.options),
        }
        self.record_again(recorder, context);
    }

    fn record_again(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        self.draws.record_keys(recorder, count);
        self.draws.record_sort(recorder, count);
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        pass.set_pipeline(if context.config.morph == 1 { &self.morphing } else { &self.pipeline });
        pass.set_bind_group(0, &self.bound, &[]);
        self.draws.draw(pass, context.crowd);
        if context.config.dot_area_px2 > 0.0 {
            pass.set_pipeline(&self.dots);
            self.draws.draw_dots(pass, context.crowd);
        }
    }

    fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.draws.buffer(name)
    }
}
