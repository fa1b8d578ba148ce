//! Meshes and poses that no modeller would make: each ends in levels that can be drawn, or in an error with a name.

use crate::test_meshes::{REST, TestMesh, TestPoses, in_order, quick, uv_sphere};
use crate::{CollapseOrder, Criteria, LodOptions, Mat3x4, find_layers, measure_interpenetration, reform, simplify};
use crate::{Error, LayeredMesh, LevelSurface, geometric_levels, measure_surfaces};
use proptest::prelude::*;

/// Panics unless every level can be drawn: indices within it, three corners at three places each, numbers that are
/// numbers, counts that add up, measures that are finite.
fn check_levels(mesh: &TestMesh, poses: &TestPoses, order: &CollapseOrder) {
    let full = order.levels.last().expect("full detail is a level");
    assert_eq!(full.triangle_count as usize, order.triangles.len());
    let dropped = order.seams.degenerate_triangle_count + order.seams.duplicate_triangle_count;
    assert_eq!(order.triangles.len() + dropped as usize, mesh.triangles.len(), "every triangle is kept or counted");
    for level in &order.levels {
        let triangles = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
        assert_eq!(triangles.len(), level.triangle_count as usize);
        assert!(triangles.iter().flatten().all(|&v| v < level.vertex_count));
        assert!(level.error_m.is_finite() && level.error_m >= 0.0, "{level:?}");
        if level.triangle_count < full.triangle_count {
            let [a, b, c] = [0, 1, 2].map(|i| triangles.iter().map(move |t| t[i]));
            for ((a, b), c) in a.zip(b).zip(c) {
                assert!(a != b && b != c && c != a, "a triangle of two corners");
            }
        }
    }
    let measured: Vec<Vec<[u32; 3]>> = geometric_levels(&order.levels, 3)
        .into_iter()
        .map(|i| order.levels[i])
        .map(|level| reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count))
        .collect();
    let measured: Vec<LevelSurface<'_>> = measured.iter().map(|level| LevelSurface::Shared(level)).collect();
    let ordered = in_order(mesh, order);
    let texels = vec![[64.0; 2]; ordered.positions.len()];
    for error in measure_surfaces(&ordered.surface(), &texels, &measured, &poses.poses(), 2, 50) {
        let numbers = [error.rms_m, error.max_m, error.bound_m, error.uv_drift_p95_texels, error.normal_mean_deg];
        assert!(numbers.iter().all(|number| number.is_finite()), "{error:?}");
    }
}

fn simplified(mesh: &TestMesh, poses: &TestPoses) -> CollapseOrder {
    let order = simplify(&mesh.mesh(), &poses.poses(), &quick(), &|_| ()).expect("the mesh is odd, not wrong");
    check_levels(mesh, poses, &order);
    order
}

fn triangle() -> TestMesh {
    let mut mesh = TestMesh::default();
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
        mesh.vertex([x, y, 0.0], [x, y]);
    }
    mesh.triangle([0, 1, 2]);
    mesh
}

fn changed(change: impl Fn(&mut TestMesh)) -> TestMesh {
    let mut mesh = uv_sphere(12, 8);
    change(&mut mesh);
    mesh
}

/// Counts of a report that a case may raise: degenerate, duplicate, coincident, non-manifold edges.
type Counts = [u32; 4];

