use super::*;
use crate::test_meshes::{REST, TestMesh, TestPoses, grid, in_order, quick, simplify_checked, tube, uv_sphere};
use crate::{level_mesh, measured_frames, reform, worst_frames};

impl TestMesh {
    pub(crate) fn surface(&self) -> Surface<'_> {
        Surface {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            joints: &self.joints,
            weights: &self.weights,
            triangles: &self.triangles,
        }
    }
}

fn tent() -> (TestMesh, [[u32; 3]; 2]) {
    let mesh = grid(2, 2, |x, y| if x == 1 && y == 1 { 1.0 } else { 0.0 }, |_, _| false);
    let corner = |x: f32, y: f32| {
        mesh.positions.iter().position(|p| p[0] == x && p[1] == y).expect("a corner of the grid") as u32
    };
    let (a, b, c, d) = (corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 2.0), corner(0.0, 2.0));
    (mesh, [[a, b, c], [a, c, d]])
}

fn measure(mesh: &TestMesh, levels: &[LevelSurface<'_>], poses: &TestPoses, mean_frames: usize) -> Vec<SurfaceError> {
    let texels = vec![[100.0, 50.0]; mesh.positions.len()];
    measure_surfaces(&mesh.surface(), &texels, levels, &poses.poses(), mean_frames, 2000)
}

#[test]
fn full_detail_measures_nothing() {
    let mesh = uv_sphere(12, 8);
    let shared = LevelSurface::Shared(&mesh.triangles);
    let own = LevelSurface::Own(mesh.surface());
    let errors = measure(&mesh, &[shared, own, LevelSurface::Shared(&[])], &TestPoses::rest(), 1);
    assert_eq!(errors[0], SurfaceError::default());
    assert!(errors[1].max_m < 1.0e-6 && errors[1].normal_mean_deg < 0.1, "{:?}", errors[1]);
    assert_eq!(errors[2], SurfaceError::default(), "nothing measures nothing");
}

#[test]
fn a_tent_against_the_ground() {
    let (mesh, flat) = tent();
    let tripled = REST.map(|row| row.map(|c| c * 3.0));
    let poses = TestPoses::even(vec![REST, tripled, REST], 1);
    let errors = measure(&mesh, &[LevelSurface::Shared(&flat)], &poses, 1);
    let error = errors[0];
    // The peak is a vertex: the maximum is exact, and found in the frame that is not in the mean.
    assert!((error.max_m - 3.0).abs() < 1.0e-5 && error.max_frame == 1, "{error:?}");
    assert_eq!(error.bound_m, error.max_m * (1.0 + BOUND_SHARE) + BOUND_ROUNDING * 3.0);
    let rest = crate::measure_level(
        &mesh.positions,
        &mesh.joints,
        &mesh.weights,
        &mesh.triangles,
        &flat,
        &TestPoses::rest().poses(),
        2000,
    );
    assert!((error.rms_m - rest.rms_m).abs() < 1.0e-5, "{error:?} {rest:?}");
    // Each side of the tent rises 1 m over 1 m along one axis or two.
    assert!((30.0..56.0).contains(&error.normal_mean_deg) || error.normal_mean_deg == 0.0, "{error:?}");
}

#[test]
fn drift_is_in_texels() {
    let (mesh, _) = tent();
    let mut moved = mesh.clone();
    moved.uvs.iter_mut().for_each(|uv| *uv = [uv[0] + 0.03, uv[1] + 0.08]);
    moved.normals.fill([1.0, 0.0, 0.0]);
    let errors = measure(&mesh, &[LevelSurface::Own(moved.surface())], &TestPoses::rest(), 1);
    // 3 texels along u, 4 along v.
    assert!((errors[0].uv_drift_p95_texels - 5.0).abs() < 1.0e-3, "{errors:?}");
    assert!((errors[0].normal_mean_deg - 90.0).abs() < 1.0e-2, "{errors:?}");
    assert!(errors[0].max_m < 1.0e-6);
}

/// A tube that bends at its middle, joint 1 turning against joint 0.
fn bending_tube() -> (TestMesh, TestPoses) {
    let mut mesh = tube(24, 48, 4.0, true);
    let (low, high) =
        mesh.positions.iter().fold((f32::MAX, f32::MIN), |(low, high), p| (low.min(p[2]), high.max(p[2])));
    for v in 0..mesh.positions.len() {
        let share = ((mesh.positions[v][2] - low) / (high - low) * 4.0 - 1.5).clamp(0.0, 1.0);
        mesh.joints[v] = [0, 1, 0, 0];
        mesh.weights[v] = [1.0 - share, share, 0.0, 0.0];
    }
    let middle = (low + high) / 2.0;
    let bent = |frame: usize| {
        let (s, c) = libm::sincosf(frame as f32 / 59.0 * 1.6);
        // About the x axis through the middle.
        [[1.0, 0.0, 0.0, 0.0], [0.0, c, -s, s * middle], [0.0, s, c, middle - c * middle]]
    };
    let palettes = (0..60).flat_map(|frame| [REST, bent(frame)]).collect();
    (mesh, TestPoses::even(palettes, 2))
}

/// Ten times the points, on frames others than those measured too, searched one by one.
fn largest_by_brute_force(mesh: &TestMesh, level: &Surface<'_>, poses: &TestPoses) -> Vec<f32> {
    let full = mesh.surface();
    let frames = poses.frame_weights.len();
    let (mut there, mut back) = (
        spread_samples(full.positions, full.triangles, 10_000),
        spread_samples(level.positions, level.triangles, 10_000),
    );
    there.extend(Points::vertices(&full, None).samples);
    back.extend(Points::vertices(level, None).samples);
    let (mut full_tree, mut level_tree) = (
        ClosestTriangles::new(full.positions, full.triangles),
        ClosestTriangles::new(level.positions, level.triangles),
    );
    let largest_in = |frame: usize| {
        let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
        let (a, b) = (pose_surface(&full, palette), pose_surface(level, palette));
        full_tree.refit(&a, full.triangles);
        level_tree.refit(&b, level.triangles);
        let far = |samples: &[Sample],
                   from: &[[f32; 3]],
                   triangles: &[[u32; 3]],
                   to: &[[f32; 3]],
                   tree: &ClosestTriangles,
                   others: &[[u32; 3]]| {
            let distance =
                |s: &Sample| tree.closest(place(s, from, triangles), to, others, u32::MAX).expect("a triangle").1;
            samples.iter().map(distance).fold(0.0, f32::max)
        };
        let one = far(&there, &a, full.triangles, &b, &level_tree, level.triangles);
        one.max(far(&back, &b, level.triangles, &a, &full_tree, full.triangles)).sqrt()
    };
    (0..frames).step_by(4).map(largest_in).collect()
}

/// Goal Q7: the bound holds in 99 % of pairs of level and frame, frames that were not measured too, and is not 3x loose.
#[test]
fn the_bound_holds_in_every_frame_and_is_not_loose() {
    let (mesh, poses) = bending_tube();
    let order = simplify_checked(&mesh, &poses, &quick());
    let chosen = crate::geometric_levels(&order.levels, 12);

    // Measured as a bake does: shared vertices, few frames.
    let ordered = in_order(&mesh, &order);
    let reformed: Vec<Vec<[u32; 3]>> = chosen[..chosen.len() - 1]
        .iter()
        .map(|&i| {
            reform(&order.triangles, &order.collapse_map, order.levels[i].vertex_count, order.levels[i].triangle_count)
        })
        .collect();
    let slices: Vec<&[[u32; 3]]> = reformed.iter().map(Vec::as_slice).collect();
    let mut frames: Vec<u32> = measured_frames(&poses.frame_weights, 8).into_iter().map(|f| f as u32).collect();
    let mean_frames = frames.len();
    let some: Vec<&[[u32; 3]]> = slices.iter().copied().step_by(2).collect();
    frames.extend(worst_frames(&ordered.surface(), &some, &poses.poses(), &frames));
    let palettes: Vec<Mat3x4> =
        frames.iter().flat_map(|&f| poses.palettes[f as usize * 2..f as usize * 2 + 2].iter().copied()).collect();
    let few = TestPoses::even(palettes, 2);
    let levels: Vec<LevelSurface<'_>> = slices.iter().map(|&triangles| LevelSurface::Shared(triangles)).collect();
    let errors = measure(&ordered, &levels, &few, mean_frames);

    let (mut pairs, mut kept) = (0, 0);
    for (i, error) in errors.iter().enumerate() {
        let level = Surface { triangles: &reformed[i], ..ordered.surface() };
        let largest = largest_by_brute_force(&ordered, &level, &poses);
        let worst = largest.iter().copied().fold(0.0, f32::max);
        pairs += largest.len();
        kept += largest.iter().filter(|&&distance| distance <= error.bound_m).count();
        let rounding = 4.0 * BOUND_ROUNDING * diagonal(&ordered.positions);
        assert!(error.bound_m <= 3.0 * worst + rounding, "level {i}: bound {} m, farthest {worst} m", error.bound_m);
        assert!(error.rms_m <= error.max_m && error.max_m <= error.bound_m);
    }
    assert!(kept * 100 >= pairs * 99, "{kept} of {pairs}");
}

#[test]
fn a_bound_made_smaller_would_be_found() {
    let (mesh, flat) = tent();
    let level = Surface { triangles: &flat, ..mesh.surface() };
    let error = measure(&mesh, &[LevelSurface::Shared(&flat)], &TestPoses::rest(), 1)[0];
    let largest = largest_by_brute_force(&mesh, &level, &TestPoses::rest());
    assert!(largest[0] <= error.bound_m && largest[0] > error.bound_m * 0.7);
}

#[test]
fn threads_do_not_change_the_numbers() {
    let (mesh, poses) = bending_tube();
    let order = simplify_checked(&mesh, &poses, &quick());
    let reformed =
        reform(&order.triangles, &order.collapse_map, order.levels[0].vertex_count, order.levels[0].triangle_count);
    let mut owned = level_mesh(&mesh.mesh(), &order, &order.levels[0]);
    owned.positions.iter_mut().for_each(|p| p[0] *= 1.02);
    assert_eq!(reformed.len(), owned.triangles.len());
    let own = Surface {
        positions: &owned.positions,
        normals: &owned.normals,
        uvs: &owned.uvs,
        joints: &owned.joints,
        weights: &owned.weights,
        triangles: &owned.triangles,
    };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| measure(&mesh, &[LevelSurface::Own(own), LevelSurface::Shared(&mesh.triangles)], &poses, 20))
    };
    assert_eq!(run(1), run(3));
}

