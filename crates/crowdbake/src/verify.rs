//! Checks that a pack keeps its promises: levels, companions, bounds, images, index tables, measured errors.
//!
//! That the bytes are whole and the records agree with each other was checked on opening; here levels are rebuilt.

use crate::measure_levels::{LevelMeasure, LevelShape, MeasuredFrames, measure_in_frame_too};
use crate::measure_packed::{MOST_SAMPLES, expect_measurable, frame_of_clip, palettes_of};
use crate::ordered_mesh::{DecodedVertices, OrderedMesh};
use crate::pose::pose_positions;
use crate::units::{counted, length};
use crate::unpack::Unpacked;
use crowd_pack::{
    ImageRecord, ImpostorRecord, LevelRecord, LodRecord, ManifestMeasured, NONE, PackContents, VertexRecord,
    vertex_class,
};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// Bounds may be missed by this share of the radius: sphere and palettes are rounded to 32 bits.
const BOUND_SLACK: f32 = 1e-5;
/// Where matrices are multiplied again (split layout) the product is rounded differently.
const SPLIT_SLACK: f32 = 1e-4;
/// Measured errors may differ by this share, and this share of the height: the same points and frames are measured, but
/// on palettes that the split layout rounds differently.
const ERROR_SLACK: f32 = 0.02;

/// One promise, looked at.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Check {
    /// The character; empty for the whole pack.
    pub character: String,
    /// Name of the check, kebab-case.
    pub check: &'static str,
    /// Kept or broken.
    pub passed: bool,
    /// What was looked at, or the first thing that is wrong.
    pub detail: String,
}

/// Checks every character of a pack that opened. `level_count`: levels looked at for each character.
pub fn verify(contents: &PackContents, level_count: usize) -> Vec<Check> {
    let mut checks = vec![check_images(contents)];
    if !contents.impostors.is_empty() {
        checks.push(check_impostors(contents));
    }
    for index in 0..contents.characters.len() {
        let character = Unpacked::new(contents, index);
        let levels = spread_levels(&character, level_count);
        for (check, result) in [
            ("levels-are-meshes", check_levels(&character, &levels)),
            ("companions-stay-together", check_companions(&character, &levels)),
            ("no-new-open-edges", check_open_edges(&character, &levels)),
            ("bounds-hold-every-frame", check_bounds(&character)),
            ("tables-hold-the-levels", check_tables(&character)),
            ("errors-measure-again", check_errors(&character)),
        ] {
            let (passed, detail) = match result {
                Ok(detail) => (true, detail),
                Err(problem) => (false, problem),
            };
            checks.push(Check { character: character.manifest.name.clone(), check, passed, detail });
        }
    }
    checks
}

fn check_images(contents: &PackContents) -> Check {
    let shown = contents.images.iter().map(|image| ("image", image, &contents.image_bytes));
    let carried = contents.finish_images.iter().map(|image| ("finish image", image, &contents.finish_bytes));
    let images: Vec<_> = shown.enumerate().chain(carried.enumerate()).collect();
    let decode = |&(index, (what, image, all_bytes)): &(usize, (&str, &ImageRecord, &Vec<u8>))| {
        let bytes = &all_bytes[image.byte_offset as usize..][..image.byte_count as usize];
        let texture = crowd_raster::decode_texture(bytes, 64).map_err(|error| format!("{what} {index}: {error}"))?;
        if texture.mips.is_empty() { Err(format!("{what} {index}: no pixels")) } else { Ok(()) }
    };
    let result: Result<Vec<()>, String> = images.par_iter().map(decode).collect();
    let (passed, detail) = match result {
        Ok(images) => (true, format!("{} decode", counted(images.len(), "image"))),
        Err(problem) => (false, problem),
    };
    Check { character: String::new(), check: "images-decode", passed, detail }
}

/// Impostors decode to pictures of the size that their tiles need.
fn check_impostors(contents: &PackContents) -> Check {
    let decode = |(index, record): (usize, &ImpostorRecord)| {
        let places = [
            (record.color_byte_offset, record.color_byte_count),
            (record.normal_byte_offset, record.normal_byte_count),
        ];
        for (start, count) in places {
            let bytes = &contents.impostor_bytes[start as usize..][..count as usize];
            let promised = [record.width(), record.height()];
            let largest = promised.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
            let picture = crowd_raster::decode_picture_within(bytes, largest)
                .map_err(|error| format!("impostors {index}: {error}, promised {promised:?} texels"))?;
            let found = [picture.width, picture.height].map(u64::from);
            if found != promised {
                return Err(format!("impostors {index}: found {found:?} texels, promised {promised:?}"));
            }
        }
        Ok(record.poses() * u64::from(record.azimuth_count * record.elevation_count))
    };
    let result: Result<Vec<u64>, String> = contents.impostors.par_iter().enumerate().map(decode).collect();
    let (passed, detail) = match result {
        Ok(tiles) => (true, format!("{} decode", counted(tiles.iter().sum::<u64>() as usize, "tile"))),
        Err(problem) => (false, problem),
    };
    Check { character: String::new(), check: "impostors-decode", passed, detail }
}

