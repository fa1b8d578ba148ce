//! Whose vertices were skinned for the crowd's own pass, told to the passes of the shadow maps.

use crate::{Buckets, DrawnInstance};
use crowd_pack::NONE;

/// Where the skinned vertices of each instance begin; [`NONE`] for those who have none: not drawn, no mesh, no room.
///
/// `sorted_keys`, `sorted`, `drawn`: of the crowd's own pass; everyone is in the list once, those in no bucket last. A level's vertices are the
/// first of every finer one's, so that whoever draws a coarser level finds its vertices there, too.
///
/// Paper: none. Twin: `shaders/stages/lend_vertices.wgsl`, entry point `lend_vertices`. Equal.
pub fn lend_vertices(buckets: &Buckets, sorted_keys: &[u32], sorted: &[u32], drawn: &[DrawnInstance]) -> Vec<u32> {
    let mut lent = vec![NONE; sorted.len()];
    for ((key, i), one) in sorted_keys.iter().zip(sorted).zip(drawn) {
        // Dots and impostors have other words there, or none.
        if *key < buckets.mesh_count {
            lent[*i as usize] = one.vertex_base;
        }
    }
    lent
}

/// The casters of a shadow map with their vertices where [`lend_vertices`] has them.
///
/// `sorted_keys`, `sorted`, `drawn`: of the casters.
///
/// Paper: none. Twin: `shaders/stages/lend_vertices.wgsl`, entry point `borrow_vertices`. Equal.
pub fn borrow_vertices(
    buckets: &Buckets,
    sorted_keys: &[u32],
    sorted: &[u32],
    lent: &[u32],
    drawn: &[DrawnInstance],
) -> Vec<DrawnInstance> {
    let borrow = |((key, i), one): ((&u32, &u32), &DrawnInstance)| match *key < buckets.mesh_count {
        true => DrawnInstance { vertex_base: lent[*i as usize], ..*one },
        false => *one,
    };
    sorted_keys.iter().zip(sorted).zip(drawn).map(borrow).collect()
}