/// What is remembered from one level to the next changes nothing.
#[test]
fn levels_measure_in_turn_as_each_does_alone() {
    let (mesh, poses) = bending_tube();
    let order = simplify_checked(&mesh, &poses, &quick());
    let ordered = in_order(&mesh, &order);
    let chosen = crate::geometric_levels(&order.levels, 40);
    let reformed = |&i: &usize| {
        reform(&order.triangles, &order.collapse_map, order.levels[i].vertex_count, order.levels[i].triangle_count)
    };
    let reformed: Vec<Vec<[u32; 3]>> = chosen.iter().map(reformed).collect();
    let wider: Vec<[f32; 3]> = ordered.positions.iter().map(|p| [p[0] * 1.02, p[1], p[2]]).collect();
    let middle = reformed.len() / 2;
    let own = Surface { positions: &wider, triangles: &reformed[middle], ..ordered.surface() };
    let mut levels: Vec<LevelSurface<'_>> = reformed.iter().map(|level| LevelSurface::Shared(level)).collect();
    levels.insert(middle, LevelSurface::Own(own));
    assert!(levels.len() > 3 * TURNS, "several levels a turn: {}", levels.len());
    let few = TestPoses::even(poses.palettes[..60].to_vec(), 2);
    let in_turn = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| measure(&ordered, &levels, &few, 12))
    };
    let alone: Vec<SurfaceError> =
        levels.iter().map(|level| measure(&ordered, std::slice::from_ref(level), &few, 12)[0]).collect();
    assert_eq!(in_turn(1), alone);
    assert_eq!(in_turn(3), alone);
}
