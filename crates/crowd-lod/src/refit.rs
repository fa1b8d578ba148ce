//! Moves the vertices of a level so that it lies as close as it can to full detail over the frames.
//!
//! One module a step: `full_detail` (with `charts`) and the level's `shape`; `pairs` and `rims` (of `patches`) find which points belong
//! together; `held` says which places stay; `pulls` says what is made least; `equations` and `solver` make it least, `fit_places` takes the step; `fit_weights` fits
//! the skinning between the rounds and after them; `fit_normals` and `fit_uvs` (by `fit_attributes`) follow; `flips` turns edges between the rounds, `fit_colors` looks at the
//! textures, `turn_normals` at single angles, `repaint` at plain colours last.

mod charts;
mod equations;
mod fit_attributes;
mod fit_colors;
mod fit_normals;
mod fit_places;
mod fit_uvs;
mod fit_weights;
mod flips;
mod full_detail;
mod held;
mod pairs;
mod patches;
mod pulls;
mod repaint;
mod rims;
mod shape;
mod solver;
#[cfg(test)]
mod tests;
mod turn_normals;

use crate::quadrics::{dot, sub};
use crate::{CollapseOrder, Level, LevelMesh, LodMesh, LodPoses, Mat3x4, level_mesh};
use full_detail::FullDetail;
use pairs::{Pair, Probes, mix};
use patches::Patches;
use rims::Rims;
use shape::Shape;

/// Points a side for each triangle of the level.
const POINTS_PER_TRIANGLE: u32 = 8;
/// Points a side at least and at most.
const LEAST_POINTS: u32 = 10_000;
const MOST_POINTS: u32 = 100_000;
/// Normals see so many times as many, and at most: few points a vertex are met better than the surface between them.
const NORMAL_POINTS: u32 = 4;
const MOST_NORMAL_POINTS: u32 = 200_000;
/// Share of the mean squared distance that may be left: textures and tilts may cost some of what is won, not all.
const MOST_LEFT: f64 = 0.9;
/// Parts that the rounds fall into; between them edges are flipped.
const STAGE_COUNT: u32 = 3;
/// Passes of flips between two stages.
const FLIP_PASSES: u32 = 2;

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
        Self { frames: 24, rounds: 8 }
    }
}

/// The level with its places, skin weights, normals and texture coordinates moved to lie closest to full detail over the frames.
///
/// `mesh` and `poses` are those that `order` was made from, `level` one of its levels. Triangles stay
/// as they are, but that some pairs of one chart have their common edge turned to the other diagonal, and some get the colours of another material or chart; vertices stay,
/// but for those. Vertices that share a
/// place still share it afterwards, to the bit, and where they share the skinning they share the new one (at most four joints,
/// weights in steps of 1/65535); no triangle turns over in a frame that counts, or in the texture but where its chart
/// already does, texture coordinates stay in their charts but for such triangles, and the mean squared distance, on points of its own and both ways, never grows. Same bits
/// for any number of threads.
///
/// Panics if an index lies outside its slice.
///
/// After Landreneau & Schaefer 2009: least squares over example poses, found anew in rounds. Departs: closest points both
/// ways instead of given counterparts (see `docs/decisions/0015-refit.md` and `0021-refit-weights.md`).
/// Cost: some 10 to 100 thousand closest points a side and round.
pub fn refit(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    order: &CollapseOrder,
    level: &Level,
    options: &RefitOptions,
) -> LevelMesh {
    let level = level_mesh(mesh, order, level);
    if options.rounds == 0 || level.triangles.is_empty() {
        return level;
    }
    let full = FullDetail::new(mesh, poses, order, options.frames);
    let mut fit = Fit::new(&full, order, level);
    for stage in 0..STAGE_COUNT {
        if stage > 0 {
            (0..FLIP_PASSES).for_each(|_| fit.flip_edges());
        }
        if stage > 0 {
            fit.fit_weights();
            fit.repaint_patches();
        }
        let rounds = options.rounds * (stage + 1) / STAGE_COUNT - options.rounds * stage / STAGE_COUNT;
        fit.move_places(rounds);
    }
    fit.fit_weights();
    fit.finish()
}

