//! Damaged files: every truncation, every flipped byte, and bytes that pass the checksums but were never written by us.

use crate::independent_reader::{crc32, u64_at};
use crate::random_pack::Random;
use crate::tiny_pack;
use crowd_pack::{AnimationLayout, Error, Pack, PackContents};
use proptest::prelude::*;

fn tiny(layout: AnimationLayout) -> Vec<u8> {
    tiny_pack::contents(layout).to_bytes().unwrap()
}

/// The file is wrong, and the error says where.
fn is_named(error: &Error) -> bool {
    let named = matches!(error, Error::Format { .. } | Error::Version { .. } | Error::Checksum { .. });
    named && error.to_string().starts_with("pack: ")
}

#[test]
fn every_truncation_is_refused() {
    for layout in [AnimationLayout::Premultiplied3x4, AnimationLayout::Split4x4] {
        let file = tiny(layout);
        for length in 0..file.len() {
            let error = Pack::from_bytes(&file[..length]).expect_err("a shorter file was accepted");
            assert!(is_named(&error), "{length} bytes: {error}");
        }
    }
}

#[test]
fn every_flipped_byte_is_refused() {
    let mut file = tiny(AnimationLayout::Split4x4);
    for at in 0..file.len() {
        for mask in [1, 2, 4, 8, 16, 32, 64, 128, 255] {
            file[at] ^= mask;
            let error = Pack::from_bytes(&file).err().unwrap_or_else(|| panic!("byte {at} xor {mask} was accepted"));
            assert!(is_named(&error), "byte {at} xor {mask}: {error}");
            file[at] ^= mask;
        }
    }
    assert!(Pack::from_bytes(&file).is_ok(), "the loop put every byte back");
}

#[test]
fn damaged_impostors_and_finishes_are_refused() {
    every_damage_is_refused(tiny_pack::with_impostors().to_bytes().unwrap());
    every_damage_is_refused(tiny_pack::with_finishes().to_bytes().unwrap());
}

fn every_damage_is_refused(whole: Vec<u8>) {
    for length in 0..whole.len() {
        let error = Pack::from_bytes(&whole[..length]).expect_err("a shorter file was accepted");
        assert!(is_named(&error), "{length} bytes: {error}");
    }
    let mut file = whole;
    for at in 0..file.len() {
        for mask in [1, 16, 128, 255] {
            file[at] ^= mask;
            let error = Pack::from_bytes(&file).err().unwrap_or_else(|| panic!("byte {at} xor {mask} was accepted"));
            assert!(is_named(&error), "byte {at} xor {mask}: {error}");
            file[at] ^= mask;
        }
    }
}

#[test]
fn bytes_behind_the_end_are_refused() {
    for extra in [1, 63, 64, 65] {
        let mut file = tiny(AnimationLayout::Premultiplied3x4);
        file.resize(file.len() + extra, 0);
        assert!(is_named(&Pack::from_bytes(&file).unwrap_err()));
    }
}

#[test]
fn a_damaged_section_is_told_by_its_name() {
    let mut file = tiny(AnimationLayout::Premultiplied3x4);
    let last_byte = file.len() - 64;
    file[last_byte] ^= 1;
    let message = Pack::from_bytes(&file).unwrap_err().to_string();
    assert!(message.contains("refit_vertices") && message.contains("damaged"), "{message}");
}

/// Puts the checksums right again, as someone who means harm would.
fn reseal(file: &mut [u8]) {
    for entry in (64..64 + 720).step_by(40) {
        let (start, length) = (u64_at(file, entry + 16), u64_at(file, entry + 24));
        let Some(section) = start.checked_add(length).and_then(|end| file.get(start..end)) else { continue };
        let crc = crc32(section).to_le_bytes();
        file[entry + 36..entry + 40].copy_from_slice(&crc);
    }
    let table = crc32(&file[64..64 + 720]).to_le_bytes();
    file[32..36].copy_from_slice(&table);
    let header = crc32(&file[..60]).to_le_bytes();
    file[60..64].copy_from_slice(&header);
}