/// The coarsest, the finest, and some between, evenly by their number.
fn spread_levels(character: &Unpacked<'_>, count: usize) -> Vec<LodRecord> {
    let mut all: Vec<LodRecord> = character.lods.to_vec();
    all.dedup();
    let last = all.len() - 1;
    let count = count.min(all.len()).max(2);
    let mut chosen: Vec<LodRecord> = (0..count).map(|i| all[i * last / (count - 1)]).collect();
    chosen.dedup();
    chosen
}

fn check_levels(character: &Unpacked<'_>, levels: &[LodRecord]) -> Result<String, String> {
    levels.par_iter().try_for_each(|&level| {
        let here = |problem: String| format!("level of {} vertices: {problem}", level.vertex_count);
        let triangles = character.level_triangles(level);
        if triangles.len() != level.triangle_count as usize {
            return Err(here(format!("found {} triangles, promised {}", triangles.len(), level.triangle_count)));
        }
        for (index, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = *triangle;
            if triangle.iter().any(|&corner| corner >= level.vertex_count) {
                return Err(here(format!("triangle {index}: found {triangle:?}, allowed below the vertex count")));
            }
            let place = |corner: u32| character.positions[corner as usize];
            if a == b || b == c || c == a || place(a) == place(b) || place(b) == place(c) || place(c) == place(a) {
                return Err(here(format!("triangle {index}: {triangle:?} has two corners at one place")));
            }
        }
        Ok(())
    })?;
    Ok(format!("{} levels", levels.len()))
}

/// Vertices at one place with one skinning are wedges of one position.
fn positions_of_vertices(character: &Unpacked<'_>) -> Vec<u32> {
    let mut known = HashMap::new();
    let key = |v: usize| {
        let vertex = &character.vertices[v];
        (vertex.position.map(f32::to_bits), vertex.joints, vertex.weights)
    };
    (0..character.vertices.len())
        .map(|v| {
            let next = known.len() as u32;
            *known.entry(key(v)).or_insert(next)
        })
        .collect()
}

/// Companions go together; where a chart has shrunk to nothing at a place that stays, its wedge there may only have
/// become a wedge of the same place.
fn check_companions(character: &Unpacked<'_>, levels: &[LodRecord]) -> Result<String, String> {
    let position_of = positions_of_vertices(character);
    let mut wedges: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (vertex, &position) in position_of.iter().enumerate() {
        if character.vertices[vertex].class() == vertex_class::COMPANION {
            wedges.entry(position).or_default().push(vertex as u32);
        }
    }
    for level in levels {
        let image = |mut vertex: u32| {
            while vertex >= level.vertex_count {
                vertex = character.collapse_map[vertex as usize];
            }
            position_of[vertex as usize]
        };
        for vertices in wedges.values() {
            // Two surfaces may touch in one place, each with a pair of its own: nobody may be left alone.
            let alone = |&vertex: &u32| vertices.iter().filter(|&&other| image(other) == image(vertex)).count() == 1;
            if vertices.len() > 1 && vertices.iter().any(alone) {
                return Err(format!(
                    "level of {} vertices: tears the companions {vertices:?} apart",
                    level.vertex_count
                ));
            }
        }
    }
    Ok(format!("{} places with companions at {} levels", wedges.len(), levels.len()))
}

