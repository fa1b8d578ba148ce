//! OBJ text, checked line by line and written again so that tobj can neither trip over it nor read it askew.
//!
//! tobj's errors name no line, corners without a texture point silently take the last one seen, and colours on some of
//! the vertices shift all others. After this step every index is positive and in range, and every corner has the same
//! attributes.

use std::fmt::Write;

use crate::Result;
use crate::names::shorten;
use crate::refusal::{Asset, Warnings};

/// What tobj gets to see.
pub(super) struct Cleaned {
    pub(super) text: String,
    /// Every corner has a normal.
    pub(super) has_normals: bool,
    /// The file turns smoothing off (`s off`) and never on. Without any word on it, computed normals are smooth, as the
    /// characters of Dong 2019 §5.2 are.
    pub(super) is_faceted: bool,
}

/// UTF-8 and UTF-16 with a byte order mark; other bytes beyond ASCII (names in some old code page) are replaced.
pub(super) fn decode_text(asset: Asset<'_>, bytes: &[u8]) -> Result<String> {
    let utf16 = |read: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|c| read([c[0], c[1]])).collect();
        String::from_utf16(&units).map_err(|e| asset.format("file", format!("the text is not UTF-16: {e}")))
    };
    match bytes {
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes),
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => Ok(String::from_utf8_lossy(rest).into_owned()),
        _ => Ok(String::from_utf8_lossy(bytes).into_owned()),
    }
}

#[derive(Default)]
struct Counts {
    positions: u64,
    colored: u64,
    textures: u64,
    normals: u64,
    corners: u64,
    corners_with_texture: u64,
    corners_with_normal: u64,
    triangles: u64,
    smoothed: u64,
    faceted: u64,
}

/// Checks and rewrites the whole text.
pub(super) fn clean_obj(asset: Asset<'_>, text: &str, warnings: &mut Warnings) -> Result<Cleaned> {
    let text = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let counts = count_lines(asset, &text)?;
    let colored = counts.colored == counts.positions;
    let textured = counts.corners_with_texture > 0;
    let has_normals = counts.corners > 0 && counts.corners_with_normal == counts.corners;
    let untextured = counts.corners - counts.corners_with_texture;
    if textured {
        warnings.add("uvs-missing", "file", untextured, "face corners without a texture point got 0, 0");
    }
    if counts.corners_with_normal > 0 && !has_normals {
        let missing = counts.corners - counts.corners_with_normal;
        let message = "face corners without a normal: all normals were computed from the triangles";
        warnings.add("normals-missing", "file", missing, message);
    }

    let mut cleaned = String::with_capacity(text.len());
    // Texture point 1 stands for corners that have none.
    let blank_texture = textured && untextured > 0;
    if blank_texture {
        cleaned.push_str("vt 0 1\n");
    }
    let mut so_far = [0u64; 3];
    let mut points_and_lines = 0;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                so_far[0] += 1;
                let numbers = parse_numbers(asset, number, line, words, 3)?;
                let kept = if numbers.len() >= 6 && colored {
                    [&numbers[..3], &numbers[numbers.len() - 3..]].concat()
                } else {
                    numbers[..3].to_vec()
                };
                write_line(&mut cleaned, "v", &kept);
            }
            Some("vt") => {
                so_far[1] += 1;
                let numbers = parse_numbers(asset, number, line, words, 1)?;
                write_line(&mut cleaned, "vt", &[numbers[0], numbers.get(1).copied().unwrap_or(0.0)]);
            }
            Some("vn") => {
                so_far[2] += 1;
                write_line(&mut cleaned, "vn", &parse_numbers(asset, number, line, words, 3)?[..3]);
            }
            Some("f") => {
                cleaned.push('f');
                for word in words {
                    let corner = parse_corner(asset, number, word, &so_far, &counts)?;
                    let texture = corner[1].map(|t| t + u64::from(blank_texture)).or(blank_texture.then_some(1));
                    let _ = write!(cleaned, " {}/", corner[0].expect("parse_corner insists on a position"));
                    if let Some(texture) = texture.filter(|_| textured) {
                        let _ = write!(cleaned, "{texture}");
                    }
                    if let Some(normal) = corner[2].filter(|_| has_normals) {
                        let _ = write!(cleaned, "/{normal}");
                    }
                }
                cleaned.push('\n');
            }
            Some("p" | "l") => points_and_lines += 1,
            Some(word @ ("o" | "g" | "usemtl" | "mtllib")) => {
                let rest = line.trim().strip_prefix(word).unwrap_or("").trim();
                // A library or material without a name says nothing; tobj would refuse it.
                if !rest.is_empty() || word == "o" || word == "g" {
                    let _ = writeln!(cleaned, "{word} {rest}");
                }
            }
            _ => {}
        }
    }
    let message = "points and lines are no surface and were left out";
    warnings.add("points-and-lines-skipped", "file", points_and_lines, message);
    let is_faceted = counts.faceted > 0 && counts.smoothed == 0;
    Ok(Cleaned { text: cleaned, has_normals, is_faceted })
}

