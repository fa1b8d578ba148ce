//! Camera paths: keys in time, and their text file.
//!
//! ```text
//! # crowd camera path v1
//! # time_s  eye x y z  target x y z  fov_deg (vertical)
//! 0   0 3 20   0 1 0   45
//! 5   8 3 12   0 1 0   45
//! # Ways go on where the path was; each takes so many seconds.
//! #           seconds  eye x y z  target x y z  fov_deg
//! line        4        0 2 12     0 1 0         45
//! #           seconds  target x y z  distance  elevation_deg  from_deg to_deg  fov_deg
//! orbit       10       0 1 0         12        5              0 360            45
//! #           seconds  low x z  high x z  eye height  fov_deg
//! walkthrough 33.3     -50 -50  50 50     1.7         45
//! ```

use std::fmt::Write as _;

use glam::Vec3;

use crate::text::{FARTHEST_M, Line, lines_after, wrong, wrong_in_words};
use crate::{Camera, Error, Result};

const HEADING: &str = "# crowd camera path v1";
/// An hour at 30 keys a second: what one path may hold.
const MOST_KEYS: usize = 108_000;

/// Where the camera is at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraKey {
    /// Seconds, rising from key to key.
    pub time_s: f32,
    /// Position, metres.
    pub eye: Vec3,
    /// Looked at, metres.
    pub target: Vec3,
    /// Vertical field of view.
    pub fov_y_rad: f32,
}

/// Keys in order of time, at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    keys: Vec<CameraKey>,
}

impl CameraPath {
    /// Reads the text file described above.
    ///
    /// # Errors
    /// [`Error::Format`] with the line: another heading, a wrong number of words, a number out of range, a time that does
    /// not rise, an eye in its target, no key at all. [`Error::Limit`] past 108,000 keys.
    pub fn parse(text: &str) -> Result<Self> {
        let mut keys: Vec<CameraKey> = Vec::new();
        for line in lines_after(text, HEADING)? {
            if let Some(way) = read_way(&line, keys.last())? {
                go_on(&mut keys, way, line.number)?;
                continue;
            }
            line.must_have(8, "time_s, eye x y z, target x y z, fov_deg")?;
            if keys.len() == MOST_KEYS {
                return Err(Error::Limit { line: line.number, allowed: MOST_KEYS });
            }
            let key = CameraKey {
                time_s: line.number_in(0, "time_s", 0.0, 1.0e6)?,
                eye: place(&line, 1, "eye")?,
                target: place(&line, 4, "target")?,
                fov_y_rad: fov_y_rad(&line, 7)?,
            };
            if let Some(before) = keys.last()
                && key.time_s <= before.time_s
            {
                return Err(wrong(line.number, &key.time_s.to_string(), &format!("a time after {}", before.time_s)));
            }
            if key.eye == key.target {
                return Err(wrong_in_words(
                    line.number,
                    &format!("eye and target at {}", key.eye),
                    "two different points",
                ));
            }
            keys.push(key);
        }
        if keys.is_empty() {
            return Err(wrong_in_words(text.lines().count().max(1), "no key", "at least one line with a key"));
        }
        Ok(Self { keys })
    }

    /// Keys in order of time, at least one.
    pub(crate) fn from_keys(keys: impl IntoIterator<Item = CameraKey>) -> Self {
        Self { keys: keys.into_iter().collect() }
    }

    /// A path that stands still: where a recording begins.
    pub fn starting(time_s: f32, camera: &Camera) -> Self {
        Self { keys: vec![key_of(time_s, camera)] }
    }

    /// Adds where the camera is now, unless that is less than a 30th of a second after the last key or the path is full
    /// (an hour).
    pub fn record(&mut self, time_s: f32, camera: &Camera) {
        let is_due = time_s >= self.end_s() + 0.99 / 30.0;
        if is_due && self.keys.len() < MOST_KEYS && camera.eye != camera.target {
            self.keys.push(key_of(time_s, camera));
        }
    }

