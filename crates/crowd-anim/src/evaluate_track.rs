//! One curve at one time, as glTF 2.0 appendix C says. In `f64` and without SIMD: the same bits on every machine.

use crate::{Interpolation, Property, TrackView};
use glam::{DQuat, DVec3, DVec4};

/// A node's local transform while it is being posed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalPose {
    pub(crate) translation: DVec3,
    pub(crate) rotation: DQuat,
    pub(crate) scale: DVec3,
}

/// Puts the track's value at `time_s` into the node's pose. The track was checked: keys and values are there.
pub(crate) fn apply_track(track: &TrackView<'_>, time_s: f64, pose: &mut LocalPose) {
    match track.property {
        Property::Translation => pose.translation = evaluate(track, time_s).truncate(),
        Property::Scale => pose.scale = evaluate(track, time_s).truncate(),
        Property::Rotation => pose.rotation = unit_or_identity(evaluate(track, time_s)),
    }
}

/// The rotation of that direction; identity when there is none to take.
pub(crate) fn unit_or_identity(quaternion: DVec4) -> DQuat {
    let length = quaternion.length();
    if length.is_finite() && length > 1e-12 { DQuat::from_vec4(quaternion / length) } else { DQuat::IDENTITY }
}

/// Before the first key and after the last their values hold.
fn evaluate(track: &TrackView<'_>, time_s: f64) -> DVec4 {
    let after = track.times.partition_point(|&t| f64::from(t) <= time_s);
    if after == 0 {
        return key_value(track, 0);
    }
    let key = after - 1;
    if after == track.times.len() {
        return key_value(track, key);
    }
    let start_s = f64::from(track.times[key]);
    let span_s = f64::from(track.times[after]) - start_s;
    let t = (time_s - start_s) / span_s;
    match track.interpolation {
        Interpolation::Step => key_value(track, key),
        Interpolation::Linear if track.property == Property::Rotation => {
            let from = unit_or_identity(key_value(track, key));
            let to = unit_or_identity(key_value(track, after));
            DVec4::from(from.slerp(to, t))
        }
        Interpolation::Linear => key_value(track, key).lerp(key_value(track, after), t),
        Interpolation::CubicSpline => {
            let (t2, t3) = (t * t, t * t * t);
            key_value(track, key) * (2.0 * t3 - 3.0 * t2 + 1.0)
                + key_part(track, key, 2) * (span_s * (t3 - 2.0 * t2 + t))
                + key_value(track, after) * (3.0 * t2 - 2.0 * t3)
                + key_part(track, after, 0) * (span_s * (t3 - t2))
        }
    }
}

fn key_value(track: &TrackView<'_>, key: usize) -> DVec4 {
    match track.interpolation {
        Interpolation::CubicSpline => key_part(track, key, 1),
        Interpolation::Step | Interpolation::Linear => key_part(track, key, 0),
    }
}

/// Part of a key: for cubic splines 0 is the in-tangent, 1 the value, 2 the out-tangent; otherwise 0 is the value.
fn key_part(track: &TrackView<'_>, key: usize, part: usize) -> DVec4 {
    let floats = floats_per_value(track.property);
    let at = (key * parts_per_key(track.interpolation) + part) * floats;
    let value = &track.values[at..at + floats];
    let w = value.get(3).copied().unwrap_or(0.0);
    DVec4::new(value[0].into(), value[1].into(), value[2].into(), w.into())
}

/// Floats of one value of the property.
pub(crate) fn floats_per_value(property: Property) -> usize {
    match property {
        Property::Translation | Property::Scale => 3,
        Property::Rotation => 4,
    }
}

