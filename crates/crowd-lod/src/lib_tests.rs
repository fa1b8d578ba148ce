//! The whole of [`crate::simplify`]: on pictures, on meshes where it matters, and on any mesh.

use crate::test_meshes::*;
use crate::{
    Coarsest, CollapseOrder, Criteria, Error, LodOptions, Mat3x4, VertexClass, measure_level, reform, simplify,
};
use proptest::prelude::*;

fn peng() -> LodOptions {
    LodOptions { criteria: Criteria::Peng2011, ..quick() }
}

/// Steps from fine to coarse: the places that leave, each with its wedges' count and the place it goes to.
fn moves(mesh: &TestMesh, order: &CollapseOrder) -> Vec<([f32; 3], usize, [f32; 3])> {
    let at = |v: u32| mesh.positions[order.vertex_source[v as usize] as usize];
    let steps = order.levels.windows(2).rev().map(|pair| pair[0].vertex_count..pair[1].vertex_count);
    steps
        .map(|dropped| {
            let mover = dropped.clone().find(|&v| at(order.collapse_map[v as usize]) != at(v)).expect("a step moves");
            let together = dropped.filter(|&v| at(v) == at(mover)).count();
            (at(mover), together, at(order.collapse_map[mover as usize]))
        })
        .collect()
}

/// ```text
///  o---o-#-o---o     A flat strip with one seam (#) across, from border to border. Inner seam vertices
///  |   |   |   |     leave as pairs along the seam; those on the border stay.
///  o---o-#-o---o
///  |   |   |   |
///  o---o-#-o---o
/// ```
#[test]
fn companions_leave_together_along_their_seam() {
    let mesh = grid(4, 4, |_, _| 0.0, |column, _| column == 2);
    for options in [quick(), peng()] {
        let order = simplify_checked(&mesh, &TestPoses::rest(), &options);
        // By default the seam leaves the strip as a whole in the end, when nothing else is left to pay for.
        let seam = moves(&mesh, &order).into_iter().filter(|m| m.0[0] == 2.0 && m.1 == 2).take(3);
        let seam: Vec<_> = seam.collect();
        assert_eq!(seam.len(), 3, "{:?}", options.criteria);
        for (from, _, to) in seam {
            assert_eq!(to[0], 2.0, "{from:?} leaves the seam to {to:?}");
        }
    }
}

#[test]
fn companions_lie_side_by_side_and_no_level_parts_them() {
    let mesh = tube(12, 12, 6.0, true);
    let order = simplify_checked(&mesh, &TestPoses::rest(), &peng());
    let at = |v: u32| mesh.positions[order.vertex_source[v as usize] as usize];
    let mut pairs = 0;
    for v in 1..order.vertex_source.len() as u32 {
        if order.vertex_classes[v as usize] == VertexClass::Companion && at(v) == at(v - 1) {
            pairs += 1;
            let map = |v: u32| order.collapse_map[v as usize];
            if map(v) != v {
                assert_eq!(at(map(v)), at(map(v - 1)));
                assert!(
                    order.levels.iter().all(|level| level.vertex_count != v),
                    "a level parts {v} from its companion"
                );
            }
        }
    }
    assert_eq!(pairs, 13, "one a ring");
}

/// A slit that ends inside the mesh: its end has one wedge and may leave sideways, but not up its own slit, where its two
/// sides would need two images. The next seam vertex may close the slit by moving down to the end.
#[test]
fn slit_end_does_not_climb_its_slit() {
    let mesh = grid(6, 6, |x, y| ((x * 7 + y * 5) % 4) as f32 * 0.05, |column, row| column == 3 && row >= 2);
    let mut targets = Vec::new();
    for options in [quick(), peng()] {
        let order = simplify_checked(&mesh, &TestPoses::rest(), &options);
        targets.extend(moves(&mesh, &order).into_iter().find(|m| m.0[0] == 3.0 && m.0[1] == 2.0).map(|m| m.2));
    }
    assert!(!targets.is_empty(), "the end never left, so it could not climb");
    assert!(targets.iter().all(|to| to[0] != 3.0 || to[1] < 2.0), "the end climbed to one of {targets:?}");
}

/// A level of at most some triangles.
fn level_of(order: &CollapseOrder, triangles: u32) -> crate::Level {
    *order.levels.iter().rfind(|level| level.triangle_count <= triangles).expect("the order goes down so far")
}

