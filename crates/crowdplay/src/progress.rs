//! A word now and then while frames are drawn that take long, with the time that is left.

use std::time::{Duration, Instant};

/// Before the first word; the wait doubles with each.
const FIRST: Duration = Duration::from_secs(5);
/// Between two words at most.
const LONGEST: Duration = Duration::from_secs(60);

/// How far a run is.
#[derive(Debug)]
pub struct Progress {
    frames: u32,
    started: Instant,
    last: Instant,
    wait: Duration,
}

impl Progress {
    /// Of so many frames, from now on.
    pub fn new(frames: u32) -> Self {
        let now = Instant::now();
        Self { frames, started: now, last: now, wait: FIRST }
    }

    /// What to say when `share` (0 to 1) of a frame is drawn, if it is time to say something.
    pub fn word(&mut self, frame: u32, share: f64) -> Option<String> {
        if self.last.elapsed() < self.wait {
            return None;
        }
        let done = (f64::from(frame) + share.clamp(0.0, 1.0)) / f64::from(self.frames.max(1));
        if done >= 1.0 {
            return None;
        }
        self.last = Instant::now();
        self.wait = (2 * self.wait).min(LONGEST);
        Some(words(frame, self.frames, done, self.started.elapsed().as_secs_f64()))
    }
}

fn words(frame: u32, frames: u32, done: f64, gone_s: f64) -> String {
    let place = if frames > 1 { format!("frame {} of {frames}", frame + 1) } else { "drawing".to_owned() };
    if done <= 0.0 {
        return format!("{place}, {gone_s:.0} s gone");
    }
    let left_s = (gone_s * (1.0 / done - 1.0)).ceil().min(1e9) as u64;
    let left = match left_s {
        0..100 => format!("{left_s} s"),
        100..6000 => format!("{} min", left_s.div_ceil(60)),
        _ => format!("{} h", left_s.div_ceil(3600)),
    };
    format!("{place}, {:.0} % done, about {left} left", 100.0 * done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_said() {
        assert_eq!(words(0, 1, 0.25, 10.0), "drawing, 25 % done, about 30 s left");
        assert_eq!(words(30, 120, 0.25, 60.0), "frame 31 of 120, 25 % done, about 3 min left");
        assert_eq!(words(1, 1000, 0.001, 60.0), "frame 2 of 1000, 0 % done, about 17 h left");
        assert_eq!(words(0, 9, 0.0, 7.0), "frame 1 of 9, 7 s gone");
    }

    #[test]
    fn short_runs_are_silent_and_long_ones_are_not_chatty() {
        let mut progress = Progress::new(2);
        assert_eq!(progress.word(0, 0.5), None, "it has just begun");
        progress.wait = Duration::ZERO;
        progress.last = progress.started;
        assert!(progress.word(0, 0.5).is_some());
        progress.wait = Duration::ZERO;
        assert_eq!(progress.word(1, 1.0), None, "it is done");
        progress.wait = LONGEST;
        assert_eq!(progress.word(0, 0.5), None);
    }
}
