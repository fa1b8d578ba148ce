//! The bound that a pack stores for a level, against a much denser measurement: every frame, ten times the points.

use crowd_lod::{LodPoses, distances_to_surface};
use crowd_pack::{LevelRecord, PackContents};
use crowd_tests::folders::{assets, fixtures};
use crowdbake::bake::bake_character;
use crowdbake::lod_target::LodTarget;
use crowdbake::measure_levels::{LevelMeasure, LevelShape, MeasuredFrames, measure_in_frame_too, measure_worse_frames};
use crowdbake::ordered_mesh::{DecodedVertices, OrderedMesh};
use crowdbake::plan::PlanEntry;
use crowdbake::pose::pose_positions;
use crowdbake::unpack::Unpacked;
use std::path::Path;

/// Points on each side in each frame; the bake looks at 2,000 on the level alone.
const POINTS: usize = 20_000;
/// Levels looked at, spread over all that are stored.
const LEVELS: usize = 6;

/// A point on a triangle: its corners' shares.
type Point = (usize, [f32; 3]);

/// Points spread by area: evenly along the summed areas, by a low-discrepancy sequence within the triangles.
fn spread(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<Point> {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| glam::Vec3::from(positions[v as usize]));
        f64::from((b - a).cross(c - a).length())
    };
    let total: f64 = triangles.iter().map(area).sum();
    let mut points = Vec::new();
    let (mut passed, mut seed) = (0.0, 0.0_f64);
    for (index, triangle) in triangles.iter().enumerate() {
        passed += area(triangle) / total * POINTS as f64;
        while (points.len() as f64) < passed {
            seed += 1.0;
            let [x, y] = [0.754_877_666, 0.569_840_291].map(|step: f64| (seed * step).fract() as f32);
            let (s, t) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            points.push((index, [s, t, 1.0 - s - t]));
        }
        // Corners are where the extremes are.
        points.extend([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|shares| (index, shares)));
    }
    points
}

/// A posed side of the comparison.
struct Side<'a> {
    positions: Vec<[f32; 3]>,
    triangles: &'a [[u32; 3]],
}

fn farthest(points: &[Point], from: &Side<'_>, to: &Side<'_>) -> f32 {
    let place = |&(triangle, shares): &Point| {
        let corners = from.triangles[triangle].map(|v| glam::Vec3::from(from.positions[v as usize]));
        (corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2]).to_array()
    };
    let places: Vec<[f32; 3]> = points.iter().map(place).collect();
    distances_to_surface(&places, &to.positions, to.triangles).into_iter().fold(0.0, f32::max)
}

/// For each level looked at: its bound, and the largest distance found.
fn measure(contents: &PackContents) -> Vec<(f32, f32)> {
    let character = Unpacked::new(contents, 0);
    let full = DecodedVertices::new(character.vertices);
    let full_points = spread(&full.positions, character.triangles);
    let palettes: Vec<_> = (0..character.clips.len()).flat_map(|clip| character.palettes(clip)).collect();
    let quantized = character.quantized_levels();
    let step = quantized.len().div_ceil(LEVELS).max(1);
    let levels: Vec<&LevelRecord> = quantized.iter().step_by(step).chain(character.discrete_levels()).collect();
    let measure = |level: &&LevelRecord| {
        let vertices = DecodedVertices::new(character.level_vertices(level));
        let triangles = character.table_triangles(level);
        let points = spread(&vertices.positions, &triangles);
        let frames = palettes.chunks(character.joint_count());
        let in_frame = |palette: &[[[f32; 4]; 3]]| {
            let pose = |v: &DecodedVertices| pose_positions(&v.positions, &v.joints, &v.weights, palette);
            let full = Side { positions: pose(&full), triangles: character.triangles };
            let level = Side { positions: pose(&vertices), triangles: &triangles };
            farthest(&full_points, &full, &level).max(farthest(&points, &level, &full))
        };
        (level.bound_m, frames.map(in_frame).fold(0.0, f32::max))
    };
    levels.iter().map(measure).collect()
}

/// Bakes at a few frames a second and measures all of them. Gives the largest share of a bound that was used up.
fn expect_bounds_to_hold(path: &Path, clips: &[&str], refit: bool) -> f32 {
    let mut entry = PlanEntry { fps: crowdbake::sample::FrameRate::Fixed(4.0), ..PlanEntry::of_file(path) };
    entry.clips = (!clips.is_empty()).then(|| clips.iter().map(|clip| (*clip).to_owned()).collect());
    entry.levels.targets = ["50%", "25%", "5%"].map(|share| LodTarget::parse_ratio(share).unwrap()).to_vec();
    entry.levels.refit = refit;
    let baked = bake_character(&entry, false, &|_, _| {}).unwrap();
    let contents = crowdbake::assemble::assemble(&[baked], Default::default()).unwrap();
    let measured = measure(&contents);
    assert!(measured.len() > 2, "{}", path.display());
    let mut most = 0.0_f32;
    for (bound_m, found_m) in measured {
        // Posing and searching round differently here and there.
        assert!(
            found_m <= bound_m + 1e-5 * contents.characters[0].height_m,
            "{}: {found_m} m above the bound {bound_m} m",
            path.display()
        );
        most = most.max(if bound_m > 0.0 { found_m / bound_m } else { 0.0 });
    }
    println!("{}: at most {most:.3} of a bound", path.display());
    most
}