/// Values of one key: cubic splines keep their tangents with it.
pub(crate) fn parts_per_key(interpolation: Interpolation) -> usize {
    match interpolation {
        Interpolation::Step | Interpolation::Linear => 1,
        Interpolation::CubicSpline => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn track<'a>(
        property: Property,
        interpolation: Interpolation,
        times: &'a [f32],
        values: &'a [f32],
    ) -> TrackView<'a> {
        TrackView { node: 0, property, interpolation, times, values }
    }

    fn x_at(track: &TrackView<'_>, time_s: f64) -> f64 {
        evaluate(track, time_s).x
    }

    #[test]
    fn step_holds_until_the_next_key() {
        let curve = track(Property::Translation, Interpolation::Step, &[1.0, 2.0], &[5.0, 0.0, 0.0, 7.0, 0.0, 0.0]);
        assert_eq!([0.0, 1.0, 1.999, 2.0, 9.0].map(|t| x_at(&curve, t)), [5.0, 5.0, 5.0, 7.0, 7.0]);
    }

    #[test]
    fn linear_is_clamped_at_both_ends() {
        let curve = track(Property::Scale, Interpolation::Linear, &[1.0, 3.0], &[2.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
        assert_eq!([0.0, 1.0, 1.5, 2.0, 3.0, 4.0].map(|t| x_at(&curve, t)), [2.0, 2.0, 2.5, 3.0, 4.0, 4.0]);
    }

    #[test]
    fn cubic_spline_by_hand() {
        // Keys 0 and 1 at 0 s and 2 s, out-tangent 1 per second, in-tangent 0. At the middle:
        // h00 = h01 = 1/2, h10 = 1/8, h11 = -1/8: 0/2 + 2 * 1/8 * 1 + 1/2 + 0 = 0.75.
        let values = [9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 9.0, 0.0, 0.0];
        let curve = track(Property::Translation, Interpolation::CubicSpline, &[0.0, 2.0], &values);
        assert_eq!([-1.0, 0.0, 1.0, 2.0, 3.0].map(|t| x_at(&curve, t)), [0.0, 0.0, 0.75, 1.0, 1.0]);
    }

    #[test]
    fn rotations_take_the_short_way() {
        // 90 degrees about Z, the second key written with the opposite sign: the same rotation, the long way round.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half];
        let curve = track(Property::Rotation, Interpolation::Linear, &[0.0, 1.0], &keys);
        let middle = unit_or_identity(evaluate(&curve, 0.5));
        let eighth = std::f64::consts::FRAC_PI_8;
        assert!((middle.z.abs() - libm::sin(eighth)).abs() < 1e-7);
        assert!((middle.w.abs() - libm::cos(eighth)).abs() < 1e-7);
    }

    #[test]
    fn a_rotation_without_direction_is_none() {
        let curve = track(Property::Rotation, Interpolation::Step, &[0.0], &[0.0; 4]);
        assert_eq!(unit_or_identity(evaluate(&curve, 0.0)), DQuat::IDENTITY);
    }

    proptest! {
        #[test]
        fn rotations_stay_unit(
            keys in prop::collection::vec(prop::array::uniform12(-1.0_f32..1.0), 1..5), time in -1.0_f64..6.0, kind in 0..3,
        ) {
            let interpolation = [Interpolation::Step, Interpolation::Linear, Interpolation::CubicSpline][kind as usize];
            let times: Vec<f32> = (0..keys.len()).map(|i| i as f32).collect();
            let floats = parts_per_key(interpolation) * 4;
            let values: Vec<f32> = keys.iter().flat_map(|key| key[..floats].to_vec()).collect();
            let curve = track(Property::Rotation, interpolation, &times, &values);
            let mut pose = LocalPose { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };
            apply_track(&curve, time, &mut pose);
            prop_assert!((pose.rotation.length() - 1.0).abs() < 1e-9);
        }

        #[test]
        fn linear_stays_between_its_keys(a in -9.0_f32..9.0, b in -9.0_f32..9.0, time in -1.0_f64..2.0) {
            let curve_values = [a, 0.0, 0.0, b, 0.0, 0.0];
            let curve = track(Property::Translation, Interpolation::Linear, &[0.0, 1.0], &curve_values);
            let x = x_at(&curve, time);
            prop_assert!(x >= f64::from(a.min(b)) - 1e-9 && x <= f64::from(a.max(b)) + 1e-9);
        }
    }
}
