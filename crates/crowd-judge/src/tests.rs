//! Known answers, and changes that must show.

use crate::*;
use crowd_raster::{Material, Texture, Wrap};

const REST: Mat3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
const OPTIONS: JudgeOptions = JudgeOptions { points: 2000, pictures: false };

pub(crate) fn paint() -> Paint {
    let material = Material {
        base_color: [1.0; 4],
        texture: None,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        alpha_cutoff: 0.0,
        double_sided: false,
        unlit: false,
        flat: false,
    };
    Paint { materials: vec![material], textures: Vec::new() }
}

/// A square of 3 m x 4 m in the plane z = 0, looking along z: a diagonal of 5 m.
pub(crate) fn square() -> SkinnedMesh {
    SkinnedMesh {
        positions: vec![[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 4.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        colors: vec![[255; 4]; 4],
        joints: vec![[0; 4]; 4],
        weights: vec![[1.0, 0.0, 0.0, 0.0]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0, 0],
    }
}

fn judge(level: SkinnedMesh, moving: Vec<Vec<Mat3x4>>) -> Verdict {
    let poses = JudgedPoses { rest: vec![REST], moving };
    Judge::new(square(), paint(), &poses, OPTIONS).unwrap().judge(level).unwrap()
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-4 * expected.abs().max(0.3), "found {found}, expected {expected}");
}

#[test]
fn the_original_is_no_way_from_itself() {
    let verdict = judge(square(), Vec::new());
    near(verdict.animated_rms, 0.0);
    near(verdict.max, 0.0);
    near(verdict.normal_deg, 0.0);
    near(verdict.color_rms, 0.0);
    assert_eq!((verdict.triangles, verdict.max_pose), (2, None));
}

#[test]
fn planes_half_a_metre_apart() {
    let mut level = square();
    level.positions.iter_mut().for_each(|p| p[2] = 0.5);
    let verdict = judge(level, Vec::new());
    for found in [verdict.animated_rms, verdict.rest_rms, verdict.mean, verdict.p99, verdict.max] {
        near(found, 10.0);
    }
    near(verdict.normal_deg, 0.0);
}

/// Half of the square missing: nothing from the level's side, up to 2 m from the original's.
#[test]
fn what_is_missing_counts_from_the_originals_side() {
    let mut level = square();
    level.positions[2][1] = 2.0;
    level.positions[3][1] = 2.0;
    let verdict = judge(level, Vec::new());
    // Of the original's points one half lies 0 to 2 m away, evenly; of both sides' points a quarter.
    assert!((verdict.mean - 100.0 * 0.25 / 5.0).abs() < 0.02, "{verdict:?}");
    assert!((verdict.animated_rms - 100.0 * (1.0_f64 / 3.0).sqrt() / 5.0).abs() < 0.05, "{verdict:?}");
    assert!(verdict.max > 39.0 && verdict.max <= 40.0, "{verdict:?}");
}

#[test]
fn only_the_pose_that_moves_it_away_shows_it() {
    // The level's upper half hangs on joint 1, the original on joint 0.
    let mut level = square();
    level.joints = vec![[1, 0, 0, 0]; 4];
    let away = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.25]];
    let poses = JudgedPoses { rest: vec![REST; 2], moving: vec![vec![REST; 2], vec![REST, away]] };
    let verdict = Judge::new(square(), paint(), &poses, OPTIONS).unwrap().judge(level).unwrap();
    near(verdict.rest_rms, 0.0);
    near(verdict.animated_rms, 5.0 * 0.5_f64.sqrt());
    near(verdict.max, 5.0);
    assert_eq!(verdict.max_pose, Some(1));
}

#[test]
fn normals_tilted_by_ten_degrees() {
    let (sine, cosine) = (libm::sinf(10.0_f32.to_radians()), libm::cosf(10.0_f32.to_radians()));
    let mut level = square();
    level.normals = vec![[sine, 0.0, cosine]; 4];
    near(judge(level.clone(), Vec::new()).normal_deg, 10.0);
    // A flat material has the face's own normals, whatever the vertices say.
    let mut flat = paint();
    flat.materials[0].flat = true;
    let poses = JudgedPoses { rest: vec![REST], moving: Vec::new() };
    near(Judge::new(square(), flat, &poses, OPTIONS).unwrap().judge(level).unwrap().normal_deg, 0.0);
}