#[test]
fn each_oddity_is_kept_or_counted() {
    let zero: Mat3x4 = [[0.0; 4]; 3];
    let flat: Mat3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0, 0.0, 1.0, 0.0]];
    let mirror: Mat3x4 = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let rest = TestPoses::rest;
    let sphere = || uv_sphere(12, 8);
    let cases: Vec<(&str, TestMesh, TestPoses, Counts)> = vec![
        ("a character of one triangle", triangle(), rest(), [0, 0, 0, 0]),
        (
            "a triangle that uses a vertex twice",
            changed(|m| {
                m.triangle([5, 5, 6]);
                m.triangle([5, 5, 5]);
            }),
            rest(),
            [2, 0, 0, 0],
        ),
        (
            "two corners at one place",
            changed(|m| {
                let twin = m.vertex(m.positions[20], [0.9, 0.1]);
                m.triangle([20, twin, 21]);
            }),
            rest(),
            [1, 0, 0, 0],
        ),
        (
            "three corners on a line",
            changed(|m| {
                let line = [0.0, 1.0, 2.0].map(|x| m.vertex([x + 5.0, 0.0, 0.0], [x, 0.0]));
                m.triangle(line);
            }),
            rest(),
            [0, 0, 0, 0],
        ),
        ("a triangle given twice", changed(|m| m.triangle(m.triangles[30])), rest(), [0, 1, 0, 0]),
        (
            "a sheet with a second one on its back",
            changed(|m| {
                let mut back = m.clone();
                back.triangles.iter_mut().for_each(|t| t.reverse());
                m.append(&back);
            }),
            rest(),
            // Every edge of the sphere, each with two triangles of either sheet.
            [0, 0, 2 * 12 * 2 * 7, 12 * 7 + 12 * 6 + 12 * 8],
        ),
        (
            "a page on an edge",
            changed(|m| {
                let [a, b, _] = m.triangles[40];
                let top = m.vertex([0.0, 0.0, 3.0], [0.5, 0.5]);
                m.triangle([a, b, top]);
            }),
            rest(),
            [0, 0, 0, 1],
        ),
        (
            "a component turned inside out",
            changed(|m| m.triangles.iter_mut().for_each(|t| t.reverse())),
            rest(),
            [0; 4],
        ),
        ("one triangle turned round", changed(|m| m.triangles[33].reverse()), rest(), [0; 4]),
        ("a clip that scales its only joint to zero", sphere(), TestPoses::even(vec![REST, zero, zero], 1), [0; 4]),
        ("no frame that shows anything", sphere(), TestPoses::even(vec![zero], 1), [0; 4]),
        ("a clip that flattens it and one that mirrors it", sphere(), TestPoses::even(vec![flat, mirror], 1), [0; 4]),
        ("everything at one place", changed(|m| m.positions.fill([1.0, 2.0, 3.0])), rest(), [168, 0, 0, 0]),
    ];
    for (what, mesh, poses, counts) in cases {
        for criteria in [Criteria::Wedge, Criteria::Peng2011] {
            let options = LodOptions { criteria, ..LodOptions::default() };
            let order = simplify(&mesh.mesh(), &poses.poses(), &options, &|_| ())
                .unwrap_or_else(|error| panic!("{what}: {error}"));
            check_levels(&mesh, &poses, &order);
            let s = &order.seams;
            let found = [
                s.degenerate_triangle_count,
                s.duplicate_triangle_count,
                s.coincident_triangle_count,
                s.non_manifold_edge_count,
            ];
            assert_eq!(found, counts, "{what}");
        }
    }
}

#[test]
fn bow_ties_are_counted_as_positions() {
    let mut mesh = triangle();
    let (a, b) = (mesh.vertex([-1.0, 0.0, 0.0], [0.0, 0.0]), mesh.vertex([0.0, -1.0, 0.0], [0.0, 0.0]));
    mesh.triangle([0, a, b]);
    let seams = simplified(&mesh, &TestPoses::rest()).seams;
    assert_eq!((seams.non_manifold_position_count, seams.non_manifold_edge_count), (1, 0));
}

#[test]
fn more_vertices_than_sixteen_bits_count() {
    let mesh = uv_sphere(300, 240);
    assert!(mesh.positions.len() > 1 << 16);
    let order = simplify(&mesh.mesh(), &TestPoses::rest().poses(), &quick(), &|_| ()).expect("a valid mesh");
    assert!(order.vertex_source.len() > 1 << 16);
    assert!(order.levels[0].triangle_count < 100, "{:?} {:?}", order.levels[0], order.blocked);
    let full = order.levels.last().expect("full detail is a level");
    let last = reform(&order.triangles, &order.collapse_map, full.vertex_count, full.triangle_count);
    assert!(last.iter().flatten().any(|&v| v >= 1 << 16));
}

