//! From rows to ways: sorted, centred, with speed, heading and gait at every sample.

use glam::DVec2;

use super::rows::{Row, Rows};
use crate::area::WalkableArea;
use crate::dice::{Dice, Purpose};
use crate::text::{FARTHEST_M, wrong};
use crate::walker::{Gait, wrapped};
use crate::{Error, Result};

/// Half the time over which a velocity is taken: a stride sways the body by a few centimetres every half second.
const HALF_WINDOW_S: f64 = 0.4;
/// A person who is not in the file for longer than this has left.
const LONGEST_GAP_S: f64 = 2.0;
/// So many frames without a row are a gap at least, for files of few frames a second.
const LONGEST_GAP_FRAMES: f64 = 5.0;
/// Slower than this the direction is noise: people keep facing where they faced.
const HEADING_FROM_M_S: f64 = 0.25;
/// Half a turn takes half a second.
const FASTEST_TURN_RAD_S: f32 = std::f32::consts::TAU;
/// A gait of shorter duration is not taken up.
const SHORTEST_GAIT_S: f32 = 0.6;
/// From the first row to the last: eleven days; f32 keeps 60 ms there.
const LONGEST_S: f64 = 1.0e6;

/// One person from coming to leaving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Track {
    /// The same for all stays of one person.
    pub(super) id: u32,
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) start_s: f32,
    pub(super) end_s: f32,
}

/// A person at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) time_s: f32,
    pub(super) x: f32,
    pub(super) z: f32,
    pub(super) yaw_rad: f32,
    pub(super) speed_m_s: f32,
    pub(super) walked_m: f32,
    pub(super) ran_m: f32,
    pub(super) gait: Gait,
    pub(super) gait_before: Gait,
    /// When the gait began; before all time where it is the first.
    pub(super) gait_since_s: f32,
}

/// What [`follow`] makes.
pub(super) struct Ways {
    /// In order of their start.
    pub(super) tracks: Vec<Track>,
    pub(super) samples: Vec<Sample>,
    pub(super) person_count: usize,
    pub(super) origin: [f64; 2],
    pub(super) end_s: f32,
    pub(super) latest_start_s: f32,
    /// The file's time at which ours begins.
    pub(super) skipped_s: f64,
}

/// Sorts the rows into ways and derives speeds, headings and gaits. At least one row.
pub(super) fn follow(rows: Rows, area: Option<&WalkableArea>) -> Result<Ways> {
    let Rows { mut rows, ids, stay_between_rows, frame_s, .. } = rows;
    sort_by_person(&mut rows, &ids)?;
    let begin_s = rows.iter().map(|row| row.time_s).fold(f64::INFINITY, f64::min);
    let end_s = rows.iter().map(|row| row.time_s).fold(f64::NEG_INFINITY, f64::max) - begin_s;
    if end_s > LONGEST_S {
        return Err(Error::content(
            "the file",
            format!("{end_s} s from first to last row"),
            format!("at most {LONGEST_S}"),
        ));
    }
    let origin = middle_of(&rows, area)?;
    let longest_gap = frame_s.map_or(LONGEST_GAP_S, |frame| LONGEST_GAP_S.max(LONGEST_GAP_FRAMES * frame));
    let mut ways = Ways {
        tracks: Vec::new(),
        samples: Vec::with_capacity(rows.len()),
        person_count: ids.len(),
        origin,
        end_s: end_s as f32,
        latest_start_s: 0.0,
        skipped_s: begin_s,
    };
    let goes_on = |a: &Row, b: &Row| a.person == b.person && (stay_between_rows || b.time_s - a.time_s <= longest_gap);
    for stay in rows.chunk_by(goes_on) {
        let first = ways.samples.len() as u32;
        let id = ids[stay[0].person as usize].key();
        push_stay(stay, id, begin_s, origin, &mut ways.samples);
        let time = |row: &Row| (row.time_s - begin_s) as f32;
        let (start_s, end_s) = (time(&stay[0]), time(&stay[stay.len() - 1]));
        ways.latest_start_s = ways.latest_start_s.max(start_s);
        ways.tracks.push(Track { id, first, count: stay.len() as u32, start_s, end_s });
    }
    ways.tracks.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.first.cmp(&b.first)));
    Ok(ways)
}

/// By person (in order of their ids), then time. What stands there twice, word for word, is taken once.
fn sort_by_person(rows: &mut Vec<Row>, ids: &[super::rows::Id]) -> Result<()> {
    let mut order: Vec<u32> = (0..ids.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| ids[a as usize].cmp(&ids[b as usize]));
    let mut rank = vec![0_u32; ids.len()];
    for (place, &person) in order.iter().enumerate() {
        rank[person as usize] = place as u32;
    }
    rows.sort_unstable_by(|a, b| {
        let by_person = rank[a.person as usize].cmp(&rank[b.person as usize]);
        by_person.then(a.time_s.total_cmp(&b.time_s)).then(a.line.cmp(&b.line))
    });
    let same_time = |a: &Row, b: &Row| a.person == b.person && a.time_s == b.time_s;
    for pair in rows.windows(2).filter(|pair| same_time(&pair[0], &pair[1])) {
        let (a, b) = (&pair[0], &pair[1]);
        // The end of a step and the start of the next are computed twice and may differ in their last digits.
        if (a.x - b.x).abs() > 1e-3 || (a.y - b.y).abs() > 1e-3 {
            let found = format!("person {} at two places at {} s", ids[b.person as usize], b.time_s);
            return Err(wrong(b.line as usize, &found, &format!("one place, as in line {}", a.line)));
        }
    }
    rows.dedup_by(|b, a| same_time(a, b));
    Ok(())
}

