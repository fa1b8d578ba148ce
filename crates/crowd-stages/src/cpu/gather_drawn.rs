//! What the vertices of a drawn instance need to know of it.

use super::frame_pair;
use crate::{BucketPlace, Buckets, CrowdData, DrawnInstance, InstanceRecord, MorphRecord};
use crowd_pack::NONE;

/// What their vertices need to know of the drawn instances, in the order of `sorted`: place, turn, frames, materials, morph.
///
/// `sorted_keys`, `sorted`: of `sort_instances`; those in no bucket come last there and are left out. `morphs`: one an instance.
/// `places`: of `place_buckets`, where vertices are skinned beforehand; else any, and where they lie means nothing.
///
/// Who is drawn as a mesh comes first in the list, so its first entries are those who need a palette: they have the slots.
///
/// Paper: none; the papers work it out for each vertex. Twin: `shaders/stages/gather_drawn.wgsl`. Integers equal, but for a frame
/// at its border; other numbers within [`DRAWN_BOUND`].
pub fn gather_drawn(
    data: &CrowdData,
    buckets: &Buckets,
    instances: &[InstanceRecord],
    morphs: &[MorphRecord],
    sorted_keys: &[u32],
    sorted: &[u32],
    places: &[BucketPlace],
    time_s: f32,
) -> Vec<DrawnInstance> {
    let drawn = (0..).zip(sorted_keys.iter().zip(sorted)).take_while(|(_, (key, _))| **key < buckets.nobody());
    let one = |(entry, (key, i)): (u32, (&u32, &u32))| {
        let place = places[*key as usize];
        let within = entry.wrapping_sub(place.first).wrapping_mul(place.vertex_count);
        let vertex_base = if place.vertex_base == NONE { NONE } else { place.vertex_base.wrapping_add(within) };
        let palette_row = buckets.palette_row(entry);
        let drawn = drawn_instance(data, &instances[*i as usize], morphs[*i as usize], time_s);
        // Dots read their few joints from the frames.
        let row_count = if *key < buckets.mesh_count { drawn.row_count } else { 0 };
        if *key >= buckets.first_impostor {
            // An impostor is of one clip, and its pixels are thinned by its number.
            let instance = &instances[*i as usize];
            let clip = if instance.leaving_share > 0.5 { instance.left_clip() } else { instance.clip };
            return DrawnInstance { vertex_base: clip, palette_row: *i, row_count, ..drawn };
        }
        DrawnInstance { vertex_base, palette_row, row_count, ..drawn }
    };
    drawn.map(one).collect()
}

/// One of them, but for where its skinned vertices and its palette lie.
pub(super) fn drawn_instance(
    data: &CrowdData,
    instance: &InstanceRecord,
    morph: MorphRecord,
    time_s: f32,
) -> DrawnInstance {
    let character = &data.characters[instance.character as usize];
    let clip = &data.clips[instance.clip as usize];
    let pair = frame_pair(clip, instance.phase_s, time_s - instance.held_s);
    let leaving = &data.clips[instance.left_clip() as usize];
    let left = frame_pair(leaving, instance.leaving_phase_s, time_s - instance.held_s);
    let frame_texels = character.storage().unwrap_or_default().frame_texels(character.joint_count);
    DrawnInstance {
        position: instance.position,
        scale: instance.scale,
        turn: libm::sincosf(instance.yaw_rad).into(),
        fraction: morph.fraction,
        blend: pair.blend,
        coarser_vertex_count: morph.coarser_vertex_count,
        material_offset: character.material_offset,
        first_texel: clip.texel_offset + pair.first * frame_texels,
        second_texel: clip.texel_offset + pair.second * frame_texels,
        leaving_first_texel: leaving.texel_offset + left.first * frame_texels,
        leaving_second_texel: leaving.texel_offset + left.second * frame_texels,
        leaving_blend: left.blend,
        leaving_share: instance.leaving_share,
        row_count: character.joint_count * 3,
        storage: character.joint_storage,
        ..Default::default()
    }
}

/// How far GPU and CPU may differ in sine, cosine and the share of a frame: WGSL asks for sines within 2^-11, a quotient is off
/// by 2.5 ulp and is multiplied by the number of frames.
pub const DRAWN_BOUND: f32 = 1e-3;