#[test]
fn bounds_hold_on_every_fixture() {
    let mut files: Vec<_> =
        std::fs::read_dir(fixtures().join("good")).unwrap().map(|file| file.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "glb" || ending == "obj"));
    files.sort();
    assert!(files.len() >= 16, "{files:?}");
    // One triangle has no level to measure.
    let used = files
        .iter()
        .filter(|path| !path.to_string_lossy().contains("smallest_character"))
        .map(|path| expect_bounds_to_hold(path, &[], true));
    let most = used.fold(0.0, f32::max);
    assert!(most > 0.5, "a bound that nothing comes near says little: {most}");
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn bounds_hold_on_real_characters() {
    let cases: [(&str, &[&str]); 5] = [
        ("khronos-fox/Fox.glb", &[]),
        ("khronos-cesium-man/CesiumMan.glb", &[]),
        ("kaykit-adventurers/Knight.glb", &["Walking_A", "Death_A", "Dualwield_Melee_Attack_Slice"]),
        ("quaternius-ultimate-characters/Wizard.gltf", &["Roll", "Walk"]),
        ("quaternius-animals/Horse.glb", &["*Gallop", "*Walk"]),
    ];
    for (path, clips) in cases {
        expect_bounds_to_hold(&assets().join(path), clips, true);
    }
}

#[test]
fn a_vertex_that_strays_in_one_frame_alone_is_measured_there() {
    let contents = crowdbake::bake_file(&fixtures().join("good/straight_tube_should_keep_its_elbow.glb")).unwrap();
    let character = Unpacked::new(&contents, 0);
    let mesh = OrderedMesh::of_pack(&character);
    let palettes: Vec<_> = (0..character.clips.len()).flat_map(|clip| character.palettes(clip)).collect();
    let joint_count = character.joint_count();
    let poses = LodPoses { palettes: &palettes, joint_count, frame_weights: &[] };
    let frame_count = (palettes.len() / joint_count) as u32;
    // One vertex goes with the joint that bends, from wherever it is.
    let mut vertices = mesh.vertices.clone();
    let stiff = |v: &usize| vertices.joints[*v][0] == 0 && vertices.weights[*v][0] == 1.0;
    let stray = (0..vertices.positions.len()).find(stiff).expect("a vertex of the root");
    vertices.joints[stray][0] = 1;
    let shape = [LevelShape::Own(vertices, mesh.order.triangles.clone())];
    let in_frames = |worst: Vec<u32>| {
        let frames = MeasuredFrames { mean: vec![0], worst };
        let palettes = frames.palettes(&poses);
        (LevelMeasure::new(&mesh, &frames, &palettes, joint_count, 100).measure(&shape), frames)
    };
    let (mut errors, frames) = in_frames(Vec::new());
    let (first, all) = (errors[0], in_frames((1..frame_count).collect()).0[0]);
    measure_worse_frames(&mesh, &frames, &poses, &shape, &mut errors);
    let found = errors[0];
    assert!(found.max_m > 2.0 * first.max_m, "{first:?} {found:?}");
    assert!((found.max_m - all.max_m).abs() <= 1e-3 * all.max_m, "{found:?} {all:?}");
    assert!(found.bound_m >= all.max_m && found.rms_m == first.rms_m, "{found:?} {all:?}");
    // As `verify` does: the same bits.
    let palette = &palettes[found.max_frame as usize * joint_count..][..joint_count];
    assert_eq!(measure_in_frame_too(&mesh, &shape[0], first, found.max_frame, palette), found);
    // Nothing is worse than where it is worst.
    measure_worse_frames(&mesh, &frames, &poses, &shape, &mut errors);
    assert_eq!(errors[0], found);
}

#[test]
fn a_bound_too_small_is_noticed() {
    let path = fixtures().join("good/straight_tube_should_keep_its_elbow.glb");
    let contents = crowdbake::bake_file(&path).unwrap();
    let broken = measure(&contents).into_iter().filter(|&(bound_m, found_m)| found_m > bound_m * 0.5);
    assert!(broken.count() > 0, "half of a bound is too little for some level");
}
