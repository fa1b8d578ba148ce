//! Encodes and decodes sections that are one value, and checks the manifest: bincode 2, standard configuration, with a byte limit.

use crate::check_contents::{expect, expect_finite};
use crate::layout::{format_error, refuse_above};
use crate::{
    CharacterRecord, LevelRecord, LevelSetRecord, Manifest, ManifestCharacter, ManifestClip, ManifestMeasured,
    ManifestTarget, ManifestTrack, PackContents, Result, limits, obstacle,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;

fn configuration() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<{ limits::MANIFEST_BYTES }>()
}

/// The manifest's bytes.
pub(crate) fn encode_manifest(manifest: &Manifest) -> Result<Vec<u8>> {
    encode_value("manifest", manifest)
}

/// The manifest of these bytes.
pub(crate) fn decode_manifest(bytes: &[u8]) -> Result<Manifest> {
    decode_value("manifest", bytes)
}

/// The bytes of a section that is one value.
pub(crate) fn encode_value(section: &str, value: &impl Serialize) -> Result<Vec<u8>> {
    let bytes = bincode::serde::encode_to_vec(value, configuration())
        .map_err(|error| format_error(section, error, "what bincode can encode"))?;
    refuse_above(&format!("bytes of the {section}"), bytes.len() as u64, limits::MANIFEST_BYTES as u64)?;
    Ok(bytes)
}

/// The value of these bytes, which it must use up and give back unchanged (no second way to write one value).
pub(crate) fn decode_value<T: Serialize + DeserializeOwned>(section: &str, bytes: &[u8]) -> Result<T> {
    refuse_above(&format!("bytes of the {section}"), bytes.len() as u64, limits::MANIFEST_BYTES as u64)?;
    let (value, used): (T, usize) = bincode::serde::decode_from_slice(bytes, configuration())
        .map_err(|error| format_error(section, error, format!("a bincode {section} of this version")))?;
    expect(used == bytes.len(), || format!("{section}: bytes used"), used, || bytes.len().to_string())?;
    let same = encode_value(section, &value)? == bytes;
    expect(same, || format!("{section}: encoding"), "a longer one", || "the shortest".to_owned())?;
    Ok(value)
}

/// The manifest against the records; those are checked already.
pub(crate) fn check_manifest(contents: &PackContents) -> Result<()> {
    let mut names = BTreeSet::new();
    for (index, character) in contents.manifest.characters.iter().enumerate() {
        let name = character.name.as_str();
        let here = |field: &str| format!("manifest: character {index} `{}`: {field}", name.escape_debug());
        let fits = !name.is_empty() && names.insert(name);
        expect(fits, || here("name"), name.escape_debug(), || "a name no other character has".to_owned())?;
        check_character(contents, &contents.characters[index], character, &here)?;
        check_measured(contents, index, character, &here)?;
    }
    Ok(())
}

fn check_character(
    contents: &PackContents,
    record: &CharacterRecord,
    character: &ManifestCharacter,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let lengths = [
        ("joints", character.joints.len(), record.joint_count),
        ("clips", character.clips.len(), record.clip_count),
        ("materials", character.materials.len(), record.material_count),
    ];
    for (field, found, count) in lengths {
        expect(found == count as usize, || here(field), found, || format!("{count}, as the record says"))?;
    }
    let fps = character.fps;
    expect(fps.is_finite() && fps >= 0.0, || here("frames a second"), fps, || "finite, at least 0".to_owned())?;
    check_nodes(character, here)?;
    check_clips(contents, record, character, here)?;
    for (number, part) in character.parts.iter().enumerate() {
        let allowed = || format!("below {}", record.material_count);
        let fits = part.material < record.material_count;
        expect(fits, || here(&format!("part {number}: material")), part.material, allowed)?;
    }
    check_obstacles(record, character, here)?;
    check_levels(contents, record, character, here)
}

