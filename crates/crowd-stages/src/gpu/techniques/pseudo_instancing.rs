//! B0: a draw per instance at full detail, nothing culled.

use super::{FrameContext, Painter, Workshop};
use crate::gpu::lit::Lit;
use crate::gpu::stage_recorder::StageRecorder;
use crate::gpu::vertex_inputs::MESH_LAYOUT;
use crate::{FrameTotals, overflow};

/// One pipeline; the CPU does the rest.
pub(crate) struct PseudoInstancing {
    pipeline: Lit,
    bound: wgpu::BindGroup,
}

impl PseudoInstancing {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Self {
        let Workshop { crowd, frame, draw, .. } = workshop;
        Self {
            pipeline: draw.pipeline_with("full_detail", &[Some(MESH_LAYOUT)]),
            bound: draw.bind(crowd, frame, &frame.choices, &frame.nothing),
        }
    }
}

impl Painter for PseudoInstancing {
    fn record_stages(&self, _: &mut StageRecorder<'_>, _: &FrameContext<'_>) {}

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        let tables = &context.crowd.tables;
        pass.set_pipeline(self.pipeline.of(context.options.shadows > 0));
        pass.set_bind_group(0, &self.bound, &[]);
        pass.set_vertex_buffer(0, context.crowd.vertices.slice(..));
        // As a renderer of its time would: the index buffer is set once for all with the same width of indices.
        let mut is_narrow = None;
        for (i, character) in context.characters.iter().enumerate() {
            let (range, narrow, first_vertex) = &tables.full_detail[*character as usize];
            if is_narrow != Some(*narrow) {
                is_narrow = Some(*narrow);
                tables.set_indices(pass, *narrow);
            }
            pass.draw_indexed(range.clone(), *first_vertex, i as u32..i as u32 + 1);
        }
    }

    fn known_totals(&self, context: &FrameContext<'_>) -> Option<FrameTotals> {
        let totals = context.full_detail_totals;
        let exceeds = totals.min_vertex_count > context.config.budget;
        Some(FrameTotals { overflow: if exceeds { overflow::BUDGET } else { 0 }, ..*totals })
    }
}
