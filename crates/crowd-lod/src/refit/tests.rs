//! The whole of [`refit`]: on shapes whose best fit is known, on seams, and on what is hardly a mesh.

use super::*;
use crate::test_meshes::*;
use crate::{Mat3x4, MeasuredError, measure_level, reform, simplify};
use proptest::prelude::*;

fn order_of(mesh: &TestMesh, poses: &TestPoses) -> CollapseOrder {
    simplify(&mesh.mesh(), &poses.poses(), &quick(), &|_| ()).expect("a valid mesh")
}

/// The finest level with at most this many triangles.
fn level_at(order: &CollapseOrder, triangles: u32) -> Level {
    let above = order.levels.partition_point(|level| level.triangle_count <= triangles);
    order.levels[above.max(1) - 1]
}

/// How far a level is from full detail, on points of [`measure_level`]'s own.
fn distance(mesh: &TestMesh, order: &CollapseOrder, level: &LevelMesh, poses: &TestPoses) -> MeasuredError {
    let base = mesh.positions.len() as u32;
    let positions = [mesh.positions.as_slice(), &level.positions].concat();
    let joints = [mesh.joints.as_slice(), &level.joints].concat();
    let weights = [mesh.weights.as_slice(), &level.weights].concat();
    let full: Vec<[u32; 3]> = order.triangle_source.iter().map(|&t| mesh.triangles[t as usize]).collect();
    let moved: Vec<[u32; 3]> = level.triangles.iter().map(|t| t.map(|v| v + base)).collect();
    measure_level(&positions, &joints, &weights, &full, &moved, &poses.poses(), 4000)
}

fn before_and_after(mesh: &TestMesh, poses: &TestPoses, held_out: &TestPoses, triangles: u32) -> [MeasuredError; 2] {
    let order = order_of(mesh, poses);
    let level = level_at(&order, triangles);
    let before = level_mesh(&mesh.mesh(), &order, &level);
    let after = refit(&mesh.mesh(), &poses.poses(), &order, &level, &RefitOptions::default());
    check_level(&before, &after);
    [before, after].map(|level| distance(mesh, &order, &level, held_out))
}

/// Edges that one triangle has alone, as vertices.
fn borders(level: &LevelMesh) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = level
        .triangles
        .iter()
        .flat_map(|t| [0, 1, 2].map(|i| [t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3])]))
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|group| group.len() == 1).map(|group| group[0]).collect()
}

/// Finite everywhere, unit normals, weights that sum to 1, and the same connectivity but for flipped edges.
fn check_level(before: &LevelMesh, after: &LevelMesh) {
    assert_eq!((&before.vertices, before.triangles.len()), (&after.vertices, after.triangles.len()));
    assert_eq!(borders(before), borders(after));
    assert!(after.positions.as_flattened().iter().chain(after.uvs.as_flattened()).all(|c| c.is_finite()));
    for v in 0..after.vertices.len() {
        let [x, y, z] = after.normals[v];
        let length = (x * x + y * y + z * z).sqrt();
        assert!((length - 1.0).abs() < 1.0e-3 || after.normals[v] == before.normals[v], "{:?}", after.normals[v]);
        let sum: f32 = after.weights[v].iter().sum();
        assert!((sum - 1.0).abs() < 1.0e-3 && after.weights[v].iter().all(|&w| w >= 0.0), "{:?}", after.weights[v]);
    }
}

/// Turns about x, around the point (0, 0, `height`).
fn bend(angle: f32, height: f32) -> Mat3x4 {
    let (sine, cosine) = (libm::sinf(angle), libm::cosf(angle));
    [[1.0, 0.0, 0.0, 0.0], [0.0, cosine, -sine, sine * height], [0.0, sine, cosine, height - cosine * height]]
}

/// An arm along z with its elbow in the middle, and poses from straight to bent by `angles`.
fn arm(angles: &[f32]) -> (TestMesh, TestPoses) {
    let mut mesh = tube(24, 48, 12.0, true);
    for v in 0..mesh.positions.len() {
        let along = ((mesh.positions[v][2] - 5.0) / 2.0).clamp(0.0, 1.0);
        mesh.joints[v] = [0, 1, 0, 0];
        mesh.weights[v] = [1.0 - along, along, 0.0, 0.0];
    }
    let palettes = angles.iter().flat_map(|&angle| [REST, bend(angle, 6.0)]).collect();
    (mesh, TestPoses::even(palettes, 2))
}

#[test]
fn inscribed_sphere_grows_to_the_mean() {
    let mesh = uv_sphere(48, 32);
    for triangles in [600, 200] {
        let [before, after] = before_and_after(&mesh, &TestPoses::rest(), &TestPoses::rest(), triangles);
        assert!(after.rms_m * 1.5 <= before.rms_m, "{triangles}: {before:?} {after:?}");
    }
}

