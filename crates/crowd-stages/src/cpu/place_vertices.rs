//! The frame's one vertex list.

use super::is_kept;
use crate::{Capacities, InstanceBase, LodChoice};

/// For each entry of the frame's vertex list, whose vertex it is.
///
/// Instance `i` owns entries `bases[i].vertex_base ..` for its count; the local vertex is the entry minus the base.
/// Instances that do not fit `capacities` get no entries. Returns the list up to its last entry.
///
/// Paper: Peng 2011 §5.2 and Dong 2019 §5.3, the successive vertices picked into one buffer object. Departs: they copy the
/// vertices; we store only the owner (4 bytes instead of 32 and more) and the vertex shader reads the vertex where it lies.
///
/// Twin: `shaders/stages/place_vertices.wgsl`. Equal.
pub fn place_vertices(choices: &[LodChoice], bases: &[InstanceBase], capacities: &Capacities) -> Vec<u32> {
    let mut slot_instances = Vec::new();
    for (i, (choice, base)) in choices.iter().zip(bases).enumerate() {
        if is_kept(*base, *choice, capacities) {
            slot_instances.resize(slot_instances.len() + choice.vertex_count as usize, i as u32);
        }
    }
    slot_instances
}
