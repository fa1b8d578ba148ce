//! Slides single texture coordinates to where the colours are right: slides count by what they show, which least squares cannot see.

use super::Dress;
use super::fit_attributes::number_by_key;
use super::full_detail::FullDetail;
use super::pairs::{Pair, mix};
use super::shape::Shape;
use crate::LevelMesh;
use crate::quadrics::{dot, sub};
use crate::split_seams::zero_signless_bits;
use rayon::prelude::*;

/// How far a coordinate is tried to each side, in mean edges of the texture around it.
const STEPS: [f32; 3] = [0.12, 0.05, 0.02];
/// Sweeps over all coordinates with each step.
const SWEEP_COUNT: usize = 3;
/// What is saved at least, as a share: pairs are a sample, not the surface.
const LEAST_GAIN: f64 = 0.02;
/// A triangle of the texture keeps at least this share of its area.
const LEAST_AREA: f32 = 0.1;

/// What a pair shows, and should.
struct Aim {
    triangle: u32,
    weights: [f32; 3],
    tint: [f32; 3],
    wanted: [f32; 3],
    share: f32,
}

/// When a coordinate was looked at last: where nothing around it has moved since, a look would find what it found.
#[derive(Debug, Clone, Copy, Default)]
struct Look {
    /// Looks are counted over all coordinates, from 1.
    at: u64,
    /// The look in which it moved last.
    moved_at: u64,
    step: f32,
    /// What it cost where it then was.
    cost: f64,
}

