//! What the vertices of a drawn instance need to know of it.

use super::frame_pair;
use crate::{Buckets, CrowdData, DrawnInstance, InstanceRecord, MorphRecord};

/// What their vertices need to know of the drawn instances, in the order of `sorted`: place, turn, frames, materials, morph.
///
/// `sorted_keys`, `sorted`: of `sort_instances`; those in no bucket come last there and are left out. `morphs`: one an instance.
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
    time_s: f32,
) -> Vec<DrawnInstance> {
    let drawn = sorted_keys.iter().zip(sorted).take_while(|(key, _)| **key < buckets.nobody());
    drawn.map(|(_, i)| drawn_instance(data, &instances[*i as usize], morphs[*i as usize], time_s)).collect()
}

/// The same of one instance.
pub fn drawn_instance(data: &CrowdData, instance: &InstanceRecord, morph: MorphRecord, time_s: f32) -> DrawnInstance {
    let character = &data.characters[instance.character as usize];
    let clip = &data.clips[instance.clip as usize];
    let pair = frame_pair(clip, instance.phase_s, time_s);
    let frame_texels = character.joint_count * 3;
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
    }
}

/// How far GPU and CPU may differ in sine, cosine and the share of a frame: WGSL asks for sines within 2^-11, a quotient is off
/// by 2.5 ulp and is multiplied by the number of frames.
pub const DRAWN_BOUND: f32 = 1e-3;
