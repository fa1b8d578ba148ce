//! Layouts as text: one person a line, for crowds placed elsewhere, or a named layout a line.
//!
//! ```text
//! # crowd layout v1
//! # x y z  yaw_deg  scale  character  clip  phase_s
//! 0 0 0   15  1.0   0 1  0.25          # by number,
//! 1 0 0   15  1.0   mara walk  0.25    # or by name
//! #     layout  count  x z   yaw_deg  spacing_m  seed
//! place seats   500    0 -40  0       0.8        7
//! ```

use std::fmt::Write as _;

use glam::Vec3;

use crate::text::{FARTHEST_M, Line, lines_after, wrong};
use crate::{Error, Instance, Kind, Layout, Leaving, Result, place};

const HEADING: &str = "# crowd layout v1";
/// People in one file: 360 MB of instances, more than any GPU of today draws.
const MOST_PEOPLE: usize = 10_000_000;

/// Reads a layout file. Characters and clips must exist in `kinds`; `clips[k]` are those that kind `k` may play where a
/// named layout deals them out, as for [`place`].
///
/// # Errors
/// [`Error::Format`] with the line: another heading, a wrong number of words, a number out of range, a character, clip or
/// layout that does not exist. [`Error::Limit`] past ten million people.
pub fn parse_layout(text: &str, kinds: &[Kind], clips: &[Vec<u32>]) -> Result<Vec<Instance>> {
    let mut crowd = Vec::new();
    let names: Vec<String> = kinds.iter().map(|kind| kind.name.clone()).filter(|name| !name.is_empty()).collect();
    let names = if names.len() == kinds.len() { names } else { Vec::new() };
    for line in lines_after(text, HEADING)? {
        if line.is_word(0, "place") {
            place_group(&line, kinds, clips, &mut crowd)?;
            continue;
        }
        line.must_have(8, "x y z yaw_deg scale character clip phase_s")?;
        if crowd.len() == MOST_PEOPLE {
            return Err(Error::Limit { line: line.number, allowed: MOST_PEOPLE });
        }
        let axis = |word: usize, name: &str| line.number_in(word, name, -FARTHEST_M, FARTHEST_M);
        let position = Vec3::new(axis(0, "x")?, axis(1, "y")?, axis(2, "z")?);
        let yaw_rad = line.number_in(3, "yaw_deg", -3600.0, 3600.0)?.to_radians();
        let scale = line.number_in(4, "scale", 0.001, 1000.0)?;
        let character = line.index_or_name(5, "character", &names, kinds.len())?;
        let kind = &kinds[character as usize];
        let clip = line.index_or_name(6, "clip", &kind.clip_names, kind.clip_durations_s.len().max(1))?;
        let phase_s = line.number_in(7, "phase_s", 0.0, 1.0e6)?;
        crowd.push(Instance { position, yaw_rad, scale, character, clip, phase_s, leaving: Leaving::default() });
    }
    Ok(crowd)
}

