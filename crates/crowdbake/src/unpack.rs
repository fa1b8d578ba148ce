//! One character of a pack as slices: what export, verify and pictures work on.

use crate::bake;
use crate::cli::BakeOptions;
use crate::error::{BakeError, Cause, Step};
use crate::level_warnings::blocked_sentence;
use crate::plan::PlanEntry;
use crate::pose::Mat3x4;
use crate::sample::FrameRate;
use crate::store_animation::animation_bytes;
use crowd_pack::{
    AnimationLayout, CharacterRecord, ClipRecord, Credits, Finish, ImpostorRecord, LevelRecord, LevelSetRecord,
    LodRecord, MAGIC, ManifestCharacter, ManifestJoint, ManifestTrack, MaterialRecord, Pack, PackContents, Rig,
    SPLIT_JOINT_BYTES, VertexRecord, stored_frames,
};
use glam::{Mat4, Quat, Vec3};
use std::io::Read;
use std::path::Path;

/// A pack from a file, or from an asset that was baked on the way.
#[derive(Debug)]
pub enum Opened {
    /// Read and checked.
    Pack(Box<Pack>),
    /// Baked just now.
    Baked(Box<PackContents>),
}

impl Opened {
    /// What is in it.
    pub fn contents(&self) -> &PackContents {
        match self {
            Self::Pack(pack) => pack.contents(),
            Self::Baked(contents) => contents,
        }
    }
}

/// True when the file begins like a pack or is named like one.
pub fn is_pack(path: &Path) -> bool {
    let mut magic = [0_u8; 8];
    // A pipe that nobody writes to would hold us for ever.
    let begins = path.is_file()
        && std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok()
        && magic == MAGIC;
    begins || path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("crowdpack"))
}

/// Opens a pack, or bakes an asset with `options`.
///
/// # Errors
/// The pack or the asset is refused.
pub fn open(path: &Path, options: &BakeOptions) -> Result<Opened, BakeError> {
    if is_pack(path) {
        let pack = Pack::open(path).map_err(|error| BakeError::whole(Step::Read, error))?;
        return Ok(Opened::Pack(Box::new(pack)));
    }
    let mut plan = crate::plan::make_plan(&[path.to_owned()], options, None);
    if let Some(error) = plan.refused.pop() {
        return Err(error);
    }
    let entries: Vec<PlanEntry> = plan.entries;
    let mut baked = Vec::new();
    for entry in &entries {
        baked.push(bake::bake_character(entry, false, &|_, _| {})?);
    }
    Ok(Opened::Baked(Box::new(crate::assemble::assemble(&baked, plan.animation_layout)?)))
}

/// The character that `--character` means: the named one, whatever the case if none is spelt so, or the only one.
///
/// # Errors
/// No such name, or several characters and no name.
pub fn choose_character(contents: &PackContents, name: Option<&str>) -> Result<usize, BakeError> {
    let names: Vec<&str> = contents.manifest.characters.iter().map(|c| c.name.as_str()).collect();
    let found = || names.join(", ");
    let cause = match name {
        None if names.len() == 1 => return Ok(0),
        None => Cause::CharacterNeeded { count: names.len(), found: found() },
        Some(asked) => match names
            .iter()
            .position(|name| *name == asked)
            .or_else(|| names.iter().position(|name| name.eq_ignore_ascii_case(asked)))
        {
            Some(index) => return Ok(index),
            None => Cause::CharacterNotFound { asked: asked.to_owned(), found: found() },
        },
    };
    Err(BakeError::whole(Step::ChooseLevel, cause))
}

