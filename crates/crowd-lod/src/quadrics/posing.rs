//! Poses all positions in all frames, eight at a time.

use super::lanes::{LANES, Lanes};
use crate::split_seams::SplitMesh;
use crate::{LodMesh, LodPoses};
use fearless_simd::{Level as Vectors, dispatch};
use rayon::prelude::*;

/// Every position in every frame: `[position][block]`.
pub(super) fn pose_in_lanes(
    vectors: Vectors,
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    split: &SplitMesh,
    block_count: usize,
) -> Vec<[Lanes; 3]> {
    // `[joint][block][row * 4 + column][lane]`; lanes past the last frame repeat it and weigh nothing.
    let mut matrices = vec![[[0.0_f32; LANES]; 12]; poses.joint_count * block_count];
    matrices.par_chunks_mut(block_count.max(1)).enumerate().for_each(|(joint, blocks)| {
        for (b, block) in blocks.iter_mut().enumerate() {
            for lane in 0..LANES {
                let frame = (b * LANES + lane).min(poses.frame_weights.len() - 1);
                let matrix = &poses.palettes[frame * poses.joint_count + joint];
                for k in 0..12 {
                    block[k][lane] = matrix[k / 4][k % 4];
                }
            }
        }
    });
    let mut posed = vec![[[0.0; LANES]; 3]; split.position_source.len() * block_count];
    posed.par_chunks_mut(block_count.max(1)).enumerate().for_each(|(p, blocks)| {
        let source = split.position_source[p] as usize;
        let mut influences = [(0, 0.0); 4];
        let mut count = 0;
        for k in (0..4).filter(|&k| mesh.weights[source][k] != 0.0) {
            influences[count] = (mesh.joints[source][k] as usize * block_count, mesh.weights[source][k]);
            count += 1;
        }
        dispatch!(vectors, _ => pose_blocks(mesh.positions[source], &influences[..count], &matrices, blocks));
    });
    posed
}

/// Poses a position in all frames. Of each influence, where the blocks of its joint begin, and its weight.
#[inline(always)]
fn pose_blocks([x, y, z]: [f32; 3], influences: &[(usize, f32)], matrices: &[[Lanes; 12]], posed: &mut [[Lanes; 3]]) {
    for (b, posed) in posed.iter_mut().enumerate() {
        // Summed apart: fresh memory that is read before it is written costs the system twice.
        let mut sum = [[0.0; LANES]; 3];
        for &(start, weight) in influences {
            let m = &matrices[start + b];
            for row in 0..3 {
                for i in 0..LANES {
                    let (mx, my, mz, mw) = (m[row * 4][i], m[row * 4 + 1][i], m[row * 4 + 2][i], m[row * 4 + 3][i]);
                    sum[row][i] += weight * (mx * x + my * y + mz * z + mw);
                }
            }
        }
        *posed = sum;
    }
}
