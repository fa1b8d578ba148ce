//! A mesh and its poses in, a collapse order with measured errors out.
//!
//! Follows Peng, Park, Cao, Tian 2011 §4: split vertices along UV seams, classify them as fixed, companioned or regular,
//! collapse half-edges in the order of a quadric error averaged over all frames of all clips. The default criteria test
//! wedges per collapse instead of once (see [`Criteria::Wedge`]).
//! What it leaves to others: files (`crowd-source`), sampling (`crowd-anim`), layout (`crowd-pack`).
//!
//! One module a step: `split_seams` (with `separate_layers`), `classify`, `quadrics`, `criteria`, `collapse` (on a `topology`),
//! `reorder`, `reform`, `level_mesh`, `refit`, `measure`, `interpenetration`.

mod classify;
mod closest;
mod collapse;
mod criteria;
mod interpenetration;
mod level_mesh;
#[cfg(test)]
mod lib_tests;
mod measure;
mod quadrics;
mod refit;
mod reform;
mod reorder;
mod separate_layers;
mod split_seams;
#[cfg(test)]
mod test_meshes;
mod topology;
mod types;
mod validate;

pub use interpenetration::{Interpenetration, LayeredMesh, find_layers, measure_interpenetration};
pub use level_mesh::{LevelMesh, level_mesh};
pub use measure::{measure_level, measured_frames};
pub use refit::{RefitOptions, refit};
pub use reform::reform;
pub use types::*;

/// Simplifies a mesh down to its fixed set and returns the whole order.
///
/// The cost of a collapse is the quadric error averaged over the frames of `poses` by their weights. Frames are used
/// all, unless positions times frames would need more than 1.5 GB; then as many as fit, drawn evenly by weight.
/// `progress` is called now and then with the share done, 0..=1, from one thread. A mesh without triangles gives an order
/// with one empty level.
///
/// # Errors
/// [`Error::Parameter`] when the slices disagree or hold indices or numbers that are not allowed.
///
/// Paper: Peng 2011 §4. Departs: link condition and flip test guard both criteria, so that every level is a valid mesh.
/// Cost: about (vertices x frames) to build, and per collapse some ten evaluations over all frames.
pub fn simplify(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    options: &LodOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<CollapseOrder> {
    validate::validate_mesh(mesh)?;
    validate::validate_poses(mesh, poses)?;
    let split = split_seams::split_seams(mesh);
    let classes = classify::classify_wedges(&split);
    let mut topology = topology::Topology::new(&split);
    let mut quadrics = quadrics::Quadrics::build(mesh, poses, &split, &classes.edge_kinds);
    let rules =
        criteria::Rules::new(mesh, poses, &split, options.criteria, &classes.non_manifold, &classes.wedge_class);
    let normals: Vec<[f32; 3]> = split.variant_source.iter().map(|&v| mesh.normals[v as usize]).collect();
    let steps = collapse::collapse_edges(&split, &normals, &mut topology, &mut quadrics, &rules, progress);
    drop(quadrics);
    let mut order = reorder::reorder_by_collapse(&split, &classes.wedge_class, &steps, classes.report);
    order.measured = measure::measure_levels(mesh, poses, &order, options);
    Ok(order)
}

/// Seams and classes alone, without simplifying: what `inspect` shows of a source asset.
///
/// The same under both criteria: [`Criteria::Wedge`] starts from the same seams and only tests them later.
///
/// # Errors
/// [`Error::Parameter`] when the slices disagree or hold indices or numbers that are not allowed.
pub fn classify(mesh: &LodMesh<'_>) -> Result<SeamReport> {
    validate::validate_mesh(mesh)?;
    Ok(classify::classify_wedges(&split_seams::split_seams(mesh)).report)
}
