//! Turns single normals to where the mean angle to full detail's is least, in the frames.
//!
//! Least squares sees vectors that are interpolated, not the directions that are shown, and the few pairs across a fold pull all around
//! them; here a direction counts by how far it is off, not by the square of that (decision 0084). Weighed anew by the inverse of its error: Weiszfeld 1937.

use super::fit_normals::{Unknowns, unit};
use super::full_detail::FullDetail;
use super::pairs::Pair;
use super::shape::{Shape, Skin, blend_skin};
use crate::Mat3x4;
use rayon::prelude::*;

/// Sweeps over all normals at most.
const SWEEP_COUNT: usize = 8;
/// Errors well below this (a tenth of a degree) count by their square: the weights grow without limit where a pair is met.
const SMALL_ERROR: f64 = 0.002;
/// Steps that are tried, in shares of what the linear system says.
const STEPS: [f64; 3] = [1.0, 0.5, 0.2];
/// What a step has to save, as a share: pairs are a sample, not the surface.
const LEAST_GAIN: f64 = 1.0e-3;
/// Holds a normal a little where it is, relative to the mean pull of its own pairs.
const DAMPING: f64 = 1.0e-3;

/// What a skin does to normals in a frame.
type Turn = [[f32; 3]; 3];

/// A direction wanted at a point of the level, in a frame.
#[derive(Debug, Clone, Copy)]
struct Aim {
    frame: u32,
    triangle: u32,
    weights: [f32; 3],
    /// Unit length.
    wanted: [f32; 3],
    share: f32,
}

/// What is held against each other.
pub(crate) struct Aims<'a> {
    shape: &'a Shape,
    /// Unknowns at the corners of each triangle.
    corners: &'a [[u32; 3]],
    aims: Vec<Aim>,
    /// By frame and skin.
    turns: Vec<Vec<Turn>>,
}

impl<'a> Aims<'a> {
    /// `pairs`: of faces that look the same way. `matrices`: of the shape's skins, by frame.
    pub fn new(
        full: &FullDetail<'_>,
        shape: &'a Shape,
        unknowns: &'a Unknowns,
        matrices: &[Vec<Mat3x4>],
        pairs: &[Pair],
    ) -> Self {
        let turns = matrices.par_iter().map(|m| m.iter().map(turn_of).collect()).collect();
        let aim = |pair: &Pair| {
            let palette = full.frames[pair.frame as usize].palette;
            let mut sum = [0.0; 3];
            for (k, v) in full.triangles[pair.full_triangle as usize].map(|v| v as usize).into_iter().enumerate() {
                let skin = Skin { place: 0, joints: full.mesh.joints[v], weights: full.mesh.weights[v] };
                let turned = apply(&turn_of(&blend_skin(&skin, palette)), full.mesh.normals[v].map(f64::from));
                sum = add(sum, unit(turned)?, f64::from(pair.full_weights[k]));
            }
            let wanted = unit(sum)?.map(|c| c as f32);
            let Pair { frame, triangle, weights, share, .. } = *pair;
            Some(Aim { frame, triangle, weights, wanted, share })
        };
        let aims = pairs.par_iter().filter_map(aim).collect();
        Self { shape, corners: &unknowns.corners, aims, turns }
    }

    fn turn(&self, aim: &Aim, corner: usize) -> &Turn {
        &self.turns[aim.frame as usize][self.shape.triangles[aim.triangle as usize][corner] as usize]
    }

    /// What the level shows at an aim, of any length.
    fn shown(&self, aim: &Aim, normals: &[[f64; 3]]) -> [f64; 3] {
        let corners = self.corners[aim.triangle as usize];
        (0..3).fold([0.0; 3], |sum, k| {
            add(sum, apply(self.turn(aim, k), normals[corners[k] as usize]), f64::from(aim.weights[k]))
        })
    }