#[test]
fn corner_of_three_charts_stays_under_both_criteria() {
    for options in [quick(), peng()] {
        let order = simplify_checked(&cube(6), &TestPoses::rest(), &options);
        let level = level_of(&order, 12);
        assert_eq!(level.triangle_count, 12, "{:?}", order.blocked);
        assert_eq!(level.error_m, 0.0);
        let mesh = cube(6);
        let kept = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
        for v in kept.as_flattened() {
            let place = mesh.positions[order.vertex_source[*v as usize] as usize];
            assert!(place.iter().all(|c| c.abs() == 1.0), "{place:?} is no corner");
            assert_eq!(order.vertex_classes[*v as usize], VertexClass::Fixed);
        }
    }
    let paper = simplify_checked(&cube(6), &TestPoses::rest(), &peng());
    assert_eq!(paper.levels[0].triangle_count, 12);
    assert_eq!(paper.blocked.fixed + paper.blocked.seam, 8, "{:?}", paper.blocked);
    assert_eq!(paper.obstacles.len(), 24, "one for each vertex of the coarsest level");
    assert!(paper.obstacles.iter().all(|&o| o <= crate::Obstacle::Seam), "{:?}", paper.obstacles);
}

/// The corner of three charts has no image for its third wedge: a stand-in keeps what that chart shows.
#[test]
fn a_corner_that_moves_keeps_its_charts() {
    let mesh = cube(1);
    let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
    assert!(order.levels[0].triangle_count < 12);
    let stand_ins: Vec<usize> = (0..order.vertex_source.len())
        .filter(|&v| {
            let (place, shown) = (order.vertex_source[v] as usize, order.attribute_source[v] as usize);
            mesh.positions[place] != mesh.positions[shown]
        })
        .collect();
    assert!(!stand_ins.is_empty());
    // Full detail has no need of them.
    for v in stand_ins {
        assert!(order.triangles.iter().flatten().all(|&corner| corner as usize != v));
    }
}

#[test]
fn fixed_vertices_never_move_under_peng() {
    for mesh in [uv_sphere(16, 12), tube(10, 8, 4.0, false), grid(7, 5, |x, y| (x * y) as f32 * 0.1, |_, _| false)] {
        let order = simplify_checked(&mesh, &TestPoses::rest(), &peng());
        // A wedge of a fixed place may lose its last triangle; the place stays.
        let coarsest = order.levels[0].vertex_count as usize;
        let at = |v: usize| mesh.positions[order.vertex_source[v] as usize];
        assert!(order.levels.len() > 4);
        for v in (0..order.vertex_source.len()).filter(|&v| order.vertex_classes[v] == VertexClass::Fixed) {
            assert!((0..coarsest).any(|kept| at(kept) == at(v)), "fixed vertex {v} moved");
        }
    }
}

#[test]
fn wedge_criteria_reach_further_than_fixed_classes() {
    let mesh = uv_sphere(24, 16);
    let wedge = simplify_checked(&mesh, &TestPoses::rest(), &quick());
    let fixed = simplify_checked(&mesh, &TestPoses::rest(), &peng());
    assert!(wedge.levels[0].triangle_count < 60, "{:?} {:?}", wedge.levels[0], wedge.blocked);
    assert!(wedge.levels[0].triangle_count <= fixed.levels[0].triangle_count);
    let open = tube(16, 20, 6.0, false);
    let wedge = simplify_checked(&open, &TestPoses::rest(), &quick());
    let fixed = simplify_checked(&open, &TestPoses::rest(), &peng());
    assert!(wedge.levels[0].triangle_count < 24, "{:?} {:?}", wedge.levels[0], wedge.blocked);
    assert!(fixed.levels[0].triangle_count >= 32, "the paper keeps all 32 border vertices");
}

#[test]
fn flat_grid_becomes_two_triangles() {
    let order = simplify_checked(&grid(12, 9, |_, _| 0.0, |_, _| false), &TestPoses::rest(), &quick());
    assert!(order.levels[0].triangle_count <= 2, "{:?} {:?}", order.levels[0], order.blocked);
}

/// Frames of a tube along z whose upper half turns about x at its middle by up to `bend_rad`.
fn bending(middle: f32, bend_rad: f32, frames: usize) -> TestPoses {
    let mut palettes: Vec<Mat3x4> = Vec::new();
    for frame in 0..frames {
        let turn = bend_rad * frame as f32 / (frames - 1) as f32;
        let (s, c) = (libm::sinf(turn), libm::cosf(turn));
        palettes.push(REST);
        palettes.push([[1.0, 0.0, 0.0, 0.0], [0.0, c, -s, s * middle], [0.0, s, c, middle - c * middle]]);
    }
    TestPoses::even(palettes, 2)
}

