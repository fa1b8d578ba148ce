//! A mesh and its poses in, a collapse order with measured errors out.
//!
//! Follows Peng, Park, Cao, Tian 2011 §4: split vertices along UV seams, classify them as fixed, companioned or regular,
//! collapse half-edges in the order of a quadric error averaged over all frames of all clips. The default criteria test
//! wedges per collapse instead of once (see [`Criteria::Wedge`]).
//! What it leaves to others: files (`crowd-source`), sampling (`crowd-anim`), layout (`crowd-pack`).

mod types;

pub use types::*;

/// Simplifies a mesh down to its fixed set and returns the whole order.
///
/// `progress` is called now and then with the share done, 0..=1, from one thread.
///
/// # Errors
/// [`Error::Parameter`] when the slices disagree or hold indices or numbers that are not allowed.
pub fn simplify(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    options: &LodOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<CollapseOrder> {
    let _ = (mesh, poses, options, progress);
    unimplemented!("crowd-lod: being written")
}

/// Seams and classes alone, without simplifying: what `inspect` shows of a source asset.
pub fn classify(mesh: &LodMesh<'_>, criteria: Criteria) -> Result<SeamReport> {
    let _ = (mesh, criteria);
    unimplemented!("crowd-lod: being written")
}

/// The triangles of the prefix with `vertex_count` vertices: the first `q` triangles with every index looked up in the
/// collapse map until it is below `vertex_count` (Peng 2011 §5.2, triangle reformation).
pub fn reform(triangles: &[[u32; 3]], collapse_map: &[u32], vertex_count: u32, triangle_count: u32) -> Vec<[u32; 3]> {
    let _ = (triangles, collapse_map, vertex_count, triangle_count);
    unimplemented!("crowd-lod: being written")
}

/// Measures how far a level lies from full detail: two-sided closest-point distance over the poses given.
///
/// `order` arrays as in [`CollapseOrder`], `positions`/`joints`/`weights` in the order's vertex order. At most
/// `samples_per_frame` points a side and frame, the same ones on every machine.
pub fn measure_level(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    triangles: &[[u32; 3]],
    level_triangles: &[[u32; 3]],
    poses: &LodPoses<'_>,
    samples_per_frame: u32,
) -> MeasuredError {
    let _ = (positions, joints, weights, triangles, level_triangles, poses, samples_per_frame);
    unimplemented!("crowd-lod: being written")
}