/// The middle of the area, or else of everyone.
fn middle_of(rows: &[Row], area: Option<&WalkableArea>) -> Result<[f64; 2]> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for row in rows {
        let place = DVec2::new(row.x, row.y);
        (low, high) = (low.min(place), high.max(place));
    }
    let (area_low, area_high) = area.map_or((low, high), WalkableArea::extent);
    let middle = (area_low + area_high) * 0.5;
    let extent = high.max(area_high) - low.min(area_low);
    if extent.max_element() > f64::from(FARTHEST_M) {
        let found = format!("{} m from one end to the other", extent.max_element());
        return Err(Error::content("the file", found, format!("at most {FARTHEST_M} m")));
    }
    Ok(middle.to_array())
}

/// Appends the samples of one stay.
fn push_stay(stay: &[Row], id: u32, begin_s: f64, origin: [f64; 2], samples: &mut Vec<Sample>) {
    let first = samples.len();
    let velocities = velocities(stay);
    let mut walked_m = 0.0_f64;
    let mut gait = Gait::Idle.at_speed(velocities[0].length() as f32);
    for (i, (row, velocity)) in stay.iter().zip(&velocities).enumerate() {
        let speed = velocity.length();
        if i > 0 {
            walked_m += 0.5 * (speed + velocities[i - 1].length()) * (row.time_s - stay[i - 1].time_s);
        }
        gait = gait.at_speed(speed as f32);
        samples.push(Sample {
            time_s: (row.time_s - begin_s) as f32,
            x: (row.x - origin[0]) as f32,
            z: (origin[1] - row.y) as f32,
            yaw_rad: 0.0,
            speed_m_s: speed as f32,
            walked_m: walked_m as f32,
            ran_m: 0.0,
            gait,
            gait_before: gait,
            gait_since_s: f32::NEG_INFINITY,
        });
    }
    let samples = &mut samples[first..];
    face_ahead(stay, &velocities, id, samples);
    drop_short_gaits(samples);
    tell_changes(samples);
}

/// When gaits began and which came before them, and the metres run.
fn tell_changes(samples: &mut [Sample]) {
    let mut ran_m = 0.0_f64;
    for i in 1..samples.len() {
        let last = samples[i - 1];
        if last.gait == Gait::Run {
            ran_m += f64::from(samples[i].walked_m - last.walked_m);
        }
        let changed = samples[i].gait != last.gait;
        let now = &mut samples[i];
        now.ran_m = ran_m as f32;
        (now.gait_before, now.gait_since_s) =
            if changed { (last.gait, now.time_s) } else { (last.gait_before, last.gait_since_s) };
    }
}

/// Displacement over the window around each row, by its time; the neighbours at least.
fn velocities(stay: &[Row]) -> Vec<DVec2> {
    let last = stay.len() - 1;
    let (mut low, mut high) = (0, 0);
    (0..stay.len())
        .map(|i| {
            let now = stay[i].time_s;
            while stay[low].time_s < now - HALF_WINDOW_S {
                low += 1;
            }
            while high < last && stay[high + 1].time_s <= now + HALF_WINDOW_S {
                high += 1;
            }
            let (a, b) = (&stay[low.min(i.saturating_sub(1))], &stay[high.max(i + 1).min(last)]);
            let seconds = b.time_s - a.time_s;
            if seconds > 0.0 { DVec2::new(b.x - a.x, b.y - a.y) / seconds } else { DVec2::ZERO }
        })
        .collect()
}

/// Headings: what the file says, else the direction of walking; who stands keeps the last one, or the first to come.
fn face_ahead(stay: &[Row], velocities: &[DVec2], id: u32, samples: &mut [Sample]) {
    let wanted = |i: usize| {
        let [x, y] = stay[i].facing.map(f64::from);
        let v = velocities[i];
        let direction = if x * x + y * y > 1e-6 {
            DVec2::new(x, y)
        } else if v.length() >= HEADING_FROM_M_S {
            v
        } else {
            return None;
        };
        Some(libm::atan2(direction.x, -direction.y) as f32)
    };
    let nowhere = || Dice { seed: 0, index: id }.around_zero(Purpose::Yaw) * std::f32::consts::PI;
    let mut yaw = (0..stay.len()).find_map(wanted).unwrap_or_else(nowhere);
    for i in 0..stay.len() {
        if let Some(goal) = wanted(i) {
            let turn = wrapped(goal - yaw);
            let most =
                if i == 0 { f32::INFINITY } else { FASTEST_TURN_RAD_S * (samples[i].time_s - samples[i - 1].time_s) };
            yaw = wrapped(yaw + turn.clamp(-most, most));
        }
        samples[i].yaw_rad = yaw;
    }
}

/// A gait that does not last gives way to the one before it, the first one to the one after it.
fn drop_short_gaits(samples: &mut [Sample]) {
    let mut start = 0;
    let mut before = None;
    while start < samples.len() {
        let gait = samples[start].gait;
        let length = samples[start..].iter().take_while(|sample| sample.gait == gait).count();
        let end = start + length;
        let until = samples.get(end).map_or(f32::INFINITY, |sample| sample.time_s);
        let is_short = until - samples[start].time_s < SHORTEST_GAIT_S;
        let instead = before.or_else(|| samples.get(end).map(|sample| sample.gait)).filter(|_| is_short);
        for sample in &mut samples[start..end] {
            sample.gait = instead.unwrap_or(gait);
        }
        before = Some(instead.unwrap_or(gait));
        start = end;
    }
}