fn count_lines(asset: Asset<'_>, text: &str) -> Result<Counts> {
    let mut counts = Counts::default();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                counts.positions += 1;
                counts.colored += u64::from(words.count() >= 6);
            }
            Some("s") => match words.next() {
                Some("off" | "0") => counts.faceted += 1,
                _ => counts.smoothed += 1,
            },
            Some("vt") => counts.textures += 1,
            Some("vn") => counts.normals += 1,
            Some("f") => {
                let mut corners = 0;
                for word in words {
                    corners += 1;
                    let mut parts = word.split('/').skip(1);
                    counts.corners_with_texture += u64::from(parts.next().is_some_and(|p| !p.is_empty()));
                    counts.corners_with_normal += u64::from(parts.next().is_some_and(|p| !p.is_empty()));
                }
                if corners < 3 {
                    let problem = format!("a face of {corners} corners; a face has three or more");
                    return Err(asset.format(line_place(number), problem));
                }
                counts.corners += corners;
                counts.triangles += corners - 2;
            }
            _ => {}
        }
    }
    let limits = asset.limits;
    asset.check_limit("file", "vertices", counts.positions, limits.vertices)?;
    asset.check_limit("file", "texture points", counts.textures, limits.vertices)?;
    asset.check_limit("file", "normals", counts.normals, limits.triangles.saturating_mul(3))?;
    asset.check_limit("file", "triangles", counts.triangles, limits.triangles)?;
    Ok(counts)
}

fn line_place(number: usize) -> String {
    format!("line {}", number + 1)
}

fn parse_numbers<'t>(
    asset: Asset<'_>,
    number: usize,
    line: &str,
    words: impl Iterator<Item = &'t str>,
    needed: usize,
) -> Result<Vec<f32>> {
    let mut numbers = Vec::with_capacity(6);
    for word in words.take(7) {
        let Ok(value) = word.parse::<f32>() else { break };
        if !value.is_finite() {
            let problem = format!("`{}`: {value} is not finite", shorten(line));
            return Err(asset.format(line_place(number), problem));
        }
        numbers.push(value);
    }
    if numbers.len() < needed {
        let problem = format!("`{}`: {} numbers, expected {needed}", shorten(line), numbers.len());
        return Err(asset.format(line_place(number), problem));
    }
    Ok(numbers)
}

fn write_line(cleaned: &mut String, word: &str, numbers: &[f32]) {
    cleaned.push_str(word);
    for n in numbers {
        let _ = write!(cleaned, " {n}");
    }
    cleaned.push('\n');
}

/// Position, texture point and normal of a face corner, counted from 1. `so_far`: how many of each came before, for
/// negative numbers, which count back.
fn parse_corner(
    asset: Asset<'_>,
    number: usize,
    word: &str,
    so_far: &[u64; 3],
    counts: &Counts,
) -> Result<[Option<u64>; 3]> {
    let names = ["vertex", "texture point", "normal"];
    let totals = [counts.positions, counts.textures, counts.normals];
    let mut corner = [None; 3];
    for (slot, part) in word.split('/').enumerate() {
        if slot >= 3 {
            let problem = format!("face corner `{}`: more than three numbers", shorten(word));
            return Err(asset.format(line_place(number), problem));
        }
        if part.is_empty() && slot > 0 {
            continue;
        }
        let found: i64 = part
            .parse()
            .map_err(|_| asset.format(line_place(number), format!("face corner `{}`: not an index", shorten(word))))?;
        let index = if found < 0 { found.saturating_add(so_far[slot] as i64).saturating_add(1) } else { found };
        if index < 1 || index as u64 > totals[slot] {
            let problem =
                format!("face corner `{}`: {} {found}, the file has {}", shorten(word), names[slot], totals[slot]);
            return Err(asset.format(line_place(number), problem));
        }
        corner[slot] = Some(index as u64);
    }
    Ok(corner)
}
