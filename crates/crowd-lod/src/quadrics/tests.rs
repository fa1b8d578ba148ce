use super::*;
use crate::Appearance;
use crate::classify::classify_wedges;
use crate::split_seams::split_seams;
use crate::test_meshes::{REST, TestMesh, TestPoses, uv_sphere};

/// The cost after two merges equals the mean over frames of area-weighted squared plane distances, summed by hand
/// in f64 over all triangles of the merged positions.
#[test]
fn cost_is_the_mean_of_plane_distances_over_frames() {
    let mesh = uv_sphere(9, 7);
    let stretched = [[2.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.5, 0.0], [0.0, 0.0, 1.0, -3.0]];
    let mut poses = TestPoses::even(vec![REST, stretched, REST], 1);
    poses.frame_weights = vec![0.2, 0.7, 0.1];
    let split = split_seams(&mesh.mesh());
    let mut classes = classify_wedges(&split);
    classes.edge_kinds.fill([EdgeKind::Interior; 3]);
    let build = |criteria| Quadrics::build(&mesh.mesh(), &poses.poses(), &split, &classes.edge_kinds, criteria);
    let mut quadrics = build(Criteria::Peng2011);

    let neighbor = |p: u32, skip: &[u32]| {
        let around = split.triangles.iter().map(|t| t.map(|v| split.position_of(v))).filter(|t| t.contains(&p));
        around.flatten().find(|q| *q != p && !skip.contains(q)).expect("a sphere's vertex has neighbours")
    };
    let (a, b) = (20, neighbor(20, &[]));
    let c = neighbor(b, &[a]);
    let cost_ab = quadrics.move_cost(a, b);
    quadrics.merge(a, b, cost_ab);
    let cost = quadrics.total_cost(quadrics.move_cost(b, c), c);

    // By default the worst frame, the stretched one here, counts once more.
    let mut alone = poses.clone();
    alone.frame_weights = vec![0.0, 1.0, 0.0];
    let stretched = Quadrics::build(&mesh.mesh(), &alone.poses(), &split, &classes.edge_kinds, Criteria::Peng2011);
    let with_worst = cost_ab + WORST_WEIGHT * stretched.move_cost(a, b);
    let default_cost = build(Criteria::Wedge).move_cost(a, b);
    assert!((default_cost - with_worst).abs() < 1.0e-4 * with_worst, "{default_cost} {with_worst}");

    let mut expected = 0.0_f64;
    let mut area = 0.0_f64;
    for frame in 0..3 {
        let pose = |p: u32| {
            let v = split.position_source[p as usize] as usize;
            pose_position(mesh.positions[v], mesh.joints[v], mesh.weights[v], &poses.palettes[frame..=frame])
                .map(f64::from)
        };
        let target = pose(c);
        for p in [a, b, c] {
            for corners in split.triangles.iter().map(|t| t.map(|v| split.position_of(v))).filter(|t| t.contains(&p)) {
                let [x, y, z] = corners.map(pose);
                let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
                let (e, f) = (minus(y, x), minus(z, x));
                let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
                let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
                let d = minus(target, x);
                let distance = (n[0] * d[0] + n[1] * d[1] + n[2] * d[2]) / length;
                expected += f64::from(poses.frame_weights[frame]) * 0.5 * length * distance * distance;
                area += f64::from(poses.frame_weights[frame]) * 0.5 * length;
            }
        }
    }
    assert!(expected > 0.0);
    assert!((f64::from(cost) - expected).abs() < 1.0e-4 * expected, "{cost} {expected}");
    assert!((f64::from(quadrics.merged_area(b, c)) - area).abs() < 1.0e-4 * area);
}

