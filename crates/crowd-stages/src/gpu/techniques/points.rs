//! P: far characters as points of their surface, near ones at full detail (the comparison of Dong 2019 §6.2).

use super::{FrameContext, Painter, Workshop};
use crate::gpu::KeyPoints;
use crate::gpu::bucket_draws::BucketDraws;
use crate::gpu::lit::Lit;
use crate::gpu::stage_recorder::StageRecorder;
use crate::{Result, WeightSums};
use wgpu::BufferUsages as Usage;

/// The buckets' draws, keyed by projected size.
pub(crate) struct Points {
    draws: BucketDraws,
    key_points: (KeyPoints, wgpu::BindGroup),
    meshes: Lit,
    points: Lit,
    bound: wgpu::BindGroup,
}

impl Points {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd, frame, draw, options } = workshop;
        let no_sums = up.empty::<WeightSums>("no sums", 1, Usage::STORAGE, "draw fewer instances")?;
        let tables = crowd.tables.with_points(up, &crowd.points)?;
        let draws = BucketDraws::of_tables(up, crowd, tables.clone(), frame, options, &no_sums)?;
        let key = KeyPoints::new(up.device);
        let key_bound = key.bind(
            up.device,
            &frame.config,
            &tables.bucket_counts,
            &frame.instances,
            &tables.bucket_sets,
            &tables.buckets,
            &frame.culled,
            draws.keys(),
        );
        Ok(Self {
            draws,
            key_points: (key, key_bound),
            meshes: draw.pipeline_with("bucketed", &BucketDraws::INPUTS),
            points: draw.points_pipeline(&BucketDraws::INPUTS),
            bound: draw.bind(crowd, frame, &frame.choices, &frame.nothing),
        })
    }
}

impl Painter for Points {
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        context.selection.record_culling(recorder, count);
        let (key, bound) = &self.key_points;
        recorder.stage("key_points", |pass| key.record(pass, bound, count));
        self.draws.record_sort(recorder, count);
        self.draws.record_drawn(recorder, count);
    }

    fn record_frozen(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        self.draws.record_listed(recorder, context.config.instance_count);
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        pass.set_bind_group(0, &self.bound, &[]);
        let shows_shadows = context.options.shadows > 0;
        pass.set_pipeline(self.meshes.of(shows_shadows));
        self.draws.draw(pass, context.crowd);
        pass.set_pipeline(self.points.of(shows_shadows));
        self.draws.draw_stand_ins(pass);
    }

    fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.draws.buffer(name)
    }
}
