//! Fits the skin weights of a level by least squares over its pairs: places given, one skin after the other.
//!
//! A vertex of the level stands for many of full detail, and what moves it should be a mean of what moves them.

use super::equations::{SLIDE_SHARE, stiffness};
use super::fit_places::Uprights;
use super::full_detail::FullDetail;
use super::pairs::Pair;
use super::pulls::slide;
use super::shape::{Shape, Skin, blend_skin, transform};
use crate::Mat3x4;
use crate::quadrics::{dot, sub};
use rayon::prelude::*;

/// Joints that a skin chooses among at most.
const CANDIDATES: usize = 8;
/// Joints that a skin keeps at most: as many as are stored.
const KEPT: usize = 4;
/// A joint is chosen among when it has at least this share in moving the points that a skin stands for.
const LEAST_INFLUENCE: f64 = 0.02;
/// Pull back to the weights that a skin has, relative to the mean pull on one of its weights.
const KEEP_SHARE: f64 = 0.02;
/// Passes over all skins: each sees what its neighbours have become.
const SWEEPS: u32 = 3;
/// Exchanges between two weights until the best ones are found.
const EXCHANGES: u32 = 60;
/// Times as far, squared, as in the frames that count may new weights move a skin in the others.
const MOST_STEP_SQUARED: f32 = 1.5;
/// Steps from weight 0 to 1 as they are stored.
const STORED_STEPS: f64 = 65_535.0;

/// The shape with weights fitted, and its skins' matrices; `None` where none becomes better.
pub(crate) fn fit_weights(
    full: &FullDetail<'_>,
    shape: &Shape,
    corner_uvs: &[[[f32; 2]; 3]],
    matrices: &[Vec<Mat3x4>],
    pairs: &[Pair],
    uprights: &Uprights,
) -> Option<(Shape, Vec<Vec<Mat3x4>>)> {
    let mut pulls: Vec<Pull> =
        pairs.iter().map(|pair| Pull::new(full, &corner_uvs[pair.triangle as usize], pair)).collect();
    let of_skin = pairs_of_skins(shape, pairs);
    let candidates: Vec<Vec<u16>> =
        (0..shape.skins.len()).map(|s| find_candidates(full, &shape.skins[s], pairs, &of_skin[s])).collect();
    let (mut fitted, mut moved) = (shape.clone(), matrices.to_vec());
    let mut changed = vec![false; shape.skins.len()];
    for _ in 0..SWEEPS {
        for s in 0..shape.skins.len() {
            let skin = fitted.skins[s];
            let Some(better) =
                fit_skin(full, &skin, shape.places[skin.place as usize], &candidates[s], pairs, &pulls, &of_skin[s])
            else {
                continue;
            };
            changed[s] = true;
            replace(full, &mut fitted, &mut moved, s, better, pairs, &mut pulls, &of_skin[s]);
        }
    }
    let wander = |&s: &usize| changed[s] && wanders(full, shape, &shape.skins[s], &fitted.skins[s]);
    let wandering: Vec<usize> = (0..shape.skins.len()).into_par_iter().filter(wander).collect();
    for s in wandering {
        put_back(s, shape, matrices, &mut fitted, &mut moved, &mut changed);
    }
    // Where a triangle turns over in some frame, its corners stay as they were.
    loop {
        let turned = uprights.turned(&fitted, &moved);
        let back: Vec<usize> =
            turned.iter().flat_map(|&t| fitted.triangles[t]).map(|s| s as usize).filter(|&s| changed[s]).collect();
        if turned.is_empty() {
            break;
        } else if back.is_empty() {
            return None;
        }
        for s in back {
            put_back(s, shape, matrices, &mut fitted, &mut moved, &mut changed);
        }
    }
    changed.contains(&true).then_some((fitted, moved))
}

/// Gives a skin the weights back that it had.
fn put_back(
    s: usize,
    shape: &Shape,
    matrices: &[Vec<Mat3x4>],
    fitted: &mut Shape,
    moved: &mut [Vec<Mat3x4>],
    changed: &mut [bool],
) {
    changed[s] = false;
    fitted.skins[s] = shape.skins[s];
    moved.iter_mut().zip(matrices).for_each(|(moved, before)| moved[s] = before[s]);
}

