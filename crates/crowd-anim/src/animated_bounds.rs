//! Boxes and spheres that hold a character in motion.

use crate::skin::skin;
use crate::{Bounds, Mat3x4};

/// Directions along which the farthest points are kept: axes, edge and corner diagonals of a cube.
const DIRECTIONS: [[f32; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];
/// Steps towards the farthest point; the centre is then within about 1 / steps of the best.
const REFINEMENT_STEPS: u32 = 256;
/// Added to all bounds, relative to the largest coordinate: covers the GPU's rounding and that of 16-bit weights.
const MARGIN: f64 = 1e-5;

/// Bounds over every vertex in every frame given. `palettes` holds whole frames of `joint_count` matrices each.
///
/// The sphere and box hold every skinned vertex even after rounding (a relative 1e-5 is added). Between two frames the
/// player blends matrices linearly, so a vertex moves on the straight line between its two places: box and sphere are
/// convex and hold it there too.
///
/// `positions`, `joints`, `weights`: one per vertex, bind space; weights of joints outside the palette count as zero.
/// Without palettes the positions are taken as they are. Points that are not finite are left out; no point at all gives
/// empty bounds at the origin.
///
/// The sphere: Bădoiu and Clarkson's steps over the extreme points of 13 directions, or the box's centre where that is
/// better; its radius is then measured over all points. Cost: each vertex is skinned twice per frame.
pub fn animated_bounds(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    palettes: &[Mat3x4],
    joint_count: usize,
) -> Bounds {
    let mut extremes = Extremes::default();
    for_each_point(positions, joints, weights, palettes, joint_count, |point| extremes.add(point));
    let Some((min, max)) = extremes.corners() else {
        return Bounds::default();
    };
    let points: Vec<Ball> = extremes.points().map(|point| Ball { center: point.map(f64::from), radius: 0.0 }).collect();
    let centers = [middle(min, max), refine_center(&points, middle(min, max))].map(|center| center.map(|c| c as f32));
    let mut squared_radii = [0.0_f32; 2];
    for_each_point(positions, joints, weights, palettes, joint_count, |point| {
        for (center, squared_radius) in centers.iter().zip(&mut squared_radii) {
            *squared_radius = squared_radius.max(squared_distance(*center, point));
        }
    });
    let best = usize::from(squared_radii[1] < squared_radii[0]);
    widen(Bounds { min, max, center: centers[best], radius: squared_radii[best].sqrt() })
}

/// The smallest bounds that hold all of `bounds` (over clips, say).
///
/// The box is exact; the sphere the better of three: around the box's centre, refined, or one of the given spheres grown.
/// None give empty bounds at the origin, one gives itself.
pub fn union_bounds(bounds: &[Bounds]) -> Bounds {
    let Some((first, rest)) = bounds.split_first() else {
        return Bounds::default();
    };
    if rest.is_empty() {
        return *first;
    }
    let (mut min, mut max) = (first.min, first.max);
    for other in rest {
        for axis in 0..3 {
            min[axis] = min[axis].min(other.min[axis]);
            max[axis] = max[axis].max(other.max[axis]);
        }
    }
    let to_ball = |b: &Bounds| Ball { center: b.center.map(f64::from), radius: f64::from(b.radius) };
    let balls: Vec<Ball> = bounds.iter().map(to_ball).collect();
    let largest = balls.iter().fold(balls[0], |a, b| if b.radius > a.radius { *b } else { a });
    let centers = [middle(min, max), refine_center(&balls, largest.center), largest.center];
    let best = centers
        .map(|center| center.map(|c| c as f32))
        .map(|center| (center, balls.iter().map(|b| reach(b, center.map(f64::from))).fold(0.0, f64::max)))
        .into_iter()
        .reduce(|a, b| if b.1 < a.1 { b } else { a });
    let (center, radius) = best.unwrap_or((first.center, f64::from(first.radius)));
    // Rounding to f32 may lose half a unit in the last place; two are given back.
    Bounds { min, max, center, radius: (radius * (1.0 + 2.0 * f64::from(f32::EPSILON))) as f32 }
}

/// A sphere in `f64`; a point has radius 0.
#[derive(Debug, Clone, Copy)]
struct Ball {
    center: [f64; 3],
    radius: f64,
}

/// Farthest points of the 13 directions and their opposites.
#[derive(Default)]
struct Extremes {
    found: Option<[[(f32, [f32; 3]); 2]; 13]>,
}

impl Extremes {
    fn add(&mut self, point: [f32; 3]) {
        let along = |d: [f32; 3]| d[0] * point[0] + d[1] * point[1] + d[2] * point[2];
        match &mut self.found {
            None => self.found = Some(DIRECTIONS.map(|d| [(along(d), point); 2])),
            Some(found) => {
                for (ends, direction) in found.iter_mut().zip(DIRECTIONS) {
                    let value = along(direction);
                    if value < ends[0].0 {
                        ends[0] = (value, point);
                    }
                    if value > ends[1].0 {
                        ends[1] = (value, point);
                    }
                }
            }
        }
    }

    /// Least and greatest corner of the box; the first three directions are the axes.
    fn corners(&self) -> Option<([f32; 3], [f32; 3])> {
        self.found.map(|found| ([0, 1, 2].map(|axis| found[axis][0].0), [0, 1, 2].map(|axis| found[axis][1].0)))
    }

    fn points(&self) -> impl Iterator<Item = [f32; 3]> {
        self.found.into_iter().flatten().flatten().map(|(_, point)| point)
    }
}

/// Skins every vertex in every frame and hands on the finite results, frame by frame.
fn for_each_point(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    palettes: &[Mat3x4],
    joint_count: usize,
    mut visit: impl FnMut([f32; 3]),
) {
    let mut visit_finite = |point: [f32; 3]| {
        if point.iter().all(|c| c.is_finite()) {
            visit(point);
        }
    };
    if palettes.is_empty() || joint_count == 0 {
        positions.iter().copied().for_each(visit_finite);
        return;
    }
    for palette in palettes.chunks_exact(joint_count) {
        for ((position, joints), weights) in positions.iter().zip(joints).zip(weights) {
            visit_finite(skin(*position, joints, weights, palette));
        }
    }
}

/// Moves a centre towards the farthest ball, by ever smaller parts of the way (Bădoiu and Clarkson 2003).
fn refine_center(balls: &[Ball], start: [f64; 3]) -> [f64; 3] {
    let mut center = start;
    for step in 1..=REFINEMENT_STEPS {
        let mut farthest: Option<(&Ball, f64)> = None;
        for ball in balls {
            let distance = reach(ball, center);
            if farthest.is_none_or(|(_, most)| distance > most) {
                farthest = Some((ball, distance));
            }
        }
        let Some((ball, distance)) = farthest.filter(|&(ball, distance)| distance > ball.radius) else {
            break; // The farthest ball is around this very centre.
        };
        // Its farthest point lies behind its own centre, as seen from here.
        let way = distance / (distance - ball.radius) / (f64::from(step) + 1.0);
        for axis in 0..3 {
            center[axis] += (ball.center[axis] - center[axis]) * way;
        }
    }
    center
}

/// Distance from `center` to the farthest point of the ball.
fn reach(ball: &Ball, center: [f64; 3]) -> f64 {
    let d = [0, 1, 2].map(|axis| ball.center[axis] - center[axis]);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() + ball.radius
}

fn middle(min: [f32; 3], max: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| (f64::from(min[axis]) + f64::from(max[axis])) / 2.0)
}

fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

/// Adds the margin on all sides.
fn widen(bounds: Bounds) -> Bounds {
    let largest = bounds.min.iter().chain(&bounds.max).fold(0.0_f32, |a, b| a.max(b.abs()));
    let margin = (f64::from(largest.max(bounds.radius)) * MARGIN) as f32;
    Bounds {
        min: bounds.min.map(|c| c - margin),
        max: bounds.max.map(|c| c + margin),
        center: bounds.center,
        radius: bounds.radius + margin,
    }
}

#[cfg(test)]
mod tests;
