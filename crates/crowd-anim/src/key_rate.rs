//! The rate that a clip's keys were made at: sampled at another, the corners of its curves fall between frames.

use crate::sample_clip::MAX_FRAMES;

/// Frames a second of clips whose keys lie on no even grid.
pub const USUAL_FPS: f32 = 30.0;
/// Frames a second that a grid of keys may have: fewer leave turns between them too wide, more are room for nothing.
const RATES: std::ops::RangeInclusive<f64> = 20.0..=60.0;
/// A key this far from a frame, in frames, is on it: exporters round times, some to milliseconds.
const OFF_GRID: f64 = 0.04;
/// Looks at a key, over all rates tried, after which a clip counts as uneven: files may have millions of keys.
const MOST_LOOKS: u32 = 1 << 24;

/// Steps from frame to frame with which every key of a clip falls on a frame, as near to [`USUAL_FPS`] as there are; `None` where no rate
/// from 20 to 60 a second has that, or the clip has no duration, or more than [`MAX_FRAMES`]. `tracks`: key times of each of its tracks,
/// seconds, not negative.
pub fn key_steps(tracks: &[&[f32]]) -> Option<u32> {
    let mut times = tracks.concat();
    times.sort_unstable_by(f32::total_cmp);
    times.dedup();
    let duration_s = f64::from(*times.last()?);
    let most = (RATES.end() * duration_s).floor().min(f64::from(MAX_FRAMES - 1));
    let least = (RATES.start() * duration_s).ceil().max(1.0);
    if least > most {
        return None;
    }
    let mut candidates: Vec<u32> = (least as u32..=most as u32).collect();
    let off_usual = |steps: &u32| (f64::from(*steps) / duration_s - f64::from(USUAL_FPS)).abs();
    candidates.sort_by(|a, b| off_usual(a).total_cmp(&off_usual(b)).then(a.cmp(b)));
    let mut looks = 0;
    for steps in candidates {
        let frame = |time: f32| f64::from(time) / duration_s * f64::from(steps);
        let is_off = |time: &f32| (frame(*time) - frame(*time).round()).abs() > OFF_GRID;
        let Some(off) = times.iter().position(is_off) else { return Some(steps) };
        looks += off as u32 + 1;
        if looks > MOST_LOOKS {
            return None;
        }
    }
    None
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
        for (fps, seconds) in [(24.0, 10.0), (30.0, 10.0), (48.0, 10.0), (60.0, 10.0), (24.0, 300.0), (60.0, 120.0)] {
            let count = (fps * seconds) as u32;
            let exact = every(1.0 / fps, count);
            let rounded: Vec<f32> = exact.iter().map(|time| (time * 1000.0).round() / 1000.0).collect();
            assert_eq!(key_steps(&[&rounded]), Some(count), "{fps} a second for {seconds} s, in milliseconds");
            assert_eq!(key_steps(&[&exact]), Some(count), "{fps} a second for {seconds} s");
        }
        // Gaps of two and of three frames at 24.
        assert_eq!(key_steps(&[&[0.0, 2.0 / 24.0, 5.0 / 24.0], &[0.0]]), Some(5));
        // Sixteen keys of a run of 0.7 seconds.
        assert_eq!(key_steps(&[&every(0.7 / 16.0, 16)]), Some(16));
        assert_eq!(key_steps(&[&[0.0, 1.0]]), Some(30));
    }

    /// A file of a few megabytes must not take a minute.
    #[test]
    fn a_crowd_of_keys_is_given_up() {
        let mut times: Vec<f32> = (0..500_000).map(|key| key as f32 * 8.0e-10).collect();
        times.extend((1..40).map(|key| key as f32 * 50.618_034));
        assert_eq!(key_steps(&[&times]), None);
    }

    #[test]
    fn uneven_keys_have_no_rate() {
        assert_eq!(key_steps(&[&[0.0, 0.317, 0.5432, 1.0]]), None);
        assert_eq!(key_steps(&[&every(1.0 / 90.0, 90)]), None);
        assert_eq!(key_steps(&[&every(1.0 / 24.0, 24), &every(1.0 / 30.0, 30)]), None);
        assert_eq!(key_steps(&[&[0.0]]), None);
        assert_eq!(key_steps(&[]), None);
        assert_eq!(key_steps(&[&[0.0, 7.0e7]]), None);
        assert_eq!(key_steps(&[&[0.0, 1.0e30]]), None);
        assert_eq!(key_steps(&[&[0.0, 1.0e-30]]), None);
    }
}
