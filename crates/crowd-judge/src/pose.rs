//! Linear blend skinning of positions and normals.

use crate::{Mat3x4, SkinnedMesh};
use glam::Vec3;

/// Positions of a posed mesh, one per vertex.
pub(crate) fn pose_positions(mesh: &SkinnedMesh, palette: &[Mat3x4]) -> Vec<Vec3> {
    let place = |v: usize| {
        let p = mesh.positions[v];
        let m = blend(mesh.joints[v], mesh.weights[v], palette);
        Vec3::from(m.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]))
    };
    (0..mesh.positions.len()).map(place).collect()
}

/// Unit normals of a posed mesh, one per vertex: through the cofactors of the blended matrix, so that they stay
/// perpendicular under uneven scale and outside under mirroring.
pub(crate) fn pose_normals(mesh: &SkinnedMesh, palette: &[Mat3x4]) -> Vec<Vec3> {
    let turn = |v: usize| {
        let m = blend(mesh.joints[v], mesh.weights[v], palette);
        let [a, b, c] = m.map(|row| Vec3::new(row[0], row[1], row[2]));
        let n = Vec3::from(mesh.normals[v]);
        let turned = Vec3::new(b.cross(c).dot(n), c.cross(a).dot(n), a.cross(b).dot(n));
        let mirrored = a.dot(b.cross(c)) < 0.0;
        (if mirrored { -turned } else { turned }).normalize_or_zero()
    };
    (0..mesh.positions.len()).map(turn).collect()
}

fn blend(joints: [u16; 4], weights: [f32; 4], palette: &[Mat3x4]) -> Mat3x4 {
    let mut out = [[0.0_f32; 4]; 3];
    for slot in 0..4 {
        if weights[slot] == 0.0 {
            continue;
        }
        let matrix = &palette[usize::from(joints[slot])];
        for row in 0..3 {
            for column in 0..4 {
                out[row][column] += weights[slot] * matrix[row][column];
            }
        }
    }
    out
}