/// A level while it is fitted.
struct Fit<'a> {
    full: &'a FullDetail<'a>,
    order: &'a CollapseOrder,
    /// As it was before the fit, but for flipped edges.
    level: LevelMesh,
    dress: Dress,
    shape: Shape,
    probes: Probes,
    /// The skins' matrices in each frame.
    matrices: Vec<Vec<Mat3x4>>,
    /// The pairs of the shape as it is, with its mean squared distance, faces that look another way too.
    paired: (Vec<Pair>, f64),
    uprights: fit_places::Uprights,
    /// Mean squared distance that a step has to come below.
    most_error: f64,
    /// Places that stay.
    held: Vec<bool>,
    /// What shows alike, with what was repainted by now.
    patches: Patches,
    /// How many times as much it costs where plain colours meet elsewhere.
    plain_factor: f32,
}

/// What the level's vertices have that no fit changes.
struct Dress {
    materials: Vec<u16>,
    /// Vertex colours, linear.
    tints: Vec<[f32; 3]>,
}

impl<'a> Fit<'a> {
    fn new(full: &'a FullDetail<'a>, order: &'a CollapseOrder, level: LevelMesh) -> Self {
        let shape = Shape::new(&level);
        let count = (level.triangles.len() as u32).saturating_mul(POINTS_PER_TRIANGLE).clamp(LEAST_POINTS, MOST_POINTS);
        let probes = Probes::new(full, &shape, count);
        let matrices = shape.blend(&full.frames);
        let dress = Dress {
            materials: level.vertices.iter().map(|&v| order.vertex_materials[v as usize]).collect(),
            tints: level.vertices.iter().map(|&v| full.tint(order.attribute_source[v as usize])).collect(),
        };
        let uprights = fit_places::Uprights::new(&shape, &matrices);
        let paired = probes.pair(full, &shape, &matrices, false);
        let error = paired.1;
        let held = held::find_held(&shape, &paired.0, error);
        let most_error = MOST_LEFT * error;
        let patches = Patches::new(full, shape.triangles.len());
        let mut fit = Self {
            full,
            order,
            level,
            dress,
            shape,
            probes,
            matrices,
            paired,
            uprights,
            most_error,
            held,
            patches,
            plain_factor: 0.0,
        };
        fit.plain_factor = rims::find_plain_factor(full, error, fit.colors_off());
        fit
    }

    /// Mean squared difference of the colours shown, textures too, of 1 between black and white; 0 where no two plain ones differ, and nobody asks.
    fn colors_off(&self) -> f64 {
        if !self.patches.can_repaint() {
            return 0.0;
        }
        let Self { full, level, dress, .. } = self;
        let off = |pair: &Pair| {
            let corners = level.triangles[pair.triangle as usize];
            let uvs = corners.map(|v| level.uvs[v as usize]);
            let uv = [0, 1].map(|i| (0..3).map(|k| uvs[k][i] * pair.weights[k]).sum());
            let tint = mix(corners.map(|v| dress.tints[v as usize]), pair.weights);
            let shown = full.color(dress.materials[corners[0] as usize], uv, tint);
            let off = sub(shown, full.color_in(pair.full_triangle, pair.full_weights));
            f64::from(pair.share * dot(off, off) / 3.0)
        };
        let (seen, _) = self.probes.pair(full, &self.shape, &self.matrices, true);
        seen.iter().map(off).sum::<f64>() / 2.0
    }

    /// Finds the triangles that would be repainted as things are, so that rims are drawn to what will be seen; but for those few that will find no room
    /// for vertices of their own.
    fn repaint_patches(&mut self) {
        if !self.patches.can_repaint() {
            return;
        }
        let mut level = self.level.clone();
        self.shape.write(&mut level);
        let pairs = self.probes.pair_seen(self.full, &self.shape, &self.matrices);
        let looks = repaint::find_looks(self.full, self.order, &pairs, &level);
        self.patches = Patches::new(self.full, self.shape.triangles.len());
        self.patches.repaint(self.full, &looks);
    }

