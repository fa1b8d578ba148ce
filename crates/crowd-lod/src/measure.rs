//! Measures how far a level lies from full detail over poses.

use crate::closest::ClosestTriangles;
use crate::frames::draw_evenly;
use crate::quadrics::{cross, dot, pose_position, sub};
use crate::{LodPoses, Mat3x4, MeasuredError};
use rayon::prelude::*;

/// Measures how far a level lies from full detail: two-sided closest-point distance over the poses given.
///
/// `positions`, `joints`, `weights`: one per vertex, in the order of the indices in `triangles` (full detail) and
/// `level_triangles`. Each side has `samples_per_frame` points, spread over the bind pose by area and carried by the
/// side's own triangles, the same ones on every machine. All frames of `poses` are measured, each counted alike.
/// An empty side measures 0.
///
/// Panics if an index lies outside its slice.
pub fn measure_level(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    triangles: &[[u32; 3]],
    level_triangles: &[[u32; 3]],
    poses: &LodPoses<'_>,
    samples_per_frame: u32,
) -> MeasuredError {
    let frames: Vec<usize> = (0..poses.frame_weights.len()).collect();
    let vertices = Vertices { positions, joints, weights };
    measure_frames(&vertices, triangles, &[level_triangles], poses, &frames, samples_per_frame)[0]
}

/// Frames to measure levels on, rising: all, or `limit` drawn evenly along the weights.
pub fn measured_frames(frame_weights: &[f32], limit: u32) -> Vec<usize> {
    draw_evenly(frame_weights, limit as usize).into_iter().map(|(frame, _)| frame).collect()
}

struct Vertices<'a> {
    positions: &'a [[f32; 3]],
    joints: &'a [[u16; 4]],
    weights: &'a [[f32; 4]],
}

/// A point on a triangle of a mesh: the triangle and the weights of its first two corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub triangle: u32,
    pub weights: [f32; 2],
}