#[test]
fn a_face_that_looks_the_other_way_is_not_compared() {
    // A thin box: the level's front lies nearer to the original's back than to its front.
    let sheet = |front_z: f32, back: [u8; 4]| {
        let mut mesh = square();
        let mut other = square();
        mesh.positions.iter_mut().for_each(|p| p[2] = front_z);
        other.normals = vec![[0.0, 0.0, -1.0]; 4];
        other.colors = vec![back; 4];
        mesh.positions.extend(other.positions);
        mesh.normals.extend(other.normals);
        mesh.uvs.extend(other.uvs);
        mesh.colors.extend(other.colors);
        mesh.joints.extend(other.joints);
        mesh.weights.extend(other.weights);
        mesh.triangles.extend([[4, 6, 5], [4, 7, 6]]);
        mesh.triangle_materials.extend([0, 0]);
        mesh
    };
    let poses = JudgedPoses { rest: vec![REST], moving: Vec::new() };
    let black = [0, 0, 0, 255];
    let judge = Judge::new(sheet(0.1, black), paint(), &poses, OPTIONS).unwrap();
    let verdict = judge.judge(sheet(0.01, black)).unwrap();
    near(verdict.normal_deg, 0.0);
    near(verdict.color_rms, 0.0);
    assert!(judge.judge(sheet(0.1, [255; 4])).unwrap().color_rms > 0.5);
}

#[test]
fn a_red_that_turns_half_way_to_black() {
    let mut level = square();
    // Linear 0.2140 is half of the way to white in sRGB; 55 of 255 is 0.2157.
    level.colors = vec![[255, 55, 255, 255]; 4];
    let half = 1.0 - (1.055 * libm::pow(55.0 / 255.0, 1.0 / 2.4) - 0.055);
    near(judge(level, Vec::new()).color_rms, half / 3.0_f64.sqrt());
}

/// Columns of 100 texels, black to white.
fn striped() -> Paint {
    let mut paint = paint();
    let texels = (0..100 * 4).map(|i| [(i % 100 * 5 / 2) as u8; 4]).collect();
    paint.textures.push(Texture::from_rgba8(100, 4, texels));
    paint.materials[0].texture = Some(0);
    paint
}

#[test]
fn a_texture_slid_by_two_texels() {
    let poses = JudgedPoses { rest: vec![REST], moving: Vec::new() };
    let judge = Judge::new(square(), striped(), &poses, OPTIONS).unwrap();
    let mut level = square();
    assert!(judge.judge(level.clone()).unwrap().uv_p95_texels.unwrap() < 1e-3);
    level.uvs.iter_mut().for_each(|uv| uv[0] += 0.02);
    let verdict = judge.judge(level).unwrap();
    near(verdict.uv_p95_texels.unwrap(), 2.0);
    near(verdict.uv_rms_texels.unwrap(), 2.0);
    assert!(verdict.color_rms > 0.001);
    // Without a texture there are no texels to slide.
    let plain = Judge::new(square(), paint(), &poses, OPTIONS).unwrap();
    assert_eq!(plain.judge(square()).unwrap().uv_p95_texels, None);
}

/// Two squares side by side, on two charts far apart: where the border between the charts moves a little, nothing slid.
#[test]
fn a_seam_that_moved_is_not_a_slide_across_the_texture() {
    let pair = |border_m: f32| {
        let mut mesh = square();
        mesh.positions = [[0.0, border_m], [border_m, 3.0]]
            .iter()
            .flat_map(|[left, right]| [[*left, 0.0, 0.0], [*right, 0.0, 0.0], [*right, 4.0, 0.0], [*left, 4.0, 0.0]])
            .collect();
        let share = border_m / 3.0;
        let uvs = [[0.0, share], [share + 10.0, 11.0]];
        mesh.uvs = uvs.iter().flat_map(|[l, r]| [[*l, 1.0], [*r, 1.0], [*r, 0.0], [*l, 0.0]]).collect();
        mesh.normals = vec![[0.0, 0.0, 1.0]; 8];
        mesh.colors = vec![[255; 4]; 8];
        mesh.joints = vec![[0; 4]; 8];
        mesh.weights = vec![[1.0, 0.0, 0.0, 0.0]; 8];
        mesh.triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        mesh.triangle_materials = vec![0; 4];
        mesh
    };
    let poses = JudgedPoses { rest: vec![REST], moving: Vec::new() };
    let judge = Judge::new(pair(1.5), striped(), &poses, OPTIONS).unwrap();
    let verdict = judge.judge(pair(1.504)).unwrap();
    assert!(verdict.uv_rms_texels.unwrap() < 0.2, "{verdict:?}");
    // Far beyond the slack it is one.
    assert!(judge.judge(pair(1.8)).unwrap().uv_rms_texels.unwrap() > 100.0);
}