    /// The text file of this path.
    pub fn write(&self) -> String {
        let mut text = format!("{HEADING}\n# time_s  eye x y z  target x y z  fov_deg\n");
        for key in &self.keys {
            let (e, t) = (key.eye, key.target);
            let fov = key.fov_y_rad.to_degrees();
            // Writing to a string does not fail.
            let _ = writeln!(text, "{} {} {} {} {} {} {} {fov}", key.time_s, e.x, e.y, e.z, t.x, t.y, t.z);
        }
        text
    }

    /// Keys in order of time.
    pub fn keys(&self) -> &[CameraKey] {
        &self.keys
    }

    /// Time of the last key, seconds.
    pub fn end_s(&self) -> f32 {
        self.keys[self.keys.len() - 1].time_s
    }

    /// The camera at a time: straight from key to key, held before the first and after the last. Planes from `planes`.
    pub fn at(&self, time_s: f32, planes: &Camera) -> Camera {
        let after = self.keys.partition_point(|key| key.time_s <= time_s);
        let camera = |key: &CameraKey| Camera { eye: key.eye, target: key.target, fov_y_rad: key.fov_y_rad, ..*planes };
        let first = &self.keys[after.saturating_sub(1)];
        match self.keys.get(after) {
            Some(second) if after > 0 => {
                let t = (time_s - first.time_s) / (second.time_s - first.time_s);
                camera(first).towards(&camera(second), t)
            }
            _ => camera(first),
        }
    }
}

fn key_of(time_s: f32, camera: &Camera) -> CameraKey {
    CameraKey { time_s, eye: camera.eye, target: camera.target, fov_y_rad: camera.fov_y_rad }
}

/// Three numbers from a word on.
fn place(line: &Line<'_>, word: usize, name: &str) -> Result<Vec3> {
    let axis = |offset: usize| line.number_in(word + offset, name, -FARTHEST_M, FARTHEST_M);
    Ok(Vec3::new(axis(0)?, axis(1)?, axis(2)?))
}

fn fov_y_rad(line: &Line<'_>, word: usize) -> Result<f32> {
    Ok(line.number_in(word, "fov_deg", 1.0, 170.0)?.to_radians())
}

/// The way that a line names, if it names one; times from 0. `last`: the key before it.
fn read_way(line: &Line<'_>, last: Option<&CameraKey>) -> Result<Option<CameraPath>> {
    let seconds = || line.number_in(1, "seconds", 0.01, 1.0e6);
    if line.is_word(0, "line") {
        line.must_have(9, "line, seconds, eye x y z, target x y z, fov_deg")?;
        let first = last.ok_or_else(|| wrong_in_words(line.number, "`line` first", "a key or a way before it"))?;
        let (eye, target) = (place(line, 2, "eye")?, place(line, 5, "target")?);
        if eye == target {
            return Err(wrong_in_words(line.number, &format!("eye and target at {eye}"), "two different points"));
        }
        let end = CameraKey { time_s: seconds()?, eye, target, fov_y_rad: fov_y_rad(line, 8)? };
        return Ok(Some(CameraPath::from_keys([CameraKey { time_s: 0.0, ..*first }, end])));
    }
    if line.is_word(0, "orbit") {
        line.must_have(10, "orbit, seconds, target x y z, distance, elevation_deg, from_deg, to_deg, fov_deg")?;
        let distance = line.number_in(5, "distance", 0.01, FARTHEST_M)?;
        let elevation = line.number_in(6, "elevation_deg", -89.0, 89.0)?.to_radians();
        let turn = |word: usize, name: &str| Ok(line.number_in(word, name, -18_000.0, 18_000.0)?.to_radians());
        let turns = [turn(7, "from_deg")?, turn(8, "to_deg")?];
        let target = place(line, 2, "target")?;
        return Ok(Some(CameraPath::orbit(target, distance, elevation, turns, seconds()?, fov_y_rad(line, 9)?)));
    }
    if line.is_word(0, "walkthrough") {
        line.must_have(8, "walkthrough, seconds, low x z, high x z, eye height, fov_deg")?;
        let axis = |word: usize, name: &str| line.number_in(word, name, -FARTHEST_M, FARTHEST_M);
        let (low_x, low_z, high_x, high_z) =
            (axis(2, "low x")?, axis(3, "low z")?, axis(4, "high x")?, axis(5, "high z")?);
        if low_x > high_x || low_z > high_z {
            return Err(wrong_in_words(line.number, "a low corner above the high one", "low x z, then high x z"));
        }
        let (low, high) = (Vec3::new(low_x, 0.0, low_z), Vec3::new(high_x, 0.0, high_z));
        let eye_m = line.number_in(6, "eye height", 0.1, 1000.0)?;
        return Ok(Some(CameraPath::walkthrough(low, high, eye_m, seconds()?, fov_y_rad(line, 7)?)));
    }
    Ok(None)
}