    /// `fitted` with single normals turned so that the mean distance between the unit directions shown and wanted falls. `first`:
    /// what they are without any fit; each is tried too. What is not of unit length stays.
    pub fn turn_normals(&self, first: &[[f64; 3]], fitted: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (offsets, around) = self.aims_around(fitted.len());
        let mut now = fitted.to_vec();
        let mut sums: Vec<[f64; 3]> = self.aims.par_iter().map(|aim| self.shown(aim, &now)).collect();
        // Where nothing around a normal has turned since, a look would find what it found.
        let mut awake = vec![true; now.len()];
        for sweep in 0..SWEEP_COUNT {
            let mut any = false;
            for g in 0..now.len() {
                let own = &around[offsets[g]..offsets[g + 1]];
                if own.is_empty() || !awake[g] || !is_unit(now[g]) {
                    continue;
                }
                awake[g] = false;
                let moved = |n: [f64; 3], &(i, k): &(u32, u8)| {
                    let aim = &self.aims[i as usize];
                    let step = apply(self.turn(aim, usize::from(k)), sub(n, now[g]));
                    add(sums[i as usize], step, f64::from(aim.weights[usize::from(k)]))
                };
                let cost = |n: [f64; 3]| -> f64 {
                    let one = |own: &(u32, u8)| {
                        let aim = &self.aims[own.0 as usize];
                        f64::from(aim.share) * off(moved(n, own), aim)
                    };
                    own.iter().map(one).sum()
                };
                let mut best = (cost(now[g]) * (1.0 - LEAST_GAIN), None);
                if sweep == 0 && is_unit(first[g]) {
                    let as_it_was = cost(first[g]);
                    if as_it_was < best.0 {
                        best = (as_it_was, Some(first[g]));
                    }
                }
                let step = self.step_of(now[g], own, &sums);
                for share in STEPS {
                    let Some(turned) = unit(add(now[g], step, share)) else { continue };
                    let after = cost(turned);
                    if after < best.0 {
                        best = (after, Some(turned));
                        break;
                    }
                }
                if let Some(turned) = best.1 {
                    let new: Vec<[f64; 3]> = own.iter().map(|own| moved(turned, own)).collect();
                    own.iter().zip(new).for_each(|(&(i, _), sum)| sums[i as usize] = sum);
                    now[g] = turned;
                    for &(i, _) in own {
                        let corners = self.corners[self.aims[i as usize].triangle as usize];
                        corners.iter().for_each(|&g| awake[g as usize] = true);
                    }
                    any = true;
                }
            }
            if !any {
                break;
            }
        }
        now
    }

    /// The step along its tangents that makes the weighed squares of one normal's aims least, with all other normals held.
    fn step_of(&self, normal: [f64; 3], own: &[(u32, u8)], sums: &[[f64; 3]]) -> [f64; 3] {
        let (mut matrix, mut right, mut pull) = ([[0.0; 3]; 3], [0.0; 3], 0.0);
        for &(i, k) in own {
            let (aim, sum, k) = (&self.aims[i as usize], sums[i as usize], usize::from(k));
            let Some(shown) = unit(sum) else { continue };
            let slope = f64::from(aim.weights[k]) / dot(sum, sum).sqrt();
            let error = sub(shown, aim.wanted.map(f64::from));
            let heed = f64::from(aim.share) / (dot(error, error).sqrt() + SMALL_ERROR);
            // Columns of how what is shown changes with the normal: across itself alone.
            let turn = self.turn(aim, k);
            let columns = [0, 1, 2].map(|c| {
                let column = [0, 1, 2].map(|r| f64::from(turn[r][c]));
                add(column, shown, -dot(column, shown)).map(|c| c * slope)
            });
            for a in 0..3 {
                right[a] -= heed * dot(columns[a], error);
                for b in 0..3 {
                    matrix[a][b] += heed * dot(columns[a], columns[b]);
                }
            }
            pull += heed * slope * slope;
        }
        for a in 0..3 {
            for b in 0..3 {
                matrix[a][b] += pull * normal[a] * normal[b];
            }
            matrix[a][a] += DAMPING * pull;
        }
        let Some(step) = solve(matrix, right) else { return [0.0; 3] };
        add(step, normal, -dot(step, normal))
    }

    /// For each unknown the aims that it takes part in, with its corner: offsets, and these.
    fn aims_around(&self, count: usize) -> (Vec<usize>, Vec<(u32, u8)>) {
        let mut offsets = vec![0_usize; count + 1];
        let corners = |aim: &Aim| self.corners[aim.triangle as usize].map(|g| g as usize);
        for aim in &self.aims {
            corners(aim).iter().for_each(|&g| offsets[g + 1] += 1);
        }
        (0..count).for_each(|g| offsets[g + 1] += offsets[g]);
        let (mut next, mut around) = (offsets.clone(), vec![(0, 0); self.aims.len() * 3]);
        for (i, aim) in self.aims.iter().enumerate() {
            for (k, g) in corners(aim).into_iter().enumerate() {
                around[next[g]] = (i as u32, k as u8);
                next[g] += 1;
            }
        }
        (offsets, around)
    }
}

/// Distance between a direction of any length and the one wanted.
fn off(sum: [f64; 3], aim: &Aim) -> f64 {
    let Some(shown) = unit(sum) else { return 1.0 };
    let error = sub(shown, aim.wanted.map(f64::from));
    dot(error, error).sqrt()
}

