//! The rate that a clip's keys were made at: sampled at another, the corners of its curves fall between frames.

use crate::sample_clip::MAX_FRAMES;

/// Frames a second of clips whose keys lie on no even grid.
pub const USUAL_FPS: f32 = 30.0;
/// Frames a second that a grid of keys may have: fewer leave turns between them too wide, more are room for nothing.
const RATES: std::ops::RangeInclusive<f64> = 20.0..=60.0;
/// A key this far from a frame, in frames, is on it: exporters round times, some to milliseconds.
const OFF_GRID: f64 = 0.03;
/// Keys less than that apart, seconds, are one: tracks round differently.
const SAME_KEY_S: f64 = 0.004;

/// Steps from frame to frame with which every key of a clip falls on a frame, as near to [`USUAL_FPS`] as there are; `None` where no rate
/// from 20 to 60 a second has that, or the clip has no duration. `tracks`: key times of each of its tracks, seconds, not negative.
pub fn key_steps(tracks: &[&[f32]]) -> Option<u32> {
    let mut times = tracks.concat();
    times.sort_unstable_by(f32::total_cmp);
    times.dedup();
    let duration_s = f64::from(*times.last()?);
    let gaps = times.windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0]));
    let gap_s = gaps.filter(|gap| *gap > SAME_KEY_S).reduce(f64::min)?;
    // The grid divides the smallest gap.
    let parts = (RATES.start() * gap_s - OFF_GRID).ceil().max(1.0) as u32..=(RATES.end() * gap_s + OFF_GRID) as u32;
    let mut steps: Vec<u32> = parts
        .map(|parts| (f64::from(parts) / gap_s * duration_s).round())
        .filter(|steps| (1.0..f64::from(MAX_FRAMES)).contains(steps))
        .map(|steps| steps as u32)
        .collect();
    let off_usual = |steps: &u32| (f64::from(*steps) / duration_s - f64::from(USUAL_FPS)).abs();
    steps.sort_by(|a, b| off_usual(a).total_cmp(&off_usual(b)).then(a.cmp(b)));
    let on_grid = |steps: &u32| {
        let frame = |time: f32| f64::from(time) / duration_s * f64::from(*steps);
        times.iter().all(|&time| (frame(time) - frame(time).round()).abs() <= OFF_GRID)
    };
    steps.into_iter().find(on_grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    fn every(step_s: f32, count: u32) -> Vec<f32> {
        (0..=count).map(|key| key as f32 * step_s).collect()
    }

    #[test]
    fn keys_fall_on_frames_at_the_rate_nearest_to_thirty() {
        for (fps, count, wanted) in [
            (24.0, 36, 36),
            (30.0, 45, 45),
            (25.0, 10, 10),
            (60.0, 60, 60),
            (12.0, 12, 24),
            (10.0, 10, 30),
            (48.0, 7, 7),
        ] {
            assert_eq!(key_steps(&[&every(1.0 / fps, count)]), Some(wanted), "{fps} a second");
        }
        // Milliseconds, as some write them; and a track of its ends alone.
        let rounded: Vec<f32> = every(1.0 / 24.0, 24).iter().map(|time| (time * 1000.0).round() / 1000.0).collect();
        assert_eq!(key_steps(&[&rounded, &[0.0, 1.0]]), Some(24));
        // Gaps of two and of three frames at 24.
        assert_eq!(key_steps(&[&[0.0, 2.0 / 24.0, 5.0 / 24.0], &[0.0]]), Some(5));
        // Sixteen keys of a run of 0.7 seconds.
        assert_eq!(key_steps(&[&every(0.7 / 16.0, 16)]), Some(16));
        assert_eq!(key_steps(&[&[0.0, 1.0]]), Some(30));
    }

    #[test]
    fn uneven_keys_have_no_rate() {
        assert_eq!(key_steps(&[&[0.0, 0.317, 0.5432, 1.0]]), None);
        assert_eq!(key_steps(&[&every(1.0 / 90.0, 90)]), None);
        assert_eq!(key_steps(&[&every(1.0 / 24.0, 24), &every(1.0 / 30.0, 30)]), None);
        assert_eq!(key_steps(&[&[0.0]]), None);
        assert_eq!(key_steps(&[]), None);
        assert_eq!(key_steps(&[&[0.0, 1.0e30]]), None);
        assert_eq!(key_steps(&[&[0.0, 1.0e-30]]), None);
    }
}
