//! One indirect draw a bucket, and what the frame came to.

use super::threshold_px;
use crate::{BucketRange, BucketRecord, Buckets, DrawArgs, DrawCounts, FrameConfig, FrameTotals, WeightSums, overflow};

/// Arguments of the indirect draws, how many of them draw anything, and the frame's totals.
///
/// `sorted_keys`: of all instances, those in no bucket last. Draws of buckets with instances come first among those of their
/// kind: of meshes with 16-bit indices, with 32-bit ones, of dots, of impostors and of those who cross over to them, in the order of the buckets; the others' arguments are zeros. `sums`: of the budget's stages; zeros where
/// there is no budget. No buffer can overflow here.
///
/// Paper: Park & Han 2009 §3.3, an instanced draw per LOD buffer; the arguments are written by the GPU.
/// Twin: `shaders/stages/write_bucket_args.wgsl`. Equal.
pub fn write_bucket_args(
    buckets: &Buckets,
    sorted_keys: &[u32],
    sums: &WeightSums,
    config: &FrameConfig,
) -> (Vec<BucketRange>, Vec<DrawArgs>, DrawCounts, FrameTotals) {
    let range = |bucket: u32| BucketRange {
        first: sorted_keys.partition_point(|key| *key < bucket) as u32,
        end: sorted_keys.partition_point(|key| *key <= bucket) as u32,
    };
    let mut totals = FrameTotals {
        min_vertex_count: sums.min_vertex_count,
        wanted_count: sums.wanted_count,
        threshold_px: threshold_px(sums, config),
        overflow: if sums.min_vertex_count > config.budget { overflow::BUDGET } else { 0 },
        ..Default::default()
    };
    let mut ranges = Vec::new();
    let ends = [buckets.count_16, buckets.mesh_count, buckets.first_impostor, buckets.first_fade, buckets.nobody()];
    let mut kinds: [Vec<DrawArgs>; 5] = Default::default();
    for (bucket, record) in buckets.records.iter().enumerate() {
        let range = range(bucket as u32);
        let count = range.end - range.first;
        if count > 0 {
            totals.visible_count += count;
            totals.vertex_count = totals.vertex_count.saturating_add(count.saturating_mul(record.vertex_count));
            totals.triangle_count = totals.triangle_count.saturating_add(count.saturating_mul(record.triangle_count));
            let kind = ends.iter().position(|end| (bucket as u32) < *end).expect("the last end is that of all");
            kinds[kind].push(draw(record, range));
            ranges.push(range);
        } else {
            ranges.push(BucketRange::default());
        }
    }
    totals.outside_count = sorted_keys.len() as u32 - totals.visible_count;
    let [count_16, count_32, dot_count, impostor_count, fade_count] = kinds.each_ref().map(|draws| draws.len() as u32);
    let counts = DrawCounts { count_16, count_32, dot_count, impostor_count, fade_count };
    totals.draw_count = count_16 + count_32 + dot_count + impostor_count + fade_count;
    (totals.needed_vertices, totals.needed_triangles) = (totals.vertex_count, totals.triangle_count);
    let mut begin = 0;
    for (draws, end) in kinds.iter_mut().zip(ends) {
        draws.resize((end - begin) as usize, DrawArgs::default());
        begin = end;
    }
    (ranges, kinds.concat(), counts, totals)
}

fn draw(record: &BucketRecord, range: BucketRange) -> DrawArgs {
    DrawArgs {
        index_count: record.index_count,
        instance_count: range.end - range.first,
        first_index: record.first_index,
        base_vertex: record.vertex_offset as i32,
        first_instance: range.first,
    }
}