/// Appends a way to the keys, from the time of the last one on.
fn go_on(keys: &mut Vec<CameraKey>, way: CameraPath, line: usize) -> Result<()> {
    let begin_s = keys.last().map_or(0.0, |key| key.time_s);
    for key in way.keys {
        let time_s = begin_s + key.time_s;
        // The way's first key falls on the last one; another place there is a cut.
        let is_first = key.time_s == 0.0;
        if is_first && keys.last().is_some_and(|last| CameraKey { time_s: last.time_s, ..key } == *last) {
            continue;
        }
        let time_s = if is_first && !keys.is_empty() { begin_s.next_up().max(begin_s + 1.0e-3) } else { time_s };
        if keys.len() == MOST_KEYS {
            return Err(Error::Limit { line, allowed: MOST_KEYS });
        }
        if keys.last().is_none_or(|last| time_s > last.time_s) {
            keys.push(CameraKey { time_s, ..key });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOOD: &str = "# crowd camera path v1\n\n0 0 3 20 0 1 0 45 # start\n4 8 3 12 0 1 0 50\n";

    fn planes() -> Camera {
        Camera::orbit(Vec3::ZERO, 10.0, 0.0, 0.0)
    }

    #[test]
    fn a_path_is_straight_between_its_keys_and_holds_at_its_ends() {
        let path = CameraPath::parse(GOOD).expect("good");
        assert_eq!(path.end_s(), 4.0);
        assert_eq!(path.at(-1.0, &planes()).eye, Vec3::new(0.0, 3.0, 20.0));
        assert_eq!(path.at(f32::NAN, &planes()).eye, Vec3::new(0.0, 3.0, 20.0));
        assert_eq!(path.at(9.0, &planes()).eye, Vec3::new(8.0, 3.0, 12.0));
        let half = path.at(2.0, &planes());
        assert!((half.eye - Vec3::new(4.0, 3.0, 16.0)).length() < 1e-5);
        assert!((half.fov_y_rad.to_degrees() - 47.5).abs() < 1e-4);
        assert_eq!(half.near_m, planes().near_m);
    }

    #[test]
    fn refusals_name_the_line_and_what_was_found() {
        for (text, expected) in [
            ("", "line 1: found nothing, expected `# crowd camera path v1`"),
            ("# crowd camera path v2\n", "line 1: found `# crowd camera path v2`"),
            ("# crowd camera path v1\n1 2 3\n", "line 2: found 3 words, expected 8"),
            ("# crowd camera path v1\n0 0 3 x 0 1 0 45\n", "line 2: found `x`, expected eye"),
            ("# crowd camera path v1\n0 0 3 inf 0 1 0 45\n", "line 2: found `inf`"),
            ("# crowd camera path v1\n0 0 3 NaN 0 1 0 45\n", "line 2: found `NaN`"),
            ("# crowd camera path v1\n0 0 3 9 0 1 0 180\n", "line 2: found `180`, expected fov_deg"),
            ("# crowd camera path v1\n0 0 3 9 0 3 9 45\n", "expected two different points"),
            (
                "# crowd camera path v1\n1 0 3 9 0 1 0 45\n1 0 3 9 0 1 0 45\n",
                "line 3: found `1`, expected a time after 1",
            ),
            ("# crowd camera path v1\nline 3 0 0 0 1 1 1 45\n", "line 2: found `line` first, expected a key"),
            ("# crowd camera path v1\norbit 3 0 0 0 1 1 45\n", "line 2: found 8 words, expected 10"),
            ("# crowd camera path v1\norbit 3 0 0 0 -1 1 0 9 45\n", "line 2: found `-1`, expected distance"),
            ("# crowd camera path v1\nwalkthrough 3 9 9 0 0 1 45\n", "expected low x z, then high x z"),
            ("# crowd camera path v1\n# nothing\n", "expected at least one line with a key"),
        ] {
            let message = CameraPath::parse(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
    }

    #[test]
    fn the_fixture_is_read() {
        let path = CameraPath::parse(include_str!("../../../fixtures/scenes/camera.txt")).expect("a fixture");
        assert!((path.end_s() - 32.0).abs() < 1e-3);
        assert!(path.keys().len() > 1090);
    }

    #[test]
    fn ways_follow_each_other() {
        let text = "# crowd camera path v1\n0 0 3 20 0 1 0 45\nline 4 0 3 12 0 1 0 45\norbit 10 0 1 0 12 10 0 90 45\n\
                    20 5 5 5 0 0 0 45\nwalkthrough 30 -9 -9 9 9 1.7 45\n";
        let path = CameraPath::parse(text).expect("good");
        assert!((path.end_s() - 50.0).abs() < 1e-3);
        assert_eq!(path.at(4.0, &planes()).eye, Vec3::new(0.0, 3.0, 12.0));
        let turned = path.at(14.0, &planes());
        assert!((turned.eye.distance(Vec3::Y) - 12.0).abs() < 1e-3 && turned.eye.x > 11.0, "{}", turned.eye);
        assert!(path.keys().windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
        let again = CameraPath::parse(&path.write()).expect("our own file");
        assert_eq!(again.keys().len(), path.keys().len());
    }

    #[test]
    fn a_recording_is_a_path() {
        let mut path = CameraPath::starting(0.0, &planes());
        for i in 1..100 {
            path.record(i as f32 / 60.0, &Camera { eye: Vec3::new(i as f32, 2.0, 0.0), ..planes() });
        }
        assert_eq!(path.keys().len(), 50);
        assert_eq!(CameraPath::parse(&path.write()).expect("our own file").at(1.0, &planes()).eye.x, 60.0);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*", words in "((line|orbit|walkthrough)( -?[0-9]{1,3}){5,10}\n|[0-9. -]{0,20}\n){0,6}") {
            let _ = CameraPath::parse(&text);
            let _ = CameraPath::parse(&format!("{HEADING}\n{words}"));
            let _ = CameraPath::parse(&format!("{HEADING}\n{text}"));
        }

        #[test]
        fn what_is_written_is_read_back(
            keys in proptest::collection::vec(proptest::array::uniform6(-1000.0_f32..1000.0), 1..8), fov in 2.0_f32..160.0,
        ) {
            let keys: Vec<CameraKey> = keys.iter().enumerate().map(|(i, k)| CameraKey {
                time_s: i as f32 * 0.3,
                eye: Vec3::new(k[0], k[1], k[2]),
                target: Vec3::new(k[3], k[4], k[5] + 2001.0),
                fov_y_rad: fov.to_radians(),
            }).collect();
            let path = CameraPath { keys };
            let again = CameraPath::parse(&path.write()).expect("our own file");
            prop_assert_eq!(again.keys.len(), path.keys.len());
            for (a, b) in again.keys.iter().zip(&path.keys) {
                prop_assert_eq!((a.time_s, a.eye, a.target), (b.time_s, b.eye, b.target));
                prop_assert!((a.fov_y_rad - b.fov_y_rad).abs() < 1e-5);
            }
        }
    }
}
