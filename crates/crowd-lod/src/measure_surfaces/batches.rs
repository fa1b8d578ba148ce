//! A few frames side by side: each vertex has its places in all of them in one row, a lane a frame, so that a point is looked at in
//! all of them at once.

use super::points::Target;
use crate::closest::{ClosestTriangles, FrameBoxes};
use crate::measure::Sample;
use fearless_simd::{Level as Vectors, dispatch};
use std::cell::OnceCell;

/// Frames of a batch from which on they are searched at once.
pub(super) const FRAMES_AT_ONCE: usize = 3;

/// Frames of a batch.
pub(super) const LANES: usize = 8;

/// Coordinates of a place in the frames of a batch.
pub(super) type Row = [[f32; LANES]; 3];

/// Frames that are looked at together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Batch {
    pub first: usize,
    /// At most [`LANES`].
    pub count: usize,
}

impl Batch {
    /// All frames, the last ones first.
    pub fn all(frame_count: usize) -> Vec<Self> {
        let ends = (0..frame_count.div_ceil(LANES)).map(|batch| frame_count - batch * LANES);
        let batch = |end: usize| Self { first: end.saturating_sub(LANES), count: end.min(LANES) };
        ends.map(batch).collect()
    }

    pub fn frames(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }
}

/// The rows of `vertices`; lanes beyond the frames repeat the last one.
pub(super) fn rows(frames: &[&[[f32; 3]]], vertices: impl Iterator<Item = usize>) -> Vec<Row> {
    let Some(last) = frames.len().checked_sub(1) else { return Vec::new() };
    let row = |v: usize| {
        let mut row = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let place = frames[lane.min(last)][v];
            (0..3).for_each(|k| row[k][lane] = place[k]);
        }
        row
    };
    vertices.map(row).collect()
}

/// Vertices in the order in which triangles in a tree's order use them, unused ones last: neighbours then lie side by side in memory.
pub(super) struct NearOrder {
    pub vertices: Vec<u32>,
    /// For each vertex its place among these.
    pub place_of: Vec<u32>,
}

impl NearOrder {
    /// `places`: each triangle's place in the tree.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]], places: &[u32]) -> Self {
        let mut by_place = vec![0_usize; triangles.len()];
        places.iter().enumerate().for_each(|(t, &place)| by_place[place as usize] = t);
        let mut order = Self { vertices: Vec::with_capacity(vertex_count), place_of: vec![u32::MAX; vertex_count] };
        let used = by_place.iter().flat_map(|&t| triangles[t]);
        for v in used.chain(0..vertex_count as u32) {
            if order.place_of[v as usize] == u32::MAX {
                order.place_of[v as usize] = order.vertices.len() as u32;
                order.vertices.push(v);
            }
        }
        order
    }

    /// Triangles with places in the place of vertices.
    pub fn map(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        triangles.iter().map(|t| t.map(|v| self.place_of[v as usize])).collect()
    }
}

/// A mesh in the frames of a batch, to take points from and to search.
pub(super) struct Side<'a> {
    pub triangles: &'a [[u32; 3]],
    rows: Rows<'a>,
    positions: Vec<&'a [[f32; 3]]>,
    trees: Trees<'a>,
}

/// Places of vertices in a batch, in an order of their own.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub rows: &'a [Row],
    /// The mesh's triangles, in that order.
    pub triangles: &'a [[u32; 3]],
}

/// A mesh to be searched in all frames of a batch at once.
#[derive(Clone, Copy)]
pub(super) struct InFrames<'a> {
    pub tree: &'a ClosestTriangles,
    pub boxes: &'a FrameBoxes<LANES>,
    pub rows: Rows<'a>,
}