/// None, or one of those there are for each vertex of the coarsest level.
fn check_obstacles(
    record: &CharacterRecord,
    character: &ManifestCharacter,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let (found, count) = (character.obstacles.len(), record.min_vertex_count as usize);
    expect(found == 0 || found == count, || here("obstacles"), found, || format!("0, or {count}, one a vertex"))?;
    for &found in &character.obstacles {
        let fits = (obstacle::FIXED..=obstacle::ENDED).contains(&found);
        let allowed = || format!("{} to {}", obstacle::FIXED, obstacle::ENDED);
        expect(fits, || here("obstacle"), found, allowed)?;
    }
    Ok(())
}

fn check_nodes(character: &ManifestCharacter, here: &dyn Fn(&str) -> String) -> Result<()> {
    for (number, node) in character.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            let fits = (parent as usize) < number;
            expect(fits, || here(&format!("node {number}: parent")), parent, || format!("below {number}"))?;
        }
        for numbers in [node.translation.as_slice(), &node.rotation, &node.scale] {
            expect_finite(numbers, || here(&format!("node {number}: transform")))?;
        }
    }
    let nodes = character.nodes.len();
    for (number, joint) in character.joints.iter().enumerate() {
        let fits = (joint.node as usize) < nodes;
        expect(fits, || here(&format!("joint {number}: node")), joint.node, || format!("below {nodes}"))?;
        expect_finite(&joint.inverse_bind, || here(&format!("joint {number}: inverse bind matrix")))?;
    }
    Ok(())
}

fn check_clips(
    contents: &PackContents,
    record: &CharacterRecord,
    character: &ManifestCharacter,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let mut names = BTreeSet::new();
    for (number, clip) in character.clips.iter().enumerate() {
        let allowed = || "a name no other clip of the character has".to_owned();
        expect(
            names.insert(clip.name.as_str()),
            || here(&format!("clip {number}: name")),
            clip.name.escape_debug(),
            allowed,
        )?;
        for (track_number, track) in clip.tracks.iter().enumerate() {
            let place = |field: &str| here(&format!("clip {number}: track {track_number}: {field}"));
            check_track(&contents.track_values, character.nodes.len(), track, &place)?;
        }
        let duration_s = contents.clips[record.clip_offset as usize + number].duration_s;
        check_feet(character.joints.len(), duration_s, clip, &|field: &str| here(&format!("clip {number}: {field}")))?;
    }
    Ok(())
}

/// Metres that a root path may go from the even way.
const FARTHEST_M: f32 = 1e6;

/// Share of a clip that contacts may end after it: their times are sums of steps.
const TIME_SLACK: f32 = 1e-3;

/// Joints that are there, times of the clip, a path that closes.
fn check_feet(joints: usize, duration_s: f32, clip: &ManifestClip, place: &dyn Fn(&str) -> String) -> Result<()> {
    let slide = clip.slide_m_s;
    expect(slide.is_finite() && slide >= 0.0, || place("slide"), slide, || "finite, at least 0".to_owned())?;
    let slide = clip.rooted_slide_m_s;
    let fits = slide.is_finite() && slide >= 0.0;
    expect(fits, || place("slide along the path"), slide, || "finite, at least 0".to_owned())?;
    // People are put there: sums of such lengths stay numbers.
    let farthest_m = clip
        .root_path_m
        .as_flattened()
        .iter()
        .fold(0.0f32, |far, part| if part.is_nan() { f32::INFINITY } else { far.max(part.abs()) });
    let allowed = || format!("at most {FARTHEST_M} m from the even way");
    expect(farthest_m <= FARTHEST_M, || place("path"), farthest_m, allowed)?;
    let closes = clip.root_path_m.first() == clip.root_path_m.last();
    expect(closes, || place("path"), "another end than start", || "one that closes".to_owned())?;
    for (number, contact) in clip.contacts.iter().enumerate() {
        let ends = contact.end_s <= duration_s * (1.0 + TIME_SLACK);
        let fits =
            contact.start_s >= 0.0 && contact.start_s < contact.end_s && ends && (contact.joint as usize) < joints;
        let allowed = || format!("a joint below {joints} and a time that passes, to {duration_s} s at most");
        expect(fits, || place(&format!("contact {number}")), format_args!("{contact:?}"), allowed)?;
    }
    Ok(())
}

