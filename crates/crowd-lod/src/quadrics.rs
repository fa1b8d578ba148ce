//! What a collapse costs: plane quadrics of every position in every frame (Peng 2011 §4.2).
//!
//! Frames lie in lanes of eight, so that one block is one vector operation and sums have one order on every machine.
//! A position's quadric is kept relative to the position itself: at first all its planes pass through it, so no digits cancel,
//! and what it has cost so far is one number, the mean over frames, rather than one a frame.
//!
//! `dispatch!` compiles a kernel for wider vectors too and runs what the machine has; no multiply and add is ever fused, so every one gives the same bits.

use crate::classify::EdgeKind;
use crate::lists::Lists;
use crate::split_seams::SplitMesh;
use crate::{Criteria, LodMesh, LodPoses, Mat3x4};
use fearless_simd::{Level as Vectors, dispatch};
use lanes::{LANES, Lanes, lanes_cross, lanes_dot, lanes_sub, sum_lanes, weighted_sum};
use posing::pose_in_lanes;
use rayon::prelude::*;

mod lanes;
mod posing;
#[cfg(test)]
mod tests;

/// Weight of the plane that holds an open border, per squared edge length (a triangle's plane weighs its area).
const BORDER_WEIGHT: f32 = 2.0;
/// The same for a seam, from both sides.
const SEAM_WEIGHT: f32 = 0.07;
/// What it weighs more per squared difference of the colours on its two sides: where red meets white, a seam that moves is seen.
const SEAM_CONTRAST_WEIGHT: f32 = 1.5;
/// How many times as much that is where no texture changes on either side: there the seam is all that shows (decisions 0058, 0085).
const PLAIN_SEAM_FACTOR: f32 = 8.0;
/// What the worst frame adds to the mean: enough that no single pose breaks, too little to spend triangles on it alone.
const WORST_WEIGHT: f32 = 0.2;

/// Symmetric 3x3 `A` (xx xy xz yy yz zz) and vector `b`: mean squared distance to the planes at `d` is
/// `d·A·d + 2 b·d` plus the constant kept apart.
type QuadricBlock = [Lanes; 9];

/// Quadrics of all positions over all frames.
#[derive(Debug)]
pub(crate) struct Quadrics {
    vectors: Vectors,
    block_count: usize,
    frame_weights: Vec<Lanes>,
    worst_weight: f32,
    /// `[position][block]`: x, y, z, metres.
    posed: Vec<[Lanes; 3]>,
    /// `[position][block]`, relative to the posed position.
    planes: Vec<QuadricBlock>,
    /// For each position, the mean over frames of its quadric at itself, m² times m².
    paid: Vec<f32>,
    /// For each position, the mean area of the triangles in its quadric, m².
    areas: Vec<f32>,
}

