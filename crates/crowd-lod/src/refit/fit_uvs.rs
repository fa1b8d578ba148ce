//! Slides the texture coordinates of a level to where full detail has them, each within its chart.

use super::fit_attributes::{REWEIGHT_COUNT, distance, interpolate, number_by_key, spread_attribute};
use super::full_detail::FullDetail;
use super::pairs::Pair;
use super::shape::Shape;
use crate::LevelMesh;
use crate::split_seams::zero_signless_bits;

/// A coordinate this close to its chart's rim, relative to the mean texture edge around it, lies on it.
const ON_RIM: f32 = 1.0e-4;
/// A coordinate moves at most this share of the mean texture edge around it.
const STEP_LIMIT: f32 = 0.75;
/// A triangle of the texture keeps at least this share of its area.
const LEAST_AREA: f32 = 0.1;

/// Slides well below this share of a texture edge count by their square, longer ones by their length.
const SMALL_ERROR: f64 = 0.1;

/// For each vertex the texture coordinate that, interpolated over the level's triangles, is closest to full detail's.
///
/// Only pairs within one chart count. Coordinates on the rim of their chart slide along it and stay on it, at its corners they
/// stay; no triangle of
/// the texture turns over. `materials`: of each vertex of the level.
pub(crate) fn fit_uvs(
    full: &FullDetail<'_>,
    shape: &Shape,
    pairs: &[Pair],
    materials: &[u16],
    level: &LevelMesh,
) -> Vec<[f32; 2]> {
    // The level's triangles are the first of full detail's: each keeps its chart.
    let charts = &full.charts;
    let (groups, count) = number_by_key(level.uvs.len(), |v| {
        (shape.skins[shape.skin_of[v] as usize].place, level.uvs[v].map(zero_signless_bits), materials[v])
    });
    let corners: Vec<[u32; 3]> = level.triangles.iter().map(|t| t.map(|v| groups[v as usize])).collect();
    let mut first = vec![[0.0_f32; 2]; count];
    for (v, &g) in groups.iter().enumerate() {
        first[g as usize] = level.uvs[v];
    }
    let before = first.iter().map(|uv| uv.map(f64::from)).collect::<Vec<_>>();
    let edges = mean_edges(&corners, &first);
    let mut wanted = before.clone();
    for _ in 0..REWEIGHT_COUNT {
        let now = wanted;
        wanted = spread_attribute(&corners, &before, pairs, |pair| {
            if charts.of_triangle[pair.triangle as usize] != charts.of_triangle[pair.full_triangle as usize] {
                return None;
            }
            let target = full.uv_at(pair).map(f64::from);
            let own = corners[pair.triangle as usize];
            let size = f64::from(own.iter().map(|&g| edges[g as usize]).sum::<f32>()) / 3.0;
            let error = distance(interpolate(own.map(|g| now[g as usize]), pair.weights), target);
            let heed = if size > 0.0 { size / (error + SMALL_ERROR * size) } else { 1.0 };
            Some((target, heed))
        });
    }
    let mut chart_of = vec![None; count];
    for (t, triangle) in corners.iter().enumerate() {
        triangle.iter().for_each(|&g| chart_of[g as usize] = Some(charts.of_triangle[t]));
    }
    let mut uvs: Vec<[f32; 2]> = (0..count)
        .map(|g| {
            let uv = limit_step(first[g], wanted[g], STEP_LIMIT * edges[g]);
            let Some(chart) = chart_of[g] else { return first[g] };
            if charts.is_corner(chart, first[g]) {
                return first[g];
            }
            match charts.to_rim(chart, first[g]) {
                Some((_, distance)) if distance <= ON_RIM * edges[g] => {
                    charts.to_rim(chart, uv).map_or(first[g], |(on_rim, _)| on_rim)
                }
                _ => uv,
            }
        })
        .collect();
    put_back_turned(&corners, &first, &mut uvs);
    groups.iter().map(|&g| uvs[g as usize]).collect()
}

fn limit_step(from: [f32; 2], to: [f64; 2], limit: f32) -> [f32; 2] {
    let step = [0, 1].map(|i| (to[i] - f64::from(from[i])) as f32);
    let length = (step[0] * step[0] + step[1] * step[1]).sqrt();
    if !length.is_finite() {
        return from;
    }
    let share = if length > limit { limit / length } else { 1.0 };
    [0, 1].map(|i| from[i] + share * step[i])
}

fn mean_edges(corners: &[[u32; 3]], uvs: &[[f32; 2]]) -> Vec<f32> {
    let (mut sums, mut counts) = (vec![0.0_f32; uvs.len()], vec![0_u32; uvs.len()]);
    for triangle in corners {
        for i in 0..3 {
            let (a, b) = (triangle[i] as usize, triangle[(i + 1) % 3] as usize);
            let (du, dv) = (uvs[b][0] - uvs[a][0], uvs[b][1] - uvs[a][1]);
            for g in [a, b] {
                sums[g] += (du * du + dv * dv).sqrt();
                counts[g] += 1;
            }
        }
    }
    sums.iter().zip(&counts).map(|(sum, &count)| sum / count.max(1) as f32).collect()
}

/// Puts the corners of triangles that turned over or shrank to nothing back to where they were, until there is none.
fn put_back_turned(corners: &[[u32; 3]], first: &[[f32; 2]], uvs: &mut [[f32; 2]]) {
    let area = |uvs: &[[f32; 2]], t: &[u32; 3]| {
        let [a, b, c] = t.map(|g| uvs[g as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    loop {
        let mut found = false;
        for triangle in corners {
            let (before, after) = (area(first, triangle), area(uvs, triangle));
            let moved = triangle.iter().any(|&g| uvs[g as usize] != first[g as usize]);
            let kept = after * before.signum() >= LEAST_AREA * before.abs();
            if moved && !kept {
                found = true;
                triangle.iter().for_each(|&g| uvs[g as usize] = first[g as usize]);
            }
        }
        if !found {
            return;
        }
    }
}