    /// Rounds of pairing and moving, as long as that makes the objective less.
    fn move_places(&mut self, rounds: u32) {
        let Self { full, probes, matrices, .. } = self;
        let rims = Rims::new(full, &self.shape, &self.patches, self.plain_factor);
        let mut rim_pairs = rims.pair(&self.shape);
        for _ in 0..rounds {
            let pairs = self.paired.0.as_slice();
            let uvs = fit_uvs::fit_uvs(full, &self.shape, pairs, &self.dress.materials, &self.level);
            let corner_uvs: Vec<[[f32; 2]; 3]> =
                self.level.triangles.iter().map(|t| t.map(|v| uvs[v as usize])).collect();
            let objective = |shape: &Shape, pairs: &[Pair], rim_cost: f64| {
                pulls::objective(full, shape, &corner_uvs, matrices, pairs) + rim_cost
            };
            let now = objective(&self.shape, pairs, rim_pairs.1);
            let pulls = (pairs, rim_pairs.0.as_slice());
            let moves = fit_places::solve_places(full, &self.shape, &corner_uvs, matrices, pulls, &self.held);
            let better = [1.0, 0.5, 0.25].into_iter().find_map(|step| {
                let moved = fit_places::move_places(&self.shape, matrices, &moves, step, &self.uprights)?;
                let paired = probes.pair(full, &moved, matrices, false);
                let rim_pairs = rims.pair(&moved);
                let less = objective(&moved, &paired.0, rim_pairs.1) < now && paired.1 <= self.most_error;
                less.then_some((moved, paired, rim_pairs))
            });
            let Some(better) = better else { break };
            (self.shape, self.paired, rim_pairs) = better;
        }
    }

    /// One pass over the weights, taken back where it does not make the objective less.
    fn fit_weights(&mut self) {
        let Self { full, probes, matrices, .. } = self;
        let (pairs, before) = &self.paired;
        let uvs = fit_uvs::fit_uvs(full, &self.shape, pairs, &self.dress.materials, &self.level);
        let corner_uvs: Vec<[[f32; 2]; 3]> = self.level.triangles.iter().map(|t| t.map(|v| uvs[v as usize])).collect();
        let now = pulls::objective(full, &self.shape, &corner_uvs, matrices, pairs);
        let fitted = fit_weights::fit_weights(full, &self.shape, &corner_uvs, matrices, pairs, &self.uprights);
        let Some((shape, fitted)) = fitted else { return };
        let paired = probes.pair(full, &shape, &fitted, false);
        let less = pulls::objective(full, &shape, &corner_uvs, &fitted, &paired.0) < now;
        if less && paired.1 <= before.max(self.most_error) {
            (self.shape, self.matrices, self.paired) = (shape, fitted, paired);
        }
    }

    /// One pass of flips, taken back where the distance would grow beyond what is allowed.
    fn flip_edges(&mut self) {
        let Self { full, probes, matrices, .. } = self;
        let (pairs, _) = probes.pair(full, &self.shape, matrices, true);
        let level = LevelMesh {
            uvs: fit_uvs::fit_uvs(full, &self.shape, &pairs, &self.dress.materials, &self.level),
            normals: fit_normals::fit_normals(full, &self.shape, &pairs, &self.level),
            ..self.level.clone()
        };
        let turned = flips::flip_edges(full, &self.shape, &level, &self.level.uvs, &self.dress, matrices, &pairs);
        if turned.is_empty() {
            return;
        }
        let mut shape = self.shape.clone();
        for &(t, corners) in &turned {
            shape.triangles[t] = corners.map(|v| shape.skin_of[v as usize]);
        }
        let paired = probes.pair(full, &shape, matrices, false);
        if paired.1 > self.paired.1.max(self.most_error) {
            return;
        }
        (self.shape, self.paired) = (shape, paired);
        turned.iter().for_each(|&(t, corners)| self.level.triangles[t] = corners);
        self.uprights.renew(&self.shape, matrices, &turned);
    }

    /// The level with everything moved.
    fn finish(self) -> LevelMesh {
        let Self { full, order, shape, mut level, dress, .. } = self;
        let (pairs, _) = self.probes.pair(full, &shape, &self.matrices, true);
        let uvs = fit_uvs::fit_uvs(full, &shape, &pairs, &dress.materials, &level);
        let uvs = fit_colors::fit_colors(full, &shape, &pairs, &dress, &level, &uvs);
        let count = (self.probes.count() * NORMAL_POINTS).min(MOST_NORMAL_POINTS);
        let (close, _) = Probes::new(full, &shape, count).pair(full, &shape, &self.matrices, true);
        level.normals = fit_normals::fit_and_turn(full, &shape, &close, &self.matrices, &level);
        level.uvs = uvs;
        shape.write(&mut level);
        repaint::repaint(full, order, &self.probes.pair_seen(full, &shape, &self.matrices), &mut level);
        level
    }
}