/// Two plain colours, one a column of quads each, and what lies around them.
fn two_colors() -> TestMesh {
    let mut mesh = TestMesh::default();
    for (column, (gray, material)) in [([0_u8; 4], 0), ([255; 4], 1)].into_iter().enumerate() {
        let x = column as f32;
        let corners = |y: f32| [[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0], [x, y + 1.0, 0.0]];
        for y in 0..3 {
            let quad = corners(y as f32).map(|at| mesh.vertex(at, [0.0; 2]));
            quad.iter().for_each(|&v| mesh.colors[v as usize] = gray);
            mesh.quad(quad);
            let last = mesh.materials.len() - 2;
            mesh.materials[last..].fill(material);
        }
    }
    mesh
}

/// Planes of all positions of a mesh at rest.
fn planes_of(mesh: &TestMesh, triangle_contrast: &[f32]) -> Vec<QuadricBlock> {
    let appearance = Appearance { triangle_contrast, ..Appearance::default() };
    let mesh = LodMesh { appearance, ..mesh.mesh() };
    let (split, poses) = (split_seams(&mesh), TestPoses::rest());
    let kinds = classify_wedges(&split).edge_kinds;
    Quadrics::build(&mesh, &poses.poses(), &split, &kinds, Criteria::Wedge).planes
}

#[test]
fn seams_between_plain_colors_count_more_and_triangles_left_out_shift_nothing() {
    let mesh = two_colors();
    let count = mesh.triangles.len();
    let textured = planes_of(&mesh, &vec![1.0; count]);
    let plain = planes_of(&mesh, &vec![0.0; count]);
    assert_ne!(plain, textured);
    assert_eq!(planes_of(&mesh, &[]), textured, "nobody looked");
    // The second column alone is textured: no position of the seam is plain.
    let half: Vec<f32> = (0..count).map(|t| if t < count / 2 { 0.0 } else { 1.0 }).collect();
    assert_eq!(planes_of(&mesh, &half), textured);
    // Six triangles that use a vertex twice come first; the simplifier leaves them out.
    let mut shifted = mesh.clone();
    shifted.triangles.splice(0..0, [[0, 0, 1]; 6]);
    shifted.materials.splice(0..0, [0; 6]);
    let contrast = |first: f32, others: f32| [vec![first; 6], vec![others; count]].concat();
    assert_eq!(planes_of(&shifted, &contrast(1.0, 0.0)), plain);
    assert_eq!(planes_of(&shifted, &contrast(0.0, 1.0)), textured);
}

#[test]
fn wider_vectors_give_the_same_bits() {
    let mesh = uv_sphere(9, 7);
    let bent = |by: f32| [[1.0, 0.1 * by, 0.0, by], [0.0, 1.0 - 0.03 * by, 0.5, 0.0], [0.1 * by, 0.0, 1.0, -3.0]];
    let poses = TestPoses::even((0..21).map(|frame| bent(frame as f32)).collect(), 1);
    let split = split_seams(&mesh.mesh());
    let kinds = classify_wedges(&split).edge_kinds;
    let mut quadrics = Quadrics::build(&mesh.mesh(), &poses.poses(), &split, &kinds, Criteria::Wedge);
    for [u, t, _] in split.triangles.iter().map(|t| t.map(|v| split.position_of(v))) {
        let blocks = |p: u32| p as usize * quadrics.block_count..(p as usize + 1) * quadrics.block_count;
        let (from, to) = (&quadrics.posed[blocks(u)], &quadrics.posed[blocks(t)]);
        let plain = mean_and_worst(from, to, &quadrics.planes[blocks(u)], &quadrics.frame_weights);
        let wide = quadrics.mean_and_worst(u, t);
        assert_eq!([plain.0, plain.1].map(f32::to_bits), [wide.0, wide.1].map(f32::to_bits));
        let mut merged = quadrics.planes[blocks(t)].to_vec();
        for (b, block) in merged.iter_mut().enumerate() {
            add_moved(&quadrics.planes[blocks(u)][b], &from[b], &to[b], block);
        }
        quadrics.merge(u, t, 0.0);
        let start = t as usize * quadrics.block_count;
        for (a, b) in merged.iter().zip(&quadrics.planes[start..]) {
            assert_eq!(a.map(|row| row.map(f32::to_bits)), b.map(|row| row.map(f32::to_bits)));
        }
    }
}
