//! How far small parts lie from the rest: what it would cost to lose them.
//!
//! A part is what hangs together. Where one vanishes, the eye sees the surface behind it: an eye's white on a face is missed for its
//! colour, a link of an arm for the gap it leaves. The largest part never vanishes.

use crate::attributes::COLOR_SHARE;
use crate::closest::ClosestTriangles;
use crate::quadrics::{dot, sub};
use crate::split_seams::SplitMesh;
use crate::{AttributeWeights, LodMesh};
use rayon::prelude::*;

/// For each position, the squared distance to the surface of the other parts, mean over `posed`, and the difference in colour as a
/// squared distance; infinite in the largest part. m².
pub(crate) fn measure_behind(
    mesh: &LodMesh<'_>,
    split: &SplitMesh,
    posed: &[&[[f32; 3]]],
    weights: &AttributeWeights,
    diagonal: f32,
) -> Vec<f32> {
    let triangles: Vec<[u32; 3]> = split.triangles.iter().map(|t| t.map(|v| split.position_of(v))).collect();
    let part_of = number_parts(split.position_source.len(), &triangles);
    let parts: Vec<u32> = triangles.iter().map(|t| part_of[t[0] as usize]).collect();
    let mut sizes = vec![0_u32; part_of.len()];
    for &part in &parts {
        sizes[part as usize] += 1;
    }
    let largest = (0..sizes.len()).max_by_key(|&part| (sizes[part], std::cmp::Reverse(part))).unwrap_or(0) as u32;
    let mut behind = vec![f32::INFINITY; part_of.len()];
    if sizes.iter().filter(|&&size| size > 0).count() < 2 {
        return behind;
    }
    let color_scale = weights.color * COLOR_SHARE as f32 * diagonal;
    let colors = shown_colors(mesh, split);
    let mut tree = ClosestTriangles::new(posed[0], &triangles);
    let tree_parts = tree.group_by(parts);
    let small: Vec<u32> = (0..part_of.len() as u32).filter(|&p| part_of[p as usize] != largest).collect();
    let mut sums = vec![0.0_f32; small.len()];
    for pose in posed {
        tree.refit(pose, &triangles);
        let measured: Vec<f32> = small
            .par_iter()
            .map(|&p| {
                let own = part_of[p as usize];
                let point = pose[p as usize];
                let Some((distance, triangle)) = tree.closest_of_others(point, pose, &triangles, &tree_parts, own)
                else {
                    return f32::INFINITY;
                };
                let there = triangles[triangle as usize].map(|q| colors[q as usize]);
                let difference =
                    [0, 1, 2].map(|i| (there[0][i] + there[1][i] + there[2][i]) / 3.0 - colors[p as usize][i]);
                distance + color_scale * color_scale * dot(difference, difference)
            })
            .collect();
        sums.iter_mut().zip(measured).for_each(|(sum, value)| *sum += value / posed.len() as f32);
    }
    for (&p, sum) in small.iter().zip(sums) {
        behind[p as usize] = sum;
    }
    behind
}

/// For each position, the lowest position that it hangs together with.
fn number_parts(position_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..position_count as u32).collect();
    let root = |parents: &mut Vec<u32>, mut at: u32| {
        while parents[at as usize] != at {
            parents[at as usize] = parents[parents[at as usize] as usize];
            at = parents[at as usize];
        }
        at
    };
    for t in triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2])] {
            let (a, b) = (root(&mut parents, a), root(&mut parents, b));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    (0..position_count as u32).map(|p| root(&mut parents, p)).collect()
}

/// For each position, the mean colour of its variants.
fn shown_colors(mesh: &LodMesh<'_>, split: &SplitMesh) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0_f32; 4]; split.position_source.len()];
    for (v, &source) in split.variant_source.iter().enumerate() {
        let sum = &mut sums[split.position_of(v as u32) as usize];
        let color = match mesh.appearance.shown_colors.get(source as usize) {
            Some(&color) => color,
            None => [0, 1, 2].map(|i| f32::from(mesh.colors[source as usize][i]) / 255.0),
        };
        for i in 0..3 {
            sum[i] += color[i];
        }
        sum[3] += 1.0;
    }
    sums.into_iter().map(|s| [0, 1, 2].map(|i| s[i] / s[3].max(1.0))).collect()
}

/// Length of the diagonal of the box around the positions in use, metres.
pub(crate) fn diagonal(places: &[[f32; 3]]) -> f32 {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for place in places {
        for i in 0..3 {
            low[i] = low[i].min(place[i]);
            high[i] = high[i].max(place[i]);
        }
    }
    let d = sub(high, low);
    if places.is_empty() { 0.0 } else { dot(d, d).sqrt() }
}