fn elbow() -> TestMesh {
    let mut mesh = tube(16, 48, 12.0, true);
    for v in 0..mesh.positions.len() {
        let upper = ((mesh.positions[v][2] - 5.0) / 2.0).clamp(0.0, 1.0);
        mesh.joints[v] = [0, 1, 0, 0];
        mesh.weights[v] = [1.0 - upper, upper, 0.0, 0.0];
    }
    mesh
}

/// Peng 2011, Fig. 2 (c-d): straight in bind pose, bent in its clip. Averaged over frames, the cost keeps rings where the
/// tube bends; from the bind pose alone it cannot know.
#[test]
fn averaged_cost_keeps_the_elbow() {
    let mesh = elbow();
    let clip = bending(6.0, 1.8, 9);
    let straight = TestPoses::even(vec![REST, REST], 2);
    let error = |poses: &TestPoses| {
        let order = simplify_checked(&mesh, poses, &quick());
        let level = *order.levels.iter().rfind(|level| level.triangle_count <= 160).expect("10 % is reached");
        let source = |v: &u32| *v as usize;
        let positions: Vec<_> = order.vertex_source.iter().map(source).map(|v| mesh.positions[v]).collect();
        let joints: Vec<_> = order.vertex_source.iter().map(source).map(|v| mesh.joints[v]).collect();
        let weights: Vec<_> = order.vertex_source.iter().map(source).map(|v| mesh.weights[v]).collect();
        let triangles = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
        let kept = positions[..level.vertex_count as usize].iter().filter(|p| (4.0..=8.0).contains(&p[2])).count();
        (measure_level(&positions, &joints, &weights, &order.triangles, &triangles, &clip.poses(), 2000), kept)
    };
    let (animated, kept_animated) = error(&clip);
    let (bind, kept_bind) = error(&straight);
    assert!(animated.max_m < 0.5 * bind.max_m, "{animated:?} {bind:?}");
    assert!(animated.rms_m < 0.7 * bind.rms_m, "{animated:?} {bind:?}");
    assert!(2 * kept_animated > 3 * kept_bind, "{kept_animated} {kept_bind}");
}

#[test]
fn same_bytes_for_any_thread_count() {
    let mesh = elbow();
    let clip = bending(6.0, 1.5, 11);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| simplify(&mesh.mesh(), &clip.poses(), &LodOptions::default(), &|_| ())).expect("a valid mesh")
    };
    let one = run(1);
    assert!(one.frames.check.is_none() && one.levels.len() > 100);
    assert_eq!(run(2), one);
    assert_eq!(run(8), one);
}

#[test]
fn progress_rises_to_one() {
    let seen = std::sync::Mutex::new(Vec::new());
    let mesh = uv_sphere(40, 40);
    simplify(&mesh.mesh(), &TestPoses::rest().poses(), &quick(), &|share| seen.lock().expect("one thread").push(share))
        .expect("a valid mesh");
    let seen = seen.into_inner().expect("one thread");
    assert!(seen.windows(2).all(|w| w[0] <= w[1]) && seen.len() > 2);
    assert_eq!(seen.last(), Some(&1.0));
}

#[test]
fn nothing_simplifies_to_nothing() {
    let order = simplify_checked(&TestMesh::default(), &TestPoses::rest(), &LodOptions::default());
    assert_eq!((order.levels.len(), order.levels[0].triangle_count), (1, 0));
}

#[test]
fn single_triangle_stays() {
    let mut mesh = TestMesh::default();
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
        mesh.vertex([x, y, 0.0], [x, y]);
    }
    mesh.triangle([0, 1, 2]);
    for options in [LodOptions::default(), peng()] {
        let order = simplify_checked(&mesh, &TestPoses::rest(), &options);
        assert_eq!((order.levels.len(), order.levels[0].triangle_count), (1, 1));
    }
}

