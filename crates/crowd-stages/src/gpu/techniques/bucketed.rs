//! Ours: instances sorted by character and quantised level, one indirect draw a bucket from the level's index table.

use super::{FrameContext, Painter, Workshop};
use crate::gpu::bucket_draws::BucketDraws;
use crate::gpu::lending::Lender;
use crate::gpu::lit::Lit;
use crate::gpu::pre_skinning::PreSkinning;
use crate::gpu::stage_recorder::StageRecorder;
use crate::{Result, Skinning};

/// The buckets' draws, keyed by the levels that the budget allows; their vertices may move between levels.
pub(crate) struct Bucketed {
    draws: BucketDraws,
    pipeline: Lit,
    morphing: Lit,
    dots: wgpu::RenderPipeline,
    /// Of impostors and of those who cross over to them, where the crowd has any.
    impostors: Option<[Lit; 2]>,
    bound: wgpu::BindGroup,
    /// Set up when it is first asked for.
    beforehand: Option<Beforehand>,
}

/// Draws from what was worked out beforehand.
struct Beforehand {
    skinning: PreSkinning,
    from_palettes: Lit,
    from_palettes_morphing: Lit,
    skinned: Lit,
    bound: wgpu::BindGroup,
}

impl Bucketed {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let draws = BucketDraws::new(up, crowd, frame, options, &frame.sums)?;
        let bound = draw.bind(crowd, frame, &frame.choices, &frame.nothing);
        let pipeline = draw.pipeline_with("bucketed", &BucketDraws::INPUTS);
        let morphing = draw.pipeline_with("bucketed_morphing", &BucketDraws::MORPHING_INPUTS);
        let dots = draw.dots_pipeline(&BucketDraws::INPUTS);
        let impostors = crowd.impostors.as_ref().map(|i| draw.impostor_pipelines(&i.layout, &BucketDraws::INPUTS));
        Ok(Self { draws, pipeline, morphing, dots, impostors, bound, beforehand: None })
    }

    /// After the draw arguments. `record_drawn`: what says who is drawn.
    fn record_before_draw(
        &self,
        recorder: &mut StageRecorder<'_>,
        context: &FrameContext<'_>,
        record_drawn: impl FnOnce(&BucketDraws, &mut StageRecorder<'_>, u32),
    ) {
        let count = context.config.instance_count;
        match self.beforehand(context) {
            Some(beforehand) => {
                let with_vertices = context.skinning == Skinning::Compute;
                let drawn = |recorder: &mut StageRecorder<'_>| record_drawn(&self.draws, recorder, count);
                beforehand.skinning.record(recorder, drawn, count, with_vertices);
            }
            None => record_drawn(&self.draws, recorder, count),
        }
    }

    /// Everything between levels and draws.
    fn record_list(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        self.draws.record_keys(recorder, count);
        if let Some(beforehand) = self.beforehand(context).filter(|_| context.options.shares_poses()) {
            let with_vertices = context.skinning == Skinning::Compute;
            beforehand.skinning.record_shared(recorder, &self.draws, count, with_vertices);
            return;
        }
        self.draws.record_sort(recorder, count);
        self.record_before_draw(recorder, context, |draws, recorder, count| draws.record_drawn(recorder, count));
    }

    fn beforehand(&self, context: &FrameContext<'_>) -> Option<&Beforehand> {
        self.beforehand.as_ref().filter(|_| context.skinning != Skinning::Vertex)
    }
}

impl Painter for Bucketed {
    fn prepare_skinning(&mut self, workshop: Workshop<'_, '_>) -> Result<()> {
        if self.beforehand.is_some() {
            return Ok(());
        }
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let skinning = PreSkinning::new(up, crowd, frame, options, &self.draws)?;
        let palettes = [("HAS_PALETTES", 1.0), ("LACKS_PALETTES", skinning.lacks_palettes.into())];
        self.beforehand = Some(Beforehand {
            from_palettes: draw.pipeline_of("bucketed", &BucketDraws::INPUTS, &palettes),
            from_palettes_morphing: draw.pipeline_of("bucketed_morphing", &BucketDraws::MORPHING_INPUTS, &palettes),
            skinned: match skinning.lacks_places {
                true => draw.pipeline_of("bucketed_partly_skinned", &BucketDraws::MORPHING_INPUTS, &palettes),
                false => draw.pipeline_with("bucketed_skinned", &BucketDraws::MORPHING_INPUTS),
            },
            bound: draw.bind_skinned(crowd, frame, &skinning.palettes, &skinning.skinned),
            skinning,
        });
        Ok(())
    }

    fn prepare_sharing(&mut self, workshop: Workshop<'_, '_>) -> Result<()> {
        let Workshop { up, crowd, frame, options, .. } = workshop;
        let Some(beforehand) = &mut self.beforehand else { return Ok(()) };
        beforehand.skinning.prepare_sharing(up, crowd, frame, options.max_instances, &self.draws)
    }

    fn forget_skinning(&mut self) {
        self.beforehand = None;
    }

    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        match context.occlusion {
            Some(occlusion) => occlusion.record_first(recorder, context.selection, context.config, &context.options),
            None => context.selection.record(recorder, context.config, &context.options),
        }
        self.record_list(recorder, context);
    }

    fn can_be_gated(&self, context: &FrameContext<'_>) -> bool {
        self.beforehand(context).is_none() && self.draws.can_be_gated()
    }

    fn record_again(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        match context.occlusion.filter(|_| self.can_be_gated(context)) {
            Some(occlusion) => self.draws.record_gated(recorder, context.config.instance_count, occlusion.gate()),
            None => self.record_list(recorder, context),
        }
    }

    fn record_frozen(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        self.record_before_draw(recorder, context, |draws, recorder, count| draws.record_listed(recorder, count));
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        let morphs = context.config.morph == 1;
        let (pipeline, bound) = match self.beforehand(context) {
            Some(b) if context.skinning == Skinning::Compute => (&b.skinned, &b.bound),
            Some(b) => (if morphs { &b.from_palettes_morphing } else { &b.from_palettes }, &b.bound),
            None => (if morphs { &self.morphing } else { &self.pipeline }, &self.bound),
        };
        let shows_shadows = context.options.shadows > 0;
        pass.set_pipeline(pipeline.of(shows_shadows));
        pass.set_bind_group(0, bound, &[]);
        self.draws.draw(pass, context.crowd);
        if context.config.dot_area_px2 > 0.0 {
            pass.set_pipeline(&self.dots);
            self.draws.draw_stand_ins(pass);
        }
        let impostors = self.impostors.iter().zip(&context.crowd.impostors);
        for (pipelines, textures) in impostors.filter(|_| context.config.impostor_area_px2 > 0.0) {
            pass.set_bind_group(2, &textures.bound, &[]);
            let pipelines = pipelines.each_ref().map(|lit| lit.of(shows_shadows));
            self.draws.draw_impostors(pass, &textures.vertices, pipelines);
        }
    }

    fn lender(&self) -> Option<Lender<'_>> {
        let beforehand = self.beforehand.as_ref()?;
        Some(Lender { skinned: &beforehand.skinning.skinned, lists: self.draws.lists() })
    }

    fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        let beforehand = self.beforehand.as_ref().and_then(|b| b.skinning.buffer(name));
        beforehand.or_else(|| self.draws.buffer(name))
    }
}