/// Edges by position that one triangle alone has (a seam that opens shows as such an edge), and edges of more than two.
fn open_edges(triangles: &[[u32; 3]], position_of: &[u32]) -> (usize, usize) {
    let mut uses: HashMap<(u32, u32), u32> = HashMap::with_capacity(triangles.len() * 2);
    for triangle in triangles {
        for corner in 0..3 {
            let a = position_of[triangle[corner] as usize];
            let b = position_of[triangle[(corner + 1) % 3] as usize];
            *uses.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    let count = |holds: fn(u32) -> bool| uses.values().filter(|&&count| holds(count)).count();
    (count(|count| count == 1), count(|count| count > 2))
}

fn check_open_edges(character: &Unpacked<'_>, levels: &[LodRecord]) -> Result<String, String> {
    let position_of = positions_of_vertices(character);
    let (full, crowded) = open_edges(character.triangles, &position_of);
    // Where surfaces touch along an edge (more than two triangles on it) they may part later: each then shows its own.
    let allowed = full + 2 * crowded;
    let most = levels
        .par_iter()
        .map(|&level| {
            let (found, _) = open_edges(&character.level_triangles(level), &position_of);
            if found <= allowed {
                Ok(found)
            } else {
                Err(format!(
                    "level of {} vertices: found {found} open edges, full detail has {full}",
                    level.vertex_count
                ))
            }
        })
        .try_reduce(|| 0, |a, b| Ok(a.max(b)))?;
    Ok(format!("{full} open edges at full detail, at most {most} at {} levels", levels.len()))
}

/// False for a NaN on either side.
fn within(found: f32, allowed: f32) -> bool {
    found <= allowed
}

fn slack(character: &Unpacked<'_>) -> f32 {
    match character.contents.manifest.animation_layout {
        crowd_pack::AnimationLayout::Premultiplied3x4 => BOUND_SLACK,
        crowd_pack::AnimationLayout::Split4x4 => SPLIT_SLACK,
    }
}

fn check_bounds(character: &Unpacked<'_>) -> Result<String, String> {
    let record = character.record;
    let slack = record.sphere[3] * slack(character);
    // Refitted levels have vertices of their own; those of the other levels are full detail's.
    let own = || character.discrete_levels().iter().filter(|level| level.refit_vertex_offset != NONE);
    let refitted: Vec<VertexRecord> = own().flat_map(|level| character.level_vertices(level)).copied().collect();
    let positions: Vec<_> = character.positions.iter().copied().chain(refitted.iter().map(|v| v.position)).collect();
    let joints: Vec<_> = character.joints.iter().copied().chain(refitted.iter().map(|v| v.joint_indices())).collect();
    let weights: Vec<_> = character.weights.iter().copied().chain(refitted.iter().map(|v| v.weights_f32())).collect();
    let of_level = |vertex: usize| if vertex < character.vertices.len() { "" } else { " (of a refitted level)" };
    let mut frames = 0;
    for (index, clip) in character.clips.iter().enumerate() {
        let palettes = character.palettes(index);
        let name = &character.manifest.clips[index].name;
        palettes.par_chunks_exact(character.joint_count()).enumerate().try_for_each(|(frame, palette)| {
            let posed = pose_positions(&positions, &joints, &weights, palette);
            for (vertex, p) in posed.iter().enumerate() {
                for (what, sphere) in [("clip's sphere", clip.sphere), ("character's sphere", record.sphere)] {
                    let d: [f32; 3] = std::array::from_fn(|axis| p[axis] - sphere[axis]);
                    let distance = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                    if !within(distance, sphere[3] + slack) {
                        return Err(format!(
                            "clip `{name}` frame {frame}: vertex {vertex}{} lies {distance} m from the {what}'s \
                             centre, its radius is {} m",
                            of_level(vertex),
                            sphere[3]
                        ));
                    }
                }
                let inside =
                    |axis: usize| p[axis] >= record.box_min[axis] - slack && p[axis] <= record.box_max[axis] + slack;
                if !(0..3).all(inside) {
                    let of = of_level(vertex);
                    return Err(format!(
                        "clip `{name}` frame {frame}: vertex {vertex}{of} at {p:?} lies outside the box"
                    ));
                }
            }
            Ok(())
        })?;
        frames += clip.frame_count;
    }
    Ok(format!("{} vertices in {frames} frames", positions.len()))
}

/// Index tables hold the triangles that reforming gives; refitted levels are meshes.
fn check_tables(character: &Unpacked<'_>) -> Result<String, String> {
    let levels: Vec<&LevelRecord> = character.quantized_levels().iter().chain(character.discrete_levels()).collect();
    levels.par_iter().enumerate().try_for_each(|(number, level)| {
        let table = character.table_triangles(level);
        if let Some(odd) = table.iter().find(|[a, b, c]| a == b || b == c || c == a) {
            return Err(format!("table {number}: {odd:?} has two equal corners"));
        }
        let counts = LodRecord { vertex_count: level.vertex_count, triangle_count: level.triangle_count };
        if !level.is_refit() && as_set(&table) != as_set(&character.level_triangles(counts)) {
            return Err(format!(
                "table {number}: other triangles than the level of {} vertices has",
                level.vertex_count
            ));
        }
        Ok(())
    })?;
    Ok(format!("{} tables", levels.len()))
}

/// Triangles from their least corner on, sorted.
fn as_set(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let turn = |&[a, b, c]: &[u32; 3]| match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    };
    let mut turned: Vec<[u32; 3]> = triangles.iter().map(turn).collect();
    turned.sort_unstable();
    turned
}

/// The levels measured again, on the frames that the manifest names.
fn check_errors(character: &Unpacked<'_>) -> Result<String, String> {
    let manifest = character.manifest;
    let measuring = &manifest.measuring;
    let frames = MeasuredFrames { mean: measuring.mean_frames.clone(), worst: measuring.worst_frames.clone() };
    let mesh = OrderedMesh::of_pack(character);
    let shape = |level: &LevelRecord| {
        if level.is_refit() {
            LevelShape::Own(DecodedVertices::new(character.level_vertices(level)), character.table_triangles(level))
        } else {
            let counts = LodRecord { vertex_count: level.vertex_count, triangle_count: level.triangle_count };
            LevelShape::Shared(character.level_triangles(counts))
        }
    };
    let stored = character.quantized_levels().iter().chain(character.discrete_levels());
    let shapes: Vec<LevelShape> = stored.map(shape).collect();
    let promised: Vec<&ManifestMeasured> =
        manifest.measured.iter().chain(manifest.discrete.iter().map(|discrete| &discrete.measured)).collect();
    let palettes = palettes_of(character, &frames);
    expect_measurable(character, &palettes)?;
    let samples = measuring.samples_per_frame.min(MOST_SAMPLES);
    let mut found = LevelMeasure::new(&mesh, &frames, &palettes, character.joint_count(), samples).measure(&shapes);
    // A refitted level may be worst in a frame that no other one is measured in.
    let own_frame = |(promised, shape): (&&ManifestMeasured, &LevelShape)| {
        let frame = frame_of_clip(character, promised.max_clip, promised.max_frame);
        (matches!(shape, LevelShape::Own(..)) && !frames.all().any(|known| known == frame)).then_some(frame)
    };
    let own: Vec<Option<u32>> = promised.iter().zip(&shapes).map(own_frame).collect();
    let further = MeasuredFrames { mean: Vec::new(), worst: own.iter().copied().flatten().collect() };
    let palettes = palettes_of(character, &further);
    expect_measurable(character, &palettes)?;
    let mut palettes = palettes.chunks_exact(character.joint_count().max(1));
    for ((frame, found), shape) in own.into_iter().zip(&mut found).zip(&shapes) {
        let Some(frame) = frame else { continue };
        let palette = palettes.next().ok_or("a frame that is named has no matrices")?;
        *found = measure_in_frame_too(&mesh, shape, *found, frame, palette);
    }
    let floor_m = 1e-5 * character.record.height_m.max(character.record.sphere[3]);
    let mut largest = 0.0_f32;
    for (promised, found) in promised.iter().zip(&found) {
        for (what, promised_m, found_m) in
            [("RMS", promised.rms_m, found.rms_m), ("largest distance", promised.max_m, found.max_m)]
        {
            if !within((promised_m - found_m).abs(), ERROR_SLACK * promised_m + floor_m) {
                return Err(format!(
                    "level of {} vertices: {what} is {found_m} m, the manifest says {promised_m} m",
                    promised.vertex_count
                ));
            }
            largest = largest.max((promised_m - found_m).abs());
        }
        if !within(found.bound_m, promised.bound_m * (1.0 + ERROR_SLACK) + floor_m) {
            return Err(format!(
                "level of {} vertices: the bound is {} m, the manifest says {} m",
                promised.vertex_count, found.bound_m, promised.bound_m
            ));
        }
    }
    Ok(format!("{} levels on {} frames, at most {} apart", promised.len(), frames.all().count(), length(largest)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seam_that_opens_shows_as_open_edges() {
        // Two triangles share the edge 1-2; vertex 3 is a wedge of position 1, vertex 4 of position 2.
        let closed = [0, 1, 2, 1, 2, 3];
        assert_eq!(open_edges(&[[0, 1, 2], [4, 3, 5]], &closed), (4, 0));
        let torn = [0, 1, 2, 9, 2, 3];
        assert_eq!(open_edges(&[[0, 1, 2], [4, 3, 5]], &torn), (6, 0));
    }
}
