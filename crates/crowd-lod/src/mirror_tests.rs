//! Whole levels of a mirrored character: both halves alike, both eyes or none.

use crate::test_meshes::*;
use crate::{CollapseOrder, Criteria, Level, LodOptions, distances_to_surface, reform};

const WHITE: [u8; 4] = [255; 4];
const SKIN: [u8; 4] = [200, 120, 90, 255];

/// A mesh moved, scaled and coloured.
fn placed(mut mesh: TestMesh, at: [f32; 3], size: [f32; 3], color: [u8; 4]) -> TestMesh {
    mesh.positions.iter_mut().for_each(|p| *p = [0, 1, 2].map(|i| p[i] * size[i] + at[i]));
    mesh.colors.fill(color);
    mesh
}

/// The same to the other side of x = 0, bit for bit, turned inside out so that fronts stay fronts.
fn mirrored(mesh: &TestMesh) -> TestMesh {
    let mut other = mesh.clone();
    other.positions.iter_mut().chain(&mut other.normals).for_each(|p| p[0] = -p[0]);
    other.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    other
}

/// The half of a bumpy head at x >= 0; its cut lies on the plane, bit for bit.
fn half_head() -> TestMesh {
    let whole = uv_sphere(40, 28);
    let mut half =
        TestMesh { triangles: Vec::new(), materials: Vec::new(), ..placed(whole.clone(), [0.0; 3], [1.0; 3], SKIN) };
    for p in &mut half.positions {
        if p[0].abs() < 1.0e-6 {
            p[0] = 0.0;
        }
        let bump = 1.0 + 0.12 * libm::sinf(5.0 * p[1] + 1.0) + 0.08 * libm::cosf(6.0 * p[0] + 3.0 * p[2]);
        *p = p.map(|c| c * bump);
    }
    for &t in &whole.triangles {
        if t.iter().all(|&v| half.positions[v as usize][0] >= 0.0) {
            half.triangle(t);
        }
    }
    half
}

/// A head, two ears, two eyes: the left half and its mirror image.
fn character() -> TestMesh {
    let mut half = half_head();
    half.append(&placed(uv_sphere(12, 8), [1.15, 0.1, 0.0], [0.18, 0.3, 0.35], SKIN));
    half.append(&placed(uv_sphere(8, 6), [0.4, 0.95, 0.35], [0.09; 3], WHITE));
    let other = mirrored(&half);
    half.append(&other);
    half
}

/// A level as places and triangles.
fn level_at(mesh: &TestMesh, order: &CollapseOrder, level: &Level) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let ordered = in_order(mesh, order);
    (ordered.positions, reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count))
}

/// Root mean square distance of a surface's corners and middles to its own mirror image.
fn lopsidedness(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f32 {
    let image: Vec<[f32; 3]> = positions.iter().map(|p| [-p[0], p[1], p[2]]).collect();
    let mut points: Vec<[f32; 3]> = triangles.iter().flatten().map(|&v| positions[v as usize]).collect();
    points.extend(triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0)
    }));
    let distances = distances_to_surface(&points, &image, triangles);
    (distances.iter().map(|d| d * d).sum::<f32>() / distances.len() as f32).sqrt()
}