impl Quadrics {
    /// Poses the mesh in all frames and gathers the planes around each position.
    ///
    /// `edge_kinds` as [`crate::classify::Classes`] gives them.
    pub fn build(
        mesh: &LodMesh<'_>,
        poses: &LodPoses<'_>,
        split: &SplitMesh,
        edge_kinds: &[[EdgeKind; 3]],
        criteria: Criteria,
    ) -> Self {
        let worst_weight = if criteria == Criteria::Peng2011 { 0.0 } else { WORST_WEIGHT };
        let position_count = split.position_source.len();
        let block_count = poses.frame_weights.len().div_ceil(LANES);
        let mut frame_weights = vec![[0.0; LANES]; block_count];
        for (i, &weight) in poses.frame_weights.iter().enumerate() {
            frame_weights[i / LANES][i % LANES] = weight;
        }
        let vectors = Vectors::new();
        let posed = pose_in_lanes(vectors, mesh, poses, split, block_count);
        let incident = Lists::incident(position_count, split.triangles.iter().map(|t| t.map(|v| split.position_of(v))));
        let mut spreads = color_spreads(mesh, split);
        let contrast = mesh.appearance.triangle_contrast;
        let is_plain = |t: u32| contrast.get(split.triangle_source[t as usize] as usize) == Some(&0.0);
        stress_plain(&mut spreads, &incident, is_plain);
        let mut planes = vec![[[0.0; LANES]; 9]; position_count * block_count];
        let mut areas = vec![0.0; position_count];
        planes.par_chunks_mut(block_count.max(1)).zip(&mut areas).enumerate().for_each(|(p, (blocks, area))| {
            let corner = |&t: &u32| {
                let corners = split.triangles[t as usize].map(|v| split.position_of(v) as usize);
                let at = corners.iter().position(|&q| q == p).expect("listed because it touches the position");
                let kinds = edge_kinds[t as usize];
                let edges = [(kinds[at], corners[(at + 1) % 3]), (kinds[(at + 2) % 3], corners[(at + 2) % 3])];
                let weights = edges.map(|(kind, to)| edge_weight(kind, spreads[p].min(spreads[to])));
                ([0, 1, 2].map(|i| corners[(at + i) % 3] * block_count), weights)
            };
            let around: Vec<([usize; 3], [f32; 2])> = incident.at(p).iter().map(corner).collect();
            dispatch!(vectors, _ => *area = sum_triangles(&around, &posed, &frame_weights, blocks));
        });
        let paid = vec![0.0; position_count];
        Self { vectors, block_count, frame_weights, worst_weight, posed, planes, paid, areas }
    }

    /// What `u`'s quadric costs at `t`: its mean over frames, and a share of the worst frame's.
    pub fn move_cost(&self, u: u32, t: u32) -> f32 {
        let (mean, worst) = self.mean_and_worst(u, t);
        // `paid` is the quadric at the position itself, which the lanes leave out.
        (mean + self.worst_weight * worst + self.paid[u as usize]).max(0.0)
    }

    /// Mean and largest over frames of what `u`'s quadric costs at `t` more than where `u` is.
    fn mean_and_worst(&self, u: u32, t: u32) -> (f32, f32) {
        let blocks = |p: u32| p as usize * self.block_count..(p as usize + 1) * self.block_count;
        let (from, to, planes) = (&self.posed[blocks(u)], &self.posed[blocks(t)], &self.planes[blocks(u)]);
        dispatch!(self.vectors, _ => mean_and_worst(from, to, planes, &self.frame_weights))
    }

    /// Cost of moving `u` to `t`, given [`Self::move_cost`]: both quadrics at `t`.
    pub fn total_cost(&self, move_cost: f32, t: u32) -> f32 {
        move_cost + self.paid[t as usize]
    }

    /// Area that a merged quadric stands for, m².
    pub fn merged_area(&self, u: u32, t: u32) -> f32 {
        self.areas[u as usize] + self.areas[t as usize]
    }

    /// What a position's quadric costs where it is, m² times m².
    pub fn paid(&self, p: u32) -> f32 {
        self.paid[p as usize]
    }

    /// Area that a position's quadric stands for, m².
    pub fn area(&self, p: u32) -> f32 {
        self.areas[p as usize]
    }

    /// Squared distance of two positions, mean over frames, m².
    pub fn distance_squared(&self, u: u32, t: u32) -> f32 {
        let from = u as usize * self.block_count;
        let to = t as usize * self.block_count;
        let mut sum = [0.0; LANES];
        for b in 0..self.block_count {
            let (a, c, w) = (&self.posed[from + b], &self.posed[to + b], &self.frame_weights[b]);
            for i in 0..LANES {
                let (x, y, z) = (c[0][i] - a[0][i], c[1][i] - a[1][i], c[2][i] - a[2][i]);
                sum[i] += w[i] * (x * x + y * y + z * z);
            }
        }
        sum_lanes(&sum)
    }

    /// Adds `u`'s quadric to `t`'s.
    pub fn merge(&mut self, u: u32, t: u32, move_cost: f32) {
        let (from, to) = (u as usize * self.block_count, t as usize * self.block_count);
        let Self { vectors, block_count, posed, planes, .. } = self;
        dispatch!(*vectors, _ => {
            for b in 0..*block_count {
                let source = planes[from + b];
                add_moved(&source, &posed[from + b], &posed[to + b], &mut planes[to + b]);
            }
        });
        self.paid[t as usize] += move_cost;
        self.areas[t as usize] += self.areas[u as usize];
    }
}

