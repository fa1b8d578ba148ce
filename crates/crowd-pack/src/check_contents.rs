//! Checks records against each other, so that whoever holds a [`crate::Pack`] may index without looking.
//!
//! What needs a whole level to be rebuilt (degenerate triangles, measured errors) is left to `crowdbake verify`.

use crate::check_impostors::check_impostors;
use crate::check_levels::{CoveredLevels, check_level_set};
use crate::check_manifest::check_manifest;
use crate::finishes::check_finishes;
use crate::layout::{ALIGNMENT, align_up, format_error, refuse_above};
use crate::store_joint::find_fault;
use crate::{
    AnimationLayout, CharacterRecord, ImageRecord, JointStorage, LodRecord, NONE, PackContents, Result, VertexRecord,
    limits, material_flags, vertex_class,
};
use std::fmt::Display;
use std::ops::Range;

/// Everything a reader relies on.
pub(crate) fn check_contents(contents: &PackContents) -> Result<()> {
    check_counts(contents)?;
    check_image_records("image", "image_bytes", &contents.images, &contents.image_bytes)?;
    let mut covered = Covered::default();
    for index in 0..contents.characters.len() {
        check_character(contents, index, &mut covered)?;
    }
    covered.expect_all(contents)?;
    check_impostors(contents)?;
    check_manifest(contents)?;
    check_finishes(contents)
}

/// Elements of each section that the characters so far account for.
#[derive(Default)]
struct Covered {
    vertices: usize,
    triangles: usize,
    lods: usize,
    clips: usize,
    materials: usize,
    texels: usize,
    inverse_bind_texels: usize,
    tables: CoveredLevels,
}

impl Covered {
    fn expect_all(&self, contents: &PackContents) -> Result<()> {
        let pairs = [
            ("vertices", contents.vertices.len(), self.vertices),
            ("triangles", contents.triangles.len(), self.triangles),
            ("lods", contents.lods.len(), self.lods),
            ("clips", contents.clips.len(), self.clips),
            ("materials", contents.materials.len(), self.materials),
            ("animation", contents.animation.len(), self.texels),
            ("inverse_binds", contents.inverse_binds.len(), self.inverse_bind_texels),
        ];
        for (name, found, used) in pairs.into_iter().chain(self.tables.pairs(contents)) {
            expect(
                found == used,
                || format!("section {name}: elements"),
                found,
                || format!("{used}, as the characters use"),
            )?;
        }
        Ok(())
    }
}

fn check_counts(contents: &PackContents) -> Result<()> {
    refuse_above("characters", contents.characters.len() as u64, limits::CHARACTERS)?;
    refuse_above("images", contents.images.len() as u64, limits::IMAGES)?;
    refuse_above("finish images", contents.finish_images.len() as u64, limits::IMAGES)?;
    for (name, count) in [
        ("vertices", contents.vertices.len()),
        ("triangles", contents.triangles.len()),
        ("lods", contents.lods.len()),
        ("clips", contents.clips.len()),
        ("animation texels", contents.animation.len()),
        ("track values", contents.track_values.len()),
        ("levels", contents.levels.len()),
        ("16-bit indices", contents.indices_16.len()),
        ("32-bit indices", contents.indices_32.len()),
        ("refitted vertices", contents.refit_vertices.len()),
    ] {
        refuse_above(name, count as u64, u64::from(u32::MAX))?;
    }
    let (found, vertices) = (contents.collapse_map.len(), contents.vertices.len());
    expect(found == vertices, || "section collapse_map: elements", found, || format!("{vertices}, one a vertex"))?;
    let characters = contents.characters.len();
    let found = contents.level_sets.len();
    expect(found == characters, || "section level_sets: elements", found, || format!("{characters}, one a character"))?;
    let found = contents.manifest.characters.len();
    expect(found == characters, || "manifest: characters", found, || format!("{characters}, one a record"))
}

/// Images lie one after the other at multiples of 64, with zeros between, and nothing behind the last but such zeros.
pub(crate) fn check_image_records(name: &str, section: &str, images: &[ImageRecord], bytes: &[u8]) -> Result<()> {
    let mut end = 0;
    for (index, image) in images.iter().enumerate() {
        let place = |field: &str| format!("{name} {index}: {field}");
        let start = align_up(end);
        expect(image.byte_offset == start as u64, || place("byte offset"), image.byte_offset, || start.to_string())?;
        let left = bytes.len().saturating_sub(start);
        let fits = image.byte_count >= 1 && image.byte_count <= left as u64;
        expect(fits, || place("bytes"), image.byte_count, || format!("1 to {left}"))?;
        expect_zeros(bytes, end..start, || place("padding before it"))?;
        end = start + image.byte_count as usize;
        for (field, pixels) in [("width", image.width), ("height", image.height)] {
            let allowed = 1..=limits::IMAGE_SIDE_PX;
            expect(allowed.contains(&pixels), || place(field), pixels, || format!("1 to {}", limits::IMAGE_SIDE_PX))?;
        }
        expect(image.encoding <= 2, || place("encoding"), image.encoding, || "0 to 2".to_owned())?;
        expect(image.reserved == 0, || place("reserved"), image.reserved, || "0".to_owned())?;
    }
    let allowed = || format!("{end}, or {} with zeros up to a multiple of {ALIGNMENT}", align_up(end));
    let fits = bytes.len() == end || bytes.len() == align_up(end);
    expect(fits, || format!("section {section}: bytes"), bytes.len(), allowed)?;
    expect_zeros(bytes, end..bytes.len(), || format!("section {section}: end"))
}

