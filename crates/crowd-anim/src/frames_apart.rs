//! How far vertices move when a clip is stored in another way: other matrices, fewer frames.

use crate::Mat3x4;
use crate::skin::skin;

/// The largest distance, metres, between a vertex as `reference` poses it and as `stored` does, at any time of the clip.
///
/// Both hold whole frames of `joint_count` matrices, at least one, spread evenly over the same time and blended linearly between, as the
/// player does. The difference of the two is linear between the frames of both, so no time has a larger one than the frames have:
/// those are looked at, and the result is exact. Ends early where something is farther than `enough`, and gives that distance.
///
/// `positions`, `joints`, `weights`: one per vertex, bind space, metres. What is not finite is infinitely far.
pub fn frames_apart(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    reference: &[Mat3x4],
    stored: &[Mat3x4],
    joint_count: usize,
    enough: f32,
) -> f32 {
    let frames = |palettes: &[Mat3x4]| (palettes.len() / joint_count.max(1)).saturating_sub(1) as u64;
    let (steps_a, steps_b) = (frames(reference), frames(stored));
    let mut difference = vec![[[0.0; 4]; 3]; joint_count];
    let mut most = 0.0_f32;
    for (time, whole) in shared_times(steps_a, steps_b) {
        let (a, b) = (place(time, whole, steps_a), place(time, whole, steps_b));
        for (joint, entry) in difference.iter_mut().enumerate() {
            let at = |palettes: &[Mat3x4], (frame, share): (usize, f64)| {
                let first = palettes[frame * joint_count + joint];
                let second = palettes.get((frame + 1) * joint_count + joint).copied().unwrap_or(first);
                (first, second, share)
            };
            *entry = minus(at(reference, a), at(stored, b));
        }
        for ((position, joints), weights) in positions.iter().zip(joints).zip(weights) {
            let [x, y, z] = skin(*position, joints, weights, &difference);
            let distance = (x * x + y * y + z * z).sqrt();
            most = if distance.is_finite() { most.max(distance) } else { f32::INFINITY };
        }
        if most > enough {
            break;
        }
    }
    most
}

/// The times at which one of the two has a frame, as parts of the second number, rising.
fn shared_times(steps_a: u64, steps_b: u64) -> impl Iterator<Item = (u64, u64)> {
    let (a, b) = (steps_a.max(1), steps_b.max(1));
    let mut times: Vec<u64> = (0..=a).map(|i| i * b).chain((0..=b).map(|i| i * a)).collect();
    times.sort_unstable();
    times.dedup();
    times.into_iter().map(move |time| (time, a * b))
}

/// The frame before a time and the share of the next one.
fn place(time: u64, whole: u64, steps: u64) -> (usize, f64) {
    let at = time * steps;
    ((at / whole) as usize, (at % whole) as f64 / whole as f64)
}

/// The first blend less the second.
fn minus(a: (Mat3x4, Mat3x4, f64), b: (Mat3x4, Mat3x4, f64)) -> Mat3x4 {
    let blend = |(first, second, share): (Mat3x4, Mat3x4, f64), r: usize, c: usize| {
        let (first, second): (f64, f64) = (first[r][c].into(), second[r][c].into());
        first + (second - first) * share
    };
    [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| (blend(a, r, c) - blend(b, r, c)) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: [[f32; 3]; 2] = [[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
    const FIRST: [[u16; 4]; 2] = [[0; 4]; 2];
    const WHOLE: [[f32; 4]; 2] = [[1.0, 0.0, 0.0, 0.0]; 2];

    fn moved(x: f32) -> Mat3x4 {
        [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    }

    fn apart(reference: &[Mat3x4], stored: &[Mat3x4]) -> f32 {
        frames_apart(&POINT, &FIRST, &WHOLE, reference, stored, 1, f32::INFINITY)
    }

    #[test]
    fn fewer_frames_of_an_even_movement_are_no_loss() {
        let even: Vec<Mat3x4> = (0..=12).map(|i| moved(i as f32 / 12.0)).collect();
        assert_eq!(apart(&even, &even), 0.0);
        assert!(apart(&even, &[moved(0.0), moved(1.0)]) < 1e-6);
        // Five steps do not divide twelve.
        let fifths: Vec<Mat3x4> = (0..=5).map(|i| moved(i as f32 / 5.0)).collect();
        assert!(apart(&even, &fifths) < 1e-6);
    }

    #[test]
    fn what_lies_between_the_frames_of_one_is_seen() {
        // There and back again: two frames see nothing of it.
        let there_and_back = [moved(0.0), moved(1.0), moved(0.0)];
        assert_eq!(apart(&there_and_back, &[moved(0.0), moved(0.0)]), 1.0);
        assert_eq!(apart(&[moved(0.0), moved(0.0)], &there_and_back), 1.0);
        // Three steps against two: a third of the way the ones are at 2/3, the others at 0.
        let thirds = [moved(0.0), moved(0.0), moved(0.0), moved(0.0)];
        assert_eq!(apart(&there_and_back, &thirds), 1.0);
    }

    #[test]
    fn the_farthest_vertex_counts_and_what_is_no_number_is_infinitely_far() {
        let mut sheared = moved(0.0);
        sheared[0][1] = 0.25;
        assert_eq!(apart(&[moved(0.0)], &[sheared]), 0.5);
        assert_eq!(apart(&[moved(0.0)], &[moved(f32::NAN)]), f32::INFINITY);
    }
}