/// Whether new weights move a skin in some frame further than they do in any of those that count: what they do there is
/// chance.
fn wanders(full: &FullDetail<'_>, shape: &Shape, before: &Skin, after: &Skin) -> bool {
    let place = shape.places[before.place as usize];
    let step = |palette: &[Mat3x4]| {
        let way = sub(transform(&blend_skin(after, palette), place), transform(&blend_skin(before, palette), place));
        dot(way, way)
    };
    let seen = full.frames.iter().map(|frame| step(frame.palette)).fold(0.0, f32::max);
    full.poses
        .palettes
        .chunks_exact(full.poses.joint_count.max(1))
        .any(|palette| step(palette) > MOST_STEP_SQUARED * seen)
}

/// How a pair pulls at its point, in its frame.
struct Pull {
    stiffness: [[f64; 3]; 3],
    /// What pushes the point away from where it belongs: falls as it comes nearer.
    force: [f64; 3],
}

impl Pull {
    fn new(full: &FullDetail<'_>, uvs: &[[f32; 2]; 3], pair: &Pair) -> Self {
        let slide = slide(full, uvs, pair);
        let slide_share = if slide.is_some() { full.slide_shares[pair.full_triangle as usize] } else { SLIDE_SHARE };
        let stiffness = stiffness(pair.contact, slide_share);
        let mut force = apply(&stiffness, pair.offset.map(f64::from));
        if let Some(slide) = slide {
            (0..3).for_each(|i| force[i] -= slide_share * f64::from(slide[i]));
        }
        Self { stiffness, force }
    }
}

/// Pairs at each skin, with the corner that it is.
fn pairs_of_skins(shape: &Shape, pairs: &[Pair]) -> Vec<Vec<(u32, u8)>> {
    let mut of_skin = vec![Vec::new(); shape.skins.len()];
    for (number, pair) in pairs.iter().enumerate() {
        for (k, &skin) in shape.triangles[pair.triangle as usize].iter().enumerate() {
            if pair.weights[k] > 0.0 {
                of_skin[skin as usize].push((number as u32, k as u8));
            }
        }
    }
    of_skin
}

/// Joints of a skin, and those that move the points that it stands for; most influential first.
fn find_candidates(full: &FullDetail<'_>, skin: &Skin, pairs: &[Pair], of_skin: &[(u32, u8)]) -> Vec<u16> {
    let mut influences: Vec<(u16, f64)> = Vec::new();
    let mut total = 0.0;
    let mut add = |joint: u16, influence: f64| match influences.iter_mut().find(|i| i.0 == joint) {
        Some(known) => known.1 += influence,
        None => influences.push((joint, influence)),
    };
    for &(number, k) in of_skin {
        let pair = &pairs[number as usize];
        let share = f64::from(pair.share * pair.weights[k as usize]);
        total += share;
        for (corner, weight) in full.triangles[pair.full_triangle as usize].iter().zip(pair.full_weights) {
            let v = *corner as usize;
            for slot in (0..4).filter(|&slot| full.mesh.weights[v][slot] > 0.0) {
                add(full.mesh.joints[v][slot], share * f64::from(weight * full.mesh.weights[v][slot]));
            }
        }
    }
    influences.retain(|i| i.1 >= LEAST_INFLUENCE * total);
    influences.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut candidates: Vec<u16> =
        (0..4).filter(|&slot| skin.weights[slot] > 0.0).map(|slot| skin.joints[slot]).collect();
    candidates.dedup();
    for (joint, _) in influences {
        if candidates.len() < CANDIDATES && !candidates.contains(&joint) {
            candidates.push(joint);
        }
    }
    candidates
}