pub(crate) fn check_track(
    values: &[f32],
    nodes: usize,
    track: &ManifestTrack,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    expect((track.node as usize) < nodes, || place("node"), track.node, || format!("below {nodes}"))?;
    expect(track.property <= 2, || place("property"), track.property, || "0 to 2".to_owned())?;
    expect(track.interpolation <= 2, || place("interpolation"), track.interpolation, || "0 to 2".to_owned())?;
    expect(track.key_count >= 1, || place("keys"), track.key_count, || "at least 1".to_owned())?;
    let floats = track.floats_per_key() * u64::from(track.key_count);
    let found = track.value_count;
    expect(
        u64::from(found) == floats,
        || place("values"),
        found,
        || format!("{floats}, for {} keys", track.key_count),
    )?;
    let slice = |offset: u32, count: u32| values.get(offset as usize..offset as usize + count as usize);
    let end = || format!("within the {} floats of the section", values.len());
    let Some(times) = slice(track.time_offset, track.key_count) else {
        return Err(format_error(
            place("times"),
            format!("{} floats at {}", track.key_count, track.time_offset),
            end(),
        ));
    };
    let Some(curve) = slice(track.value_offset, track.value_count) else {
        return Err(format_error(place("values"), format!("{} floats at {}", found, track.value_offset), end()));
    };
    expect_finite(curve, || place("values"))?;
    let rising = times.iter().all(|t| t.is_finite()) && times.windows(2).all(|pair| pair[0] < pair[1]);
    expect(rising, || place("times"), "other numbers", || "finite, strictly increasing".to_owned())
}

fn check_levels(
    contents: &PackContents,
    record: &CharacterRecord,
    character: &ManifestCharacter,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let lods = &contents.lods[record.lod_offset as usize..][..record.vertex_count as usize + 1];
    let is_level = |vertex_count: u32, triangle_count: u32| {
        let lod = lods.get(vertex_count as usize);
        lod.is_some_and(|lod| lod.vertex_count == vertex_count && lod.triangle_count == triangle_count)
    };
    let mut last = 0;
    for (number, level) in character.levels.iter().enumerate() {
        let fits = is_level(level.vertex_count, level.triangle_count) && level.vertex_count > last;
        let allowed = || "rising levels of the LOD table".to_owned();
        expect(fits, || here(&format!("level {number}")), format_args!("{level:?}"), allowed)?;
        expect_finite(&[level.error_m], || here(&format!("level {number}: error")))?;
        last = level.vertex_count;
    }
    Ok(())
}

/// What the manifest says about the levels with index tables: one entry a record, the same counts, the same bound.
fn check_measured(
    contents: &PackContents,
    index: usize,
    character: &ManifestCharacter,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let set: &LevelSetRecord = &contents.level_sets[index];
    for (field, found, count) in [
        ("measured levels", character.measured.len(), set.quantized_count),
        ("discrete levels", character.discrete.len(), set.discrete_count),
    ] {
        expect(found == count as usize, || here(field), found, || format!("{count}, as the record says"))?;
    }
    let (first, quantized) = (set.level_offset as usize, set.quantized_count as usize);
    let record = &contents.characters[index];
    for (number, measured) in character.measured.iter().enumerate() {
        let place = |field: &str| here(&format!("measured level {number}{field}"));
        check_one_measured(contents, record, &contents.levels[first + number], measured, &place)?;
    }
    let mut names = BTreeSet::new();
    for (number, discrete) in character.discrete.iter().enumerate() {
        let place = |field: &str| here(&format!("discrete level {number}{field}"));
        let fits = !discrete.name.is_empty() && names.insert(discrete.name.as_str());
        let allowed = || "a name no other level of the character has".to_owned();
        expect(fits, || place(": name"), discrete.name.escape_debug(), allowed)?;
        let numbers = match discrete.target {
            ManifestTarget::Ratio(number)
            | ManifestTarget::ErrorM(number)
            | ManifestTarget::ErrorHeight(number)
            | ManifestTarget::RmsM(number)
            | ManifestTarget::RmsHeight(number) => [number, 1.0],
            ManifestTarget::Pixels(pixels, height) | ManifestTarget::RmsPixels(pixels, height) => [pixels, height],
        };
        let fits = numbers.iter().all(|number| number.is_finite() && *number > 0.0);
        expect(fits, || place(": target"), format_args!("{numbers:?}"), || "finite, above 0".to_owned())?;
        let level = &contents.levels[first + quantized + number];
        check_one_measured(contents, record, level, &discrete.measured, &place)?;
    }
    check_measured_frames(contents, record, character, here)
}

