//! Linear blend skinning of whole meshes: `sum of weight * palette[joint] * position`.

/// Rows of an affine matrix.
pub type Mat3x4 = [[f32; 4]; 3];

/// A posed mesh; one entry per vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Posed {
    /// Metres, character space.
    pub positions: Vec<[f32; 3]>,
    /// Not unit length where a matrix scales.
    pub normals: Vec<[f32; 3]>,
}

/// The blend of a vertex's matrices.
pub fn blend(joints: [u16; 4], weights: [f32; 4], palette: &[Mat3x4]) -> Mat3x4 {
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

/// A point through an affine matrix.
pub fn transform(matrix: &Mat3x4, p: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
}

/// Positions of a posed mesh. `palette`: one matrix a joint.
pub fn pose_positions(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    palette: &[Mat3x4],
) -> Vec<[f32; 3]> {
    let vertices = positions.iter().zip(joints).zip(weights);
    vertices.map(|((&p, &j), &w)| transform(&blend(j, w, palette), p)).collect()
}

/// Positions and normals of a posed mesh. Normals follow the cofactors of the blended matrix, so that they stay
/// perpendicular under non-uniform scale and keep facing outwards under mirroring.
pub fn pose_mesh(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    palette: &[Mat3x4],
) -> Posed {
    let mut posed = Posed::default();
    for vertex in 0..positions.len() {
        let matrix = blend(joints[vertex], weights[vertex], palette);
        posed.positions.push(transform(&matrix, positions[vertex]));
        posed.normals.push(turn_normal(&matrix, normals[vertex]));
    }
    posed
}

/// The frame of a clip at a time, blended linearly between its two neighbours. `palettes`: frame by frame.
pub fn palette_at(palettes: &[Mat3x4], joint_count: usize, duration_s: f32, time_s: f32) -> Vec<Mat3x4> {
    let frame_count = palettes.len() / joint_count.max(1);
    let last = frame_count.saturating_sub(1);
    let share = if duration_s > 0.0 { (time_s / duration_s).clamp(0.0, 1.0) } else { 0.0 };
    let place = share * last as f32;
    let frame = (place.floor() as usize).min(last);
    let (next, t) = ((frame + 1).min(last), place - frame as f32);
    let of = |frame: usize| &palettes[frame * joint_count..(frame + 1) * joint_count];
    let pairs = of(frame).iter().zip(of(next));
    pairs.map(|(a, b)| std::array::from_fn(|r| std::array::from_fn(|c| a[r][c] + (b[r][c] - a[r][c]) * t))).collect()
}

fn turn_normal(m: &Mat3x4, n: [f32; 3]) -> [f32; 3] {
    let row = |r: usize| glam::Vec3::new(m[r][0], m[r][1], m[r][2]);
    let (a, b, c) = (row(0), row(1), row(2));
    let n = glam::Vec3::from(n);
    // Rows of the cofactor matrix are cross products of the other two rows.
    let turned = glam::Vec3::new(b.cross(c).dot(n), c.cross(a).dot(n), a.cross(b).dot(n));
    let mirrored = a.dot(b.cross(c)) < 0.0;
    let outward = if mirrored { -turned } else { turned };
    outward.normalize_or(n).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP_BY_TWO: Mat3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, 0.0]];
    const TWICE_AS_WIDE: Mat3x4 = [[2.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

    #[test]
    fn half_of_each_is_half_way() {
        let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let posed =
            pose_positions(&[[1.0, 0.0, 0.0]], &[[0, 1, 0, 0]], &[[0.5, 0.5, 0.0, 0.0]], &[identity, UP_BY_TWO]);
        assert_eq!(posed, [[1.0, 1.0, 0.0]]);
    }

    #[test]
    fn normals_stay_perpendicular_under_stretching() {
        let normal = turn_normal(&TWICE_AS_WIDE, [0.707, 0.707, 0.0]);
        // The surface along (1, -1, 0) goes to (2, -1, 0).
        assert!((normal[0] * 2.0 - normal[1]).abs() < 1e-5, "{normal:?}");
    }

    #[test]
    fn a_time_between_frames_blends_them() {
        let frames = [TWICE_AS_WIDE, UP_BY_TWO];
        assert_eq!(palette_at(&frames, 1, 1.0, 0.0)[0], TWICE_AS_WIDE);
        assert_eq!(palette_at(&frames, 1, 1.0, 9.0)[0], UP_BY_TWO);
        assert_eq!(palette_at(&frames, 1, 1.0, 0.5)[0][1][3], 1.0);
        assert_eq!(palette_at(&frames[..1], 1, 0.0, 0.5)[0], TWICE_AS_WIDE);
    }
}