#[test]
fn bent_arm_comes_closer_in_poses_not_seen() {
    let (mesh, poses) = arm(&[0.0, 0.5, 1.0, 1.5, 2.0]);
    let (_, held_out) = arm(&[0.25, 0.75, 1.25, 1.75]);
    let [before, after] = before_and_after(&mesh, &poses, &held_out, 300);
    assert!(after.rms_m * 1.4 <= before.rms_m, "{before:?} {after:?}");
}

/// The arm with weights that change over half the elbow's length, places as they should be.
#[test]
fn wrong_weights_are_mended() {
    let (mesh, poses) = arm(&[0.0, 0.5, 1.0, 1.5, 2.0]);
    let (_, held_out) = arm(&[0.25, 0.75, 1.25, 1.75]);
    let order = order_of(&mesh, &poses);
    let mut wrong = level_mesh(&mesh.mesh(), &order, &level_at(&order, 300));
    for weights in &mut wrong.weights {
        let along = (weights[1] * 2.0 - 0.5).clamp(0.0, 1.0);
        *weights = [1.0 - along, along, 0.0, 0.0];
    }
    let (view, poses) = (mesh.mesh(), poses.poses());
    let full = FullDetail::new(&view, &poses, &order, 24);
    let mut fit = Fit::new(&full, &order, wrong.clone());
    fit.most_error = f64::INFINITY;
    (0..3).for_each(|_| fit.fit_weights());
    let mended = fit.finish();
    check_level(&wrong, &mended);
    assert_eq!(mended.positions, wrong.positions);
    let [before, after] = [&wrong, &mended].map(|level| distance(&mesh, &order, level, &held_out));
    assert!(after.rms_m * 2.0 <= before.rms_m, "{before:?} {after:?}");
    let fitted = mended.weights.iter().zip(&wrong.weights).filter(|(after, before)| after != before);
    for weight in fitted.flat_map(|(after, _)| after) {
        let steps = weight * 65535.0;
        assert!((steps - steps.round()).abs() < 0.01, "{weight} is not stored so");
    }
}

/// Where input vertices were welded, the level's vertices still are.
#[test]
fn seams_stay_together_to_the_bit() {
    let (mut together, mut moved) = (0, 0);
    for mesh in [arm(&[0.0]).0, tube(16, 12, 6.0, true), uv_sphere(24, 16)] {
        let (_, poses) = arm(&[0.0, 1.0, 2.0]);
        let order = order_of(&mesh, &poses);
        let level = level_at(&order, mesh.triangles.len() as u32 / 2);
        let before = level_mesh(&mesh.mesh(), &order, &level);
        let after = refit(&mesh.mesh(), &poses.poses(), &order, &level, &RefitOptions::default());
        for a in 0..before.vertices.len() {
            for b in 0..a {
                if before.positions[a] == before.positions[b] {
                    together += 1;
                    moved += usize::from(after.positions[a] != before.positions[a]);
                    assert_eq!(after.positions[a].map(f32::to_bits), after.positions[b].map(f32::to_bits));
                    assert_eq!((after.joints[a], after.weights[a]), (after.joints[b], after.weights[b]));
                }
            }
        }
    }
    assert!(together > 20 && moved > 10, "{together} {moved}");
}

/// Two balls, one in the other, so close that a level's facets cut through both.
#[test]
fn shells_that_lie_close_keep_apart() {
    let mut mesh = uv_sphere(32, 24);
    let mut outer = uv_sphere(30, 22);
    outer.positions.iter_mut().for_each(|p| *p = p.map(|c| c * 1.01));
    mesh.append(&outer);
    let order = order_of(&mesh, &TestPoses::rest());
    let level = level_at(&order, order.triangles.len() as u32 / 3);
    let before = level_mesh(&mesh.mesh(), &order, &level);
    let after = refit(&mesh.mesh(), &TestPoses::rest().poses(), &order, &level, &RefitOptions::default());
    check_level(&before, &after);
    // Each shell is as far out, in the mean over its area, as at full detail.
    let inner_count = uv_sphere(32, 24).positions.len() as u32;
    let length = |p: [f32; 3]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    let mean_radius = |triangles: &mut dyn Iterator<Item = [[f32; 3]; 3]>| {
        let (mut sum, mut areas) = (0.0, 0.0);
        for [a, b, c] in triangles {
            let area = length(crate::quadrics::cross(crate::quadrics::sub(b, a), crate::quadrics::sub(c, a)));
            let middle = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
            sum += area * (length(middle) * 0.75 + (length(a) + length(b) + length(c)) / 12.0);
            areas += area;
        }
        sum / areas
    };
    for outer in [false, true] {
        let source = |v: u32| order.vertex_source[after.vertices[v as usize] as usize];
        let full = mesh.triangles.iter().filter(|t| (t[0] >= inner_count) == outer);
        let fitted = after.triangles.iter().filter(|t| (source(t[0]) >= inner_count) == outer);
        let full = mean_radius(&mut full.map(|t| t.map(|v| mesh.positions[v as usize])));
        let fitted = mean_radius(&mut fitted.map(|t| t.map(|v| after.positions[v as usize])));
        assert!((full - fitted).abs() < 0.001, "{full} {fitted}");
    }
}