/// A named layout, turned and moved.
fn place_group(line: &Line<'_>, kinds: &[Kind], clips: &[Vec<u32>], crowd: &mut Vec<Instance>) -> Result<()> {
    line.must_have(8, "place, layout, count, x z, yaw_deg, spacing_m, seed")?;
    let layout = Layout::named(line.word(1)).ok_or_else(|| wrong(line.number, line.word(1), &Layout::names()))?;
    let room = MOST_PEOPLE - crowd.len();
    let count = line.index_below(2, "count", MOST_PEOPLE + 1)?;
    if count as usize > room {
        return Err(Error::Limit { line: line.number, allowed: MOST_PEOPLE });
    }
    let axis = |word: usize, name: &str| line.number_in(word, name, -FARTHEST_M, FARTHEST_M);
    let middle = Vec3::new(axis(3, "x")?, 0.0, axis(4, "z")?);
    let yaw_rad = line.number_in(5, "yaw_deg", -3600.0, 3600.0)?.to_radians();
    let spacing_m = line.number_in(6, "spacing_m", 0.01, 10_000.0)?;
    let seed = line.index_below(7, "seed", u32::MAX as usize)?;
    let (sin, cos) = libm::sincosf(yaw_rad);
    crowd.extend(place(layout, count, spacing_m, kinds, clips, seed).into_iter().map(|one| {
        let Vec3 { x, y, z } = one.position;
        let position = middle + Vec3::new(x * cos + z * sin, y, z * cos - x * sin);
        Instance { position, yaw_rad: one.yaw_rad + yaw_rad, ..one }
    }));
    Ok(())
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
            Kind {
                name: "mara".into(),
                clip_names: vec!["idle".into(), "walk".into()],
                footprint_m: 0.3,
                clip_durations_s: vec![1.0, 2.0],
            },
            Kind { name: "pip".into(), footprint_m: 0.3, ..Kind::default() },
        ]
    }

    #[test]
    fn what_is_written_is_read_back() {
        let crowd = place(Layout::Street, 200, 1.3, &kinds(), &[], 9);
        let again = parse_layout(&write_layout(&crowd), &kinds(), &[]).expect("our own file");
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
            ("# crowd layout v1\n0 0 0 0 1 0 0", "line 2: found 7 words, expected 8"),
            ("# crowd layout v1\nx", "line 2: found 1 word, expected 8"),
            ("# crowd layout v1\n0 0 0 0 1 \"mara 0 0", "line 2: found a quote that is not closed, expected 8"),
            ("", "line 1: found nothing, expected `# crowd layout v1`"),
            ("# crowd layout v1\n\n0 0 0 0 1 2 0 0", "line 3: found `2`, expected character, a whole number below 2"),
            ("# crowd layout v1\n0 0 0 0 1 0 2 0", "line 2: found `2`, expected clip, a whole number below 2"),
            ("# crowd layout v1\n0 0 0 0 0 0 0 0", "line 2: found `0`, expected scale"),
            ("# crowd layout v1\n0 1e9 0 0 1 0 0 0", "line 2: found `1e9`, expected y"),
            ("# crowd layout v1\n0 0 0 0 1 -1 0 0", "line 2: found `-1`, expected character"),
            (
                "# crowd layout v1\n0 0 0 0 1 bob 0 0",
                "line 2: found `bob`, expected character, a whole number below 2, or one of mara, pip",
            ),
            (
                "# crowd layout v1\n0 0 0 0 1 mara fly 0",
                "line 2: found `fly`, expected clip, a whole number below 2, or one of idle, walk",
            ),
            ("# crowd layout v1\n0 NaN 0 0 1 0 0 0", "line 2: found `NaN`, expected y"),
            (
                "# crowd layout v1\nplace circle 9 0 0 0 1 1",
                "line 2: found `circle`, expected grid, disc, ranks, street or seats",
            ),
            ("# crowd layout v1\nplace grid 10000001 0 0 0 1 1", "line 2: found `10000001`, expected count"),
            ("# crowd layout v1\nplace grid 9 0 0 0 0 1", "line 2: found `0`, expected spacing_m"),
        ] {
            let message = parse_layout(text, &kinds(), &[]).expect_err(text).to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
        assert_eq!(parse_layout("# crowd layout v1\n", &[], &[]).expect("empty is fine"), []);
    }

    #[test]
    fn the_fixture_is_read() {
        let text = include_str!("../../../fixtures/scenes/layout.txt");
        let named = |name: &str| Kind {
            name: name.into(),
            clip_names: vec!["idle".into(), "walk".into(), "clip 0".into()],
            clip_durations_s: vec![2.0, 1.0, 3.0],
            ..Kind::default()
        };
        let blank = "# crowd layout v1\n0 0 0 0 1 \"Old Mara\" \"Clip 0\" 0.5\n";
        assert_eq!(parse_layout(blank, &[named("mara"), named("Old Mara")], &[]).expect("in quotes")[0].clip, 2);
        assert_eq!(parse_layout(text, &[named("mara"), named("oskar")], &[]).expect("a fixture").len(), 66);
        let message = parse_layout(text, &[named("mara")], &[]).expect_err("no oskar").to_string();
        assert!(message.contains("line 4: found `oskar`, expected character"), "{message}");
    }

    #[test]
    fn people_stand_by_name_and_in_groups() {
        let text = "# crowd layout v1\n1 0 2 90 1 Mara walk 0.5\nplace ranks 4 10 0 90 2 1\nplace disc 0 0 0 0 1 1\n";
        let crowd = parse_layout(text, &kinds(), &[]).expect("good");
        assert_eq!(crowd.len(), 5);
        assert_eq!((crowd[0].character, crowd[0].clip), (0, 1));
        // Two ranks of two, the front one to +X, facing there.
        let expected = [[11.0, 1.0], [11.0, -1.0], [9.0, 1.0], [9.0, -1.0]];
        for (person, [x, z]) in crowd[1..].iter().zip(expected) {
            assert!(person.position.distance(Vec3::new(x, 0.0, z)) < 1e-5, "{}", person.position);
            assert!((person.yaw_rad.to_degrees() - 90.0).abs() < 1e-3);
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*") {
            let _ = parse_layout(&text, &kinds(), &[]);
            let _ = parse_layout(&format!("{HEADING}\n{text}"), &kinds(), &[]);
        }
    }
}