#[test]
fn pictures_show_what_is_missing_and_what_is_painted_over() {
    let poses = JudgedPoses { rest: vec![REST; 2], moving: vec![vec![REST; 2]; 3] };
    let options = JudgeOptions { points: 10, pictures: true };
    let mut double_sided = paint();
    double_sided.materials[0].double_sided = true;
    let judge = Judge::new(square(), double_sided, &poses, options).unwrap();
    let same = judge.judge(square()).unwrap();
    assert_eq!((same.image_rmse, same.silhouette_xor), (Some(0.0), Some(0.0)));

    let mut half = square();
    half.positions[2][1] = 2.0;
    half.positions[3][1] = 2.0;
    let verdict = judge.judge(half).unwrap();
    assert!((verdict.silhouette_xor.unwrap() - 50.0).abs() < 4.0, "{verdict:?}");

    let mut black = square();
    black.colors = vec![[0, 0, 0, 255]; 4];
    let verdict = judge.judge(black).unwrap();
    assert_eq!(verdict.silhouette_xor, Some(0.0));
    assert!(verdict.image_rmse.unwrap() > 0.3, "{verdict:?}");
}

#[test]
fn a_limb_that_is_missed_counts_as_much_as_a_body() {
    // Beside the square, which hangs on joint 0, a strip a tenth as wide, which hangs on joint 70; far off a speck on joint 5.
    let with_strip = |width_m: f32| {
        let mut mesh = square();
        for (joint, low, high) in [(70, [3.5, 0.0], [3.5 + width_m, 4.0]), (5, [0.0, 4.01], [0.02, 4.03])] {
            let first = mesh.positions.len() as u32;
            let corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
            mesh.positions.extend(corners.map(|[x, y]| [x, y, 0.0]));
            mesh.joints.extend([[joint, 0, 0, 0]; 4]);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        let count = mesh.positions.len();
        mesh.normals = vec![[0.0, 0.0, 1.0]; count];
        mesh.uvs.resize(count, [0.0; 2]);
        mesh.colors = vec![[255; 4]; count];
        mesh.weights = vec![[1.0, 0.0, 0.0, 0.0]; count];
        mesh.triangle_materials = vec![0; mesh.triangles.len()];
        mesh
    };
    let poses = JudgedPoses { rest: vec![REST; 71], moving: vec![vec![REST; 71]] };
    let judge = Judge::new(with_strip(0.3), paint(), &poses, JudgeOptions { points: 10, pictures: true }).unwrap();
    let seen = |level: SkinnedMesh| {
        let verdict = judge.judge(level).unwrap();
        (verdict.silhouette_missed.unwrap(), verdict.limbs_missed.unwrap())
    };
    assert_eq!(seen(with_strip(0.3)), (0.0, 0.0));
    let (missed, of_limbs) = seen(with_strip(0.15));
    assert!((missed - 100.0 * 0.15 / 3.3).abs() < 1.0 && (of_limbs - 25.0).abs() < 3.0, "{missed} {of_limbs}");
    // What sticks out is not missed.
    assert_eq!(seen(with_strip(0.5)), (0.0, 0.0));
}

#[test]
fn a_level_may_have_joints_of_its_own() {
    let aside = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let poses = JudgedPoses { rest: vec![REST], moving: vec![vec![aside]] };
    let judge = Judge::new(square(), paint(), &poses, OPTIONS).unwrap();
    let mut mesh = square();
    mesh.joints = vec![[3, 0, 0, 0]; 4];
    let own = JudgedPoses { rest: vec![REST; 4], moving: vec![vec![aside; 4]] };
    let level = Level { mesh: mesh.clone(), poses: Some(own) };
    near(judge.judge_level(level).unwrap().animated_rms, 0.0);
    let short = JudgedPoses { rest: vec![REST; 4], moving: Vec::new() };
    assert!(judge.judge_level(Level { mesh: mesh.clone(), poses: Some(short) }).is_err());
    assert!(judge.judge(mesh).is_err(), "the original has no fourth joint");
}

#[test]
fn what_does_not_fit_is_refused() {
    let poses = JudgedPoses { rest: vec![REST], moving: Vec::new() };
    let judge = Judge::new(square(), paint(), &poses, OPTIONS).unwrap();
    let broken: [fn(&mut SkinnedMesh); 8] = [
        |mesh| mesh.triangles[0][1] = 4,
        |mesh| mesh.joints[2][3] = 1,
        |mesh| mesh.triangle_materials[1] = 1,
        |mesh| mesh.normals.truncate(3),
        |mesh| mesh.positions[0][1] = f32::NAN,
        |mesh| mesh.triangles = vec![[0, 1, 1], [0, 0, 0]],
        |mesh| mesh.triangle_materials.truncate(1),
        |mesh| *mesh = SkinnedMesh::default(),
    ];
    for (i, break_it) in broken.into_iter().enumerate() {
        let mut level = square();
        break_it(&mut level);
        assert!(judge.judge(level.clone()).is_err(), "{i}");
        assert!(Judge::new(level, paint(), &poses, OPTIONS).is_err(), "{i}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let mut level = square();
    level.positions[2] = [2.5, 3.5, 0.25];
    let moving = vec![vec![REST]; 7];
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let many = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
    let first = alone.install(|| judge(level.clone(), moving.clone()));
    assert_eq!(first, many.install(|| judge(level, moving)));
    assert!(first.animated_rms > 0.0);
}