#[test]
fn bow_ties_and_spines_stay_valid() {
    let mut mesh = grid(4, 4, |x, y| ((x + y) % 2) as f32 * 0.1, |_, _| false);
    // A second sheet that shares one corner, and a page that stands on an inner edge.
    let mut other = grid(4, 4, |_, _| 0.0, |_, _| false);
    other.positions.iter_mut().for_each(|p| *p = [p[0] - 4.0, p[1] - 4.0, p[2]]);
    mesh.append(&other);
    let spine: Vec<u32> = [[1.0, 1.0], [1.0, 2.0]]
        .iter()
        .map(|at| mesh.positions.iter().position(|p| p[..2] == at[..]).expect("a grid vertex") as u32)
        .collect();
    let top = mesh.vertex([1.0, 1.5, 2.0], [0.3, 0.3]);
    mesh.triangle([spine[0], spine[1], top]);
    for options in [quick(), peng()] {
        let order = simplify_checked(&mesh, &TestPoses::rest(), &options);
        assert_eq!(order.seams.non_manifold_edge_count, 1);
        assert!(order.levels.len() > 5);
        if options.criteria == Criteria::Peng2011 {
            assert!(order.blocked.fixed >= 3, "{:?}", order.blocked);
        }
    }
}

/// What a part costs that vanishes is how far the rest is: a far mote outlives most of a near ball, one on the ball's skin does not.
#[test]
fn a_far_part_outlives_one_that_lies_on_another() {
    let level_with_mote_at = |x: f32| {
        let mut mesh = uv_sphere(24, 16);
        let mut mote = uv_sphere(6, 4);
        mote.positions.iter_mut().for_each(|p| *p = [p[0] * 0.02 + x, p[1] * 0.02, p[2] * 0.02]);
        mesh.append(&mote);
        let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
        let far = |v: u32| (mesh.positions[order.vertex_source[v as usize] as usize][0] - x).abs() < 0.03;
        let keeps = |level: &&crate::Level| {
            let kept = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
            kept.iter().any(|t| t.iter().all(|&v| far(v)))
        };
        order.levels.iter().find(keeps).expect("full detail keeps it").triangle_count
    };
    let (far, near) = (level_with_mote_at(5.0), level_with_mote_at(1.0));
    assert!(far < near, "{far} {near}");
    assert!(far < 100, "{far}");
}

/// Lumps that lie on each other do not all go because each has another one behind it: the last of them stays as long as if it were alone.
#[test]
fn the_last_of_many_far_parts_outlives_them() {
    let mut mesh = uv_sphere(24, 16);
    for i in 0..6 {
        let mut mote = uv_sphere(6, 4);
        mote.positions.iter_mut().for_each(|p| *p = [p[0] * 0.02 + 5.0, p[1] * 0.02 + 0.02 * i as f32, p[2] * 0.02]);
        mesh.append(&mote);
    }
    let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
    let far = |v: u32| mesh.positions[order.vertex_source[v as usize] as usize][0] > 4.0;
    let motes = |level: &crate::Level| {
        let kept = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
        kept.iter().filter(|t| t.iter().all(|&v| far(v))).count()
    };
    let last = order.levels.iter().find(|level| motes(level) > 0).expect("full detail keeps them");
    assert!(last.triangle_count < 100, "{last:?}");
    assert!(motes(last) <= 8, "one of six is left: {}", motes(last));
}

/// A ball of 5 cm that vanishes 2 m beside a large one is an error of 2 m over its area; as long as it only loses triangles, of less than its size.
#[test]
fn an_error_knows_what_vanished() {
    let mut mesh = uv_sphere(24, 16);
    let mut ball = uv_sphere(8, 6);
    ball.positions.iter_mut().for_each(|p| *p = [p[0] * 0.05 + 3.0, p[1] * 0.05, p[2] * 0.05]);
    mesh.append(&ball);
    let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
    let keeps = |level: &crate::Level| {
        let kept = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
        kept.iter().any(|t| t.iter().all(|&v| mesh.positions[order.vertex_source[v as usize] as usize][0] > 2.0))
    };
    let vanished = order.levels.iter().rposition(|level| !keeps(level)).expect("the ball vanishes in the end");
    let (without, with) = (order.levels[vanished], order.levels[vanished + 1]);
    assert!(with.error_m < 1.0, "{with:?}");
    assert!((1.9..2.4).contains(&without.error_m), "{without:?} {with:?}");
}

#[test]
fn an_order_ends_where_it_is_told_to_and_is_the_same_up_to_there() {
    let mesh = tube(12, 40, 6.0, true);
    let poses = TestPoses::rest();
    let all = simplify_checked(&mesh, &poses, &quick());
    assert_eq!(all.blocked.ended, 0);
    for (coarsest, most) in [
        (Coarsest::Triangles(100), 100),
        (Coarsest::Share(0.05), mesh.triangles.len() as u32 / 20),
        (Coarsest::Useful, 16),
        (Coarsest::Triangles(5000), 984),
    ] {
        let ended = simplify_checked(&mesh, &poses, &LodOptions { coarsest, ..quick() });
        let first = ended.levels[0].triangle_count;
        assert!(first <= most && first + 8 > most, "{coarsest:?}: {first}");
        assert!(ended.blocked.ended > 0 && ended.obstacles.contains(&crate::Obstacle::Ended), "{:?}", ended.blocked);
        let levels =
            |order: &CollapseOrder| order.levels.iter().map(|l| (l.triangle_count, l.error_m)).collect::<Vec<_>>();
        assert!(levels(&all).ends_with(&levels(&ended)), "{coarsest:?}");
    }
}

