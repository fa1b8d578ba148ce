//! Layouts as text: one person a line, for crowds placed elsewhere.
//!
//! ```text
//! # crowd layout v1
//! # x y z  yaw_deg  scale  character  clip  phase_s
//! 0 0 0   15  1.0   0 1  0.25
//! ```

use std::fmt::Write as _;

use glam::Vec3;

use crate::text::{FARTHEST_M, lines_after};
use crate::{Error, Instance, Kind, Result};

const HEADING: &str = "# crowd layout v1";
/// People in one file: 360 MB of instances, more than any GPU of today draws.
const MOST_PEOPLE: usize = 10_000_000;

/// Reads a layout file. Characters and clips must exist in `kinds`.
///
/// # Errors
/// [`Error::Format`] with the line: another heading, a wrong number of words, a number out of range, a character or clip
/// that does not exist. [`Error::Limit`] past ten million people.
pub fn parse_layout(text: &str, kinds: &[Kind]) -> Result<Vec<Instance>> {
    let mut crowd = Vec::new();
    for line in lines_after(text, HEADING)? {
        line.must_have(8, "x y z yaw_deg scale character clip phase_s")?;
        if crowd.len() == MOST_PEOPLE {
            return Err(Error::Limit { line: line.number, allowed: MOST_PEOPLE });
        }
        let axis = |word: usize, name: &str| line.number_in(word, name, -FARTHEST_M, FARTHEST_M);
        let position = Vec3::new(axis(0, "x")?, axis(1, "y")?, axis(2, "z")?);
        let yaw_rad = line.number_in(3, "yaw_deg", -3600.0, 3600.0)?.to_radians();
        let scale = line.number_in(4, "scale", 0.001, 1000.0)?;
        let character = line.index_below(5, "character", kinds.len())?;
        let clip = line.index_below(6, "clip", kinds[character as usize].clip_durations_s.len().max(1))?;
        let phase_s = line.number_in(7, "phase_s", 0.0, 1.0e6)?;
        crowd.push(Instance { position, yaw_rad, scale, character, clip, phase_s });
    }
    Ok(crowd)
}

/// The text file of a crowd.
pub fn write_layout(instances: &[Instance]) -> String {
    let mut text = format!("{HEADING}\n# x y z  yaw_deg  scale  character  clip  phase_s\n");
    for person in instances {
        let Vec3 { x, y, z } = person.position;
        let yaw = person.yaw_rad.to_degrees();
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{x} {y} {z} {yaw} {} {} {} {}",
            person.scale, person.character, person.clip, person.phase_s
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layout, place};
    use proptest::prelude::*;

    fn kinds() -> Vec<Kind> {
        vec![
            Kind { footprint_m: 0.3, clip_durations_s: vec![1.0, 2.0] },
            Kind { footprint_m: 0.3, clip_durations_s: vec![] },
        ]
    }

    #[test]
    fn what_is_written_is_read_back() {
        let crowd = place(Layout::Street, 200, 1.3, &kinds(), &[], 9);
        let again = parse_layout(&write_layout(&crowd), &kinds()).expect("our own file");
        assert_eq!(again.len(), crowd.len());
        for (a, b) in again.iter().zip(&crowd) {
            assert!((a.yaw_rad - b.yaw_rad).abs() < 1e-5);
            assert_eq!(Instance { yaw_rad: b.yaw_rad, ..*a }, *b);
        }
    }

    #[test]
    fn refusals_name_the_line_and_what_was_found() {
        for (text, expected) in [
            ("0 0 0 0 1 0 0 0", "line 1: found `0 0 0 0 1 0 0 0`, expected `# crowd layout v1`"),
            ("# crowd layout v1\n0 0 0 0 1 0 0", "line 2: found `7 words`, expected 8"),
            ("# crowd layout v1\n\n0 0 0 0 1 2 0 0", "line 3: found `2`, expected character, a whole number below 2"),
            ("# crowd layout v1\n0 0 0 0 1 0 2 0", "line 2: found `2`, expected clip, a whole number below 2"),
            ("# crowd layout v1\n0 0 0 0 0 0 0 0", "line 2: found `0`, expected scale"),
            ("# crowd layout v1\n0 1e9 0 0 1 0 0 0", "line 2: found `1e9`, expected y"),
            ("# crowd layout v1\n0 0 0 0 1 -1 0 0", "line 2: found `-1`, expected character"),
        ] {
            let message = parse_layout(text, &kinds()).expect_err(text).to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
        assert_eq!(parse_layout("# crowd layout v1\n", &[]).expect("empty is fine"), []);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*") {
            let _ = parse_layout(&text, &kinds());
            let _ = parse_layout(&format!("{HEADING}\n{text}"), &kinds());
        }
    }
}