/// Coordinates at least as good as `uvs` by the colours that the pairs see. `level`: as it was before the fit.
pub(crate) fn fit_colors(
    full: &FullDetail<'_>,
    shape: &Shape,
    pairs: &[Pair],
    dress: &Dress,
    level: &LevelMesh,
    uvs: &[[f32; 2]],
) -> Vec<[f32; 2]> {
    if !full.knows_colors() {
        return uvs.to_vec();
    }
    let charts = &full.charts;
    let Dress { materials, tints } = dress;
    let (groups, count) = number_by_key(level.uvs.len(), |v| {
        (shape.skins[shape.skin_of[v] as usize].place, level.uvs[v].map(zero_signless_bits), materials[v])
    });
    let corners: Vec<[u32; 3]> = level.triangles.iter().map(|t| t.map(|v| groups[v as usize])).collect();
    let (mut first, mut now, mut material_of) = (vec![[0.0; 2]; count], vec![[0.0; 2]; count], vec![0; count]);
    for (v, &g) in groups.iter().enumerate() {
        (first[g as usize], now[g as usize], material_of[g as usize]) = (level.uvs[v], uvs[v], materials[v]);
    }
    let aims: Vec<Aim> = pairs
        .par_iter()
        .filter(|p| charts.of_triangle[p.triangle as usize] == charts.of_triangle[p.full_triangle as usize])
        .map(|pair| {
            let wanted = full.color_in(pair.full_triangle, pair.full_weights);
            let tint = mix(level.triangles[pair.triangle as usize].map(|v| tints[v as usize]), pair.weights);
            Aim { triangle: pair.triangle, weights: pair.weights, tint, wanted, share: pair.share }
        })
        .collect();
    let mut of_triangle: Vec<Vec<u32>> = vec![Vec::new(); corners.len()];
    for (i, aim) in aims.iter().enumerate() {
        of_triangle[aim.triangle as usize].push(i as u32);
    }
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (t, triangle) in corners.iter().enumerate() {
        triangle.iter().for_each(|&g| around[g as usize].push(t as u32));
    }
    // No term is below zero: once the sum reaches `enough` it stays there.
    let cost = |now: &[[f32; 2]], g: usize, enough: f64| -> f64 {
        let mut sum = 0.0;
        for &t in &around[g] {
            let uv = corners[t as usize].map(|g| now[g as usize]);
            for &i in &of_triangle[t as usize] {
                let aim = &aims[i as usize];
                let at = [0, 1].map(|k| (0..3).map(|c| uv[c][k] * aim.weights[c]).sum());
                let off = sub(full.color(material_of[g], at, aim.tint), aim.wanted);
                sum += f64::from(aim.share * dot(off, off));
                if sum >= enough {
                    return sum;
                }
            }
        }
        sum
    };
    let area = |uvs: &[[f32; 2]], t: u32| {
        let [a, b, c] = corners[t as usize].map(|g| uvs[g as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut looks = vec![Look::default(); count];
    let mut clock = 0;
    for step in STEPS.into_iter().flat_map(|step| [step; SWEEP_COUNT]) {
        for g in 0..count {
            if around[g].is_empty() {
                continue;
            }
            let last = looks[g];
            let of_look = |g: &u32| looks[*g as usize].moved_at;
            let moved_at = around[g].iter().flat_map(|&t| corners[t as usize].iter().map(of_look)).max().unwrap_or(0);
            let seen = last.at > 0;
            let quiet = seen && moved_at < last.at;
            if quiet && last.step == step {
                continue;
            }
            let before = now[g];
            let known = seen && moved_at <= last.at;
            let mut best = (if known { last.cost } else { cost(&now, g, f64::INFINITY) }, before);
            let chart = charts.of_triangle[around[g][0] as usize];
            let mut length = 0.0;
            for &t in &around[g] {
                let uv = corners[t as usize].map(|g| now[g as usize]);
                let along =
                    |a: [f32; 2], b: [f32; 2]| ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt();
                length +=
                    (along(uv[0], uv[1]) + along(uv[1], uv[2]) + along(uv[2], uv[0])) / (3 * around[g].len()) as f32;
            }
            let at_corner = charts.is_corner(chart, first[g]);
            let inside =
                !at_corner && charts.to_rim(chart, first[g]).is_none_or(|(_, distance)| distance > 1.0e-4 * length);
            let half = [0, 1].map(|k| (first[g][k] + before[k]) / 2.0);
            // What does not go by the step was tried before.
            let mut tried = if quiet { Vec::new() } else { vec![first[g]] };
            let way = step * length;
            let beside = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
                .map(|(u, v)| [before[0] + u * way, before[1] + v * way]);
            if inside {
                if !quiet {
                    tried.push(half);
                }
                tried.extend(beside);
            } else if !at_corner {
                // On the rim it slides along it: half way, too, it is there, and not on its way to another side or around a corner.
                let on_rim = beside.iter().filter_map(|&uv| charts.to_rim(chart, uv)).map(|(on_rim, _)| on_rim);
                tried.extend(on_rim.filter(|uv| {
                    let middle = [0, 1].map(|k| (uv[k] + before[k]) / 2.0);
                    charts.to_rim(chart, middle).is_some_and(|(_, distance)| distance <= 1.0e-4 * length)
                }));
            }
            for uv in tried {
                if uv == before {
                    continue;
                }
                now[g] = uv;
                let upright = around[g].iter().all(|&t| {
                    let (was, is) = (area(&first, t), area(&now, t));
                    is * was.signum() >= LEAST_AREA * was.abs()
                });
                if !upright {
                    continue;
                }
                let enough = best.0 * (1.0 - LEAST_GAIN);
                let cost = cost(&now, g, enough);
                if cost < enough {
                    best = (cost, uv);
                }
            }
            now[g] = best.1;
            clock += 1;
            let moved_at = if best.1 == before { last.moved_at } else { clock };
            looks[g] = Look { at: clock, moved_at, step, cost: best.0 };
        }
    }
    groups.iter().map(|&g| now[g as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refit::Probes;
    use crate::test_meshes::{TestPoses, grid, quick};
    use crate::{Appearance, LodMesh, ShownColors, level_mesh, simplify};

    /// Dark to bright along u, and nothing along v.
    #[derive(Debug)]
    struct Ramp;

    impl ShownColors for Ramp {
        fn color(&self, _: u16, [u, _]: [f32; 2], _: [f32; 3]) -> [f32; 3] {
            [u.clamp(0.0, 1.0); 3]
        }
    }

    #[test]
    fn a_coordinate_slides_to_its_colour_and_on_the_rim_along_it() {
        let mesh = grid(2, 2, |_, _| 0.0, |_, _| false);
        let appearance = Appearance { textures: Some(&Ramp), ..Appearance::default() };
        let lod_mesh = LodMesh { appearance, ..mesh.mesh() };
        let poses = TestPoses::rest();
        let order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        let level = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        let full = FullDetail::new(&lod_mesh, &poses.poses(), &order, 1);
        let shape = Shape::new(&level);
        let (pairs, _) = Probes::new(&full, &shape, 2000).pair(&full, &shape, &shape.blend(&full.frames), true);
        let dress = Dress { materials: vec![0; 9], tints: vec![[1.0; 3]; 9] };
        let middle = level.uvs.iter().position(|&uv| uv == [0.5, 0.5]).expect("a vertex in the middle");
        let mut slid = level.uvs.clone();
        slid[middle] = [0.58, 0.5];
        let found = fit_colors(&full, &shape, &pairs, &dress, &level, &slid);
        for v in 0..9 {
            let near = if v == middle { 0.02 } else { 0.0 };
            assert!((found[v][0] - level.uvs[v][0]).abs() <= near, "{v}: {:?}", found[v]);
        }
        // On the rim it slides along it, from a wrong place of the level's own.
        let below = level.uvs.iter().position(|&uv| uv == [0.5, 0.0]).expect("a vertex on the rim");
        let mut off = level.clone();
        off.uvs[below] = [0.58, 0.0];
        let found = fit_colors(&full, &shape, &pairs, &dress, &off, &off.uvs)[below];
        assert!((found[0] - 0.5).abs() <= 0.02 && found[1] == 0.0, "{found:?}");
        // Nobody knows the colours: nothing moves.
        let blind = mesh.mesh();
        let full = FullDetail::new(&blind, &poses.poses(), &order, 1);
        assert_eq!(fit_colors(&full, &shape, &pairs, &dress, &level, &slid), slid);
    }
}
