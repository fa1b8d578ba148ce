//! Finds the closest triangle to a point: a box tree built once and refitted for each pose.

mod distance;
mod frames;
mod lines;
mod point;
mod slabs;

pub(crate) use distance::{distances_of_lanes, distances_squared, triangle_distance_squared};
pub(crate) use frames::FrameBoxes;
pub(crate) use lines::line_crosses_triangle;
pub(crate) use point::{Hit, closest_on_triangle};

use crate::quadrics::sub;
use slabs::Slab;

/// Triangles in a leaf at most.
const LEAF_SIZE: usize = 4;
/// A limit that no box lies within.
const NOTHING: f32 = -1.0;

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
#[derive(Debug, Default)]
pub(crate) struct NodeGroups {
    of_triangle: Vec<u32>,
    /// The group that all triangles below a node are of, or `u32::MAX`.
    of_node: Vec<u32>,
}

impl NodeGroups {
    /// The group of a triangle.
    pub fn group_of(&self, triangle: u32) -> u32 {
        self.of_triangle[triangle as usize]
    }

    /// Whether triangles of a group may lie below a node.
    fn may_hold(&self, node: u32, group: u32) -> bool {
        let of_node = self.of_node[node as usize];
        of_node == group || of_node == u32::MAX
    }
}

/// How many triangles below each node of a tree are still of interest.
#[derive(Debug, Default)]
pub(crate) struct LivingNodes {
    of_node: Vec<u32>,
    /// Node above each one; the first one is above itself.
    above: Vec<u32>,
    /// Leaf of each triangle.
    leaf_of: Vec<u32>,
}

impl LivingNodes {
    /// A triangle is of no interest any more.
    pub fn remove(&mut self, triangle: u32) {
        let mut node = self.leaf_of[triangle as usize];
        loop {
            self.of_node[node as usize] -= 1;
            if node == 0 {
                return;
            }
            node = self.above[node as usize];
        }
    }
}