fn check_character(contents: &PackContents, index: usize, covered: &mut Covered) -> Result<()> {
    let character = &contents.characters[index];
    let place = |field: &str| format!("character {index}: {field}");
    check_character_numbers(character, &place)?;
    let vertices = take(
        &mut covered.vertices,
        character.vertex_offset,
        character.vertex_count.into(),
        contents.vertices.len(),
        &|| place("vertices"),
    )?;
    let triangles = take(
        &mut covered.triangles,
        character.triangle_offset,
        character.triangle_count.into(),
        contents.triangles.len(),
        &|| place("triangles"),
    )?;
    let lods = take(
        &mut covered.lods,
        character.lod_offset,
        u64::from(character.vertex_count) + 1,
        contents.lods.len(),
        &|| place("LOD table"),
    )?;
    let clips =
        take(&mut covered.clips, character.clip_offset, character.clip_count.into(), contents.clips.len(), &|| {
            place("clips")
        })?;
    let materials = take(
        &mut covered.materials,
        character.material_offset,
        character.material_count.into(),
        contents.materials.len(),
        &|| place("materials"),
    )?;
    check_vertices(contents, character, vertices.clone(), &place)?;
    for (number, triangle) in contents.triangles[triangles].iter().enumerate() {
        let fits = triangle.iter().all(|&corner| corner < character.vertex_count);
        let allowed = || format!("indices below {}", character.vertex_count);
        expect(fits, || place(&format!("triangle {number}")), format_args!("{triangle:?}"), allowed)?;
    }
    for (vertex, &target) in contents.collapse_map[vertices].iter().enumerate() {
        let stays = target as usize == vertex && vertex < character.min_vertex_count as usize;
        let allowed = || format!("below {vertex}, or {vertex} itself below {}", character.min_vertex_count);
        expect(
            (target as usize) < vertex || stays,
            || place(&format!("collapse map of vertex {vertex}")),
            target,
            allowed,
        )?;
    }
    check_lods(character, &contents.lods[lods.clone()], &place)?;
    check_level_set(contents, index, &contents.lods[lods], &mut covered.tables)?;
    check_clips(contents, character, clips, covered, &place)?;
    check_inverse_binds(contents, character, covered, &place)?;
    check_materials(contents, materials, &place)
}

fn check_character_numbers(character: &CharacterRecord, place: &dyn Fn(&str) -> String) -> Result<()> {
    let counts = [
        ("vertex count", character.vertex_count, limits::VERTICES_PER_CHARACTER),
        ("triangle count", character.triangle_count, limits::TRIANGLES_PER_CHARACTER),
        ("joint count", character.joint_count, limits::JOINTS_PER_CHARACTER),
        ("clip count", character.clip_count, limits::CLIPS_PER_CHARACTER),
        ("material count", character.material_count, limits::MATERIALS_PER_CHARACTER),
    ];
    for (field, count, limit) in counts {
        expect(count >= 1, || place(field), count, || "at least 1".to_owned())?;
        refuse_above(&place(field), count.into(), limit)?;
    }
    let (found, full) = (character.min_vertex_count, character.vertex_count);
    expect((1..=full).contains(&found), || place("coarsest vertex count"), found, || format!("1 to {full}"))?;
    let (found, full) = (character.min_triangle_count, character.triangle_count);
    expect(found <= full, || place("coarsest triangle count"), found, || format!("at most {full}"))?;
    expect_sphere(character.sphere, || place("sphere"))?;
    expect_finite(&character.box_min, || place("box"))?;
    expect_finite(&character.box_max, || place("box"))?;
    let ordered = (0..3).all(|axis| character.box_min[axis] <= character.box_max[axis]);
    let found = format!("{:?} to {:?}", character.box_min, character.box_max);
    expect(ordered, || place("box"), found, || "least corner first".to_owned())?;
    let height = character.height_m;
    expect(height.is_finite() && height >= 0.0, || place("height"), height, || "finite, at least 0".to_owned())
}

