//! Finds the triangles that a line leaves.

use super::{ClosestTriangles, corners_of};
use crate::quadrics::{cross, dot, sub};

impl ClosestTriangles {
    /// Calls `visit` with each triangle through whose front the line through `origin` along `direction`, a unit vector, leaves,
    /// within `reach` to both sides, and with the signed distance from the origin.
    pub fn leaving_line(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        reach: f32,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        mut visit: impl FnMut(u32, f32),
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0_u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            if !line_meets_box(origin, direction, reach, node.low, node.high) {
                continue;
            }
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    let corners = corners_of(triangles[t as usize], positions);
                    if let Some(height) = line_leaves_triangle(origin, direction, corners).filter(|h| h.abs() <= reach)
                    {
                        visit(t, height);
                    }
                }
                continue;
            }
            stack[depth] = node.second;
            stack[depth + 1] = at + 1;
            depth += 2;
        }
    }
}

/// Whether a piece of a line meets a box. May say yes where it only comes near.
fn line_meets_box(origin: [f32; 3], direction: [f32; 3], reach: f32, low: [f32; 3], high: [f32; 3]) -> bool {
    let (mut from, mut to) = (-reach, reach);
    for i in 0..3 {
        if direction[i].abs() < 1.0e-9 {
            if origin[i] < low[i] || origin[i] > high[i] {
                return false;
            }
            continue;
        }
        let (a, b) = ((low[i] - origin[i]) / direction[i], (high[i] - origin[i]) / direction[i]);
        // Rounding must not lose a triangle that lies in its box's side.
        let slack = 1.0e-6 * (1.0 + a.abs().max(b.abs()));
        from = from.max(a.min(b) - slack);
        to = to.min(a.max(b) + slack);
    }
    from <= to
}

/// Where a line leaves through the front of a triangle, as the signed distance from its origin; edges belong to it. None
/// where it enters from the front, or runs along.
pub(crate) fn line_leaves_triangle(origin: [f32; 3], direction: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> Option<f32> {
    let faces = dot(direction, cross(sub(b, a), sub(c, a)));
    if faces > 0.0 { line_crosses_triangle(origin, direction, [a, b, c]) } else { None }
}

/// Where a line crosses a triangle from either side, as the signed distance from its origin; edges belong to it.
pub(crate) fn line_crosses_triangle(origin: [f32; 3], direction: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> Option<f32> {
    let (e, f) = (sub(b, a), sub(c, a));
    let across = cross(direction, f);
    // Minus twice the area times the cosine between line and normal.
    let determinant = dot(e, across);
    if determinant * determinant <= 1.0e-12 * dot(e, e) * dot(f, f) {
        return None;
    }
    let from_a = sub(origin, a);
    let s = dot(from_a, across) / determinant;
    let turned = cross(from_a, e);
    let t = dot(direction, turned) / determinant;
    const EDGE: f32 = 1.0e-5;
    (s >= -EDGE && t >= -EDGE && s + t <= 1.0 + EDGE).then(|| dot(f, turned) / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{loose_triangles, place};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tree_lets_lines_leave_where_trying_all_does(
            built in prop::collection::vec([place(), place(), place()], 1..80),
            origin in place(),
            aim in place(),
            reach in 0.1_f32..6.0,
        ) {
            let length = dot(aim, aim).sqrt();
            prop_assume!(length > 0.01);
            let direction = aim.map(|c| c / length);
            let triangles = loose_triangles(built.len());
            let mut tree = ClosestTriangles::new(built.as_flattened(), &triangles);
            tree.refit(built.as_flattened(), &triangles);
            let mut found = Vec::new();
            tree.leaving_line(origin, direction, reach, built.as_flattened(), &triangles, |t, h| found.push((t, h)));
            found.sort_unstable_by_key(|hit| hit.0);
            let all: Vec<(u32, f32)> = built
                .iter()
                .enumerate()
                .filter_map(|(t, &corners)| Some((t as u32, line_leaves_triangle(origin, direction, corners)?)))
                .filter(|hit| hit.1.abs() <= reach)
                .collect();
            prop_assert_eq!(found, all);
        }
    }

    #[test]
    fn line_through_a_triangle_by_hand() {
        let triangle = [[0.0, 0.0, 2.0], [4.0, 0.0, 2.0], [0.0, 4.0, 2.0]];
        let up = [0.0, 0.0, 1.0];
        assert_eq!(line_leaves_triangle([1.0, 1.0, 0.0], up, triangle), Some(2.0));
        assert_eq!(line_leaves_triangle([1.0, 1.0, 5.0], up, triangle), Some(-3.0));
        assert_eq!(line_leaves_triangle([0.0, 0.0, 0.0], up, triangle), Some(2.0), "a corner belongs to it");
        assert_eq!(line_leaves_triangle([3.0, 3.0, 0.0], up, triangle), None);
        assert_eq!(line_leaves_triangle([1.0, 1.0, 2.0], [1.0, 0.0, 0.0], triangle), None, "edge-on");
        assert_eq!(line_leaves_triangle([1.0, 1.0, 5.0], [0.0, 0.0, -1.0], triangle), None, "from the front");
    }
}
