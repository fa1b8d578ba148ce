//! B3: the triangles of every instance reformed into one index buffer each frame, one indirect draw.

use super::{FrameContext, Painter, Workshop};
use crate::dispatch::BLOCK_SIZE;
use crate::gpu::lit::Lit;
use crate::gpu::stage_recorder::StageRecorder;
use crate::gpu::{PlaceVertices, ReformTriangles, ScanCounts, WriteDrawArgs};
use crate::{Capacities, DrawArgs, InstanceBase, Result};
use wgpu::BufferUsages as Usage;

/// Buffers as large as the budget, and the stages that fill them.
pub(crate) struct Reform {
    buffers: Buffers,
    scan_counts: (ScanCounts, wgpu::BindGroup),
    place_vertices: (PlaceVertices, wgpu::BindGroup),
    /// Bound to each part of the index buffer.
    reform_triangles: (ReformTriangles, Vec<wgpu::BindGroup>),
    write_draw_args: (WriteDrawArgs, wgpu::BindGroup),
    pipeline: Lit,
    bound: wgpu::BindGroup,
}

/// Three indices.
const TRIANGLE_BYTES: u64 = 3 * size_of::<u32>() as u64;
/// Triangles that parts of an index buffer begin at multiples of: 768 bytes, three times what bindings are aligned to.
const WINDOW_STEP: u64 = 64;

/// Parts of an index buffer of so many triangles that each fit a binding: first triangle and how many.
pub(crate) fn windows(triangle_count: u32, largest_binding: u64) -> Vec<(u32, u32)> {
    let triangle_count = triangle_count.max(1);
    let most =
        (largest_binding / TRIANGLE_BYTES / WINDOW_STEP * WINDOW_STEP).clamp(WINDOW_STEP, u32::MAX.into()) as u32;
    let firsts = (0..triangle_count).step_by(most as usize);
    firsts.map(|first| (first, most.min(triangle_count - first))).collect()
}

struct Buffers {
    bases: wgpu::Buffer,
    slot_instances: wgpu::Buffer,
    indices: wgpu::Buffer,
    draw_args: wgpu::Buffer,
}

impl Reform {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Result<Self> {
        let Workshop { up, crowd: c, frame: f, draw, options } = workshop;
        let (fewer, smaller) = ("draw fewer instances", "lower the vertex budget");
        let n = u64::from(options.max_instances);
        let blocks = u64::from(options.max_instances.div_ceil(BLOCK_SIZE));
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let capacities = Capacities {
            vertex_count: options.max_vertices,
            triangle_count: options.max_triangles,
            ..Default::default()
        };
        let limits = capacities;
        let capacities = up.filled("capacities", &[capacities], Usage::UNIFORM, fewer)?;
        let block_totals = up.empty::<InstanceBase>("counts of blocks", blocks, written, fewer)?;
        let counts = up.empty::<InstanceBase>("counts", 1, written, fewer)?;
        let vertex_count = u64::from(options.max_vertices);
        let index_count = u64::from(options.max_triangles) * 3;
        let b = Buffers {
            bases: up.empty::<InstanceBase>("bases", n, written, fewer)?,
            slot_instances: up.empty::<u32>("bytes of the vertex list", vertex_count, written, smaller)?,
            indices: up.in_parts::<u32>("bytes of the index buffer", index_count, written | Usage::INDEX, smaller)?,
            draw_args: up.empty::<DrawArgs>("draw arguments", 1, written | Usage::INDIRECT, fewer)?,
        };

        let device = up.device;
        let scan = ScanCounts::new(device);
        let place = PlaceVertices::new(device);
        let reform = ReformTriangles::new(device);
        let write = WriteDrawArgs::new(device);
        let config = &f.config;
        let scan_bound = scan.bind(device, config, &f.choices, &block_totals, &b.bases, &counts);
        let place_bound = place.bind(device, config, &capacities, &f.choices, &b.bases, &b.slot_instances);
        let mut reform_bound = Vec::new();
        for (window_first, window_count) in windows(limits.triangle_count, up.largest_binding()) {
            let window = Capacities { window_first, window_count, ..limits };
            let window = up.filled("window of the index buffer", &[window], Usage::UNIFORM, fewer)?;
            reform_bound.push(reform.bind(
                device,
                config,
                &window,
                &f.instances,
                &c.characters,
                &c.triangles,
                &c.collapse_map,
                &f.choices,
                &b.bases,
                wgpu::BufferBinding {
                    buffer: &b.indices,
                    offset: u64::from(window_first) * TRIANGLE_BYTES,
                    size: std::num::NonZeroU64::new(u64::from(window_count) * TRIANGLE_BYTES),
                },
            ));
        }
        let write_bound =
            write.bind(device, config, &capacities, &f.sums, &f.choices, &b.bases, &counts, &b.draw_args, &f.totals);
        Ok(Self {
            scan_counts: (scan, scan_bound),
            place_vertices: (place, place_bound),
            reform_triangles: (reform, reform_bound),
            write_draw_args: (write, write_bound),
            pipeline: draw.pipeline("reformed"),
            bound: draw.bind(c, f, &b.slot_instances, &b.bases),
            buffers: b,
        })
    }
}

impl Painter for Reform {
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>) {
        let count = context.config.instance_count;
        context.selection.record(recorder, context.config, &context.options);
        recorder.stage("scan_counts", |pass| self.scan_counts.0.record(pass, &self.scan_counts.1, count));
        recorder.stage("place_vertices", |pass| self.place_vertices.0.record(pass, &self.place_vertices.1, count));
        recorder.stage("reform_triangles", |pass| {
            let (reform, parts) = &self.reform_triangles;
            parts.iter().for_each(|bound| reform.record(pass, bound, count));
        });
        recorder.stage("write_draw_args", |pass| self.write_draw_args.0.record(pass, &self.write_draw_args.1));
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        pass.set_pipeline(self.pipeline.of(context.options.shadows > 0));
        pass.set_bind_group(0, &self.bound, &[]);
        pass.set_index_buffer(self.buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed_indirect(&self.buffers.draw_args, 0);
    }

    fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "bases" => Some(&self.buffers.bases),
            "slot_instances" => Some(&self.buffers.slot_instances),
            "indices" => Some(&self.buffers.indices),
            "draw_args" => Some(&self.buffers.draw_args),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cover_the_buffer_and_each_fits_a_binding() {
        assert_eq!(windows(100, 128 << 20), [(0, 100)]);
        assert_eq!(windows(0, 128 << 20), [(0, 1)]);
        let all = windows(200_000, 1 << 20);
        assert_eq!(all.iter().map(|(_, count)| count).sum::<u32>(), 200_000);
        assert!(all.iter().all(|(first, count)| first % 64 == 0 && u64::from(*count) * TRIANGLE_BYTES <= 1 << 20));
        assert!(all.is_sorted_by(|a, b| a.0 + a.1 == b.0) && all.len() == 3, "{all:?}");
    }
}