/// Triangles of the left eye and of the right one.
fn eyes(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> [usize; 2] {
    let near = |v: u32, side: f32| {
        let p = positions[v as usize];
        let off = [p[0] - side * 0.4, p[1] - 0.95, p[2] - 0.35];
        off.iter().map(|c| c * c).sum::<f32>() < 0.1 * 0.1
    };
    [1.0, -1.0].map(|side| triangles.iter().filter(|t| t.iter().all(|&v| near(v, side))).count())
}

/// Two frames in which the head bows, turns and leans to one side, and one eye comes out.
fn lopsided_motion() -> TestPoses {
    let turned = |by: f32, out: f32| {
        let (s, c) = (libm::sinf(by), libm::cosf(by));
        let head = [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let mut eye = head;
        eye[0][3] = -s * out;
        eye[1][3] = c * out;
        [head, eye]
    };
    TestPoses::even([turned(0.5, 0.01), turned(0.7, 0.02)].concat(), 2)
}

#[test]
fn both_eyes_go_together_where_one_moves_and_the_other_does_not() {
    let mut mesh = character();
    for v in 0..mesh.positions.len() {
        let in_left_eye = eyes(&mesh.positions, &[[v as u32; 3]])[0] > 0;
        mesh.joints[v] = [0, 1, 0, 0];
        mesh.weights[v] = if in_left_eye { [0.0, 1.0, 0.0, 0.0] } else { [1.0, 0.0, 0.0, 0.0] };
    }
    let order = simplify_checked(&mesh, &lopsided_motion(), &quick());
    let counts: Vec<(u32, [usize; 2])> = order
        .levels
        .iter()
        .map(|level| {
            let (positions, triangles) = level_at(&mesh, &order, level);
            (level.triangle_count, eyes(&positions, &triangles))
        })
        .collect();
    let gone = [0, 1].map(|side| counts.iter().find(|(_, eyes)| eyes[side] > 0).expect("full detail has eyes").0);
    assert!(gone[0] > counts[0].0, "they do go: {counts:?}");
    assert!(gone[0].abs_diff(gone[1]) <= 4, "{gone:?}");
}

#[test]
fn a_level_is_nearly_its_own_mirror_image_and_has_both_eyes_or_none() {
    let mesh = character();
    let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
    let full = mesh.triangles.len() as f32;
    for (share, most_m) in [(0.5, 0.001), (0.25, 0.003), (0.1, 0.008), (0.05, 0.024)] {
        let level = order.levels.iter().rfind(|l| l.triangle_count as f32 <= share * full).expect("so small a level");
        let (positions, triangles) = level_at(&mesh, &order, level);
        let off = lopsidedness(&positions, &triangles);
        assert!(off < most_m, "{share}: {off} m of 2 m");
        let [left, right] = eyes(&positions, &triangles);
        assert!(left.abs_diff(right) <= 2 && (left > 0) == (right > 0), "{share}: {left} and {right}");
    }
    // Over the whole order: where one eye goes, the other goes with the next few triangles.
    let gone = |side: usize| {
        let has = |level: &&Level| {
            let (positions, triangles) = level_at(&mesh, &order, level);
            eyes(&positions, &triangles)[side] > 0
        };
        order.levels.iter().find(has).expect("full detail has eyes").triangle_count
    };
    assert!(gone(0).abs_diff(gone(1)) <= 4, "{} {}", gone(0), gone(1));
}

#[test]
fn a_level_with_one_eye_or_without_its_partners_is_found_out() {
    let mesh = character();
    assert!(lopsidedness(&mesh.positions, &mesh.triangles) < 1.0e-6);
    assert_eq!(eyes(&mesh.positions, &mesh.triangles), [80, 80]);
    let in_left_eye = |t: &[u32; 3]| eyes(&mesh.positions, &[*t])[0] > 0;
    let one_eye: Vec<[u32; 3]> = mesh.triangles.iter().copied().filter(|t| !in_left_eye(t)).collect();
    assert!(lopsidedness(&mesh.positions, &one_eye) > 0.01);
    assert_eq!(eyes(&mesh.positions, &one_eye), [0, 80]);
    // The paper's order knows no partners.
    let paper = LodOptions { criteria: Criteria::Peng2011, ..quick() };
    let order = simplify_checked(&mesh, &TestPoses::rest(), &paper);
    let level =
        order.levels.iter().rfind(|l| l.triangle_count as usize <= mesh.triangles.len() / 4).expect("a quarter");
    let (positions, triangles) = level_at(&mesh, &order, level);
    assert!(lopsidedness(&positions, &triangles) > 0.002);
}