/// A box tree over the triangles of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct ClosestTriangles {
    order: Vec<u32>,
    nodes: Vec<Node>,
    /// Whether it is a mesh of needles, whose nodes have further boxes.
    needles: bool,
    slabs: Vec<Slab>,
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
        let order = (0..triangles.len() as u32).collect();
        let mut tree = Self { order, nodes: Vec::new(), needles: false, slabs: Vec::new() };
        if !triangles.is_empty() {
            tree.split(&centres, 0, triangles.len());
            tree.needles = tree.is_of_needles(positions, triangles);
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
        if self.needles {
            self.fit_slabs(positions, triangles);
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
        let (mut best, mut found) = match triangles.get(hint as usize) {
            Some(t) => (triangle_distance_squared(point, corners_of(*t, positions)), hint),
            None => (f32::INFINITY, *self.order.first()?),
        };
        let limit = |best: f32| if best <= enough { NOTHING } else { best };
        self.descend(
            point,
            limit(best),
            |_| true,
            |leaf| {
                for (&t, squared) in leaf.iter().zip(leaf_distances(point, positions, triangles, leaf)) {
                    if squared < best {
                        (best, found) = (squared, t);
                    }
                }
                limit(best)
            },
        );
        Some((found, best))
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

    /// Counts the triangles below each node, all of them of interest.
    pub fn count_living(&self) -> LivingNodes {
        let mut living = LivingNodes {
            of_node: self.nodes.iter().map(|node| node.end - node.start).collect(),
            above: vec![0; self.nodes.len()],
            leaf_of: vec![0; self.order.len()],
        };
        for (at, node) in self.nodes.iter().enumerate() {
            if node.second == 0 {
                let below = &self.order[node.start as usize..node.end as usize];
                below.iter().for_each(|&t| living.leaf_of[t as usize] = at as u32);
            } else {
                living.above[at + 1] = at as u32;
                living.above[node.second as usize] = at as u32;
            }
        }
        living
    }

    /// Squared distance to the closest triangle of the groups that are `wanted`, and which one. `living`: at least the triangles of those.
    pub fn closest_of_groups(
        &self,
        point: [f32; 3],
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        groups: &NodeGroups,
        living: &LivingNodes,
        wanted: impl Fn(u32) -> bool,
    ) -> Option<(f32, u32)> {
        let mut best: Option<(f32, u32)> = None;
        let holds = |node: u32| {
            let group = groups.of_node[node as usize];
            living.of_node[node as usize] > 0 && (group == u32::MAX || wanted(group))
        };
        self.descend(point, f32::INFINITY, holds, |leaf| {
            for (&t, squared) in leaf.iter().zip(leaf_distances(point, positions, triangles, leaf)) {
                if best.is_none_or(|b| squared < b.0) && wanted(groups.of_triangle[t as usize]) {
                    best = Some((squared, t));
                }
            }
            best.map_or(f32::INFINITY, |b| b.0)
        });
        best
    }

    /// Goes down to the leaves whose box lies nearer to a point than the limit, the nearer of two children first. `limit`: a squared
    /// distance; `visit` gets the triangles of a leaf and gives the limit from then on, [`NOTHING`] to end. `enter`: whether a
    /// node is of interest at all.
    fn descend(
        &self,
        point: [f32; 3],
        mut limit: f32,
        enter: impl Fn(u32) -> bool,
        mut visit: impl FnMut(&[u32]) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        // Halving splits of fewer than 2^28 triangles: the stack never holds more than one node a level.
        let mut stack = [(0_u32, 0.0_f32); 64];
        let mut depth = 1;
        stack[0] = (0, self.box_distance(0, point));
        while depth > 0 {
            depth -= 1;
            let (at, distance) = stack[depth];
            if distance >= limit || !enter(at) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second == 0 {
                limit = visit(&self.order[node.start as usize..node.end as usize]);
                continue;
            }
            let (a, b) = (at + 1, node.second);
            let (to_a, to_b) = (self.box_distance(a, point), self.box_distance(b, point));
            let (near, far) = if to_a <= to_b { ((a, to_a), (b, to_b)) } else { ((b, to_b), (a, to_a)) };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
    }

    #[inline(always)]
    fn box_distance(&self, at: u32, point: [f32; 3]) -> f32 {
        let node = &self.nodes[at as usize];
        let mut squared = 0.0;
        for i in 0..3 {
            let outside = (node.low[i] - point[i]).max(point[i] - node.high[i]).max(0.0);
            squared += outside * outside;
        }
        if self.needles { self.slabs[at as usize].distance(point).max(squared) } else { squared }
    }
}

/// Squared distances of a point to the triangles of a leaf; what exceeds their number repeats the first.
fn leaf_distances(point: [f32; 3], positions: &[[f32; 3]], triangles: &[[u32; 3]], leaf: &[u32]) -> [f32; LEAF_SIZE] {
    let mut corners = [[[0.0; 3]; 3]; LEAF_SIZE];
    for (i, corners) in corners.iter_mut().enumerate() {
        let t = *leaf.get(i).unwrap_or(&leaf[0]);
        *corners = corners_of(triangles[t as usize], positions);
    }
    distances_squared(&[point; LEAF_SIZE], &corners)
}

/// Where the corners of a triangle lie. Spelt out, for the searches spend their time here and in the distance.
#[inline]
pub(crate) fn corners_of([a, b, c]: [u32; 3], positions: &[[f32; 3]]) -> [[f32; 3]; 3] {
    [positions[a as usize], positions[b as usize], positions[c as usize]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrics::dot;
    use crate::test_meshes::{loose_triangles, place};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tree_finds_what_trying_all_finds(
            built in prop::collection::vec([place(), place(), place()], 1..80),
            moved in prop::collection::vec([place(), place(), place()], 80),
            point in place(),
        ) {
            let triangles = loose_triangles(built.len());
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
                let group: Vec<u32> = (0..triangles.len() as u32).map(|t| t / 8 % 3).collect();
                let groups = tree.group_by(group.clone());
                let own = tree.closest_point_in(point, positions, &triangles, None, Some(0), Some((&groups, 0)));
                let own = own.expect("the first triangles are of group 0");
                let least_own = triangles
                    .iter()
                    .zip(&group)
                    .filter(|(_, group)| **group == 0)
                    .map(|(t, _)| triangle_distance_squared(point, t.map(|v| positions[v as usize])))
                    .fold(f32::INFINITY, f32::min);
                prop_assert_eq!(group[own.triangle as usize], 0);
                prop_assert!((own.distance_squared - least_own).abs() <= 1.0e-4 * least_own.max(1.0));
                let corners = triangles[hit.triangle as usize].map(|v| positions[v as usize]);
                let at = [0, 1, 2].map(|k| (0..3).map(|c| hit.weights[c] * corners[c][k]).sum::<f32>());
                let gap = dot(sub(point, at), sub(point, at));
                prop_assert!((gap - least).abs() <= 1.0e-2 * least.max(1.0), "{gap} {least}");
            }
        }
    }

    #[test]
    fn no_triangle_is_no_distance() {
        assert_eq!(ClosestTriangles::new(&[], &[]).closest([0.0; 3], &[], &[], 0), None);
    }
}
