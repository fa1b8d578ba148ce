//! A mesh and its poses in, a collapse order out, and how far its levels lie from full detail.
//!
//! Follows Peng, Park, Cao, Tian 2011 §4: split vertices along UV seams, classify them as fixed, companioned or regular,
//! collapse half-edges in the order of a quadric error averaged over all frames of all clips. The default criteria charge
//! what the paper forbids (see [`Criteria::Wedge`]).
//! What it leaves to others: files (`crowd-source`), sampling (`crowd-anim`), layout (`crowd-pack`).
//!
//! One module a step: `split_seams` (with `separate_layers` and `duplicate_triangles`), `classify`, `frames` (with `align`),
//! `quadrics`, `attributes`, `behind`, `criteria`, `layer_gaps`, `volumes`, `symmetry`, `collapse` (on a `topology`, with `fan` and `find_images`),
//! `reorder`, `reform`, `check_frames`, `level_mesh`, `refit`, `measure`, `choose_levels`, `worst_frames`, `worse_frames`, `measure_surfaces`,
//! `interpenetration`. `lists` is what several fill by counting.

mod align;
mod attributes;
mod behind;
mod check_frames;
mod choose_levels;
mod classify;
mod closest;
mod collapse;
mod criteria;
mod distances;
mod duplicate_triangles;
mod fan;
mod find_images;
mod frames;
#[cfg(test)]
mod hostile_tests;
mod interpenetration;
mod layer_gaps;
mod level_mesh;
#[cfg(test)]
mod lib_tests;
mod lists;
mod measure;
mod measure_surfaces;
#[cfg(test)]
mod mirror_tests;
mod quadrics;
mod refit;
mod reform;
mod reorder;
mod separate_layers;
mod split_seams;
mod symmetry;
#[cfg(test)]
mod test_meshes;
mod topology;
mod types;
mod validate;
mod volumes;
mod worse_frames;
mod worst_frames;

pub use choose_levels::geometric_levels;
pub use distances::distances_to_surface;
pub use interpenetration::{Interpenetration, LayeredMesh, find_layers, measure_interpenetration};
pub use level_mesh::{LevelMesh, level_mesh};
pub use measure::{measure_level, measured_frames};
pub use measure_surfaces::{LevelSurface, Surface, SurfaceError, SurfaceMeasure, measure_surfaces};
pub use refit::{RefitOptions, refit};
pub use reform::reform;
pub use types::*;
pub use worse_frames::worse_frames;
pub use worst_frames::worst_frames;

/// Times that an order is made anew, with frames added, before a check that still fails is only reported.
const MAX_RERUNS: u32 = 2;

/// Simplifies a mesh, down to where `options` ends it or nothing may collapse any more, and returns the whole order.
///
/// The cost of a collapse is the quadric error averaged over frames of `poses`, by their weights; which frames, `options`
/// says. `progress` is called now and then with the share done, 0..=1, from one thread. A mesh without triangles gives an
/// order with one empty level.
///
/// # Errors
/// [`Error::Parameter`] when the slices disagree or hold indices or numbers that are not allowed, and when the frames would
/// take more memory than is allowed.
///
/// Paper: Peng 2011 §4, attributes by Hoppe 1999. Departs: a flip test guards both criteria, a link condition [`Criteria::Peng2011`],
/// so that every level is a valid mesh.
/// Cost: about (vertices x frames that count) to build, and per collapse some ten evaluations over those frames; twice or
/// three times that when the check of [`FrameChoice::Auto`] fails.
pub fn simplify(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    options: &LodOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> Result<CollapseOrder> {
    validate::validate_mesh(mesh)?;
    validate::validate_poses(mesh, poses)?;
    let weights = frames::multiply_weights(poses.frame_weights, &options.frame_factors)?;
    let poses = &LodPoses { frame_weights: &weights, ..*poses };
    let split = split_seams::split_seams(mesh);
    let (classes, partners) = rayon::join(
        || classify::classify_wedges(&split),
        || match options.criteria {
            Criteria::Wedge => symmetry::find_partners(&split.bind_places(mesh)),
            Criteria::Peng2011 => vec![symmetry::NO_PARTNER; split.position_source.len()],
        },
    );
    let (mut chosen, portraits) = frames::choose_frames(mesh, poses, &split, options.frames);
    let mut report = FrameReport { given: poses.frame_weights.len() as u32, ..FrameReport::default() };
    let mut order = loop {
        validate::validate_frame_memory(split.position_source.len(), chosen.frames.len())?;
        let order = collapse(mesh, &chosen.poses(), &split, &classes, &partners, options, progress);
        let Some(portraits) = &portraits else { break order };
        let errors = check_frames::measure_all_frames(mesh, poses, &order);
        let check = errors.check(poses, &chosen);
        report.check = Some(check);
        if check.holds || report.rerun_count == MAX_RERUNS {
            break order;
        }
        let added = errors.frames_to_add(poses, &chosen);
        chosen = portraits.stand_for_all(poses, [chosen.frames, added].concat());
        report.rerun_count += 1;
    };
    report.used = chosen.frames.len() as u32;
    order.frames = report;
    Ok(order)
}

/// Seams, classes, mirror images and frames in, the order out.
fn collapse(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    split: &split_seams::SplitMesh,
    classes: &classify::Classes,
    partners: &[u32],
    options: &LodOptions,
    progress: &(dyn Fn(f32) + Sync),
) -> CollapseOrder {
    let mut split = split.clone();
    let rules =
        criteria::Rules::new(mesh, poses, &split, options.criteria, &classes.non_manifold, &classes.wedge_class);
    let minded = match options.criteria {
        Criteria::Wedge => options.attribute_weights,
        Criteria::Peng2011 => AttributeWeights { uv: 0.0, normal: 0.0, color: 0.0, layers: 0.0 },
    };
    let some_poses = rules.some_poses();
    let diagonal = behind::diagonal(&some_poses[0]);
    // Part of the second is work for one thread alone: it is done beside the first, which is work for all.
    let (mut quadrics, (mut topology, mut attributes)) = rayon::join(
        || quadrics::Quadrics::build(mesh, poses, &split, &classes.edge_kinds, options.criteria),
        || (topology::Topology::new(&split), attributes::Attributes::build(mesh, &split, &minded, diagonal)),
    );
    let mut behind = match options.criteria {
        Criteria::Wedge => behind::Behind::measure(mesh, &split, partners, some_poses, &minded, diagonal),
        Criteria::Peng2011 => behind::Behind::default(),
    };
    let mut normals: Vec<[f32; 3]> = split.variant_source.iter().map(|&v| mesh.normals[v as usize]).collect();
    let mut posed = rules.poses();
    let bind = posed.remove(0);
    let mut gaps = layer_gaps::LayerGaps::find(&topology, &bind, posed, minded.layers);
    let surface = collapse::Surface {
        partners,
        gaps: &mut gaps,
        split: &mut split,
        normals: &mut normals,
        topology: &mut topology,
        quadrics: &mut quadrics,
        attributes: &mut attributes,
        behind: &mut behind,
    };
    let ends_at = options.coarsest.triangles(surface.topology.alive_count);
    let steps = collapse::collapse_edges(surface, &rules, ends_at, progress);
    reorder::reorder_by_collapse(&split, &classes.wedge_class, &steps, classes.report.clone())
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
