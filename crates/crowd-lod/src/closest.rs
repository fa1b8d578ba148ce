//! Finds the closest triangle to a point: a box tree built once and refitted for each pose.

mod point;

pub(crate) use point::Hit;

use crate::quadrics::{cross, dot, sub};

/// Triangles in a leaf at most.
const LEAF_SIZE: usize = 4;

#[derive(Debug, Clone, Copy)]
struct Node {
    low: [f32; 3],
    high: [f32; 3],
    /// Triangles below, in the tree's order.
    start: u32,
    end: u32,
    /// Second child; the first one follows the node. 0 in a leaf.
    second: u32,
}

/// Groups of triangles, as [`ClosestTriangles::group_by`] notes them.
#[derive(Debug)]
pub(crate) struct NodeGroups {
    of_triangle: Vec<u32>,
    /// The group that all triangles below a node are of, or `u32::MAX`.
    of_node: Vec<u32>,
}

/// A box tree over the triangles of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct ClosestTriangles {
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl ClosestTriangles {
    /// Sorts triangles into a tree by their place in `positions`; [`Self::refit`] must follow.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let centres: Vec<[f32; 3]> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                [0, 1, 2].map(|i| a[i] + b[i] + c[i])
            })
            .collect();
        let mut tree = Self { order: (0..triangles.len() as u32).collect(), nodes: Vec::new() };
        if !triangles.is_empty() {
            tree.split(&centres, 0, triangles.len());
        }
        tree
    }

    fn split(&mut self, centres: &[[f32; 3]], start: usize, end: usize) {
        let node = self.nodes.len();
        let (low, high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        self.nodes.push(Node { low, high, start: start as u32, end: end as u32, second: 0 });
        if end - start <= LEAF_SIZE {
            return;
        }
        let (mut low, mut high) = (low, high);
        for &t in &self.order[start..end] {
            for i in 0..3 {
                low[i] = low[i].min(centres[t as usize][i]);
                high[i] = high[i].max(centres[t as usize][i]);
            }
        }
        let extent = sub(high, low);
        let axis =
            if extent[0] >= extent[1] && extent[0] >= extent[2] { 0 } else { 1 + usize::from(extent[2] > extent[1]) };
        let middle = (end - start) / 2;
        self.order[start..end].select_nth_unstable_by(middle, |&a, &b| {
            centres[a as usize][axis].total_cmp(&centres[b as usize][axis]).then(a.cmp(&b))
        });
        self.split(centres, start, start + middle);
        self.nodes[node].second = self.nodes.len() as u32;
        self.split(centres, start + middle, end);
    }

    /// Fits the boxes to moved positions.
    pub fn refit(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) {
        for i in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[i];
            node.low = [f32::INFINITY; 3];
            node.high = [f32::NEG_INFINITY; 3];
            let mut include = |low: [f32; 3], high: [f32; 3]| {
                for k in 0..3 {
                    node.low[k] = node.low[k].min(low[k]);
                    node.high[k] = node.high[k].max(high[k]);
                }
            };
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    triangles[t as usize].iter().for_each(|&v| include(positions[v as usize], positions[v as usize]));
                }
            } else {
                for child in [i + 1, node.second as usize] {
                    include(self.nodes[child].low, self.nodes[child].high);
                }
            }
            self.nodes[i] = node;
        }
    }

    /// For each triangle, its place in the tree: triangles next to each other are so in space too.
    pub fn places(&self) -> Vec<u32> {
        let mut places = vec![0; self.order.len()];
        for (place, &t) in self.order.iter().enumerate() {
            places[t as usize] = place as u32;
        }
        places
    }

    /// The triangle closest to a point and its squared distance, `None` when there is no triangle. `hint`: a triangle that is likely
    /// close, where the search starts; beyond their number for none.
    pub fn closest(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        hint: u32,
    ) -> Option<(u32, f32)> {
        self.close_enough(point, positions, triangles, hint, 0.0)
    }

    /// Like [`Self::closest`], but a triangle at most `enough` (squared) away ends the search, though another may be closer.
    pub fn close_enough(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        hint: u32,
        enough: f32,
    ) -> Option<(u32, f32)> {
        if self.nodes.is_empty() {
            return None;
        }
        let (mut best, mut found) = match triangles.get(hint as usize) {
            Some(t) => (triangle_distance_squared(point, t.map(|v| positions[v as usize])), hint),
            None => (f32::INFINITY, self.order[0]),
        };
        // Halving splits of fewer than 2^28 triangles: the stack never holds more than one node a level.
        let mut stack = [(0_u32, 0.0_f32); 64];
        let mut depth = 1;
        stack[0] = (0, self.box_distance(0, point));
        while depth > 0 && best > enough {
            depth -= 1;
            let (at, distance) = stack[depth];
            if distance >= best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    let corners = triangles[t as usize].map(|v| positions[v as usize]);
                    let squared = triangle_distance_squared(point, corners);
                    if squared < best {
                        (best, found) = (squared, t);
                    }
                }
                continue;
            }
            let (a, b) = (at + 1, node.second);
            let (to_a, to_b) = (self.box_distance(a, point), self.box_distance(b, point));
            let (near, far) = if to_a <= to_b { ((a, to_a), (b, to_b)) } else { ((b, to_b), (a, to_a)) };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
        Some((found, best))
    }

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
                    let corners = triangles[t as usize].map(|v| positions[v as usize]);
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

    /// Notes which nodes hold triangles of one group alone. `of_triangle`: each triangle's group, below `u32::MAX`.
    pub fn group_by(&self, of_triangle: Vec<u32>) -> NodeGroups {
        let groups = &of_triangle;
        let of = |node: &Node| {
            let first = groups[self.order[node.start as usize] as usize];
            let below = &self.order[node.start as usize..node.end as usize];
            if below.iter().all(|&t| groups[t as usize] == first) { first } else { u32::MAX }
        };
        let of_node = self.nodes.iter().map(of).collect();
        NodeGroups { of_triangle, of_node }
    }

    /// Squared distance to the closest triangle of another group than `own`, and which one.
    pub fn closest_of_others(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        groups: &NodeGroups,
        own: u32,
    ) -> Option<(f32, u32)> {
        let mut best: Option<(f32, u32)> = None;
        let mut stack = vec![0_u32];
        while let Some(at) = stack.pop() {
            let reach = best.map_or(f32::INFINITY, |b| b.0);
            if groups.of_node[at as usize] == own || self.box_distance(at, point) >= reach {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    if groups.of_triangle[t as usize] != own {
                        let corners = triangles[t as usize].map(|v| positions[v as usize]);
                        let distance = triangle_distance_squared(point, corners);
                        if best.is_none_or(|b| distance < b.0) {
                            best = Some((distance, t));
                        }
                    }
                }
                continue;
            }
            let (a, b) = (at + 1, node.second);
            let near_first = self.box_distance(a, point) <= self.box_distance(b, point);
            let (near, far) = if near_first { (a, b) } else { (b, a) };
            stack.push(far);
            stack.push(near);
        }
        best
    }

    fn box_distance(&self, node: u32, point: [f32; 3]) -> f32 {
        let node = &self.nodes[node as usize];
        let mut squared = 0.0;
        for i in 0..3 {
            let outside = (node.low[i] - point[i]).max(point[i] - node.high[i]).max(0.0);
            squared += outside * outside;
        }
        squared
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

/// Squared distance from a point to a triangle: to its plane when the point is above it, else to its edges.
pub(crate) fn triangle_distance_squared(point: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> f32 {
    let n = cross(sub(b, a), sub(c, a));
    let length_squared = dot(n, n);
    let flat = length_squared <= f32::MIN_POSITIVE;
    // The closest point lies on an edge that the point is beyond.
    let mut least = f32::INFINITY;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        if flat || dot(cross(n, sub(to, from)), sub(point, from)) < 0.0 {
            least = least.min(segment_distance_squared(point, from, to));
        }
    }
    if least < f32::INFINITY {
        return least;
    }
    let height = dot(n, sub(point, a));
    height * height / length_squared
}

fn segment_distance_squared(point: [f32; 3], from: [f32; 3], to: [f32; 3]) -> f32 {
    let along = sub(to, from);
    let offset = sub(point, from);
    let length_squared = dot(along, along);
    let share = if length_squared > 0.0 { (dot(offset, along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    let rest = [offset[0] - share * along[0], offset[1] - share * along[1], offset[2] - share * along[2]];
    dot(rest, rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = [f32; 3]> {
        [-4.0_f32..4.0, -4.0_f32..4.0, -4.0_f32..4.0]
    }

    proptest! {
        #[test]
        fn tree_finds_what_trying_all_finds(
            built in prop::collection::vec([place(), place(), place()], 1..80),
            moved in prop::collection::vec([place(), place(), place()], 80),
            point in place(),
        ) {
            let triangles: Vec<[u32; 3]> = (0..built.len() as u32).map(|i| [i * 3, i * 3 + 1, i * 3 + 2]).collect();
            let mut tree = ClosestTriangles::new(built.as_flattened(), &triangles);
            for positions in [built.as_flattened(), &moved.as_flattened()[..built.len() * 3]] {
                tree.refit(positions, &triangles);
                let all = triangles.iter().map(|t| triangle_distance_squared(point, t.map(|v| positions[v as usize])));
                let least = all.fold(f32::INFINITY, f32::min);
                for hint in [u32::MAX, 0, built.len() as u32 - 1] {
                    let (found, squared) = tree.closest(point, positions, &triangles, hint).expect("a triangle");
                    prop_assert_eq!(squared, least);
                    let corners = triangles[found as usize].map(|v| positions[v as usize]);
                    prop_assert_eq!(triangle_distance_squared(point, corners), least);
                    // A search that may stop early stops within what is enough, or with the closest.
                    let early = tree.close_enough(point, positions, &triangles, hint, least * 2.0).expect("a triangle");
                    prop_assert!(early.1 >= least && early.1 <= least * 2.0);
                }
                let hit = tree.closest_point(point, positions, &triangles, None, None).expect("a triangle");
                let again = tree.closest_point(point, positions, &triangles, None, Some(0));
                prop_assert_eq!(again, Some(hit));
                prop_assert!((hit.distance_squared - least).abs() <= 1.0e-4 * least.max(1.0));
                let corners = triangles[hit.triangle as usize].map(|v| positions[v as usize]);
                let at = [0, 1, 2].map(|k| (0..3).map(|c| hit.weights[c] * corners[c][k]).sum::<f32>());
                let gap = dot(sub(point, at), sub(point, at));
                prop_assert!((gap - least).abs() <= 1.0e-2 * least.max(1.0), "{gap} {least}");
            }
        }

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
            let triangles: Vec<[u32; 3]> = (0..built.len() as u32).map(|i| [i * 3, i * 3 + 1, i * 3 + 2]).collect();
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
    fn distance_to_a_triangle_by_hand() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        for (point, squared) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([2.0, -2.0, 0.0], 4.0),
            ([4.0, 4.0, 0.0], 8.0),
            ([6.0, 0.0, 1.0], 5.0),
        ] {
            let found = triangle_distance_squared(point, triangle);
            assert!((found - squared).abs() < 1.0e-5, "{point:?}: {found}");
        }
        let thread = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert_eq!(triangle_distance_squared([1.0, 2.0, 0.0], thread), 4.0);
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

    #[test]
    fn no_triangle_is_no_distance() {
        assert_eq!(ClosestTriangles::new(&[], &[]).closest([0.0; 3], &[], &[], 0), None);
    }
}