#[test]
fn texture_triangles_keep_their_side() {
    let mesh = grid(24, 24, |x, y| libm::sinf(x as f32 * 0.4) * libm::cosf(y as f32 * 0.3) * 2.0, |x, _| x == 11);
    let order = order_of(&mesh, &TestPoses::rest());
    for triangles in [400, 150, 60] {
        let level = level_at(&order, triangles);
        let before = level_mesh(&mesh.mesh(), &order, &level);
        let after = refit(&mesh.mesh(), &TestPoses::rest().poses(), &order, &level, &RefitOptions::default());
        for t in &after.triangles {
            let area = |level: &LevelMesh| {
                let [a, b, c] = t.map(|v| level.uvs[v as usize]);
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            assert!(area(&before) * area(&after) >= 0.0);
        }
        // Rims run straight along v = 0 and v = 1: who was there stays there.
        for (before, after) in before.uvs.iter().zip(&after.uvs) {
            assert!((-1.0e-5..=1.00001).contains(&after[1]), "{after:?}");
            assert!(
                (before[1] != 0.0 && before[1] != 1.0) || (after[1] - before[1]).abs() < 1.0e-5,
                "{before:?} {after:?}"
            );
        }
    }
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let (mesh, poses) = arm(&[0.0, 0.7, 1.4]);
    let order = order_of(&mesh, &poses);
    let level = level_at(&order, 400);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| refit(&mesh.mesh(), &poses.poses(), &order, &level, &RefitOptions::default()))
    };
    let [one, two, eight] = [run(1), run(2), run(8)];
    assert_eq!(one, two);
    assert_eq!(one, eight);
}

#[test]
fn no_rounds_leave_the_level() {
    let mesh = uv_sphere(12, 8);
    let order = order_of(&mesh, &TestPoses::rest());
    let level = level_at(&order, 60);
    let options = RefitOptions { rounds: 0, ..RefitOptions::default() };
    let same = refit(&mesh.mesh(), &TestPoses::rest().poses(), &order, &level, &options);
    assert_eq!(same, level_mesh(&mesh.mesh(), &order, &level));
}

#[test]
fn hardly_a_mesh_does_no_harm() {
    let mut one = TestMesh::default();
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|p| one.vertex(p, [p[0], p[1]]));
    one.triangle(corners);
    let mut thread = TestMesh::default();
    for x in 0..4 {
        thread.vertex([x as f32, 0.0, 0.0], [0.0; 2]);
    }
    thread.triangle([0, 1, 2]);
    thread.triangle([1, 2, 3]);
    let mut sheets = grid(6, 6, |x, y| ((x * y) % 3) as f32, |_, _| false);
    sheets.append(&sheets.clone());
    sheets.append(&thread);
    let nothing = [[0.0; 4]; 3];
    for mesh in [one, thread, sheets, TestMesh::default()] {
        for poses in [TestPoses::rest(), TestPoses::even(vec![REST, nothing, REST], 1)] {
            let order = order_of(&mesh, &poses);
            for level in order.levels.iter().step_by(1 + order.levels.len() / 6) {
                let before = level_mesh(&mesh.mesh(), &order, level);
                let after = refit(&mesh.mesh(), &poses.poses(), &order, level, &RefitOptions::default());
                check_level(&before, &after);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Measured on other points than those it was fitted to.
    #[test]
    fn no_level_gets_further_away(heights in prop::collection::vec(-1.0_f32..1.0, 121), share in 0.05_f32..0.8) {
        let mesh = grid(10, 10, |x, y| heights[y * 11 + x], |x, y| x == 5 && y > 3);
        let order = order_of(&mesh, &TestPoses::rest());
        let level = level_at(&order, (200.0 * share) as u32);
        let before = level_mesh(&mesh.mesh(), &order, &level);
        let after = refit(&mesh.mesh(), &TestPoses::rest().poses(), &order, &level, &RefitOptions::default());
        check_level(&before, &after);
        let [b, a] = [&before, &after].map(|level| distance(&mesh, &order, level, &TestPoses::rest()).rms_m);
        prop_assert!(a <= b * 1.01 + 1.0e-6, "{b} {a}");
        prop_assert_eq!(
            reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count).len(),
            after.triangles.len()
        );
    }
}

#[test]
fn slides_cost_what_the_colours_change() {
    let mesh = tube(8, 4, 3.0, true);
    let sources: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let shares = |triangle_contrast: &[f32]| {
        let appearance = crate::Appearance { triangle_contrast, ..Default::default() };
        pulls::slide_shares(&LodMesh { appearance, ..mesh.mesh() }, &mesh.triangles, &sources)
    };
    let count = mesh.triangles.len();
    let (unknown, plain, motley) = (shares(&[]), shares(&vec![0.0; count]), shares(&vec![4.0; count]));
    assert_eq!(unknown, plain);
    let wild = shares(&vec![f32::MAX; count]);
    for t in 0..count {
        assert!(plain[t] < motley[t] && motley[t] < wild[t] && wild[t] < 1.0, "{} {} {}", plain[t], motley[t], wild[t]);
    }
}