#[test]
fn two_percent_stay_within_reach_of_every_mesh() {
    for full in (0..5000).chain([100_000, u32::MAX]) {
        let ends = Coarsest::Useful.triangles(full);
        assert!(f64::from(ends) <= f64::from(full) * 0.02 + 1.0e-6, "{full}: {ends}");
        assert!(full < 800 || ends >= 16, "{full}: {ends}");
    }
    assert_eq!([800, 6952, 1_000_000].map(|full| Coarsest::Useful.triangles(full)), [16, 34, 5000]);
    assert_eq!((Coarsest::Last.triangles(9), Coarsest::Share(0.1).triangles(10)), (0, 1));
}

/// A fan of many triangles around one hub must not cost their square.
#[test]
fn hub_with_many_triangles_is_quick() {
    let mut mesh = TestMesh::default();
    let hub = mesh.vertex([0.0, 0.0, 0.0], [0.5, 0.5]);
    let count = 60_000;
    for i in 0..count {
        let turn = i as f32 / count as f32 * std::f32::consts::TAU;
        let (x, y) = (libm::cosf(turn), libm::sinf(turn));
        mesh.vertex([x, y, 0.1 * libm::sinf(turn * 5.0)], [0.5 + 0.5 * x, 0.5 + 0.5 * y]);
    }
    for i in 0..count {
        mesh.triangle([hub, 1 + i, 1 + (i + 1) % count]);
    }
    let start = std::time::Instant::now();
    let order = simplify(&mesh.mesh(), &TestPoses::rest().poses(), &quick(), &|_| ()).expect("a valid mesh");
    assert!(order.levels[0].triangle_count < 64, "{:?} {:?}", order.levels[0], order.blocked);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

/// Two hubs over one ring, each with as many wedges as triangles.
#[test]
fn two_hubs_with_many_wedges_are_quick() {
    let mesh = uv_sphere(30_000, 2);
    let start = std::time::Instant::now();
    let order = simplify(&mesh.mesh(), &TestPoses::rest().poses(), &quick(), &|_| ()).expect("a valid mesh");
    assert!(order.levels[0].triangle_count < 2_000, "{:?} {:?}", order.levels[0], order.blocked);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn wrong_parameters_are_refused_by_name() {
    let good = grid(2, 2, |_, _| 0.0, |_, _| false);
    let poses = TestPoses::rest();
    let refused = |mesh: &TestMesh, poses: &TestPoses| {
        let found = simplify(&mesh.mesh(), &poses.poses(), &quick(), &|_| ());
        let Err(Error::Parameter { what, .. }) = found else { panic!("accepted: {found:?}") };
        what
    };
    let with = |change: &dyn Fn(&mut TestMesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        refused(&mesh, &poses)
    };
    assert_eq!(with(&|m| m.positions[3][1] = f32::NAN), "positions[3]");
    assert_eq!(with(&|m| m.positions[3][1] = 1.0e9), "positions[3]");
    assert_eq!(with(&|m| m.normals[1][0] = f32::INFINITY), "normals[1]");
    assert_eq!(with(&|m| m.uvs[8][1] = f32::NAN), "uvs[8]");
    assert_eq!(with(&|m| m.weights[2] = [-0.5, 1.5, 0.0, 0.0]), "weights[2]");
    assert_eq!(with(&|m| m.weights[2] = [0.0; 4]), "sum of weights[2]");
    assert_eq!(with(&|m| m.weights[2] = [0.9, 0.9, 0.0, 0.0]), "sum of weights[2]");
    assert_eq!(with(&|m| m.joints[2][3] = 1), "joints[2]");
    assert_eq!(with(&|m| m.triangles[4][0] = 9), "triangles[4]");
    assert_eq!(with(&|m| m.uvs.truncate(3)), "length of uvs");
    assert_eq!(with(&|m| m.materials.push(0)), "length of triangle_materials");
    let posed = |change: &dyn Fn(&mut TestPoses)| {
        let mut poses = poses.clone();
        change(&mut poses);
        refused(&good, &poses)
    };
    assert_eq!(posed(&|p| p.palettes[0][1][1] = f32::NAN), "palettes[0]");
    assert_eq!(posed(&|p| p.palettes[0][1] = [9.0e5, 9.0e5, 0.0, 9.0e5]), "palettes[0]", "metres add up");
    assert_eq!(posed(&|p| p.palettes.push(REST)), "palettes");
    assert_eq!(posed(&|p| p.frame_weights = vec![0.5]), "sum of frame_weights");
    assert_eq!(posed(&|p| p.frame_weights = vec![-1.0]), "frame_weights[0]");
    assert_eq!(posed(&|p| p.frame_weights.clear()), "frame_weights");
    assert_eq!(posed(&|p| p.joint_count = 0), "joint_count");
}

fn any_grid() -> impl Strategy<Value = TestMesh> {
    let size = (2_usize..9, 2_usize..9);
    (size, prop::collection::vec(0_u8..40, 100), prop::collection::vec(0_u8..6, 100), any::<bool>()).prop_map(
        |((width, height), lifts, cuts, hard)| {
            let lift = |x: usize, y: usize| f32::from(lifts[y * 10 + x]) * 0.01;
            let mut mesh = grid(width, height, lift, |x, y| x > 0 && x < width && cuts[y * 10 + x] == 0);
            if hard {
                split_normals(&mut mesh);
            }
            mesh
        },
    )
}

/// Gives every other triangle vertices and a normal of its own.
fn split_normals(mesh: &mut TestMesh) {
    for i in (0..mesh.triangles.len()).step_by(2) {
        let triangle = mesh.triangles[i].map(|v| {
            let v = v as usize;
            let own = mesh.vertex(mesh.positions[v], mesh.uvs[v]);
            mesh.normals[own as usize] = [0.0, 0.6, 0.8];
            own
        });
        mesh.triangles[i] = triangle;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn every_prefix_of_any_height_field_is_valid(mesh in any_grid(), paper in any::<bool>()) {
        let options = if paper { peng() } else { quick() };
        let order = simplify_checked(&mesh, &TestPoses::rest(), &options);
        prop_assert!(order.levels.len() > 1);
    }

    #[test]
    fn every_prefix_of_any_soup_is_valid(
        corners in prop::collection::vec([0_u32..12, 0_u32..12, 0_u32..12], 0..40),
        places in prop::collection::vec([0_u8..3, 0_u8..3, 0_u8..3], 12),
        uvs in prop::collection::vec([0_u8..2, 0_u8..2], 12),
        paper in any::<bool>(),
    ) {
        let mut mesh = TestMesh::default();
        for (place, uv) in places.iter().zip(&uvs) {
            mesh.vertex(place.map(f32::from), uv.map(f32::from));
        }
        corners.iter().for_each(|&t| mesh.triangle(t));
        let options = if paper { peng() } else { quick() };
        simplify_checked(&mesh, &TestPoses::rest(), &options);
    }
}

/// The checks above can fail.
mod checks_fail {
    use super::*;

    fn broken(change: impl Fn(&mut CollapseOrder)) {
        let mesh = grid(4, 4, |x, y| (x * y) as f32 * 0.1, |column, _| column == 2);
        let poses = TestPoses::rest();
        let mut order = simplify(&mesh.mesh(), &poses.poses(), &peng(), &|_| ()).expect("a valid mesh");
        change(&mut order);
        check_order(&mesh, &poses, &order, Criteria::Peng2011);
    }

    #[test]
    #[should_panic(expected = "maps to")]
    fn on_a_map_that_goes_up() {
        broken(|order| {
            let last = order.collapse_map.len() - 1;
            order.collapse_map[last - 1] = last as u32;
        });
    }

    #[test]
    #[should_panic]
    fn on_a_wrong_target() {
        broken(|order| {
            let last = order.collapse_map.len() - 1;
            order.collapse_map[last] = if order.collapse_map[last] == 0 { 1 } else { 0 };
        });
    }

    #[test]
    #[should_panic]
    fn on_a_level_between_companions() {
        broken(|order| {
            let pair = order.levels.windows(2).position(|w| w[1].vertex_count - w[0].vertex_count == 2);
            order.levels[pair.expect("companions collapse")].vertex_count += 1;
        });
    }

    #[test]
    #[should_panic]
    fn on_a_triangle_too_few() {
        broken(|order| order.levels[0].triangle_count -= 1);
    }
}
