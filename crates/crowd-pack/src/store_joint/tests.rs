use super::*;
use proptest::prelude::*;

const IDENTITY: JointRows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A rotation about a unit axis by an angle, scaled, with a translation.
fn turned(axis: [f32; 3], angle: f32, scale: f32, translation: [f32; 3]) -> JointRows {
    let length = axis.iter().map(|c| c * c).sum::<f32>().sqrt();
    let [x, y, z] = axis.map(|c| c / length);
    let (s, c) = libm::sincosf(angle);
    let t = 1.0 - c;
    let [tx, ty, tz] = translation;
    let rotation = [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
    ];
    let [a, b, c] = rotation.map(|row| row.map(|entry| entry * scale));
    [[a[0], a[1], a[2], tx], [b[0], b[1], b[2], ty], [c[0], c[1], c[2], tz]]
}

fn through(storage: JointStorage, joints: &[JointRows]) -> Vec<JointRows> {
    let mut texels = Vec::new();
    store_frame(storage, joints, &mut texels);
    assert_eq!(texels.len(), storage.frame_texels(joints.len() as u32) as usize);
    assert_eq!(find_fault(storage, &texels, joints.len() as u32), None);
    stored_frames(storage, &texels, joints.len() as u32)
}

fn largest_difference(a: &JointRows, b: &JointRows, columns: std::ops::Range<usize>) -> f32 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a[columns.clone()].iter().zip(&b[columns.clone()]));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn whole_and_still_joints_come_back_exactly() {
    let still = [IDENTITY, turned([0.0, 1.0, 0.0], 0.0, 4.0, [0.5, -1.25, 3.0]), [[0.0; 4]; 3]];
    for storage in JointStorage::ALL {
        assert_eq!(through(storage, &still), still, "{storage:?}");
        assert_eq!(JointStorage::of_code(storage.code()), Some(storage));
    }
    assert_eq!(JointStorage::of_code(3), None);
}

#[test]
fn what_mirrors_or_shears_shows() {
    let mut mirrored = IDENTITY;
    mirrored[0][0] = -1.0;
    let mut sheared = IDENTITY;
    sheared[0][1] = 0.5;
    for odd in [mirrored, sheared] {
        assert!(largest_difference(&through(JointStorage::Quantized, &[odd])[0], &odd, 0..4) > 0.1);
        assert_eq!(through(JointStorage::F16, &[odd]), [odd]);
    }
}

#[test]
fn every_half_float_comes_back() {
    for half in 0..=u16::MAX {
        let (exponent, number) = (half >> 10 & 0x1f, of_half(half));
        match exponent {
            0 => assert!(number.abs() < 6.2e-5 && to_half(number) == 0),
            31 => assert!(number.abs() >= 65_536.0),
            _ => assert_eq!(to_half(number), half),
        }
    }
    assert_eq!([of_half(0x3c00), of_half(0xc000), of_half(0x3555)], [1.0, -2.0, 0.333_251_95]);
    assert_eq!([to_half(1e9), to_half(-1e9), to_half(f32::NAN)], [0x7bff, 0xfbff, 0]);
    // Half way between 1 and the next one goes to the even one.
    assert_eq!([to_half(1.0 + 1.0 / 2048.0), to_half(1.0 + 3.0 / 2048.0)], [0x3c00, 0x3c02]);
}

#[test]
fn faults_are_found() {
    let quantized = |exponents: u32| [0, 0, 0, exponents << 16];
    assert_eq!(find_fault(JointStorage::Quantized, &[quantized(0x8e7f)], 1), None);
    assert!(find_fault(JointStorage::Quantized, &[quantized(0x8f00)], 1).is_some());
    assert!(find_fault(JointStorage::Quantized, &[quantized(0x0080)], 1).is_some());
    assert!(find_fault(JointStorage::F16, &[[0x7c00, 0, 0, 0], [0; 4]], 1).is_some());
    assert!(find_fault(JointStorage::F16, &[[0, 0, 0xfe00_0000, 0], [0; 4]], 1).is_some());
    assert_eq!(find_fault(JointStorage::F16, &[[0; 4], [0, 0, 1, 0]], 1), Some((1, "zeros behind the last joint")));
    assert!(find_fault(JointStorage::F32, &[[0, f32::NAN.to_bits(), 0, 0]], 1).is_some());
}

proptest! {
    #[test]
    fn a_rotation_a_scale_and_a_translation_fit_in_16_bytes(
        axis in prop::array::uniform3(-1.0_f32..1.0),
        angle in -7.0_f32..7.0,
        scale in 0.01_f32..50.0,
        translation in prop::array::uniform3(-20.0_f32..20.0),
    ) {
        prop_assume!(axis.iter().map(|c| c * c).sum::<f32>() > 0.01);
        let joint = turned(axis, angle, scale, translation);
        let back = through(JointStorage::Quantized, &[joint])[0];
        prop_assert!(largest_difference(&back, &joint, 0..3) <= 2e-4 * scale, "{back:?} of {joint:?}");
        let largest = translation.iter().fold(0.0_f32, |a, b| a.max(b.abs()));
        prop_assert!(largest_difference(&back, &joint, 3..4) <= largest / 32_000.0, "{back:?} of {joint:?}");
        let halves = through(JointStorage::F16, &[joint, IDENTITY, joint]);
        prop_assert!(largest_difference(&halves[2], &joint, 0..4) <= 50.0 / 2048.0);
        prop_assert_eq!(halves[0], halves[2]);
    }

    #[test]
    fn any_texel_without_fault_gives_finite_numbers(texel: [u32; 4]) {
        for storage in JointStorage::ALL {
            let frame = vec![texel; storage.frame_texels(1) as usize];
            if find_fault(storage, &frame, 1).is_none() {
                prop_assert!(stored_joint(storage, &frame, 0).iter().flatten().all(|number| number.is_finite()));
            }
        }
    }
}
