//! Clips of real characters, sampled and bounded; the oracle skins in `f64`, one vertex at a time.

use crowd_anim::{Bounds, Joint, Mat3x4, Skeleton, animated_bounds, pose_at, sample_clip, union_bounds};
use crowd_source::{Limits, RawCharacter, load_character};
use crowd_tests::folders::assets;
use crowdbake::views::{clip_view, joints_of, skeleton_of};

fn load(path: &str) -> RawCharacter {
    load_character(&assets().join(path), &Limits::default()).unwrap()
}

fn skeleton(raw: &RawCharacter) -> (Skeleton, Vec<Joint>) {
    (skeleton_of(raw), joints_of(raw))
}

fn skin(raw: &RawCharacter, vertex: usize, palette: &[Mat3x4]) -> [f64; 3] {
    let position = raw.mesh.positions[vertex].map(f64::from);
    let mut point = [0.0; 3];
    for (joint, weight) in raw.mesh.joints[vertex].iter().zip(raw.mesh.weights[vertex]) {
        for (sum, row) in point.iter_mut().zip(palette[usize::from(*joint)]) {
            let [x, y, z, w] = row.map(f64::from);
            *sum += f64::from(weight) * (x * position[0] + y * position[1] + z * position[2] + w);
        }
    }
    point
}

fn holds(bounds: &Bounds, point: [f64; 3]) -> bool {
    let inside = |axis: usize| (f64::from(bounds.min[axis])..=f64::from(bounds.max[axis])).contains(&point[axis]);
    let apart = [0, 1, 2].map(|axis: usize| point[axis] - f64::from(bounds.center[axis]));
    let squared: f64 = apart.iter().map(|d| d * d).sum();
    (0..3).all(inside) && squared.sqrt() <= f64::from(bounds.radius)
}

fn blend(a: &[Mat3x4], b: &[Mat3x4], t: f32) -> Vec<Mat3x4> {
    let mix = |(a, b): (&Mat3x4, &Mat3x4)| {
        [0, 1, 2].map(|r: usize| [0, 1, 2, 3].map(|c: usize| a[r][c] * (1.0 - t) + b[r][c] * t))
    };
    a.iter().zip(b).map(mix).collect()
}

/// Characters of different make: a quadruped of 100 units, a man, rigid parts, many clips.
const CHARACTERS: [&str; 4] = [
    "khronos-fox/Fox.glb",
    "khronos-cesium-man/CesiumMan.glb",
    "kaykit-skeleton-minion/skeleton_minion.glb",
    "nasty/valid/cesium_man_step_cubic_mix.glb",
];

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn bounds_hold_every_vertex_of_every_frame_and_between() {
    for path in CHARACTERS {
        let raw = load(path);
        let (skeleton, joints) = skeleton(&raw);
        assert!(!raw.clips.is_empty(), "{path} moves");
        let clips: Vec<_> =
            raw.clips.iter().map(|clip| sample_clip(&skeleton, &joints, &clip_view(clip), 30.0).unwrap()).collect();
        let mesh = &raw.mesh;
        let bound =
            |palettes: &[Mat3x4]| animated_bounds(&mesh.positions, &mesh.joints, &mesh.weights, palettes, joints.len());
        let bounds: Vec<Bounds> = clips.iter().map(|clip| bound(&clip.palettes)).collect();
        let all = union_bounds(&bounds);
        for (clip, own) in clips.iter().zip(&bounds) {
            let frames: Vec<&[Mat3x4]> = clip.palettes.chunks(joints.len()).collect();
            assert_eq!(frames.len(), clip.frame_count as usize);
            for (frame, palette) in frames.iter().enumerate() {
                let between = blend(palette, frames[(frame + 1).min(frames.len() - 1)], 0.4);
                for vertex in 0..mesh.positions.len() {
                    for point in [skin(&raw, vertex, palette), skin(&raw, vertex, &between)] {
                        assert!(
                            holds(own, point) && holds(&all, point),
                            "{path} {} frame {frame}: {point:?}",
                            clip.name
                        );
                    }
                }
            }
            // Tight as well: no face of the box is a thousandth of its size away from the nearest vertex.
            let points = || frames.iter().flat_map(|palette| (0..mesh.positions.len()).map(|v| skin(&raw, v, palette)));
            for axis in 0..3 {
                let size = f64::from(own.max[axis] - own.min[axis]);
                let least = points().map(|p| p[axis]).fold(f64::MAX, f64::min);
                assert!(least - f64::from(own.min[axis]) < 1e-3 * size, "{path} {} axis {axis}", clip.name);
            }
        }
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn frames_are_the_poses_at_their_times() {
    let raw = load(CHARACTERS[0]);
    let (skeleton, joints) = skeleton(&raw);
    for clip in &raw.clips {
        let view = clip_view(clip);
        let sampled = sample_clip(&skeleton, &joints, &view, 24.0).unwrap();
        for frame in [0, 1, sampled.frame_count / 2, sampled.frame_count - 1] {
            let time_s = sampled.duration_s * frame as f32 / (sampled.frame_count - 1) as f32;
            let pose = pose_at(&skeleton, &joints, &view, time_s).unwrap();
            let stored = &sampled.palettes[frame as usize * joints.len()..][..joints.len()];
            for (a, b) in pose.iter().flatten().flatten().zip(stored.iter().flatten().flatten()) {
                assert!((a - b).abs() <= 1e-4 * (1.0 + b.abs()), "{} frame {frame}: {a} and {b}", clip.name);
            }
        }
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn the_fox_closes_its_loops() {
    let raw = load(CHARACTERS[0]);
    let (skeleton, joints) = skeleton(&raw);
    let sampled: Vec<_> =
        raw.clips.iter().map(|clip| sample_clip(&skeleton, &joints, &clip_view(clip), 30.0).unwrap()).collect();
    let told: Vec<_> = sampled.iter().map(|clip| (clip.name.as_str(), clip.frame_count)).collect();
    // 82, 17 and 28 keys at 24 a second: 3.417 s, 0.708 s and 1.158 s.
    assert_eq!(told, [("Survey", 104), ("Walk", 23), ("Run", 36)]);
    for clip in &sampled {
        // The fox is 79 units high.
        assert!(clip.loop_gap_m < 0.8, "{}: gap {}", clip.name, clip.loop_gap_m);
    }
}