/// Better weights for one skin, as they are stored; `None` where the ones it has are as good.
fn fit_skin(
    full: &FullDetail<'_>,
    skin: &Skin,
    place: [f32; 3],
    candidates: &[u16],
    pairs: &[Pair],
    pulls: &[Pull],
    of_skin: &[(u32, u8)],
) -> Option<Skin> {
    let count = candidates.len();
    if count < 2 || of_skin.is_empty() {
        return None;
    }
    // From where the skin is, where each joint alone would take it, frame by frame.
    let ways: Vec<Vec<[f64; 3]>> = full
        .frames
        .iter()
        .map(|frame| {
            let now = transform(&blend_skin(skin, frame.palette), place);
            let way = |&joint: &u16| sub(transform(&frame.palette[usize::from(joint)], place), now).map(f64::from);
            candidates.iter().map(way).collect()
        })
        .collect();
    let mut problem = Problem { matrix: [[0.0; CANDIDATES]; CANDIDATES], right: [0.0; CANDIDATES], count };
    for &(number, k) in of_skin {
        let (pair, pull) = (&pairs[number as usize], &pulls[number as usize]);
        let (share, weight) = (f64::from(pair.share), f64::from(pair.weights[k as usize]));
        let ways = &ways[pair.frame as usize];
        for a in 0..count {
            let pulled = apply(&pull.stiffness, ways[a]);
            problem.right[a] -= share * weight * inner(ways[a], pull.force);
            for b in 0..count {
                problem.matrix[a][b] += share * weight * weight * inner(pulled, ways[b]);
            }
        }
    }
    let mut now = [0.0; CANDIDATES];
    for slot in (0..4).filter(|&slot| skin.weights[slot] > 0.0) {
        if let Some(at) = candidates.iter().position(|&joint| joint == skin.joints[slot]) {
            now[at] += f64::from(skin.weights[slot]);
        }
    }
    let keep = KEEP_SHARE * (0..count).map(|a| problem.matrix[a][a]).sum::<f64>() / count as f64;
    let stored = problem.least(&now, keep)?;
    let gain = problem.value(&now) - problem.value(&stored.map(|steps| steps as f64 / STORED_STEPS));
    if gain.is_nan() || gain <= 0.0 {
        return None;
    }
    let mut kept: Vec<(u16, u32)> = candidates.iter().copied().zip(stored).filter(|&(_, steps)| steps > 0).collect();
    kept.sort_unstable();
    let mut better = Skin { joints: [0; 4], weights: [0.0; 4], ..*skin };
    for (slot, (joint, steps)) in kept.into_iter().enumerate() {
        better.joints[slot] = joint;
        better.weights[slot] = (f64::from(steps) / STORED_STEPS) as f32;
    }
    Some(better)
}

/// Gives a skin its new weights, and its pairs what is left of their pull.
#[expect(clippy::too_many_arguments, reason = "what is read and what is changed stand side by side")]
fn replace(
    full: &FullDetail<'_>,
    shape: &mut Shape,
    matrices: &mut [Vec<Mat3x4>],
    s: usize,
    better: Skin,
    pairs: &[Pair],
    pulls: &mut [Pull],
    of_skin: &[(u32, u8)],
) {
    let place = shape.places[better.place as usize];
    shape.skins[s] = better;
    let steps: Vec<[f64; 3]> = full
        .frames
        .iter()
        .zip(matrices)
        .map(|(frame, matrices)| {
            let before = transform(&matrices[s], place);
            matrices[s] = blend_skin(&better, frame.palette);
            sub(transform(&matrices[s], place), before).map(f64::from)
        })
        .collect();
    for &(number, k) in of_skin {
        let (pair, pull) = (&pairs[number as usize], &mut pulls[number as usize]);
        let weight = f64::from(pair.weights[k as usize]);
        let pulled = apply(&pull.stiffness, steps[pair.frame as usize].map(|c| c * weight));
        (0..3).for_each(|i| pull.force[i] += pulled[i]);
    }
}

/// Half of `w M w` minus `right w`, over weights that are not negative and sum to 1.
struct Problem {
    matrix: [[f64; CANDIDATES]; CANDIDATES],
    right: [f64; CANDIDATES],
    /// Weights that there are.
    count: usize,
}

impl Problem {
    fn value(&self, weights: &[f64; CANDIDATES]) -> f64 {
        let row = |a: usize| weights[a] * (inner(self.matrix[a], *weights) / 2.0 - self.right[a]);
        (0..self.count).map(row).sum()
    }

