//! Linear blend skinning.

use crate::Mat3x4;

/// Where one vertex goes; weights of joints outside the palette count as zero.
pub(crate) fn skin(position: [f32; 3], joints: &[u16; 4], weights: &[f32; 4], palette: &[Mat3x4]) -> [f32; 3] {
    let mut point = [0.0_f32; 3];
    for (&joint, &weight) in joints.iter().zip(weights) {
        let Some(rows) = palette.get(usize::from(joint)).filter(|_| weight != 0.0) else {
            continue;
        };
        for (sum, row) in point.iter_mut().zip(rows) {
            *sum += weight * (row[0] * position[0] + row[1] * position[1] + row[2] * position[2] + row[3]);
        }
    }
    point
}
