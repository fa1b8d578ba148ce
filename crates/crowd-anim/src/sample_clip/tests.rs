use super::*;
use crate::{Error, Interpolation, Mat3x4, TrackView, Trs, pose_at};
use glam::{Mat4, Quat, Vec3};
use proptest::prelude::*;

fn trs(translation: Vec3) -> Trs {
    Trs { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE }
}

/// A hip one metre up, a knee half a metre below it, bound where they rest.
fn leg() -> (Skeleton, Vec<Joint>) {
    let skeleton = Skeleton {
        parents: vec![None, Some(0)],
        rest: vec![trs(Vec3::new(0.0, 1.0, 0.0)), trs(Vec3::new(0.0, -0.5, 0.0))],
    };
    let bind =
        |node: u32, height: f32| Joint { node, inverse_bind: Mat4::from_translation(Vec3::new(0.0, -height, 0.0)) };
    (skeleton, vec![bind(0, 1.0), bind(1, 0.5)])
}

fn track<'a>(node: u32, property: Property, times: &'a [f32], values: &'a [f32]) -> TrackView<'a> {
    TrackView { node, property, interpolation: Interpolation::Linear, times, values }
}

fn is_identity(matrix: &Mat3x4) -> bool {
    let identity = Mat4::IDENTITY.transpose().to_cols_array_2d();
    matrix.iter().flatten().zip(identity.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn rest_is_one_frame_of_identities() {
    let (skeleton, joints) = leg();
    let clip = rest_clip(&skeleton, &joints).unwrap();
    assert_eq!((clip.name.as_str(), clip.frame_count, clip.duration_s), ("rest", 1, 0.0));
    assert!(clip.palettes.len() == 2 && clip.palettes.iter().all(is_identity));
    assert_eq!(
        clip.worlds[1],
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    );
    assert_eq!(clip.root_motion, RootMotion::default());
}

#[test]
fn frames_end_on_the_clips_end() {
    let (skeleton, joints) = leg();
    let values = [0.0, 1.0, 0.0, 0.0, 1.0, 3.0];
    // Last key time, frames asked for, frames given: 1 s at 30 is 30 steps; 25 frames' worth of rounded seconds stays 25.
    for (end_s, fps, frames) in
        [(1.0, 30.0, 31), (0.833_333_4, 30.0, 26), (0.01, 30.0, 2), (1.02, 30.0, 32), (0.0, 30.0, 1)]
    {
        let times = [end_s - 1.0, end_s];
        let tracks = vec![track(0, Property::Translation, &times, &values)];
        let clip = sample_clip(&skeleton, &joints, &ClipView { name: "walk", tracks }, fps).unwrap();
        assert_eq!(clip.frame_count, frames, "{end_s} s");
        assert_eq!(clip.palettes.len(), clip.frame_count as usize * 2);
        assert_eq!(clip.duration_s, end_s);
        assert_eq!(clip.palettes.last().unwrap()[2][3], 3.0);
    }
}

#[test]
fn a_walk_reports_its_travel_and_has_no_gap() {
    let (skeleton, joints) = leg();
    // The hip goes 3 m forward and 4 m sideways in two seconds; the knee swings and comes back.
    let times = [0.0, 1.0, 2.0];
    let hip = [0.0, 1.0, 0.0, 9.0, 1.0, 9.0, 4.0, 1.0, 3.0];
    let knee = [0.0, -0.5, 0.0, 0.0, -0.4, 0.3, 0.0, -0.5, 0.0];
    let tracks = vec![track(1, Property::Translation, &times, &knee), track(0, Property::Translation, &times, &hip)];
    let clip = sample_clip(&skeleton, &joints, &ClipView { name: "walk", tracks }, 30.0).unwrap();
    assert_eq!(clip.root_motion, RootMotion { node: Some(0), displacement_m: [4.0, 0.0, 3.0] });
    assert!(clip.loop_gap_m < 1e-6);
}

#[test]
fn a_bent_knee_at_the_end_is_a_gap() {
    let (skeleton, joints) = leg();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn = [0.0, 0.0, 0.0, 1.0, half, 0.0, 0.0, half];
    let tracks = vec![track(0, Property::Rotation, &[0.0, 1.0], &turn)];
    let clip = sample_clip(&skeleton, &joints, &ClipView { name: "kick", tracks }, 10.0).unwrap();
    // A quarter turn about X takes the knee from (0, 0.5, 0) to (0, 1, -0.5).
    assert!((clip.loop_gap_m - 0.5 * std::f32::consts::SQRT_2).abs() < 1e-6);
    let knee = clip.worlds.last().unwrap();
    assert!((knee[1][3] - 1.0).abs() < 1e-6 && (knee[2][3] + 0.5).abs() < 1e-6);
}

#[test]
fn nonsense_is_refused_by_name() {
    let (skeleton, joints) = leg();
    let sample = |node: u32, times: &[f32], values: &[f32], fps: f32| {
        let tracks = vec![track(node, Property::Translation, times, values)];
        match sample_clip(&skeleton, &joints, &ClipView { name: "bad", tracks }, fps) {
            Err(Error::Parameter { what, .. }) => what,
            other => panic!("{other:?}"),
        }
    };
    let ok = [0.0; 3];
    assert_eq!(sample(0, &[0.0], &ok, 0.5), "frames a second");
    assert_eq!(sample(0, &[0.0], &ok, f32::NAN), "frames a second");
    assert_eq!(sample(2, &[0.0], &ok, 30.0), "clip `bad`: track 0: node");
    assert_eq!(sample(0, &[], &[], 30.0), "clip `bad`: track 0: keys");
    assert_eq!(sample(0, &[f32::NAN], &ok, 30.0), "clip `bad`: track 0: times");
    assert_eq!(sample(0, &[1.0, 1.0], &[0.0; 6], 30.0), "clip `bad`: track 0: times");
    assert_eq!(sample(0, &[0.0], &[0.0; 4], 30.0), "clip `bad`: track 0: values");
    assert_eq!(sample(0, &[0.0], &[f32::INFINITY; 3], 30.0), "clip `bad`: track 0: values");
    assert_eq!(sample(0, &[1e30], &ok, 30.0), "clip `bad`: frames");
    let huge = Skeleton { parents: vec![None, Some(0)], rest: vec![trs(Vec3::splat(3e38)); 2] };
    assert!(rest_clip(&huge, &joints).is_err());
    let upward = Skeleton { parents: vec![Some(0)], rest: vec![trs(Vec3::ZERO)] };
    assert!(rest_clip(&upward, &[]).is_err());
    let outside = [Joint { node: 7, inverse_bind: Mat4::IDENTITY }];
    assert!(rest_clip(&skeleton, &outside).is_err());
}

#[test]
fn times_out_of_this_world_hold_the_ends() {
    let (skeleton, joints) = leg();
    let tracks = vec![track(0, Property::Translation, &[1.0, 2.0], &[0.0, 1.0, 0.0, 0.0, 4.0, 0.0])];
    let clip = ClipView { name: "up", tracks };
    let height = |time_s| pose_at(&skeleton, &joints, &clip, time_s).unwrap()[0][1][3];
    assert_eq!([f32::NAN, f32::NEG_INFINITY, 1.5, f32::INFINITY].map(height), [0.0, 0.0, 1.5, 3.0]);
}

proptest! {
    #[test]
    fn both_layouts_agree(
        keys in prop::collection::vec(prop::array::uniform4(-1.0_f32..1.0), 2..6),
        scale in prop::array::uniform3(0.5_f32..2.0), offset in prop::array::uniform3(-1.0_f32..1.0),
    ) {
        let (mut skeleton, mut joints) = leg();
        skeleton.rest[0].scale = Vec3::from(scale);
        joints[1].inverse_bind = Mat4::from_translation(Vec3::from(offset));
        let times: Vec<f32> = (0..keys.len()).map(|i| i as f32 * 0.1).collect();
        let values: Vec<f32> = keys.iter().flatten().copied().collect();
        let tracks = vec![track(0, Property::Rotation, &times, &values), track(1, Property::Rotation, &times, &values)];
        let view = ClipView { name: "twist", tracks };
        let clip = sample_clip(&skeleton, &joints, &view, 30.0).unwrap();
        for frame in 0..clip.frame_count as usize {
            for (j, joint) in joints.iter().enumerate() {
                let world = Mat4::from_cols_array_2d(&clip.worlds[frame * 2 + j]).transpose();
                let product = (world * joint.inverse_bind).transpose().to_cols_array_2d();
                let palette = clip.palettes[frame * 2 + j];
                for r in 0..3 {
                    for c in 0..4 {
                        prop_assert!((product[r][c] - palette[r][c]).abs() < 1e-4);
                    }
                }
            }
        }
        prop_assert_eq!(&clip.palettes[..2], &pose_at(&skeleton, &joints, &view, 0.0).unwrap()[..]);
        let last = pose_at(&skeleton, &joints, &view, clip.duration_s).unwrap();
        prop_assert_eq!(&clip.palettes[clip.palettes.len() - 2..], &last[..]);
    }
}
