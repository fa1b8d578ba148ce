//! Trajectories from crowd simulators and from recordings: who was where at what time, made ready to be shown.
//!
//! Read are JuPedSim's database, the Juelich archive's text, Vadere's text (steps or positions) and comma-separated
//! values. The file's plane becomes the ground: x goes to +X, y to -Z, and the middle of the walkable area (or of
//! everyone) to the origin, in f64, so that map coordinates keep their millimetres.

mod juelich;
mod jupedsim;
mod rows;
mod table;
mod tracks;

#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::area::WalkableArea;
use crate::sqlite;
use crate::walker::{Walker, between_yaws};
use crate::{Error, Result};
use rows::Rows;
use tracks::{Sample, Track};

/// Frames a second a file may have.
pub(crate) const RATES_HZ: std::ops::RangeInclusive<f64> = 0.001..=100_000.0;

/// Everyone's way through time.
#[derive(Debug, Clone)]
pub struct Trajectories {
    tracks: Vec<Track>,
    samples: Vec<Sample>,
    person_count: usize,
    end_s: f32,
    origin: [f64; 2],
    area: Option<WalkableArea>,
    remarks: Vec<String>,
}

impl Trajectories {
    /// Reads a file of any of the kinds above; which one is told from its content, not from its name. Rows may stand in any
    /// order. `frame_rate_hz`: for text that counts frames and does not say how many a second.
    ///
    /// # Errors
    /// [`Error::Format`] with the line: a missing column, a number that is none, is not finite or is too large, the same
    /// person twice at one time. [`Error::Limit`] past ten million rows. [`Error::Content`] for a damaged database, an area
    /// that is no polygon, no frame rate, nobody at all.
    pub fn read(bytes: &[u8], frame_rate_hz: Option<f64>) -> Result<Self> {
        if bytes.starts_with(sqlite::MAGIC) {
            let (rows, area) = jupedsim::read(bytes)?;
            return Self::new(rows, area);
        }
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
            Error::content(format!("line {line}"), "bytes that are no text", "UTF-8 text, or a database of JuPedSim")
        })?;
        let text = text.trim_start_matches('\u{feff}');
        let first = text.lines().find(|line| table::is_content(line)).unwrap_or("");
        let rows = if juelich::looks_like_it(first) {
            juelich::read(text, frame_rate_hz)?
        } else {
            table::read(text, frame_rate_hz)?
        };
        Self::new(rows, None)
    }

    fn new(rows: Rows, area: Option<WalkableArea>) -> Result<Self> {
        if rows.rows.is_empty() {
            return Err(Error::content("the file", "nobody", "at least one row with a person"));
        }
        let mut remarks = rows.remarks.clone();
        let ways = tracks::follow(rows, area.as_ref())?;
        if ways.latest_start_s > 0.0 && ways.skipped_s.abs() > 1.0 {
            remarks.push(format!("time begins with the first person, at {:.1} s of the file", ways.skipped_s));
        }
        let area = area.map(|area| area.moved_to(ways.origin));
        Ok(Self {
            person_count: ways.person_count,
            end_s: ways.end_s,
            origin: ways.origin,
            tracks: ways.tracks,
            samples: ways.samples,
            area,
            remarks,
        })
    }

    /// People in the file, present or not.
    pub fn person_count(&self) -> usize {
        self.person_count
    }

    /// Stays in the file: who leaves for more than two seconds and comes back has two. As many walkers as there can be.
    pub fn stay_count(&self) -> usize {
        self.tracks.len()
    }

    /// From the first row to the last, seconds.
    pub fn end_s(&self) -> f32 {
        self.end_s
    }

    /// Where the scene's origin lies in the file's coordinates, metres.
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Least and greatest corner of the ground that people stand on, metres around the origin.
    pub fn extent(&self) -> (Vec3, Vec3) {
        let places = self.samples.iter().map(|sample| Vec3::new(sample.x, 0.0, sample.z));
        places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    }

    /// Where people may walk, if the file says so; in metres around the origin.
    pub fn area(&self) -> Option<&WalkableArea> {
        self.area.as_ref()
    }

    /// What the reader passed over or assumed, as sentences.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Fills `walkers` with those present at `time_s`, in the order in which they came. Positions are straight between two
    /// rows, directions turn the shorter way. Before the first row and after the last nobody is there.
    pub fn people_at(&self, time_s: f32, walkers: &mut Vec<Walker>) {
        walkers.clear();
        let come = self.tracks.partition_point(|track| track.start_s <= time_s);
        walkers
            .extend(self.tracks[..come].iter().filter(|track| track.end_s >= time_s).map(|t| self.walker(t, time_s)));
    }

    /// Everyone once, where they first were: for sizes and names.
    pub fn everyone(&self) -> Vec<Walker> {
        self.tracks.iter().map(|track| self.walker(track, track.start_s)).collect()
    }

    fn walker(&self, track: &Track, time_s: f32) -> Walker {
        let samples = &self.samples[track.first as usize..(track.first + track.count) as usize];
        let after = samples.partition_point(|sample| sample.time_s <= time_s).clamp(1, samples.len());
        let before = &samples[after - 1];
        let next = samples.get(after).unwrap_or(before);
        let span = next.time_s - before.time_s;
        let t = if span > 0.0 { ((time_s - before.time_s) / span).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Walker {
            id: track.id,
            position: Vec3::new(mix(before.x, next.x), 0.0, mix(before.z, next.z)),
            yaw_rad: between_yaws(before.yaw_rad, next.yaw_rad, t),
            speed_m_s: mix(before.speed_m_s, next.speed_m_s),
            gait: before.gait,
            walked_m: mix(before.walked_m, next.walked_m),
            ran_m: mix(before.ran_m, next.ran_m),
            gait_before: before.gait_before,
            changed_s: time_s - before.gait_since_s,
        }
    }
}