fn check_one_measured(
    contents: &PackContents,
    record: &CharacterRecord,
    level: &LevelRecord,
    measured: &ManifestMeasured,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    let clip = (measured.max_clip < record.clip_count)
        .then(|| &contents.clips[(record.clip_offset + measured.max_clip) as usize]);
    let in_clip = clip.is_some_and(|clip| measured.max_frame < clip.frame_count);
    let same = (measured.vertex_count, measured.triangle_count) == (level.vertex_count, level.triangle_count)
        && measured.bound_m.to_bits() == level.bound_m.to_bits();
    let allowed = || "counts and bound of the level's record, a clip and a frame of the character".to_owned();
    expect(in_clip && same, || place(""), format_args!("{measured:?}"), allowed)?;
    let numbers = [
        measured.rms_m,
        measured.max_m,
        measured.bound_m,
        measured.uv_drift_p95_texels,
        measured.normal_mean_deg,
        measured.bound_px,
        measured.poked_share,
    ];
    let fits = numbers.iter().all(|number| number.is_finite() && *number >= 0.0);
    expect(fits, || place(": distance"), format_args!("{numbers:?}"), || "finite, at least 0".to_owned())
}

/// Frames measured are frames of the character, rising.
fn check_measured_frames(
    contents: &PackContents,
    record: &CharacterRecord,
    character: &ManifestCharacter,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let clips = &contents.clips[record.clip_offset as usize..][..record.clip_count as usize];
    let frame_count: u64 = clips.iter().map(|clip| u64::from(clip.frame_count)).sum();
    let measuring = &character.measuring;
    for frames in [&measuring.mean_frames, &measuring.worst_frames] {
        let rising = frames.windows(2).all(|pair| pair[0] < pair[1]);
        let fits = rising && frames.last().is_none_or(|&last| u64::from(last) < frame_count);
        expect(
            fits,
            || here("frames measured"),
            format_args!("others, the last {:?}", frames.last()),
            || format!("rising, below {frame_count}"),
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;

    fn refusal(bytes: &[u8]) -> String {
        match decode_manifest(bytes) {
            Err(error @ Error::Format { .. }) => error.to_string(),
            other => panic!("{bytes:?}: {other:?}"),
        }
    }

    #[test]
    fn the_shortest_manifest_is_three_zeros() {
        assert_eq!(encode_manifest(&Manifest::default()).unwrap(), [0, 0, 0]);
        assert_eq!(decode_manifest(&[0, 0, 0]).unwrap(), Manifest::default());
    }

    #[test]
    fn lengths_beyond_the_bytes_are_errors_and_not_allocations() {
        // A generator, then characters, of 2^64 - 1, 2^40 and 200 million elements; the last is within the byte limit.
        for length in [u64::MAX, 1 << 40, 200_000_000] {
            let varint = [&[253][..], &length.to_le_bytes()].concat();
            refusal(&[&varint[..], b"x"].concat());
            refusal(&[&[0, 0][..], &varint, &[1, b'n']].concat());
        }
    }

    #[test]
    fn what_is_not_the_one_way_to_write_it_is_refused() {
        refusal(&[]);
        refusal(&[0, 0]);
        assert!(refusal(&[0, 0, 0, 0]).contains("bytes used"));
        assert!(refusal(&[251, 0, 0, 0, 0]).contains("encoding"), "a zero in three bytes");
        assert!(refusal(&[0, 2, 0]).contains("manifest"), "an unknown layout");
        assert!(refusal(&[1, 0xff, 0, 0]).contains("manifest"), "a name that is not UTF-8");
    }
}
