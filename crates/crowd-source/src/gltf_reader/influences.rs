//! Joints and weights: any number of sets down to the four strongest, summing to 1.

use crate::refusal::Warnings;

/// Up to four joints of a vertex, strongest first. Joint indices are the skin's own; unused ones are 0 with weight 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Influence {
    pub(super) joints: [u32; 4],
    pub(super) weights: [f32; 4],
}

/// Weights whose sum is further from 1 than this were not meant so. Less is what eight bits a weight round by.
const SUM_SLACK: f64 = 0.01;

/// Keeps each vertex's four strongest joints and makes their weights sum to 1.
///
/// `sets[s]` are the numbers of JOINTS_s and WEIGHTS_s, four a vertex. A joint named twice counts once, with the sum. Ties
/// go to the lower joint. A vertex without any weight follows its first joint.
pub(super) fn keep_four_strongest(
    place: &str,
    vertices: usize,
    sets: &[(Vec<u32>, Vec<f32>)],
    warnings: &mut Warnings,
) -> Vec<Influence> {
    let mut influences = Vec::with_capacity(vertices);
    let (mut dropping, mut largest, mut negative, mut unweighted) = (0u64, 0.0f32, 0u64, 0u64);
    let (mut rescaled, mut furthest) = (0u64, 1.0f64);
    let mut found: Vec<(u32, f32)> = Vec::with_capacity(sets.len() * 4);
    for v in 0..vertices {
        found.clear();
        for (joints, weights) in sets {
            for slot in v * 4..v * 4 + 4 {
                let (joint, weight) = (joints[slot], weights[slot]);
                if weight < 0.0 {
                    negative += 1;
                } else if weight > 0.0 {
                    match found.iter_mut().find(|(j, _)| *j == joint) {
                        Some((_, sum)) => *sum += weight,
                        None => found.push((joint, weight)),
                    }
                }
            }
        }
        if found.is_empty() {
            unweighted += 1;
            found.push((sets[0].0[v * 4], 1.0));
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let total: f32 = found.iter().map(|(_, w)| w).sum();
        let sum: f64 = found.iter().map(|(_, w)| f64::from(*w)).sum();
        if (sum - 1.0).abs() > SUM_SLACK {
            rescaled += 1;
            if (sum - 1.0).abs() > (furthest - 1.0).abs() {
                furthest = sum;
            }
        }
        if found.len() > 4 {
            dropping += 1;
            largest = largest.max(found[4].1 / total);
            found.truncate(4);
        }
        // In f64: the sum of very large weights does not overflow, that of very small ones does not vanish.
        let kept: f64 = found.iter().map(|(_, w)| f64::from(*w)).sum();
        let mut influence = Influence { joints: [0; 4], weights: [0.0; 4] };
        for (slot, (joint, weight)) in found.iter().enumerate() {
            let weight = (f64::from(*weight) / kept) as f32;
            if weight > 0.0 {
                influence.joints[slot] = *joint;
                influence.weights[slot] = weight;
            }
        }
        influences.push(influence);
    }
    let message = format!(
        "vertices with more than four joints keep the four strongest; the largest weight dropped is {largest:.3}. Limit influences to four before export to choose them yourself"
    );
    warnings.add("weights-dropped", place, dropping, message);
    warnings.add("weights-negative", place, negative, "negative weights were taken as zero");
    let message = "vertices whose weights are all zero now follow their first joint; assign them before export";
    warnings.add("weights-missing", place, unweighted, message);
    let message = format!(
        "vertices whose weights do not sum to 1 had them scaled until they do; the sum furthest off is {furthest:.3}. \
         Normalise the weights before export"
    );
    warnings.add("weights-normalized", place, rescaled, message);
    influences
}
