use super::*;
use crate::pose::{palette_at, pose_positions};
use crate::sample::{FrameRate, sample_clips};
use crowd_source::{Limits, RawInterpolation, RawProperty, RawTrack};
use std::path::Path;

/// A tube of two joints that bends, 1.9 m high.
fn tube() -> RawCharacter {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/good/straight_tube_should_keep_its_elbow.glb");
    crowd_source::load_character(&path, &Limits::default()).expect("a good fixture")
}

/// The tube with a track more, from `first` to `last` in the time of its clip.
fn moved(property: RawProperty, first: [f32; 3], last: [f32; 3]) -> RawCharacter {
    let mut raw = tube();
    let node = raw.joints[1].node;
    let clip = &mut raw.clips[0];
    clip.tracks.retain(|track| track.node != node || track.property != property);
    let times = vec![0.0, views::clip_end_s(clip)];
    let (values, interpolation) = ([first, last].concat(), RawInterpolation::Linear);
    clip.tracks.push(RawTrack { node, property, interpolation, times, values });
    raw
}

const HEIGHT_M: f32 = 1.9;

fn store(raw: &RawCharacter, asked: StorageAsked) -> (QuantizedMesh, Vec<SampledClip>, StoredAnimation) {
    let (clips, _) = sample_clips(raw, FrameRate::Fixed(30.0)).expect("it was sampled before");
    let mesh = views::quantize(&raw.mesh);
    let stored = store_animation(raw, &mesh, &clips, HEIGHT_M, &asked).expect("it was sampled before");
    (mesh, clips, stored)
}

/// The largest distance of a vertex at many times, worked out as a reader would.
fn looked_at(mesh: &QuantizedMesh, sampled: &SampledClip, stored: &SampledClip, joint_count: usize) -> f32 {
    let pose = |clip: &SampledClip, time_s: f32| {
        let palette = palette_at(&clip.palettes, joint_count, clip.duration_s, time_s);
        pose_positions(&mesh.positions, &mesh.joints, &mesh.weights, &palette)
    };
    let mut most = 0.0_f32;
    for i in 0..=1000 {
        let time_s = sampled.duration_s * i as f32 / 1000.0;
        for (a, b) in pose(sampled, time_s).iter().zip(pose(stored, time_s)) {
            let d = [0, 1, 2].map(|axis| a[axis] - b[axis]);
            most = most.max((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt());
        }
    }
    most
}

#[test]
fn no_vertex_is_ever_off_by_more_than_is_said_and_allowed() {
    let raw = tube();
    let mut last_bytes = u64::MAX;
    for error_share in [0.0, 0.000_1, 0.001, 0.01] {
        let (mesh, sampled, stored) = store(&raw, StorageAsked { error_share, ..StorageAsked::default() });
        assert!(stored.error_m <= stored.allowed_m && stored.bytes(raw.joints.len()) <= last_bytes, "{error_share}");
        let found = looked_at(&mesh, &sampled[0], &stored.clips[0], raw.joints.len());
        assert!(found <= stored.error_m + 1e-5, "{error_share}: {found} m, said {}", stored.error_m);
        assert!(found >= stored.error_m * 0.9 - 1e-5, "{error_share}: the error is no mere bound");
        if error_share == 0.0 {
            assert_eq!((stored.storage, stored.error_m, stored.warning()), (JointStorage::F32, 0.0, None));
            assert_eq!(stored.clips, sampled, "bit for bit");
        } else {
            assert_eq!((stored.storage, stored.warning()), (JointStorage::Quantized, None));
        }
        last_bytes = stored.bytes(raw.joints.len());
    }
    assert!(last_bytes * 4 < store(&raw, StorageAsked::exact()).2.papers_bytes(raw.joints.len()));
}

#[test]
fn a_clip_that_is_shown_late_is_found_out() {
    let raw = tube();
    let (mesh, sampled, stored) = store(&raw, StorageAsked::default());
    let mut late = stored.clips[0].clone();
    late.palettes.rotate_right(raw.joints.len());
    assert!(looked_at(&mesh, &sampled[0], &late, raw.joints.len()) > stored.allowed_m);
    assert!(Points::of(&mesh, raw.joints.len()).apart(&sampled[0], &late, f32::INFINITY) > stored.allowed_m);
}

#[test]
fn what_does_not_fit_16_bytes_gets_more_and_is_told() {
    let wider = moved(RawProperty::Scale, [1.0; 3], [1.5, 1.0, 1.0]);
    let mirrored = moved(RawProperty::Scale, [-1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]);
    for odd in [wider, mirrored] {
        let (.., stored) = store(&odd, StorageAsked::default());
        assert_eq!(stored.storage, JointStorage::F16);
        assert!(stored.error_m <= stored.allowed_m && stored.passed_over.len() == 1);
        let warning = stored.warning().expect("it is told");
        assert!(warning.message.contains("stored as f16"), "{}", warning.message);
    }
    let far = moved(RawProperty::Translation, [0.0; 3], [0.0, 300.0, 0.0]);
    let (.., stored) = store(&far, StorageAsked::default());
    assert_eq!((stored.storage, stored.passed_over.len()), (JointStorage::F32, 2));
    // Whoever asks gets it, and hears by how much it is off.
    let asked = StorageAsked { storage: Some(JointStorage::F16), ..StorageAsked::default() };
    let (.., stored) = store(&far, asked);
    assert_eq!(stored.storage, JointStorage::F16);
    assert!(stored.error_m > stored.allowed_m && stored.warning().is_some());
}

#[test]
fn one_that_grows_alike_on_all_sides_fits() {
    let grown = moved(RawProperty::Scale, [1.0; 3], [3.0; 3]);
    assert_eq!(store(&grown, StorageAsked::default()).2.storage, JointStorage::Quantized);
}