/// Cofactors of a matrix, so that normals stay perpendicular under uneven scale and outside under mirroring; of about unit length.
fn turn_of(m: &Mat3x4) -> Turn {
    let [a, b, c] = m.map(|row| [0, 1, 2].map(|i| f64::from(row[i])));
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let sign = if dot(a, rows[0]) < 0.0 { -1.0 } else { 1.0 };
    let size = (rows.iter().map(|&r| dot(r, r)).sum::<f64>() / 3.0).sqrt();
    let scale = if size > 0.0 { sign / size } else { 0.0 };
    rows.map(|row| row.map(|c| (c * scale) as f32))
}

fn apply(turn: &Turn, n: [f64; 3]) -> [f64; 3] {
    turn.map(|row| dot(row.map(f64::from), n))
}

/// By Cramer's rule; `None` where there is nothing to solve.
fn solve(m: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let crossed = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let volume = dot(m[0], crossed[0]);
    let out = [0, 1, 2].map(|i| (0..3).map(|k| crossed[k][i] * right[k]).sum::<f64>() / volume);
    out.iter().all(|c| c.is_finite()).then_some(out)
}

fn is_unit(v: [f64; 3]) -> bool {
    (dot(v, v) - 1.0).abs() < 1.0e-3
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a` and `share` times `b`.
fn add(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refit::pairs::Probes;
    use crate::test_meshes::{REST, TestMesh, TestPoses, grid, quick};
    use crate::{LevelMesh, level_mesh, simplify};

    const UP: [f64; 3] = [0.0, 0.0, 1.0];
    const AWRY: [f64; 3] = [0.6, 0.0, 0.8];

    /// A sheet at full detail, its level skinned as `dress` says, and what comes of it with `awry` of its aims turned away.
    fn turned(poses: &TestPoses, dress: impl Fn(&mut LevelMesh), awry: usize, normals: [[f64; 3]; 2]) -> Vec<[f64; 3]> {
        let mut mesh: TestMesh = grid(6, 6, |_, _| 0.0, |_, _| false);
        mesh.normals.fill([0.0, 0.0, 1.0]);
        let (lod_mesh, poses) = (mesh.mesh(), poses.poses());
        let order = simplify(&lod_mesh, &poses, &quick(), &|_| ()).expect("a valid mesh");
        let mut level = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        dress(&mut level);
        let full = FullDetail::new(&lod_mesh, &poses, &order, 8);
        let shape = Shape::new(&level);
        let matrices = shape.blend(&full.frames);
        let (pairs, _) = Probes::new(&full, &shape, 4000).pair(&full, &shape, &matrices, true);
        let unknowns = Unknowns::new(&shape, &level);
        let mut aims = Aims::new(&full, &shape, &unknowns, &matrices, &pairs);
        aims.aims.iter_mut().step_by(10).take(awry).for_each(|aim| aim.wanted = [1.0, 0.0, 0.0]);
        let count = level.normals.len();
        aims.turn_normals(&vec![normals[0]; count], &vec![normals[1]; count])
    }

    fn off_by(normals: &[[f64; 3]], wanted: [f64; 3]) -> f64 {
        normals.iter().map(|&n| dot(sub(n, wanted), sub(n, wanted)).sqrt()).fold(0.0, f64::max)
    }

    #[test]
    fn a_tenth_of_the_pairs_across_a_fold_turns_nothing() {
        let found = turned(&TestPoses::rest(), |_| (), usize::MAX, [AWRY, AWRY]);
        assert!(off_by(&found, UP) < 0.01, "{}", off_by(&found, UP));
        let found = turned(&TestPoses::rest(), |_| (), usize::MAX, [UP, AWRY]);
        assert!(off_by(&found, UP) < 0.002, "what was there before is tried: {}", off_by(&found, UP));
    }

    #[test]
    fn normals_are_right_in_the_frames_where_the_level_is_skinned_otherwise() {
        let (sine, cosine) = (libm::sinf(0.2), libm::cosf(0.2));
        let tilted = [[1.0, 0.0, 0.0, 0.0], [0.0, cosine, -sine, 0.0], [0.0, sine, cosine, 0.0]];
        let poses = TestPoses::even(vec![REST, tilted], 2);
        let on_second = |level: &mut LevelMesh| level.joints.fill([1, 0, 0, 0]);
        let found = turned(&poses, on_second, 0, [UP, UP]);
        let wanted = [0.0, f64::from(sine), f64::from(cosine)];
        assert!(off_by(&found, wanted) < 0.01, "{:?} instead of {wanted:?}", found[0]);
    }

    #[test]
    fn what_points_nowhere_stays() {
        let flat = [[0.0; 4]; 3];
        for palettes in [vec![flat], vec![REST, flat]] {
            let poses = TestPoses::even(palettes, 1);
            assert!(off_by(&turned(&poses, |_| (), 0, [[0.0; 3]; 2]), [0.0; 3]) == 0.0);
            assert!(off_by(&turned(&poses, |_| (), 0, [UP, UP]), UP) < 1.0e-6);
        }
    }
}