/// Where a sample lies, given the corners of its triangle.
pub(crate) fn place_of(sample: &Sample, [a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let [s, t] = sample.weights;
    let r = 1.0 - s - t;
    [s * a[0] + t * b[0] + r * c[0], s * a[1] + t * b[1] + r * c[1], s * a[2] + t * b[2] + r * c[2]]
}

fn measure_frames(
    vertices: &Vertices<'_>,
    triangles: &[[u32; 3]],
    levels: &[&[[u32; 3]]],
    poses: &LodPoses<'_>,
    frames: &[usize],
    samples_per_frame: u32,
) -> Vec<MeasuredError> {
    // In the order of the tree, so that one search finds what it needs where the last one was.
    let ordered_samples = |side: &[[u32; 3]], tree: &ClosestTriangles| {
        let mut samples = spread_samples(vertices.positions, side, samples_per_frame);
        let places = tree.places();
        samples.sort_by_key(|sample| places[sample.triangle as usize]);
        samples
    };
    let full_tree = ClosestTriangles::new(vertices.positions, triangles);
    let full_samples = ordered_samples(triangles, &full_tree);
    let level_trees: Vec<ClosestTriangles> =
        levels.par_iter().map(|level| ClosestTriangles::new(vertices.positions, level)).collect();
    let level_samples: Vec<Vec<Sample>> =
        levels.par_iter().zip(&level_trees).map(|(level, tree)| ordered_samples(level, tree)).collect();

    // Sum of squares, count and largest square for each frame and level.
    let by_frame: Vec<Vec<(f64, u32, f32)>> = frames
        .par_iter()
        .map(|&frame| {
            let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
            let posed = pose_all(vertices, palette);
            let mut full_tree = full_tree.clone();
            full_tree.refit(&posed, triangles);
            // A level's triangle is the one of full detail at its place, and what lies close in one level does in the next.
            let mut there_hints: Vec<u32> = full_samples.iter().map(|sample| sample.triangle).collect();
            let measure = |i: usize| {
                let mut level_tree = level_trees[i].clone();
                level_tree.refit(&posed, levels[i]);
                let mut back_hints: Vec<u32> = level_samples[i].iter().map(|sample| sample.triangle).collect();
                let there = one_sided(&posed, triangles, &full_samples, levels[i], &level_tree, &mut there_hints);
                let back = one_sided(&posed, levels[i], &level_samples[i], triangles, &full_tree, &mut back_hints);
                (there.0 + back.0, there.1 + back.1, there.2.max(back.2))
            };
            (0..levels.len()).map(measure).collect()
        })
        .collect();

    (0..levels.len())
        .map(|level| {
            let (mut sum, mut count, mut largest, mut max_frame) = (0.0, 0_u64, 0.0_f32, 0);
            for (i, &frame) in frames.iter().enumerate() {
                let (frame_sum, frame_count, frame_largest) = by_frame[i][level];
                sum += frame_sum;
                count += u64::from(frame_count);
                if frame_largest > largest {
                    largest = frame_largest;
                    max_frame = frame as u32;
                }
            }
            let rms_m = if count == 0 { 0.0 } else { (sum / count as f64).sqrt() as f32 };
            MeasuredError { rms_m, max_m: largest.sqrt(), max_frame }
        })
        .collect()
}

fn pose_all(vertices: &Vertices<'_>, palette: &[Mat3x4]) -> Vec<[f32; 3]> {
    let pose = |i: usize| pose_position(vertices.positions[i], vertices.joints[i], vertices.weights[i], palette);
    (0..vertices.positions.len()).map(pose).collect()
}

/// Squared distances from samples of one mesh to the other: their sum, their count, the largest. `hints`: for each sample a triangle
/// of the other that is likely close; the closest afterwards.
fn one_sided(
    posed: &[[f32; 3]],
    from: &[[u32; 3]],
    samples: &[Sample],
    to: &[[u32; 3]],
    to_tree: &ClosestTriangles,
    hints: &mut [u32],
) -> (f64, u32, f32) {
    let (mut sum, mut largest, mut count) = (0.0_f64, 0.0_f32, 0);
    for (sample, hint) in samples.iter().zip(hints) {
        let point = place_of(sample, from[sample.triangle as usize].map(|v| posed[v as usize]));
        if let Some((found, squared)) = to_tree.closest(point, posed, to, *hint) {
            *hint = found;
            sum += f64::from(squared);
            largest = largest.max(squared);
            count += 1;
        }
    }
    (sum, count, largest)
}

/// Points spread over a mesh by bind-pose area: evenly along the summed areas, low-discrepancy within the triangles.
pub(crate) fn spread_samples(positions: &[[f32; 3]], triangles: &[[u32; 3]], count: u32) -> Vec<Sample> {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let n = cross(sub(b, a), sub(c, a));
        f64::from(dot(n, n).sqrt())
    };
    let areas: Vec<f64> = triangles.iter().map(area).collect();
    let total: f64 = areas.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let (mut triangle, mut passed) = (0, areas[0]);
    (0..count)
        .map(|i| {
            let mark = (f64::from(i) + 0.5) / f64::from(count) * total;
            while passed < mark && triangle + 1 < triangles.len() {
                triangle += 1;
                passed += areas[triangle];
            }
            // The R2 sequence: multiples of the plastic number's inverse powers.
            let unit = |step: f64| {
                let x = 0.5 + step * f64::from(i + 1);
                x - x.floor()
            };
            let (x, y) = (unit(0.754_877_666_246_692_7), unit(0.569_840_290_998_053_3));
            let (s, t) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            Sample { triangle: triangle as u32, weights: [s as f32, t as f32] }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{REST, TestMesh, TestPoses, grid};

    fn measure(mesh: &TestMesh, level: &[[u32; 3]], poses: &TestPoses, samples: u32) -> MeasuredError {
        measure_level(&mesh.positions, &mesh.joints, &mesh.weights, &mesh.triangles, level, &poses.poses(), samples)
    }

    #[test]
    fn full_detail_lies_on_itself() {
        let mesh = grid(5, 5, |x, y| ((x * y) % 3) as f32, |_, _| false);
        let error = measure(&mesh, &mesh.triangles, &TestPoses::rest(), 500);
        assert!(error.max_m < 1.0e-5, "{error:?}");
    }

    /// A tent of 2 x 2 quads, 1 m high in the middle, against the flat square below it.
    #[test]
    fn tent_against_ground_by_fine_sums() {
        let mesh = grid(2, 2, |x, y| if x == 1 && y == 1 { 1.0 } else { 0.0 }, |_, _| false);
        let corner = |x: f32, y: f32| {
            mesh.positions.iter().position(|p| p[0] == x && p[1] == y).expect("a corner of the grid") as u32
        };
        let (a, b, c, d) = (corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 2.0), corner(0.0, 2.0));
        let flat = [[a, b, c], [a, c, d]];
        let error = measure(&mesh, &flat, &TestPoses::rest(), 20_000);
        assert!((0.9..=1.0).contains(&error.max_m), "the peak is 1 m above the ground: {error:?}");
        let coarse = measure(&mesh, &flat, &TestPoses::rest(), 2_000);
        assert!((error.rms_m - coarse.rms_m).abs() < 0.02 * error.rms_m, "{error:?} {coarse:?}");
        assert!((0.3..0.6).contains(&error.rms_m), "{error:?}");
    }

    #[test]
    fn largest_error_names_its_frame_and_scales_with_the_pose() {
        let mesh = grid(2, 2, |x, y| if x == 1 && y == 1 { 1.0 } else { 0.0 }, |_, _| false);
        let corner = |x: f32, y: f32| {
            mesh.positions.iter().position(|p| p[0] == x && p[1] == y).expect("a corner of the grid") as u32
        };
        let flat = [
            [corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 2.0)],
            [corner(0.0, 0.0), corner(2.0, 2.0), corner(0.0, 2.0)],
        ];
        let tripled = REST.map(|row| row.map(|c| c * 3.0));
        let error = measure(&mesh, &flat, &TestPoses::even(vec![REST, tripled, REST], 1), 1000);
        let small = measure(&mesh, &flat, &TestPoses::rest(), 1000);
        assert_eq!(error.max_frame, 1);
        assert!((error.max_m - 3.0 * small.max_m).abs() < 1.0e-4, "{error:?} {small:?}");
    }

    #[test]
    fn nothing_measures_nothing() {
        let mesh = TestMesh::default();
        assert_eq!(measure(&mesh, &[], &TestPoses::rest(), 100), MeasuredError::default());
        let mesh = grid(1, 1, |_, _| 0.0, |_, _| false);
        assert_eq!(measure(&mesh, &[], &TestPoses::rest(), 100), MeasuredError::default());
        assert_eq!(measure(&mesh, &mesh.triangles, &TestPoses::rest(), 0), MeasuredError::default());
    }
}