/// Mean and largest over frames of what a quadric costs at `to` more than at `from`.
#[inline(always)]
fn mean_and_worst(from: &[[Lanes; 3]], to: &[[Lanes; 3]], planes: &[QuadricBlock], weights: &[Lanes]) -> (f32, f32) {
    let mut sum = [0.0; LANES];
    let mut most = [0.0_f32; LANES];
    for (((a, c), q), w) in from.iter().zip(to).zip(planes).zip(weights) {
        for i in 0..LANES {
            let (x, y, z) = (c[0][i] - a[0][i], c[1][i] - a[1][i], c[2][i] - a[2][i]);
            let row_x = q[0][i] * x + 2.0 * (q[1][i] * y + q[2][i] * z + q[6][i]);
            let row_y = q[3][i] * y + 2.0 * (q[4][i] * z + q[7][i]);
            let row_z = q[5][i] * z + 2.0 * q[8][i];
            let cost = row_x * x + row_y * y + row_z * z;
            sum[i] += w[i] * cost;
            most[i] = most[i].max(cost);
        }
    }
    (sum_lanes(&sum), most.iter().fold(0.0_f32, |a, &b| a.max(b)))
}

/// Adds a quadric to another one elsewhere.
#[inline(always)]
fn add_moved(source: &QuadricBlock, from: &[Lanes; 3], to: &[Lanes; 3], target: &mut QuadricBlock) {
    for i in 0..LANES {
        let (x, y, z) = (to[0][i] - from[0][i], to[1][i] - from[1][i], to[2][i] - from[2][i]);
        for k in 0..6 {
            target[k][i] += source[k][i];
        }
        target[6][i] += source[6][i] + source[0][i] * x + source[1][i] * y + source[2][i] * z;
        target[7][i] += source[7][i] + source[1][i] * x + source[3][i] * y + source[4][i] * z;
        target[8][i] += source[8][i] + source[2][i] * x + source[4][i] * y + source[5][i] * z;
    }
}

/// Sums the planes of the triangles around a position to its quadric, and gives back their mean area. Of each triangle, where the
/// blocks of its corners begin, that at the position first, and what the edges there weigh.
#[inline(always)]
fn sum_triangles(
    around: &[([usize; 3], [f32; 2])],
    posed: &[[Lanes; 3]],
    frame_weights: &[Lanes],
    blocks: &mut [QuadricBlock],
) -> f32 {
    let mut area = 0.0;
    for (b, block) in blocks.iter_mut().enumerate() {
        // Summed apart: fresh memory that is read before it is written costs the system twice.
        let (mut sum, mut block_area) = ([[0.0; LANES]; 9], [0.0; LANES]);
        for &(starts, edge_weights) in around {
            add_triangle(starts.map(|start| &posed[start + b]), edge_weights, &mut sum, &mut block_area);
        }
        *block = sum;
        area += weighted_sum(&block_area, &frame_weights[b]);
    }
    area
}

/// What a plane that holds an edge weighs per squared edge length. `contrast`: squared difference of the colours on its two sides.
fn edge_weight(kind: EdgeKind, contrast: f32) -> f32 {
    match kind {
        EdgeKind::Interior => 0.0,
        EdgeKind::Seam => SEAM_WEIGHT + SEAM_CONTRAST_WEIGHT * contrast,
        EdgeKind::Border | EdgeKind::NonManifold => BORDER_WEIGHT,
    }
}

