//! Well-known text (OGC 06-103r4, section 7) of areas.

use glam::DVec2;

use super::{Polygon, WalkableArea, signed_area};
use crate::{Error, Result};

/// Points of one area: a city's quarter, drawn finely.
const MOST_POINTS: usize = 20_000;
/// Collections in collections.
const DEEPEST: usize = 8;
const FARTHEST_M: f64 = 1.0e9;

pub(super) fn parse(text: &str) -> Result<WalkableArea> {
    // PostGIS puts the coordinate system in front.
    let body = text.trim_start();
    let skipped = if body.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("SRID=")) {
        body.find(';').map_or(0, |semicolon| semicolon + 1)
    } else {
        0
    };
    let start = text.len() - body.len() + skipped;
    let mut reader = Reader { text, at: start, points: 0, polygons: Vec::new() };
    reader.geometry(0)?;
    let rest = reader.peek();
    if !rest.is_empty() {
        return Err(reader.refuse("the end of the text"));
    }
    if reader.polygons.is_empty() {
        return Err(Error::content("walkable area", "an empty geometry", "at least one polygon"));
    }
    Ok(WalkableArea { polygons: reader.polygons })
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    points: usize,
    polygons: Vec<Polygon>,
}

impl<'a> Reader<'a> {
    /// What follows, blanks passed over: a word, a number, or one sign; empty at the end.
    fn peek(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let trimmed = rest.trim_start();
        self.at += rest.len() - trimmed.len();
        let length = trimmed.find(|c: char| c.is_whitespace() || "(),".contains(c)).unwrap_or(trimmed.len());
        if length > 0 { &trimmed[..length] } else { trimmed.chars().next().map_or("", |c| &trimmed[..c.len_utf8()]) }
    }

    fn take(&mut self) -> &'a str {
        let word = self.peek();
        self.at += word.len();
        word
    }

    fn refuse(&mut self, expected: &str) -> Error {
        let found: String = self.peek().chars().take(40).collect();
        let found = if found.is_empty() { "its end".to_owned() } else { format!("`{}`", found.escape_debug()) };
        Error::content(format!("walkable area, character {}", self.at + 1), found, expected)
    }

    fn expect(&mut self, sign: &str) -> Result<()> {
        if self.peek() != sign {
            return Err(self.refuse(&format!("`{sign}`")));
        }
        self.take();
        Ok(())
    }

    fn geometry(&mut self, depth: usize) -> Result<()> {
        let kind = self.peek().to_ascii_uppercase();
        let reads: fn(&mut Self, usize) -> Result<()> = match kind.trim_end_matches(['Z', 'M']) {
            "POLYGON" => Self::polygon,
            "MULTIPOLYGON" => |reader, depth| reader.list(depth, Self::polygon),
            "GEOMETRYCOLLECTION" if depth < DEEPEST => |reader, depth| reader.list(depth, Self::geometry),
            _ => return Err(self.refuse("POLYGON, MULTIPOLYGON or a GEOMETRYCOLLECTION of those")),
        };
        self.take();
        if ["Z", "M", "ZM"].iter().any(|word| self.peek().eq_ignore_ascii_case(word)) {
            self.take();
        }
        if self.peek().eq_ignore_ascii_case("EMPTY") {
            self.take();
            return Ok(());
        }
        reads(self, depth + 1)
    }

    /// `( item, item )`
    fn list(&mut self, depth: usize, mut item: impl FnMut(&mut Self, usize) -> Result<()>) -> Result<()> {
        self.expect("(")?;
        loop {
            item(self, depth)?;
            match self.take() {
                "," => {}
                ")" => return Ok(()),
                word => {
                    self.at -= word.len();
                    return Err(self.refuse("`,` or `)`"));
                }
            }
        }
    }

    fn polygon(&mut self, depth: usize) -> Result<()> {
        let mut rings: Vec<Vec<DVec2>> = Vec::new();
        self.list(depth, |reader, depth| {
            let mut ring = Vec::new();
            reader.list(depth, |reader, _| {
                let point = reader.point()?;
                if ring.last() != Some(&point) {
                    ring.push(point);
                }
                Ok(())
            })?;
            if ring.len() > 1 && ring.first() == ring.last() {
                ring.pop();
            }
            if ring.len() < 3 {
                let found = format!("a ring of {} different points", ring.len());
                return Err(Error::content(format!("walkable area, character {}", reader.at), found, "at least 3"));
            }
            // The walkable side is on the left: holes the other way round.
            if (signed_area(&ring) > 0.0) != rings.is_empty() {
                ring.reverse();
            }
            rings.push(ring);
            Ok(())
        })?;
        self.polygons.push(Polygon { rings });
        Ok(())
    }

    /// x and y; further numbers (height, measure) are passed over.
    fn point(&mut self) -> Result<DVec2> {
        self.points += 1;
        if self.points > MOST_POINTS {
            return Err(self.refuse(&format!("at most {MOST_POINTS} points")));
        }
        let point = DVec2::new(self.number()?, self.number()?);
        for _ in 0..2 {
            if !matches!(self.peek(), "," | ")" | "") {
                self.number()?;
            }
        }
        Ok(point)
    }

    fn number(&mut self) -> Result<f64> {
        match self.peek().parse::<f64>() {
            Ok(value) if value.abs() <= FARTHEST_M => {
                self.take();
                Ok(value)
            }
            _ => Err(self.refuse("a number from -1e9 to 1e9")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn polygons_with_holes_are_read_whichever_way_round() {
        let area = parse("POLYGON ((0 0, 0 4, 4 4, 4 0, 0 0), (1 1, 2 1, 2 2, 1 2, 1 1))").expect("good");
        assert_eq!(area.polygon_count(), 1);
        assert_eq!(area.square_metres(), 15.0);
        assert_eq!(area.polygons[0].rings[0].len(), 4);
        let both = "GEOMETRYCOLLECTION (POLYGON ((0 0, 1 0, 1 1)), MULTIPOLYGON Z (((5 5 9, 6 5 9, 6 6 9)), ((7 7 1, 8 7 1, 8 8 1))))";
        assert_eq!(parse(both).expect("good").polygon_count(), 3);
        assert_eq!(parse("SRID=25832;polygon((0 0,1 0,1 1,0 0))").expect("good").square_metres(), 0.5);
    }

    #[test]
    fn refusals_name_the_place() {
        for (text, expected) in [
            ("", "character 1: found its end, expected POLYGON"),
            ("POINT (1 2)", "character 1: found `POINT`"),
            ("POLYGON ((0 0, 1 x, 1 1))", "character 18: found `x`, expected a number"),
            ("POLYGON ((0 0, 1 nan, 1 1))", "found `nan`"),
            ("POLYGON ((0 0, 1 1e10, 1 1))", "found `1e10`"),
            ("POLYGON ((0 0, 1 1, 0 0))", "found a ring of 2 different points"),
            ("POLYGON ((0 0, 1 0, 1 1)", "found its end, expected `,` or `)`"),
            ("POLYGON ((0 0, 1 0, 1 1)) x", "found `x`, expected the end"),
            ("POLYGON EMPTY", "found an empty geometry"),
        ] {
            let message = parse(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
        let deep = "GEOMETRYCOLLECTION(".repeat(100_000);
        assert!(parse(&deep).is_err(), "no stack is long enough");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*", words in "[POLYGNMUTIEZ(), 0-9.e-]{0,200}") {
            let _ = parse(&text);
            let _ = parse(&words);
            let _ = parse(&format!("POLYGON (({words}"));
        }
    }
}
