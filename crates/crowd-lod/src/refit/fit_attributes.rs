//! Spreads an attribute of full detail over a level by least squares: whatever is interpolated over triangles.

use super::pairs::Pair;

/// Pull towards what an unknown has, relative to the mean pull on one.
const KEEP_SHARE: f64 = 0.02;
/// Sweeps over all unknowns; neighbours share a triangle, so few suffice.
const SWEEP_COUNT: usize = 12;

/// Times that pairs are weighed anew by how well they were met, so that the mean error counts, not its square: a few
/// pairs across an edge or a seam would spoil all around them.
pub(crate) const REWEIGHT_COUNT: usize = 3;

/// The values that, interpolated over the level's triangles, are closest to the targets of the pairs.
///
/// `corners`: unknown at each corner of each triangle of the level. `first`: what the unknowns are now. `target`: what
/// a pair asks for; and how much it is heeded; `None` leaves it out. An unknown that no pair asks for stays.
pub(crate) fn spread_attribute<const N: usize>(
    corners: &[[u32; 3]],
    first: &[[f64; N]],
    pairs: &[Pair],
    target: impl Fn(&Pair) -> Option<([f64; N], f64)>,
) -> Vec<[f64; N]> {
    let mut matrices = vec![[[0.0_f64; 3]; 3]; corners.len()];
    let mut rights = vec![[[0.0_f64; N]; 3]; corners.len()];
    let mut total = 0.0;
    for pair in pairs {
        let Some((target, heed)) = target(pair) else { continue };
        let t = pair.triangle as usize;
        for k in 0..3 {
            let pull = heed * f64::from(pair.share * pair.weights[k]);
            for i in 0..N {
                rights[t][k][i] += pull * target[i];
            }
            for l in 0..3 {
                matrices[t][k][l] += pull * f64::from(pair.weights[l]);
            }
            total += pull * f64::from(pair.weights[k]);
        }
    }
    let keep = KEEP_SHARE * total / first.len().max(1) as f64;
    let (offsets, around) = corners_around(corners, first.len());
    let mut values = first.to_vec();
    for _ in 0..SWEEP_COUNT {
        for g in 0..first.len() {
            let mut right = first[g].map(|c| keep * c);
            let mut own = keep;
            for &corner in &around[offsets[g]..offsets[g + 1]] {
                let (t, k) = (corner as usize / 3, corner as usize % 3);
                for l in 0..3 {
                    let other = corners[t][l] as usize;
                    if other == g {
                        own += matrices[t][k][l];
                    } else {
                        for i in 0..N {
                            right[i] -= matrices[t][k][l] * values[other][i];
                        }
                    }
                }
                for i in 0..N {
                    right[i] += rights[t][k][i];
                }
            }
            let value = right.map(|c| c / own);
            if own > 0.0 && value.iter().all(|c| c.is_finite()) {
                values[g] = value;
            }
        }
    }
    values
}

/// A value between those of three corners.
pub(crate) fn interpolate<const N: usize>(corners: [[f64; N]; 3], weights: [f32; 3]) -> [f64; N] {
    std::array::from_fn(|i| (0..3).map(|k| corners[k][i] * f64::from(weights[k])).sum())
}

/// How far two values are apart.
pub(crate) fn distance<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    (0..N).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>().sqrt()
}

/// Corners (triangle times three plus corner) that use each unknown: offsets, and the corners.
fn corners_around(corners: &[[u32; 3]], count: usize) -> (Vec<usize>, Vec<u32>) {
    let mut offsets = vec![0_usize; count + 1];
    for &g in corners.as_flattened() {
        offsets[g as usize + 1] += 1;
    }
    for g in 0..count {
        offsets[g + 1] += offsets[g];
    }
    let mut next = offsets.clone();
    let mut around = vec![0_u32; corners.len() * 3];
    for (corner, &g) in corners.as_flattened().iter().enumerate() {
        around[next[g as usize]] = corner as u32;
        next[g as usize] += 1;
    }
    (offsets, around)
}

/// Numbers vertices so that those with equal keys share a number. Returns each vertex's number, and how many there are.
pub(crate) fn number_by_key<K: Ord>(count: usize, key: impl Fn(usize) -> K) -> (Vec<u32>, usize) {
    let keys: Vec<K> = (0..count).map(key).collect();
    let mut by_key: Vec<usize> = (0..count).collect();
    by_key.sort_unstable_by(|&a, &b| keys[a].cmp(&keys[b]).then(a.cmp(&b)));
    let mut numbers = vec![0_u32; count];
    let mut next = 0;
    for group in by_key.chunk_by(|&a, &b| keys[a] == keys[b]) {
        group.iter().for_each(|&v| numbers[v] = next);
        next += 1;
    }
    (numbers, next as usize)
}
