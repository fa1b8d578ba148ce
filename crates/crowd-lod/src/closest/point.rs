//! Finds the closest point itself, not its distance alone.

use super::{ClosestTriangles, NodeGroups, corners_of};
use crate::quadrics::{cross, dot, sub};

/// The closest point of a mesh to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// Triangle it lies on.
    pub triangle: u32,
    /// Weights of the triangle's corners, summing to 1; exactly 0 for a corner across an edge or vertex it lies on.
    pub weights: [f32; 3],
    /// Squared distance.
    pub distance_squared: f32,
}

impl ClosestTriangles {
    /// The closest point on the triangles whose normal has a part along `facing` (on all of them without it); the lowest
    /// triangle where several are equally close. `first`: a triangle that is likely close, for speed alone.
    pub fn closest_point(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        facing: Option<[f32; 3]>,
        first: Option<u32>,
    ) -> Option<Hit> {
        self.closest_point_in(point, positions, triangles, facing, first, None)
    }

    /// The same among the triangles of one group, where one is given.
    pub fn closest_point_in(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        facing: Option<[f32; 3]>,
        first: Option<u32>,
        within: Option<(&NodeGroups, u32)>,
    ) -> Option<Hit> {
        self.closest_point_near(point, positions, triangles, facing, first, within, f32::INFINITY)
    }

    /// The same, not looking much farther than `farthest`, a squared distance.
    #[expect(clippy::too_many_arguments, reason = "one search, spelt out")]
    pub fn closest_point_near(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        facing: Option<[f32; 3]>,
        first: Option<u32>,
        within: Option<(&NodeGroups, u32)>,
        farthest: f32,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let try_triangle = |t: u32, best: &mut Option<Hit>| {
            if within.is_some_and(|(groups, own)| groups.of_triangle[t as usize] != own) {
                return;
            }
            let corners = corners_of(triangles[t as usize], positions);
            if let Some(facing) = facing {
                let n = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
                let faces = dot(n, facing) > 0.0;
                if !faces {
                    return;
                }
            }
            let (weights, distance_squared) = closest_on_triangle(point, corners);
            let nearer = |hit: Hit| (distance_squared, t) < (hit.distance_squared, hit.triangle);
            if best.is_none_or(nearer) {
                *best = Some(Hit { triangle: t, weights, distance_squared });
            }
        };
        // An equally close triangle may be a lower one.
        let limit = |best: Option<Hit>| {
            best.map_or(f32::INFINITY, |hit| hit.distance_squared.next_up()).min(farthest.next_up())
        };
        if let Some(t) = first.filter(|&t| (t as usize) < triangles.len()) {
            try_triangle(t, &mut best);
        }
        self.descend(
            point,
            limit(best),
            |node| within.is_none_or(|(groups, own)| groups.may_hold(node, own)),
            |leaf| {
                leaf.iter().for_each(|&t| try_triangle(t, &mut best));
                limit(best)
            },
        );
        best
    }
}

/// Weights of the corners at the triangle's closest point, and the squared distance to it.
pub(crate) fn closest_on_triangle(point: [f32; 3], corners: [[f32; 3]; 3]) -> ([f32; 3], f32) {
    let [a, b, c] = corners;
    let n = cross(sub(b, a), sub(c, a));
    let length_squared = dot(n, n);
    if length_squared > f32::MIN_POSITIVE {
        let part = |from: [f32; 3], to: [f32; 3]| dot(cross(sub(to, from), sub(point, from)), n);
        let (over_a, over_b, over_c) = (part(b, c), part(c, a), part(a, b));
        if over_a >= 0.0 && over_b >= 0.0 && over_c >= 0.0 {
            let height = dot(n, sub(point, a));
            let (v, w) = (over_b / length_squared, over_c / length_squared);
            return ([(1.0 - v - w).max(0.0), v, w], height * height / length_squared);
        }
    }
    let mut best = ([1.0, 0.0, 0.0], f32::INFINITY);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let along = sub(corners[j], corners[i]);
        let offset = sub(point, corners[i]);
        let length_squared = dot(along, along);
        let share = if length_squared > 0.0 { (dot(offset, along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
        let rest = [0, 1, 2].map(|k| offset[k] - share * along[k]);
        let distance_squared = dot(rest, rest);
        if distance_squared < best.1 {
            let mut weights = [0.0; 3];
            weights[i] = 1.0 - share;
            weights[j] = share;
            best = (weights, distance_squared);
        }
    }
    best
}