/// Touches everything by the indices a pack promises to be right.
fn walk(contents: &PackContents) -> usize {
    let mut touched = 0;
    for (index, character) in contents.characters.iter().enumerate() {
        let [first, count] = [character.vertex_offset, character.vertex_count].map(|n| n as usize);
        let lods = &contents.lods[character.lod_offset as usize..][..count + 1];
        for lod in lods {
            for triangle in &contents.triangles[character.triangle_offset as usize..][..lod.triangle_count as usize] {
                for mut v in triangle.map(|v| v as usize) {
                    while v >= lod.vertex_count as usize {
                        v = contents.collapse_map[first + v] as usize;
                    }
                    touched += usize::from(contents.vertices[first + v].position[0].is_finite());
                }
            }
        }
        for vertex in &contents.vertices[first..first + count] {
            let material = contents.materials[(character.material_offset + vertex.material()) as usize];
            touched += contents.images.get(material.image as usize).map_or(0, |image| {
                contents.image_bytes[image.byte_offset as usize..][..image.byte_count as usize].len()
            });
        }
        touched += walk_levels(contents, index);
        let names = &contents.manifest.characters[index];
        for (clip, named) in contents.clips[character.clip_offset as usize..].iter().zip(&names.clips) {
            let storage = character.storage().expect("checked");
            let frame_texels = contents.manifest.animation_layout.frame_texels(storage, character.joint_count);
            let texels = clip.frame_count * frame_texels;
            touched += contents.animation[clip.texel_offset as usize..][..texels as usize].len();
            for track in &named.tracks {
                touched += contents.track_values[track.value_offset as usize..][..track.value_count as usize].len();
                touched += names.nodes[track.node as usize].name.len();
            }
        }
    }
    touched
}

/// Looks every index of a character's tables up.
fn walk_levels(contents: &PackContents, index: usize) -> usize {
    let (character, set) = (&contents.characters[index], &contents.level_sets[index]);
    let count = set.quantized_count + set.discrete_count;
    let mut touched = 0;
    for level in &contents.levels[set.level_offset as usize..][..count as usize] {
        let vertices = if level.is_refit() {
            &contents.refit_vertices[level.refit_vertex_offset as usize..][..level.vertex_count as usize]
        } else {
            &contents.vertices[character.vertex_offset as usize..][..level.vertex_count as usize]
        };
        let range = level.index_offset as usize..(level.index_offset + 3 * level.triangle_count) as usize;
        let place = |index: usize| usize::from(vertices[index].position[0].is_finite());
        touched += match level.index_bytes {
            2 => contents.indices_16[range].iter().map(|&i| place(i as usize)).sum::<usize>(),
            _ => contents.indices_32[range].iter().map(|&i| place(i as usize)).sum::<usize>(),
        };
    }
    touched
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn well_sealed_lies_do_no_harm(seed: u64, changes in 1_usize..4, split: bool) {
        let layout = if split { AnimationLayout::Split4x4 } else { AnimationLayout::Premultiplied3x4 };
        let mut file = tiny(layout);
        let mut random = Random(seed);
        for _ in 0..changes {
            let at = 12 + random.below(file.len() as u64 - 12) as usize;
            file[at] = *[0, 1, 2, 255, 128, 251, 253, random.below(256) as u8].get(random.below(8) as usize).unwrap_or(&7);
        }
        reseal(&mut file);
        match Pack::from_bytes(&file) {
            Ok(pack) => {
                // What passes can be walked and written again as it was.
                walk(pack.contents());
                prop_assert_eq!(pack.contents().to_bytes().unwrap(), file);
            }
            Err(error) => prop_assert!(!matches!(error, Error::Io { .. }), "{}", error),
        }
    }
}

#[test]
fn the_walk_touches_something() {
    assert!(walk(&tiny_pack::contents(AnimationLayout::Premultiplied3x4)) > 100);
}