    /// The best weights in stored steps, at most [`KEPT`] of them, held back to `now` by `keep`; `None` where nothing pulls.
    fn least(&self, now: &[f64; CANDIDATES], keep: f64) -> Option<[u32; CANDIDATES]> {
        if !(keep.is_finite() && keep > 0.0) {
            return None;
        }
        let mut allowed = [true; CANDIDATES];
        let mut weights = self.exchange(now, now, keep, &allowed);
        let mut by_weight: Vec<usize> = (0..self.count).collect();
        by_weight.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]).then(a.cmp(&b)));
        if by_weight.len() > KEPT && weights[by_weight[KEPT]] > 0.0 {
            let mut rest = 0.0;
            for &a in &by_weight[KEPT..] {
                allowed[a] = false;
                rest += std::mem::take(&mut weights[a]);
            }
            weights[by_weight[0]] += rest;
            weights = self.exchange(&weights, now, keep, &allowed);
        }
        Some(store(&weights))
    }

    /// Moves weight from where it costs most to where it costs least until that gains nothing.
    fn exchange(
        &self,
        from: &[f64; CANDIDATES],
        now: &[f64; CANDIDATES],
        keep: f64,
        allowed: &[bool; CANDIDATES],
    ) -> [f64; CANDIDATES] {
        let mut weights = *from;
        for _ in 0..EXCHANGES {
            let slope = |a: usize| inner(self.matrix[a], weights) - self.right[a] + keep * (weights[a] - now[a]);
            let may_grow = (0..self.count).filter(|&a| allowed[a]);
            let Some(to) = may_grow.min_by(|&a, &b| slope(a).total_cmp(&slope(b))) else { break };
            let may_shrink = (0..self.count).filter(|&a| weights[a] > 0.0);
            let Some(off) = may_shrink.max_by(|&a, &b| slope(a).total_cmp(&slope(b))) else { break };
            let m = &self.matrix;
            let bend = m[to][to] + m[off][off] - 2.0 * m[to][off] + 2.0 * keep;
            let step = ((slope(off) - slope(to)) / bend).min(weights[off]);
            // Half a stored step is nothing.
            if to == off || step.is_nan() || step * STORED_STEPS < 0.5 {
                break;
            }
            weights[to] += step;
            weights[off] -= step;
        }
        weights
    }
}

/// Weights in stored steps, summing to all of them; what rounding leaves goes to the largest.
fn store(weights: &[f64; CANDIDATES]) -> [u32; CANDIDATES] {
    let mut stored = weights.map(|w| (w * STORED_STEPS + 0.5) as u32);
    let largest = (0..CANDIDATES).fold(0, |best, a| if stored[a] > stored[best] { a } else { best });
    let others: u32 = (0..CANDIDATES).filter(|&a| a != largest).map(|a| stored[a]).sum();
    stored[largest] = (STORED_STEPS as u32).saturating_sub(others);
    stored
}

fn apply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| inner(row, v))
}

fn inner<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(goal: [f64; 2]) -> Problem {
        // (w0 - goal0)^2 + (w1 - goal1)^2, over three weights.
        let mut problem = Problem { matrix: [[0.0; CANDIDATES]; CANDIDATES], right: [0.0; CANDIDATES], count: 3 };
        for a in 0..2 {
            problem.matrix[a][a] = 2.0;
            problem.right[a] = 2.0 * goal[a];
        }
        problem
    }

    fn solve(goal: [f64; 2]) -> [f64; 3] {
        let mut now = [0.0; CANDIDATES];
        now[2] = 1.0;
        let stored = problem(goal).least(&now, 1.0e-9).expect("a problem that pulls");
        assert_eq!(stored.iter().sum::<u32>(), 65_535);
        [0, 1, 2].map(|a| f64::from(stored[a]) / STORED_STEPS)
    }

    #[test]
    fn weights_are_the_nearest_that_are_allowed() {
        for (goal, nearest) in [
            ([0.25, 0.5], [0.25, 0.5, 0.25]),
            ([2.0, -1.0], [1.0, 0.0, 0.0]),
            ([0.8, 0.8], [0.5, 0.5, 0.0]),
            ([-1.0, 0.25], [0.0, 0.25, 0.75]),
        ] {
            let found = solve(goal);
            (0..3).for_each(|a| assert!((found[a] - nearest[a]).abs() < 1.0e-3, "{goal:?}: {found:?}"));
        }
    }

    #[test]
    fn four_of_eight_stay() {
        let mut problem = Problem { matrix: [[0.0; CANDIDATES]; CANDIDATES], right: [0.0; CANDIDATES], count: 8 };
        for a in 0..8 {
            problem.matrix[a][a] = 1.0;
            problem.right[a] = 0.1 + 0.01 * a as f64;
        }
        let stored = problem.least(&[0.125; 8], 1.0e-6).expect("a problem that pulls");
        assert_eq!(stored.map(|steps| steps > 0), [false, false, false, false, true, true, true, true]);
        assert_eq!(stored.iter().sum::<u32>(), 65_535);
    }
}
