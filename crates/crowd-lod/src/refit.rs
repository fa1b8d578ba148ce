//! Moves the vertices of a level so that it lies as close as it can to full detail over the frames.

mod charts;
mod fit_attributes;
mod fit_normals;
mod fit_places;
mod fit_uvs;
mod full_detail;
mod pairs;
mod shape;
#[cfg(test)]
mod tests;

use crate::{CollapseOrder, Level, LevelMesh, LodMesh, LodPoses, level_mesh};
use charts::Charts;
use full_detail::FullDetail;
use pairs::Probes;
use shape::Shape;

/// Points a side for each triangle of the level.
const POINTS_PER_TRIANGLE: u32 = 8;
/// Points a side at least and at most.
const LEAST_POINTS: u32 = 10_000;
const MOST_POINTS: u32 = 100_000;

/// Knobs of [`refit`].
#[derive(Debug, Clone, PartialEq)]
pub struct RefitOptions {
    /// Frames that count, drawn evenly along the weights of the poses given.
    pub frames: u32,
    /// Rounds of finding the closest points and moving the vertices towards them. 0 leaves the level as it is.
    pub rounds: u32,
}

impl Default for RefitOptions {
    fn default() -> Self {
        Self { frames: 24, rounds: 6 }
    }
}

/// The level with places, normals, texture coordinates and skinning moved to lie closest to full detail over the frames.
///
/// `mesh` and `poses` are those that `order` was made from, `level` one of its levels. Connectivity stays as it is.
/// Vertices that share place and skinning still share them afterwards, to the bit.
///
/// Panics if an index lies outside its slice.
pub fn refit(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    order: &CollapseOrder,
    level: &Level,
    options: &RefitOptions,
) -> LevelMesh {
    let mut fitted = level_mesh(mesh, order, level);
    if options.rounds == 0 || fitted.triangles.is_empty() {
        return fitted;
    }
    let full = FullDetail::new(mesh, poses, order, options.frames);
    let mut shape = Shape::new(&fitted);
    let count = (fitted.triangles.len() as u32).saturating_mul(POINTS_PER_TRIANGLE).clamp(LEAST_POINTS, MOST_POINTS);
    let probes = Probes::new(&full, &shape, count);
    fit_shape(&full, &probes, &mut shape, options.rounds);
    shape.write(&mut fitted);
    let (pairs, _) = probes.pair(&full, &shape, &shape.blend(&full.frames), true);
    fit_normals::fit_normals(&full, &shape, &pairs, &mut fitted);
    let materials: Vec<u16> = order.triangle_source.iter().map(|&t| mesh.triangle_materials[t as usize]).collect();
    let charts = Charts::new(mesh, &full.triangles, &materials);
    let materials: Vec<u16> = fitted.vertices.iter().map(|&v| order.vertex_materials[v as usize]).collect();
    fit_uvs::fit_uvs(&full, &charts, &shape, &pairs, &materials, &mut fitted);
    fitted
}

/// Rounds of pairing and moving, as long as the level comes closer.
fn fit_shape(full: &FullDetail<'_>, probes: &Probes, shape: &mut Shape, rounds: u32) {
    let matrices = shape.blend(&full.frames);
    let uprights = fit_places::Uprights::new(shape, &matrices);
    let (mut pairs, mut error) = probes.pair(full, shape, &matrices, false);
    for _ in 0..rounds {
        let moves = fit_places::solve_places(shape, &matrices, &pairs);
        let closer = [1.0, 0.5, 0.25].into_iter().find_map(|step| {
            let moved = fit_places::move_places(shape, &matrices, &moves, step, &uprights)?;
            let (pairs, moved_error) = probes.pair(full, &moved, &matrices, false);
            (moved_error < error).then_some((moved, pairs, moved_error))
        });
        let Some((moved, moved_pairs, moved_error)) = closer else { break };
        *shape = moved;
        (pairs, error) = (moved_pairs, moved_error);
    }
}
