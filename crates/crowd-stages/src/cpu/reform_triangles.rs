//! The triangles of each instance at its level.

use super::is_kept;
use crate::buckets::from_least;
use crate::{Capacities, CrowdData, InstanceBase, InstanceRecord, LodChoice};
use crowd_pack::CharacterRecord;

/// Writes the frame's index buffer: the first q triangles of each instance with collapsed vertices replaced.
///
/// An index is an entry of the frame's vertex list (see [`super::place_vertices()`]). Instances that do not fit `capacities`
/// get no triangles. Returns three indices a triangle, of the window alone where `capacities` has one: index buffers that are larger
/// than a binding are written in parts.
///
/// Paper: Peng 2011 §5.2, "the vertex indices of a triangle are replaced with the target indices returned from the per-vertex
/// lookup of the collapsing information". Departs: none.
///
/// Twin: `shaders/stages/reform_triangles.wgsl`. Equal.
pub fn reform_triangles(
    data: &CrowdData,
    instances: &[InstanceRecord],
    choices: &[LodChoice],
    bases: &[InstanceBase],
    capacities: &Capacities,
) -> Vec<u32> {
    let mut indices = Vec::new();
    for i in 0..instances.len() {
        if choices[i].vertex_count == 0 || !is_kept(bases[i], choices[i], capacities) {
            continue;
        }
        let character = &data.characters[instances[i].character as usize];
        let base = bases[i].vertex_base;
        for triangle in reform_level(data, character, choices[i]) {
            indices.extend(triangle.map(|v| base + v));
        }
    }
    match capacities.window_count {
        0 => indices,
        count => {
            let (first, end) = (capacities.window_first as usize, (capacities.window_first + count) as usize);
            indices[(3 * first).min(indices.len())..(3 * end).min(indices.len())].to_vec()
        }
    }
}

/// The triangles of one level, indices local to the character and below the level's vertex count, the least of each first (as
/// in [`crate::Buckets`], so that the same triangles give the same pixels).
pub fn reform_level(data: &CrowdData, character: &CharacterRecord, choice: LodChoice) -> Vec<[u32; 3]> {
    let first = character.triangle_offset as usize;
    let vertices = character.vertex_offset as usize..(character.vertex_offset + character.vertex_count) as usize;
    let collapse_map = &data.collapse_map[vertices];
    data.triangles[first..first + choice.triangle_count as usize]
        .iter()
        .map(|triangle| from_least(triangle.map(|v| surviving(collapse_map, v, choice.vertex_count))))
        .collect()
}

/// Follows collapse targets until one lies below `k`. A target lies below its vertex (the pack's reader checked), so this ends.
pub fn surviving(collapse_map: &[u32], mut v: u32, k: u32) -> u32 {
    while v >= k {
        let target = collapse_map[v as usize];
        if target >= v {
            return 0;
        }
        v = target;
    }
    v
}
