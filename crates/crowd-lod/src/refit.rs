//! Moves the vertices of a level so that it lies as close as it can to full detail over the frames.
//!
//! One module a step: `full_detail` (with `charts`) and the level's `shape`; `pairs` and `rims` find which points belong
//! together; `pulls` says what is made least; `equations` and `solver` make it least, `fit_places` takes the step;
//! `fit_normals` and `fit_uvs` (by `fit_attributes`) follow.

mod charts;
mod equations;
mod fit_attributes;
mod fit_normals;
mod fit_places;
mod fit_uvs;
mod full_detail;
mod pairs;
mod pulls;
mod rims;
mod shape;
mod solver;
#[cfg(test)]
mod tests;

use crate::{CollapseOrder, Level, LevelMesh, LodMesh, LodPoses, level_mesh};
use full_detail::FullDetail;
use pairs::{Pair, Probes};
use rims::Rims;
use shape::Shape;

/// Points a side for each triangle of the level.
const POINTS_PER_TRIANGLE: u32 = 8;
/// Points a side at least and at most.
const LEAST_POINTS: u32 = 10_000;
const MOST_POINTS: u32 = 100_000;
/// Share of the mean squared distance that may be left: textures and tilts may cost some of what is won, not all.
const MOST_LEFT: f64 = 0.9;

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
        Self { frames: 24, rounds: 5 }
    }
}

/// The level with its places, normals and texture coordinates moved to lie closest to full detail over the frames.
///
/// `mesh` and `poses` are those that `order` was made from, `level` one of its levels. Connectivity and skinning stay as
/// they are. Vertices that share a place still share it afterwards, to the bit; no triangle turns over in a frame that
/// counts or in the texture, texture coordinates stay in their charts, and the mean squared distance, on points of its own
/// and both ways, never grows. Same bits for any number of threads.
///
/// Panics if an index lies outside its slice.
///
/// After Landreneau & Schaefer 2009: least squares over example poses, found anew in rounds. Departs: closest points both
/// ways instead of given counterparts; weights stay (see `docs/decisions/0015-refit.md`).
/// Cost: some 10 to 100 thousand closest points a side and round.
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
    let materials: Vec<u16> = fitted.vertices.iter().map(|&v| order.vertex_materials[v as usize]).collect();
    fit_shape(&full, &probes, &mut shape, &fitted, &materials, options.rounds);
    let (pairs, _) = probes.pair(&full, &shape, &shape.blend(&full.frames), true);
    let uvs = fit_uvs::fit_uvs(&full, &shape, &pairs, &materials, &fitted);
    fitted.normals = fit_normals::fit_normals(&full, &shape, &pairs, &fitted);
    fitted.uvs = uvs;
    shape.write(&mut fitted);
    fitted
}

/// Rounds of pairing and moving, as long as that makes the objective less. `materials`: of each vertex of the level.
fn fit_shape(
    full: &FullDetail<'_>,
    probes: &Probes,
    shape: &mut Shape,
    level: &LevelMesh,
    materials: &[u16],
    rounds: u32,
) {
    let matrices = shape.blend(&full.frames);
    let uprights = fit_places::Uprights::new(shape, &matrices);
    let rims = Rims::new(full, shape);
    let mut rim_pairs = rims.pair(shape);
    let (mut pairs, first_error) = probes.pair(full, shape, &matrices, false);
    for _ in 0..rounds {
        let corner_uvs = fit_corner_uvs(full, shape, level, materials, &pairs);
        let objective = |shape: &Shape, pairs: &[Pair], rim_error: f64| {
            pulls::objective(full, shape, &corner_uvs, &matrices, pairs) + pulls::RIM_SHARE * rim_error
        };
        let now = objective(shape, &pairs, rim_pairs.1);
        let moves = fit_places::solve_places(full, shape, &corner_uvs, &matrices, &pairs, &rim_pairs.0);
        let better = [1.0, 0.5, 0.25].into_iter().find_map(|step| {
            let moved = fit_places::move_places(shape, &matrices, &moves, step, &uprights)?;
            let (pairs, error) = probes.pair(full, &moved, &matrices, false);
            let rim_pairs = rims.pair(&moved);
            let less = objective(&moved, &pairs, rim_pairs.1) < now && error <= MOST_LEFT * first_error;
            less.then_some((moved, pairs, rim_pairs))
        });
        let Some(better) = better else { break };
        (*shape, pairs, rim_pairs) = better;
    }
}

/// Texture coordinates of each triangle's corners, as they would be fitted to the pairs.
fn fit_corner_uvs(
    full: &FullDetail<'_>,
    shape: &Shape,
    level: &LevelMesh,
    materials: &[u16],
    pairs: &[Pair],
) -> Vec<[[f32; 2]; 3]> {
    let uvs = fit_uvs::fit_uvs(full, shape, pairs, materials, level);
    level.triangles.iter().map(|t| t.map(|v| uvs[v as usize])).collect()
}