/// A character's slices, and its vertices' fields unpacked; one entry per vertex.
#[derive(Debug)]
pub struct Unpacked<'a> {
    /// The whole pack.
    pub contents: &'a PackContents,
    /// Counts and bounds.
    pub record: &'a CharacterRecord,
    /// Names, nodes, errors.
    pub manifest: &'a ManifestCharacter,
    /// Vertices in collapse order.
    pub vertices: &'a [VertexRecord],
    /// Triangles in collapse order.
    pub triangles: &'a [[u32; 3]],
    /// Target of each vertex.
    pub collapse_map: &'a [u32],
    /// LOD table, one entry more than vertices.
    pub lods: &'a [LodRecord],
    /// Clips.
    pub clips: &'a [ClipRecord],
    /// Materials.
    pub materials: &'a [MaterialRecord],
    /// Bind-space positions, metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Joint indices.
    pub joints: Vec<[u16; 4]>,
    /// Weights.
    pub weights: Vec<[f32; 4]>,
    index: usize,
}

impl<'a> Unpacked<'a> {
    /// The character of that index, which must exist. The contents are checked ones, or made by `assemble`.
    pub fn new(contents: &'a PackContents, index: usize) -> Self {
        let record = &contents.characters[index];
        let part = |offset: u32, count: u32| offset as usize..offset as usize + count as usize;
        let vertices = &contents.vertices[part(record.vertex_offset, record.vertex_count)];
        Self {
            contents,
            record,
            manifest: &contents.manifest.characters[index],
            vertices,
            triangles: &contents.triangles[part(record.triangle_offset, record.triangle_count)],
            collapse_map: &contents.collapse_map[part(record.vertex_offset, record.vertex_count)],
            lods: &contents.lods[part(record.lod_offset, record.vertex_count + 1)],
            clips: &contents.clips[part(record.clip_offset, record.clip_count)],
            materials: &contents.materials[part(record.material_offset, record.material_count)],
            positions: vertices.iter().map(|vertex| vertex.position).collect(),
            normals: vertices.iter().map(VertexRecord::normal).collect(),
            joints: vertices.iter().map(VertexRecord::joint_indices).collect(),
            weights: vertices.iter().map(VertexRecord::weights_f32).collect(),
            index,
        }
    }