/// Pages on one edge: all would go to its ends, each collapse there made all others look again. Counted, not timed.
#[test]
fn pages_on_one_edge_are_looked_at_a_few_times_each() {
    for (pages, hurried) in [(1_000, false), (2_500, true)] {
        let mut mesh = TestMesh::default();
        let spine = [0.0, 1.0].map(|z| mesh.vertex([0.0, 0.0, z], [0.0, z]));
        for page in 0..pages {
            let angle = page as f32 / pages as f32 * std::f32::consts::TAU;
            let edge = mesh.vertex([libm::cosf(angle), libm::sinf(angle), 0.5], [1.0, 0.5]);
            mesh.triangle([spine[0], spine[1], edge]);
        }
        let order = simplified(&mesh, &TestPoses::rest());
        assert_eq!(order.seams.hurried_collapse_count > 0, hurried, "{pages}: {:?}", order.seams);
        let coarsest = order.levels[0].triangle_count;
        assert!(coarsest < 100, "{coarsest} triangles left, {:?}", order.blocked);
    }
}

fn any_matrix() -> impl Strategy<Value = Mat3x4> {
    prop_oneof![
        2 => Just(REST),
        1 => Just([[0.0; 4]; 3]),
        1 => Just([[0.0, 0.0, 0.0, 1.0]; 3]),
        2 => prop::array::uniform3(prop::array::uniform4(-2.0_f32..2.0)),
        1 => prop::array::uniform3(prop::array::uniform4(-1.0e6_f32..1.0e6)),
        1 => prop::array::uniform3(prop::array::uniform4(-1.0e-20_f32..1.0e-20)),
    ]
}

fn any_coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => (0_u8..3).prop_map(f32::from),
        2 => -1.0_f32..1.0,
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(1.0e6), Just(-1.0e6), Just(1.0e-38), Just(1.0e-45)],
    ]
}

fn any_vertex() -> impl Strategy<Value = ([f32; 3], [f32; 2], [f32; 3], [u16; 4], [f32; 4])> {
    let normal = prop_oneof![Just([0.0, 0.0, 1.0]), Just([0.0; 3]), Just([0.0, -1.0, 0.0])];
    let weights = prop_oneof![
        3 => Just([1.0, 0.0, 0.0, 0.0]),
        1 => Just([0.25; 4]),
        1 => (0.0_f32..1.0).prop_map(|w| [w, 1.0 - w, 0.0, 0.0]),
    ];
    let place = prop::array::uniform3(any_coordinate());
    (place, prop::array::uniform2(any_coordinate()), normal, prop::array::uniform4(0_u16..3), weights)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Soups with odd places, weights, poses and materials: never a panic, never a triangle lost without a count.
    #[test]
    fn any_soup_under_any_poses_gives_levels(
        vertices in prop::collection::vec(any_vertex(), 1..16),
        corners in prop::collection::vec(([0_u32..16, 0_u32..16, 0_u32..16], 0_u16..3), 0..60),
        palettes in prop::collection::vec(prop::collection::vec(any_matrix(), 3), 1..5),
        paper in any::<bool>(),
    ) {
        let mut mesh = TestMesh::default();
        for (place, uv, normal, joints, weights) in &vertices {
            let v = mesh.vertex(*place, *uv) as usize;
            (mesh.normals[v], mesh.joints[v], mesh.weights[v]) = (*normal, *joints, *weights);
        }
        for (corners, material) in &corners {
            mesh.triangle(corners.map(|c| c % vertices.len() as u32));
            *mesh.materials.last_mut().expect("just added") = *material;
        }
        let poses = TestPoses::even(palettes.concat(), 3);
        let criteria = if paper { Criteria::Peng2011 } else { Criteria::Wedge };
        let options = LodOptions { criteria, ..LodOptions::default() };
        match simplify(&mesh.mesh(), &poses.poses(), &options, &|_| ()) {
            Ok(order) => {
                check_levels(&mesh, &poses, &order);
                let layers = find_layers(&mesh.positions, &mesh.triangles);
                let full = LayeredMesh {
                    positions: &mesh.positions,
                    joints: &mesh.joints,
                    weights: &mesh.weights,
                    triangles: &mesh.triangles,
                    triangle_layers: &layers,
                };
                let frames: Vec<usize> = (0..palettes.len()).collect();
                let found = measure_interpenetration(&full, &[full], &poses.poses(), &frames, 20);
                prop_assert!(found[0].mean_share == 0.0 && found[0].mean_area_m2.is_finite(), "{:?}", found);
            }
            Err(Error::Parameter { what, .. }) => prop_assert!(what.starts_with("palettes["), "{what}"),
        }
    }
}