fn check_vertices(
    contents: &PackContents,
    character: &CharacterRecord,
    vertices: Range<usize>,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    for (number, vertex) in contents.vertices[vertices].iter().enumerate() {
        check_vertex(vertex, character, &|field: &str| place(&format!("vertex {number}: {field}")))?;
    }
    Ok(())
}

/// Numbers finite, material, class and joints there, weights whole.
pub(crate) fn check_vertex(
    vertex: &VertexRecord,
    character: &CharacterRecord,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    expect_finite(&vertex.position, || here("position"))?;
    expect_finite(&vertex.uv, || here("texture coordinates"))?;
    let materials = character.material_count;
    expect(vertex.material() < materials, || here("material"), vertex.material(), || format!("below {materials}"))?;
    let fits = vertex.class() <= vertex_class::FIXED;
    expect(fits, || here("class"), vertex.class(), || format!("at most {}", vertex_class::FIXED))?;
    let joints = vertex.joint_indices();
    let fits = joints.iter().all(|&joint| u32::from(joint) < character.joint_count);
    let allowed = || format!("below {}", character.joint_count);
    expect(fits, || here("joints"), format_args!("{joints:?}"), allowed)?;
    let sum: u32 = vertex.weights_unorm16().iter().map(|&weight| u32::from(weight)).sum();
    expect(sum == 65_535, || here("sum of weights"), sum, || "65535".to_owned())
}

/// One entry for each k: at most max(k, coarsest) vertices, counts never falling, the last entry full detail.
fn check_lods(character: &CharacterRecord, lods: &[LodRecord], place: &dyn Fn(&str) -> String) -> Result<()> {
    let coarsest = LodRecord { vertex_count: character.min_vertex_count, triangle_count: character.min_triangle_count };
    let full = LodRecord { vertex_count: character.vertex_count, triangle_count: character.triangle_count };
    let mut last = coarsest;
    for (k, &lod) in lods.iter().enumerate() {
        let most = coarsest.vertex_count.max(k as u32);
        let monotone = lod.vertex_count >= last.vertex_count && lod.triangle_count >= last.triangle_count;
        let same_level = lod.vertex_count != last.vertex_count || lod.triangle_count == last.triangle_count;
        let allowed = || format!("at least {last:?}, at most {most} vertices, one triangle count a vertex count");
        let fits = monotone && same_level && lod.vertex_count <= most;
        expect(fits, || place(&format!("LOD table entry {k}")), format_args!("{lod:?}"), allowed)?;
        last = lod;
    }
    expect(last == full, || place("last LOD table entry"), format_args!("{last:?}"), || format!("{full:?}"))
}

fn check_clips(
    contents: &PackContents,
    character: &CharacterRecord,
    clips: Range<usize>,
    covered: &mut Covered,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    let storage = check_storage(contents, character, place)?;
    let frame_texels = contents.manifest.animation_layout.frame_texels(storage, character.joint_count);
    for (number, clip) in contents.clips[clips].iter().enumerate() {
        let here = |field: &str| place(&format!("clip {number}: {field}"));
        expect(clip.frame_count >= 1, || here("frames"), clip.frame_count, || "at least 1".to_owned())?;
        let texel_count = u64::from(frame_texels) * u64::from(clip.frame_count);
        let texels =
            take(&mut covered.texels, clip.texel_offset, texel_count, contents.animation.len(), &|| here("texels"))?;
        for (frame, texels) in contents.animation[texels].chunks_exact(frame_texels.max(1) as usize).enumerate() {
            if let Some((texel, allowed)) = find_fault(storage, texels, character.joint_count) {
                let at = frame * frame_texels as usize + texel;
                return Err(format_error(here(&format!("texel {at}")), format!("{:x?}", texels[texel]), allowed));
            }
        }
        let numbers =
            [("duration", clip.duration_s), ("ground speed", clip.ground_speed_m_s), ("loop gap", clip.loop_gap_m)];
        for (field, number) in numbers {
            let fits = number.is_finite() && number >= 0.0;
            expect(fits, || here(field), number, || "finite, at least 0".to_owned())?;
        }
        expect_finite(&clip.root_displacement_m, || here("root displacement"))?;
        expect_sphere(clip.sphere, || here("sphere"))?;
    }
    Ok(())
}

/// A known storage, full floats in the split layout, an error that is a number.
fn check_storage(
    contents: &PackContents,
    character: &CharacterRecord,
    place: &dyn Fn(&str) -> String,
) -> Result<JointStorage> {
    let code = character.joint_storage;
    let premultiplied = contents.manifest.animation_layout == AnimationLayout::Premultiplied3x4;
    let storage = character.storage().filter(|&storage| premultiplied || storage == JointStorage::F32);
    let error_m = character.storage_error_m;
    let fits = error_m.is_finite() && error_m >= 0.0;
    expect(fits, || place("storage error"), error_m, || "finite, at least 0".to_owned())?;
    let zeros = character.reserved == [0; 2];
    expect(zeros, || place("reserved"), format_args!("{:?}", character.reserved), || "zeros".to_owned())?;
    let allowed = if premultiplied { "0 to 2" } else { "0 in the split layout" };
    storage.ok_or_else(|| format_error(place("joint storage"), code, allowed))
}