    /// Its impostors, where the pack has them.
    pub fn impostors(&self) -> Option<&'a ImpostorRecord> {
        self.contents.impostors.get(self.index)
    }

    /// What a material of it has beside its base colour.
    pub fn finish(&self, material: u32) -> Finish {
        let index = (self.record.material_offset + material) as usize;
        self.contents.finishes.materials.get(index).cloned().unwrap_or_default()
    }

    /// Its skin as the source has it, where that is another than what its vertices need.
    pub fn rig(&self) -> Option<&'a Rig> {
        self.contents.finishes.rigs.get(self.index)
    }

    /// The joints of its skin, used or not.
    pub fn skin_joints(&self) -> &'a [ManifestJoint] {
        match self.rig() {
            Some(rig) if !rig.joints.is_empty() => &rig.joints,
            _ => &self.manifest.joints,
        }
    }

    /// The name of its skin, where that has one.
    pub fn skin_name(&self) -> Option<&'a str> {
        let name = self.contents.finishes.skin_names.get(self.index)?;
        Some(name.as_str()).filter(|name| !name.is_empty())
    }

    /// What its file says of its makers, if anything.
    pub fn credits(&self) -> Option<&'a Credits> {
        self.contents.finishes.credits.get(self.index)
    }

    /// Levels in geometric steps, coarsest first.
    pub fn quantized_levels(&self) -> &'a [LevelRecord] {
        let set = self.level_set();
        &self.contents.levels[set.level_offset as usize..][..set.quantized_count as usize]
    }

    /// Levels that someone asked for, finest first; parallel to the manifest's `discrete`.
    pub fn discrete_levels(&self) -> &'a [LevelRecord] {
        let set = self.level_set();
        let first = (set.level_offset + set.quantized_count) as usize;
        &self.contents.levels[first..][..set.discrete_count as usize]
    }

    fn level_set(&self) -> &'a LevelSetRecord {
        &self.contents.level_sets[self.index]
    }

    /// The triangles of a level's index table, in the order drawn.
    pub fn table_triangles(&self, level: &LevelRecord) -> Vec<[u32; 3]> {
        let range = level.index_offset as usize..level.index_offset as usize + level.triangle_count as usize * 3;
        match level.index_bytes {
            2 => {
                let indices = self.contents.indices_16[range].as_chunks::<3>().0;
                indices.iter().map(|corners| corners.map(u32::from)).collect()
            }
            _ => self.contents.indices_32[range].as_chunks::<3>().0.to_vec(),
        }
    }

    /// The vertices that a level's indices go to.
    pub fn level_vertices(&self, level: &LevelRecord) -> &'a [VertexRecord] {
        let count = level.vertex_count as usize;
        if level.is_refit() {
            &self.contents.refit_vertices[level.refit_vertex_offset as usize..][..count]
        } else {
            &self.vertices[..count]
        }
    }

    /// Matrices a frame.
    pub fn joint_count(&self) -> usize {
        self.record.joint_count as usize
    }

    /// Premultiplied matrices of a whole clip, frame by frame, whatever the pack's layout.
    pub fn palettes(&self, clip: usize) -> Vec<Mat3x4> {
        let clip = &self.clips[clip];
        let layout = self.contents.manifest.animation_layout;
        let storage = self.record.storage().unwrap_or_default();
        let texel_count = clip.frame_count as usize * layout.frame_texels(storage, self.record.joint_count) as usize;
        let texels = &self.contents.animation[clip.texel_offset as usize..][..texel_count];
        match layout {
            AnimationLayout::Premultiplied3x4 => stored_frames(storage, texels, self.record.joint_count),
            AnimationLayout::Split4x4 => {
                let offset = self.record.inverse_bind_offset as usize;
                let inverse_binds = &self.contents.inverse_binds[offset..][..self.joint_count() * 4];
                let rows = |rows: &[[f32; 4]]| Mat4::from_cols_array_2d(&std::array::from_fn(|r| rows[r])).transpose();
                let inverse_binds: Vec<Mat4> = inverse_binds.chunks_exact(4).map(rows).collect();
                let worlds = texels.chunks_exact(4).map(|texels| {
                    let floats: [[f32; 4]; 4] = std::array::from_fn(|row| texels[row].map(f32::from_bits));
                    rows(&floats)
                });
                let pairs = worlds.zip(inverse_binds.iter().cycle());
                pairs.map(|(world, inverse_bind)| rows_of(world * *inverse_bind)).collect()
            }
        }
    }

    /// Bytes of all clips.
    pub fn animation_bytes(&self) -> u64 {
        let (layout, storage) = (self.contents.manifest.animation_layout, self.record.storage().unwrap_or_default());
        animation_bytes(layout, storage, self.record.joint_count, self.clips.iter().map(|clip| clip.frame_count))
    }

    /// Frames of a clip at the rate asked for, of which the pack may keep fewer.
    pub fn sampled_frames(&self, index: usize) -> u64 {
        let clip = &self.clips[index];
        let times = |track: &ManifestTrack| {
            &self.contents.track_values[track.time_offset as usize..][..track.key_count as usize]
        };
        let tracks: Vec<&[f32]> = self.manifest.clips[index].tracks.iter().map(times).collect();
        let sampled = FrameRate::of_code(self.manifest.fps).frames_of(&tracks).min(f64::from(u32::MAX)) as u64;
        if clip.duration_s > 0.0 { sampled.max(clip.frame_count.into()) } else { 1 }
    }

    /// Bytes of all clips at that rate in the papers' layout, four RGBA32F texels a joint and frame.
    pub fn papers_animation_bytes(&self) -> u64 {
        let frames: u64 = (0..self.clips.len()).map(|clip| self.sampled_frames(clip)).sum();
        frames.saturating_mul(u64::from(self.record.joint_count) * u64::from(SPLIT_JOINT_BYTES))
    }

    /// Matrices of the pose at rest, from the manifest's node tree.
    pub fn rest_palette(&self) -> Vec<Mat3x4> {
        let nodes = self.manifest.nodes.iter().map(|n| (n.parent, n.translation, n.rotation, n.scale));
        rest_palette(nodes, self.manifest.joints.iter().map(|joint| (joint.node, joint.inverse_bind)))
    }

    /// The triangles of the level with that many vertices, indices below it.
    pub fn level_triangles(&self, level: LodRecord) -> Vec<[u32; 3]> {
        crowd_lod::reform(self.triangles, self.collapse_map, level.vertex_count, level.triangle_count)
    }

    /// The largest level that `fits`, or the coarsest one and `false`.
    pub fn largest_level(&self, fits: impl Fn(LodRecord) -> bool) -> (LodRecord, bool) {
        // Counts never fall along the table, so the levels that fit are its beginning.
        let count = self.lods.partition_point(|&lod| fits(lod));
        (self.lods[count.saturating_sub(1)], count > 0)
    }

    /// The largest level of at most this share of the triangles, or the coarsest one and `false`.
    pub fn level_of_ratio(&self, ratio: f64) -> (LodRecord, bool) {
        let target = triangle_target(self.record.triangle_count, ratio);
        self.largest_level(|lod| lod.triangle_count <= target)
    }

    /// What keeps the coarsest level from going further, and where that is.
    pub fn blocked(&self) -> String {
        let b = self.manifest.blocked;
        let counts = blocked_sentence(b.fixed, b.seam, b.topology, b.flip, b.ended);
        match crate::explain::held_where(self) {
            Some(places) if b.ended == 0 => format!("{counts}; {places}"),
            _ => counts,
        }
    }
}