/// Its box trees, a frame each.
enum Trees<'a> {
    Ready(Vec<&'a ClosestTriangles>),
    /// Fitted to a frame when it is searched first.
    OfRest(&'a ClosestTriangles, Vec<OnceCell<ClosestTriangles>>, OnceCell<FrameBoxes<LANES>>),
}

/// The boxes of a tree in the frames of a batch.
pub(super) fn boxes_in_frames(tree: &ClosestTriangles, rows: Rows<'_>) -> FrameBoxes<LANES> {
    dispatch!(Vectors::new(), _ => tree.boxes_in_frames(rows.rows, rows.triangles))
}

impl<'a> Side<'a> {
    /// With trees that are fitted already, one a frame.
    pub fn ready(
        triangles: &'a [[u32; 3]],
        rows: Rows<'a>,
        positions: Vec<&'a [[f32; 3]]>,
        trees: Vec<&'a ClosestTriangles>,
    ) -> Self {
        Self { triangles, rows, positions, trees: Trees::Ready(trees) }
    }

    /// With a tree that fits any frame.
    pub fn of_rest(
        triangles: &'a [[u32; 3]],
        rows: Rows<'a>,
        positions: Vec<&'a [[f32; 3]]>,
        tree: &'a ClosestTriangles,
    ) -> Self {
        Self { triangles, rows, positions, trees: Trees::OfRest(tree, vec![OnceCell::new(); LANES], OnceCell::new()) }
    }

    pub fn positions(&self, lane: usize) -> &'a [[f32; 3]] {
        self.positions[lane]
    }

    /// To be searched in one frame.
    pub fn target(&self, lane: usize) -> Target<'_> {
        let positions = self.positions[lane];
        let tree = match &self.trees {
            Trees::Ready(trees) => trees[lane],
            Trees::OfRest(rest, trees, boxes) => trees[lane].get_or_init(|| {
                if self.positions.len() >= FRAMES_AT_ONCE {
                    let boxes = boxes.get_or_init(|| boxes_in_frames(rest, self.rows));
                    return rest.in_frame(boxes, lane, positions, self.triangles);
                }
                let mut tree = (*rest).clone();
                tree.refit(positions, self.triangles);
                tree
            }),
        };
        Target { positions, triangles: self.triangles, tree }
    }

    /// To be searched in all frames at once. `None` where trees are fitted already.
    pub fn in_frames(&self) -> Option<InFrames<'_>> {
        match &self.trees {
            Trees::Ready(_) => None,
            Trees::OfRest(tree, _, boxes) => {
                let boxes = boxes.get_or_init(|| boxes_in_frames(tree, self.rows));
                Some(InFrames { tree, boxes, rows: self.rows })
            }
        }
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: u32) -> [Row; 3] {
        self.rows.triangles[triangle as usize].map(|v| self.rows.rows[v as usize])
    }

    /// Where a sample lies, as `place_of` has it.
    #[inline(always)]
    pub fn point(&self, sample: &Sample) -> Row {
        let [a, b, c] = self.rows.triangles[sample.triangle as usize].map(|v| &self.rows.rows[v as usize]);
        let [s, t] = sample.weights;
        let r = 1.0 - s - t;
        let mut point = [[0.0; LANES]; 3];
        for k in 0..3 {
            for lane in 0..LANES {
                point[k][lane] = s * a[k][lane] + t * b[k][lane] + r * c[k][lane];
            }
        }
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_every_frame_once_the_last_first() {
        for count in [0, 1, 7, 8, 9, 24, 25] {
            let batches = Batch::all(count);
            let mut frames: Vec<usize> = batches.iter().flat_map(|batch| batch.frames().rev()).collect();
            frames.reverse();
            assert_eq!(frames, (0..count).collect::<Vec<usize>>());
            assert!(batches.iter().all(|batch| (1..=LANES).contains(&batch.count)));
        }
    }

    #[test]
    fn a_lane_has_the_place_of_its_frame_to_the_bit() {
        let number = |i: usize| libm::sinf(i as f32 * 7.31) * 2.0;
        let frames: Vec<Vec<[f32; 3]>> = (0..3)
            .map(|f| {
                (0..3).map(|v| [number(f * 9 + v * 3), number(f * 9 + v * 3 + 1), number(f * 9 + v * 3 + 2)]).collect()
            })
            .collect();
        let positions: Vec<&[[f32; 3]]> = frames.iter().map(Vec::as_slice).collect();
        let triangles = [[2, 0, 1]];
        let order = NearOrder::new(3, &triangles, &[0]);
        assert_eq!(order.vertices, [2, 0, 1]);
        let (rows, mapped) = (rows(&positions, order.vertices.iter().map(|&v| v as usize)), order.map(&triangles));
        let side = Side::ready(&triangles, Rows { rows: &rows, triangles: &mapped }, positions.clone(), Vec::new());
        let sample = Sample { triangle: 0, weights: [0.3, 0.45] };
        let point = side.point(&sample);
        for lane in 0..LANES {
            let placed = super::super::place(&sample, positions[lane.min(2)], &triangles);
            assert_eq!(point.map(|k| k[lane].to_bits()), placed.map(f32::to_bits));
        }
    }
}