fn check_inverse_binds(
    contents: &PackContents,
    character: &CharacterRecord,
    covered: &mut Covered,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    let here = || place("inverse bind matrices");
    let offset = character.inverse_bind_offset;
    match contents.manifest.animation_layout {
        AnimationLayout::Premultiplied3x4 => {
            expect(offset == 0, here, offset, || "0 where the animation is premultiplied".to_owned())
        }
        AnimationLayout::Split4x4 => {
            let count = u64::from(character.joint_count) * 4;
            let texels = take(&mut covered.inverse_bind_texels, offset, count, contents.inverse_binds.len(), &here)?;
            contents.inverse_binds[texels].iter().try_for_each(|row| expect_finite(row, here))
        }
    }
}

fn check_materials(contents: &PackContents, materials: Range<usize>, place: &dyn Fn(&str) -> String) -> Result<()> {
    use material_flags::{DOUBLE_SIDED, FILTER_MASK, FILTER_SHIFT, FLAT, UNLIT, WRAP_U_SHIFT, is_sampler};
    let known = DOUBLE_SIDED | UNLIT | FLAT | (0xff << WRAP_U_SHIFT);
    const { assert!(0xff << WRAP_U_SHIFT == 0xf << WRAP_U_SHIFT | FILTER_MASK << FILTER_SHIFT) };
    for (number, material) in contents.materials[materials].iter().enumerate() {
        let here = |field: &str| place(&format!("material {number}: {field}"));
        expect_finite(&material.base_color, || here("base colour"))?;
        let (image, images) = (material.image, contents.images.len());
        let fits = image == NONE || (image as usize) < images;
        expect(fits, || here("image"), image, || format!("below {images}, or {NONE} for none"))?;
        let flags = material.flags;
        let fits = flags & !known == 0 && is_sampler((flags >> WRAP_U_SHIFT) & 0xff);
        let allowed = || format!("bits of {known:#x}, wraps at most 2, filters at most 11");
        expect(fits, || here("flags"), format_args!("{flags:#x}"), allowed)?;
        let cutoff = material.alpha_cutoff;
        expect(
            cutoff.is_finite() && cutoff >= 0.0,
            || here("alpha cutoff"),
            cutoff,
            || "finite, at least 0".to_owned(),
        )?;
        expect(material.reserved == 0, || here("reserved"), material.reserved, || "0".to_owned())?;
    }
    Ok(())
}

/// The next `count` elements of a section, which must start at `offset` and lie within `len`.
pub(crate) fn take(
    covered: &mut usize,
    offset: u32,
    count: u64,
    len: usize,
    place: &dyn Fn() -> String,
) -> Result<Range<usize>> {
    let start = *covered;
    expect(
        offset as usize == start,
        || format!("{}: offset", place()),
        offset,
        || format!("{start}, behind the ones before"),
    )?;
    let left = (len - start) as u64;
    expect(count <= left, || format!("{}: elements", place()), count, || format!("at most {left}"))?;
    *covered = start + count as usize;
    Ok(start..*covered)
}

/// [`crate::Error::Format`] unless `holds`; the words are made only then.
pub(crate) fn expect<P: Display>(
    holds: bool,
    place: impl FnOnce() -> P,
    found: impl Display,
    allowed: impl FnOnce() -> String,
) -> Result<()> {
    if holds { Ok(()) } else { Err(format_error(place(), found, allowed())) }
}

/// Every number is finite.
pub(crate) fn expect_finite(numbers: &[f32], place: impl FnOnce() -> String) -> Result<()> {
    if numbers.iter().all(|n| n.is_finite()) {
        Ok(())
    } else {
        Err(format_error(place(), format!("{numbers:?}"), "finite numbers"))
    }
}

fn expect_sphere(sphere: [f32; 4], place: impl FnOnce() -> String) -> Result<()> {
    let fits = sphere.iter().all(|n| n.is_finite()) && sphere[3] >= 0.0;
    if fits { Ok(()) } else { Err(format_error(place(), format!("{sphere:?}"), "finite, radius at least 0")) }
}

pub(crate) fn expect_zeros(bytes: &[u8], range: Range<usize>, place: impl FnOnce() -> String) -> Result<()> {
    let zeros = bytes.get(range).is_some_and(|padding| padding.iter().all(|&b| b == 0));
    if zeros { Ok(()) } else { Err(format_error(place(), "other bytes", "zeros")) }
}