/// Triangles that a share asks for, at least one.
pub fn triangle_target(triangle_count: u32, ratio: f64) -> u32 {
    // A tenth of 10 triangles is 1, although 0.1 is a little more than a tenth in binary.
    ((f64::from(triangle_count) * ratio + 1e-6).floor() as u32).max(1)
}

/// Matrices of a source's pose at rest.
pub fn rest_palette_of(raw: &crowd_source::RawCharacter) -> Vec<Mat3x4> {
    let nodes = raw.nodes.iter().map(|n| (n.parent, n.translation, n.rotation, n.scale));
    rest_palette(nodes, raw.joints.iter().map(|joint| (joint.node, joint.inverse_bind)))
}

/// `nodes`: parent, translation, rotation, scale, parents first. `joints`: node and inverse bind matrix.
fn rest_palette(
    nodes: impl Iterator<Item = (Option<u32>, [f32; 3], [f32; 4], [f32; 3])>,
    joints: impl Iterator<Item = (u32, [f32; 16])>,
) -> Vec<Mat3x4> {
    let mut worlds: Vec<Mat4> = Vec::new();
    for (parent, translation, rotation, scale) in nodes {
        let local = Mat4::from_scale_rotation_translation(
            Vec3::from(scale),
            Quat::from_array(rotation),
            Vec3::from(translation),
        );
        worlds.push(parent.map_or(local, |parent| worlds[parent as usize] * local));
    }
    joints.map(|(node, bind)| rows_of(worlds[node as usize] * Mat4::from_cols_array(&bind))).collect()
}

fn rows_of(matrix: Mat4) -> Mat3x4 {
    let rows = matrix.transpose().to_cols_array_2d();
    [rows[0], rows[1], rows[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_rounded_down_but_not_by_binary_dust() {
        assert_eq!(triangle_target(10, 0.1), 1);
        assert_eq!(triangle_target(1000, 0.7), 700);
        assert_eq!(triangle_target(999, 0.5), 499);
        assert_eq!(triangle_target(7, 1.0), 7);
        assert_eq!(triangle_target(128, 0.001), 1);
    }

    #[test]
    fn rows_hold_the_translation_at_their_end() {
        let rows = rows_of(Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0)));
        assert_eq!([rows[0][3], rows[1][3], rows[2][3]], [1.0, 2.0, 3.0]);
    }
}
