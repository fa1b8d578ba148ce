//! Finds the closest triangle to a point: a box tree built once and refitted for each pose.

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

    /// Squared distance from a point to the closest triangle, `None` when there is no triangle.
    pub fn distance_squared(&self, point: [f32; 3], positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<f32> {
        if self.nodes.is_empty() {
            return None;
        }
        let mut best = f32::INFINITY;
        // Halving splits of fewer than 2^28 triangles: the stack never holds more than one node a level.
        let mut stack = [(0_u32, 0.0_f32); 64];
        let mut depth = 1;
        stack[0] = (0, self.box_distance(0, point));
        while depth > 0 {
            depth -= 1;
            let (at, distance) = stack[depth];
            if distance >= best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    let corners = triangles[t as usize].map(|v| positions[v as usize]);
                    best = best.min(triangle_distance_squared(point, corners));
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
        Some(best)
    }

    fn box_distance(&self, node: u32, point: [f32; 3]) -> f32 {
        let node = &self.nodes[node as usize];
        let outside = [0, 1, 2].map(|i| (node.low[i] - point[i]).max(point[i] - node.high[i]).max(0.0));
        dot(outside, outside)
    }
}

/// Squared distance from a point to a triangle: to its plane when the point is above it, else to its edges.
fn triangle_distance_squared(point: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> f32 {
    let n = cross(sub(b, a), sub(c, a));
    let inside = |from: [f32; 3], to: [f32; 3]| dot(cross(n, sub(to, from)), sub(point, from)) >= 0.0;
    let length_squared = dot(n, n);
    if length_squared > f32::MIN_POSITIVE && inside(a, b) && inside(b, c) && inside(c, a) {
        let height = dot(n, sub(point, a));
        return height * height / length_squared;
    }
    let to_edges = [(a, b), (b, c), (c, a)].map(|(from, to)| segment_distance_squared(point, from, to));
    to_edges[0].min(to_edges[1]).min(to_edges[2])
}

fn segment_distance_squared(point: [f32; 3], from: [f32; 3], to: [f32; 3]) -> f32 {
    let along = sub(to, from);
    let offset = sub(point, from);
    let length_squared = dot(along, along);
    let share = if length_squared > 0.0 { (dot(offset, along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    let rest = [0, 1, 2].map(|i| offset[i] - share * along[i]);
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
                prop_assert_eq!(tree.distance_squared(point, positions, &triangles), Some(least));
            }
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
    fn no_triangle_is_no_distance() {
        assert_eq!(ClosestTriangles::new(&[], &[]).distance_squared([0.0; 3], &[], &[]), None);
    }
}
