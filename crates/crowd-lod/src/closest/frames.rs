//! The closest triangle in a few frames at once: a point is near the same triangles in all of them, so one way down a tree serves all.

use super::ClosestTriangles;
use super::distance::{Vectors, distances_of_lanes, lanes};

/// Boxes of a tree's nodes in a few frames, a lane each: lower corner and upper one.
pub(crate) type FrameBoxes<const N: usize> = Vec<[Vectors<N>; 2]>;

/// Nodes still to look into, with their squared distances; kept between searches for its memory alone.
pub(crate) type Waiting<const N: usize> = Vec<(u32, [f32; N])>;

impl ClosestTriangles {
    /// Whether [`Self::closest_in_frames`] is the way to search: needles have further boxes, which it does not look at.
    pub fn suits_frames(&self) -> bool {
        !self.needles
    }

    /// Fitted to one of a few frames: what [`Self::refit`] gives.
    pub fn in_frame<const N: usize>(
        &self,
        boxes: &[[Vectors<N>; 2]],
        frame: usize,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Self {
        let mut tree = self.clone();
        for (node, [low, high]) in tree.nodes.iter_mut().zip(boxes) {
            node.low = [low[0][frame], low[1][frame], low[2][frame]];
            node.high = [high[0][frame], high[1][frame], high[2][frame]];
        }
        if tree.needles {
            tree.fit_slabs(positions, triangles);
        }
        tree
    }

    /// The boxes in a few frames. `rows`: where vertices lie in them, `triangles` over these.
    #[inline(always)]
    pub fn boxes_in_frames<const N: usize>(&self, rows: &[Vectors<N>], triangles: &[[u32; 3]]) -> FrameBoxes<N> {
        let none = [[[f32::INFINITY; N]; 3], [[f32::NEG_INFINITY; N]; 3]];
        let mut boxes = vec![none; self.nodes.len()];
        for i in (0..self.nodes.len()).rev() {
            let node = &self.nodes[i];
            let mut all = none;
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    triangles[t as usize].iter().for_each(|&v| include(&mut all, &rows[v as usize], &rows[v as usize]));
                }
            } else {
                for child in [i + 1, node.second as usize] {
                    include(&mut all, &boxes[child][0], &boxes[child][1]);
                }
            }
            boxes[i] = all;
        }
        boxes
    }

    /// The squared distance to the closest triangle in each frame, as [`Self::closest`] finds it there, and a triangle that is closest in one
    /// of them. `hint`: a triangle that is likely close; beyond their number for none. There must be a triangle.
    #[inline(always)]
    pub fn closest_in_frames<const N: usize>(
        &self,
        boxes: &[[Vectors<N>; 2]],
        point: &Vectors<N>,
        rows: &[Vectors<N>],
        triangles: &[[u32; 3]],
        hint: u32,
        waiting: &mut Waiting<N>,
    ) -> ([f32; N], u32) {
        let (mut best, mut found) = match triangles.get(hint as usize) {
            Some(triangle) => (distances(point, triangle, rows), hint),
            None => ([f32::INFINITY; N], self.order[0]),
        };
        waiting.clear();
        waiting.push((0, box_distances(&boxes[0], point)));
        while let Some((at, to_box)) = waiting.pop() {
            if !any_below(&to_box, &best) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    let squared = distances(point, &triangles[t as usize], rows);
                    if any_below(&squared, &best) {
                        best = lanes(|i| if squared[i] < best[i] { squared[i] } else { best[i] });
                        found = t;
                    }
                }
                continue;
            }
            let (a, b) = (at + 1, node.second);
            let (to_a, to_b) = (box_distances(&boxes[a as usize], point), box_distances(&boxes[b as usize], point));
            let (near, far) = if to_a[0] <= to_b[0] { ((a, to_a), (b, to_b)) } else { ((b, to_b), (a, to_a)) };
            for child in [far, near] {
                if any_below(&child.1, &best) {
                    waiting.push(child);
                }
            }
        }
        (best, found)
    }
}

#[inline(always)]
fn distances<const N: usize>(point: &Vectors<N>, &[a, b, c]: &[u32; 3], rows: &[Vectors<N>]) -> [f32; N] {
    distances_of_lanes(point, &[rows[a as usize], rows[b as usize], rows[c as usize]])
}

#[inline(always)]
fn include<const N: usize>([low, high]: &mut [Vectors<N>; 2], new_low: &Vectors<N>, new_high: &Vectors<N>) {
    for k in 0..3 {
        low[k] = lanes(|i| if new_low[k][i] < low[k][i] { new_low[k][i] } else { low[k][i] });
        high[k] = lanes(|i| if new_high[k][i] > high[k][i] { new_high[k][i] } else { high[k][i] });
    }
}

#[inline(always)]
fn any_below<const N: usize>(values: &[f32; N], limits: &[f32; N]) -> bool {
    let mut any = false;
    for i in 0..N {
        any |= values[i] < limits[i];
    }
    any
}

/// As for one frame.
#[inline(always)]
fn box_distances<const N: usize>([low, high]: &[Vectors<N>; 2], point: &Vectors<N>) -> [f32; N] {
    let mut squared = [0.0; N];
    for k in 0..3 {
        squared = lanes(|i| {
            let outside = (low[k][i] - point[k][i]).max(point[k][i] - high[k][i]).max(0.0);
            squared[i] + outside * outside
        });
    }
    squared
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closest::Node;
    use crate::test_meshes::{loose_triangles, place};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_frames_find_what_each_finds(
            built in prop::collection::vec([place(), place(), place()], 1..80),
            moved in prop::collection::vec([place(), place(), place()], 240),
            points in [place(), place(), place(), place()],
        ) {
            let triangles = loose_triangles(built.len());
            let tree = ClosestTriangles::new(built.as_flattened(), &triangles);
            let frames: [&[[f32; 3]]; 4] = std::array::from_fn(|frame| match frame {
                0 => built.as_flattened(),
                _ => &moved.as_flattened()[(frame - 1) * 240..][..built.len() * 3],
            });
            let rows: Vec<Vectors<4>> =
                (0..built.len() * 3).map(|v| [0, 1, 2].map(|k| lanes(|frame| frames[frame][v][k]))).collect();
            let boxes = tree.boxes_in_frames(&rows, &triangles);
            let point = [0, 1, 2].map(|k| lanes(|frame| points[frame][k]));
            for hint in [u32::MAX, 0, built.len() as u32 - 1] {
                let (squared, found) =
                    tree.closest_in_frames(&boxes, &point, &rows, &triangles, hint, &mut Vec::new());
                prop_assert!((found as usize) < triangles.len());
                for frame in 0..4 {
                    let mut alone = tree.clone();
                    alone.refit(frames[frame], &triangles);
                    let taken = tree.in_frame(&boxes, frame, frames[frame], &triangles);
                    let same = |(a, b): (&Node, &Node)| (a.low, a.high) == (b.low, b.high);
                    prop_assert!(alone.nodes.iter().zip(&taken.nodes).all(same));
                    let (_, least) =
                        alone.closest(points[frame], frames[frame], &triangles, u32::MAX).expect("a triangle");
                    prop_assert_eq!(squared[frame], least);
                }
            }
        }
    }
}
