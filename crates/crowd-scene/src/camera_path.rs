//! Camera paths: keys in time, and their text file.
//!
//! ```text
//! # crowd camera path v1
//! # time_s  eye x y z  target x y z  fov_deg (vertical)
//! 0   0 3 20   0 1 0   45
//! 5   8 3 12   0 1 0   45
//! ```

use std::fmt::Write as _;

use glam::Vec3;

use crate::text::{FARTHEST_M, lines_after, wrong};
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
            line.must_have(8, "time_s, eye x y z, target x y z, fov_deg")?;
            if keys.len() == MOST_KEYS {
                return Err(Error::Limit { line: line.number, allowed: MOST_KEYS });
            }
            let place = |word: usize, name: &str| -> Result<Vec3> {
                let axis = |offset: usize| line.number_in(word + offset, name, -FARTHEST_M, FARTHEST_M);
                Ok(Vec3::new(axis(0)?, axis(1)?, axis(2)?))
            };
            let key = CameraKey {
                time_s: line.number_in(0, "time_s", 0.0, 1.0e6)?,
                eye: place(1, "eye")?,
                target: place(4, "target")?,
                fov_y_rad: line.number_in(7, "fov_deg", 1.0, 170.0)?.to_radians(),
            };
            if let Some(before) = keys.last()
                && key.time_s <= before.time_s
            {
                return Err(wrong(line.number, &key.time_s.to_string(), &format!("a time after {}", before.time_s)));
            }
            if key.eye == key.target {
                return Err(wrong(line.number, &format!("eye and target at {}", key.eye), "two different points"));
            }
            keys.push(key);
        }
        if keys.is_empty() {
            return Err(wrong(text.lines().count().max(1), "no key", "at least one line with a key"));
        }
        Ok(Self { keys })
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
            ("", "line 1: found ``, expected `# crowd camera path v1`"),
            ("# crowd camera path v2\n", "line 1: found `# crowd camera path v2`"),
            ("# crowd camera path v1\n1 2 3\n", "line 2: found `3 words`, expected 8"),
            ("# crowd camera path v1\n0 0 3 x 0 1 0 45\n", "line 2: found `x`, expected eye"),
            ("# crowd camera path v1\n0 0 3 inf 0 1 0 45\n", "line 2: found `inf`"),
            ("# crowd camera path v1\n0 0 3 NaN 0 1 0 45\n", "line 2: found `NaN`"),
            ("# crowd camera path v1\n0 0 3 9 0 1 0 180\n", "line 2: found `180`, expected fov_deg"),
            ("# crowd camera path v1\n0 0 3 9 0 3 9 45\n", "expected two different points"),
            (
                "# crowd camera path v1\n1 0 3 9 0 1 0 45\n1 0 3 9 0 1 0 45\n",
                "line 3: found `1`, expected a time after 1",
            ),
            ("# crowd camera path v1\n# nothing\n", "expected at least one line with a key"),
        ] {
            let message = CameraPath::parse(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*") {
            let _ = CameraPath::parse(&text);
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
