//! Checks impostors: shapes within limits, pictures one after the other. Pictures are not decoded.

use crate::check_contents::{expect, expect_zeros};
use crate::layout::{ALIGNMENT, align_up, refuse_above};
use crate::{ImpostorRecord, PackContents, Result, limits};

/// None, or one a character, all of one shape, their pictures at multiples of 64 with zeros between.
pub(crate) fn check_impostors(contents: &PackContents) -> Result<()> {
    let (found, characters) = (contents.impostors.len(), contents.characters.len());
    let fits = found == 0 || found == characters;
    expect(fits, || "section impostors: elements", found, || format!("0, or {characters}, one a character"))?;
    let mut end = 0;
    let mut texels = 0_u64;
    for (index, (record, character)) in contents.impostors.iter().zip(&contents.characters).enumerate() {
        let place = |field: &str| format!("impostors {index}: {field}");
        check_shape(record, &contents.impostors[0], character.clip_count, &place)?;
        texels = texels.saturating_add(record.width().saturating_mul(record.height()));
        refuse_above("texels of impostors", texels, limits::IMPOSTOR_TEXELS)?;
        let pictures = [
            ("colours", record.color_byte_offset, record.color_byte_count),
            ("normals", record.normal_byte_offset, record.normal_byte_count),
        ];
        for (field, byte_offset, byte_count) in pictures {
            let start = align_up(end);
            let allowed = || start.to_string();
            expect(byte_offset == start as u64, || place(&format!("{field}: byte offset")), byte_offset, allowed)?;
            let left = contents.impostor_bytes.len().saturating_sub(start);
            let fits = (1..=left as u64).contains(&u64::from(byte_count));
            expect(fits, || place(&format!("{field}: bytes")), byte_count, || format!("1 to {left}"))?;
            expect_zeros(&contents.impostor_bytes, end..start, || place(&format!("{field}: padding before them")))?;
            end = start + byte_count as usize;
        }
    }
    let found = contents.impostor_bytes.len();
    let allowed = || format!("{end}, or {} with zeros up to a multiple of {ALIGNMENT}", align_up(end));
    expect(found == end || found == align_up(end), || "section impostor_bytes: bytes", found, allowed)?;
    expect_zeros(&contents.impostor_bytes, end..found, || "section impostor_bytes: end".to_owned())
}

fn check_shape(
    record: &ImpostorRecord,
    first: &ImpostorRecord,
    character_clips: u32,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    let tile_px = record.tile_px;
    let fits = (8..=limits::IMPOSTOR_TILE_PX).contains(&tile_px) && tile_px.is_power_of_two();
    let allowed = || format!("a power of two from 8 to {}", limits::IMPOSTOR_TILE_PX);
    expect(fits, || place("tile"), tile_px, allowed)?;
    let most = limits::IMPOSTOR_DIRECTIONS;
    let counts = [
        ("azimuths", record.azimuth_count, most),
        ("elevations", record.elevation_count, most),
        ("poses a clip", record.pose_count, most),
        ("clips", record.clip_count, character_clips),
    ];
    for (field, found, most) in counts {
        expect((1..=most).contains(&found), || place(field), found, || format!("1 to {most}"))?;
    }
    let shape = |r: &ImpostorRecord| (r.tile_px, r.azimuth_count, r.elevation_count);
    let allowed = || format!("{:?}, as the first character has", shape(first));
    expect(shape(record) == shape(first), || place("shape"), format_args!("{:?}", shape(record)), allowed)?;
    let (height, most) = (record.height(), u64::from(limits::IMAGE_SIDE_PX));
    expect(height <= most, || place("texels high"), height, || format!("at most {most}"))?;
    expect(record.reserved == 0, || place("reserved"), record.reserved, || "0".to_owned())
}