/// For each position, the largest squared difference between the colours that its variants show.
fn color_spreads(mesh: &LodMesh<'_>, split: &SplitMesh) -> Vec<f32> {
    let shown = |v: usize| {
        let source = split.variant_source[v] as usize;
        let tint = mesh.colors[source];
        let color = mesh.appearance.shown_colors.get(source).copied();
        color.unwrap_or_else(|| [0, 1, 2].map(|i| f32::from(tint[i]) / 255.0))
    };
    let mut spreads = vec![0.0_f32; split.position_source.len()];
    let mut firsts: Vec<Option<[f32; 3]>> = vec![None; spreads.len()];
    for v in 0..split.variant_wedge.len() {
        let p = split.position_of(v as u32) as usize;
        match firsts[p] {
            None => firsts[p] = Some(shown(v)),
            Some(first) => {
                let d = sub(shown(v), first);
                spreads[p] = spreads[p].max(dot(d, d));
            }
        }
    }
    spreads
}

/// Lets differences count for more at positions around which no triangle shows a change of texture.
fn stress_plain(spreads: &mut [f32], incident: &Lists<u32>, is_plain: impl Fn(u32) -> bool) {
    for (p, spread) in spreads.iter_mut().enumerate() {
        if incident.at(p).iter().all(|&t| is_plain(t)) {
            *spread *= PLAIN_SEAM_FACTOR;
        }
    }
}

/// Adds the plane of a triangle, and those that hold its edges, to the quadric of its first corner.
///
/// `edge_weights`: of the edges from the first corner to the second, and from the third to the first; 0 for none.
#[inline(always)]
fn add_triangle(positions: [&[Lanes; 3]; 3], edge_weights: [f32; 2], block: &mut QuadricBlock, area: &mut Lanes) {
    let [p, q, r] = positions;
    let (e, f) = (lanes_sub(q, p), lanes_sub(r, p));
    let n = lanes_cross(&e, &f);
    let squared = lanes_dot(&n, &n);
    let (mut unit, mut weight) = ([[0.0; LANES]; 3], [0.0; LANES]);
    for i in 0..LANES {
        let length = squared[i].sqrt();
        // A triangle of no area in a frame has no plane there: nothing is added.
        let flat = length <= f32::MIN_POSITIVE;
        for k in 0..3 {
            unit[k][i] = if flat { 0.0 } else { n[k][i] / length };
        }
        weight[i] = if flat { 0.0 } else { length * 0.5 };
        area[i] += weight[i];
    }
    add_plane(block, &unit, &weight);
    for (edge, edge_weight) in [(&e, edge_weights[0]), (&f, edge_weights[1])] {
        if edge_weight == 0.0 {
            continue;
        }
        let across = lanes_cross(edge, &unit);
        let (across_squared, edge_squared) = (lanes_dot(&across, &across), lanes_dot(edge, edge));
        let (mut normal, mut edge_weights) = ([[0.0; LANES]; 3], [0.0; LANES]);
        for i in 0..LANES {
            let length = across_squared[i].sqrt();
            let plane = length > f32::MIN_POSITIVE;
            for k in 0..3 {
                normal[k][i] = if plane { across[k][i] / length } else { 0.0 };
            }
            edge_weights[i] = if plane { edge_weight * edge_squared[i] } else { 0.0 };
        }
        add_plane(block, &normal, &edge_weights);
    }
}

#[inline(always)]
fn add_plane(block: &mut QuadricBlock, n: &[Lanes; 3], weight: &Lanes) {
    for (k, (a, b)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
        for i in 0..LANES {
            block[k][i] += weight[i] * (n[a][i] * n[b][i]);
        }
    }
}

/// One skinned position: the weighted sum of its joints' matrices at work on it (Peng 2011 Eq. 2).
pub(crate) fn pose_position(position: [f32; 3], joints: [u16; 4], weights: [f32; 4], palette: &[Mat3x4]) -> [f32; 3] {
    let [x, y, z] = position;
    let mut out = [0.0; 3];
    for k in 0..4 {
        if weights[k] != 0.0 {
            let m = &palette[joints[k] as usize];
            for row in 0..3 {
                out[row] += weights[k] * (m[row][0] * x + m[row][1] * y + m[row][2] * z + m[row][3]);
            }
        }
    }
    out
}

pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
