//! Full detail as the fit sees it: its triangles, posed in the frames that count, with points spread over it.

use super::charts::Charts;
use super::pairs::{Pair, mix};
use super::pulls::{FLAT_TILT_SHARE, TILT_SHARE, slide_shares};
use super::repaint::Look;
use crate::closest::{ClosestTriangles, NodeGroups};
use crate::frames::draw_evenly;
use crate::interpenetration::find_layers;
use crate::measure::{Sample, spread_samples};
use crate::quadrics::{dot, pose_position, sub};
use crate::{CollapseOrder, LodMesh, LodPoses, Mat3x4};
use rayon::prelude::*;

/// Posed vertices kept at most, over all frames: 400 MB.
const POSED_LIMIT: usize = 1 << 25;

/// A frame that counts.
pub(crate) struct Frame<'a> {
    /// One matrix per joint.
    pub palette: &'a [Mat3x4],
    /// Share of the frame in the mean; all sum to about 1.
    pub weight: f64,
    /// Full detail's vertices in this frame.
    pub posed: Vec<[f32; 3]>,
    /// Its triangles in this frame.
    pub tree: ClosestTriangles,
}

/// The surface that a level is held against.
pub(crate) struct FullDetail<'a> {
    pub mesh: &'a LodMesh<'a>,
    /// The order's triangles, in vertices of `mesh`.
    pub triangles: Vec<[u32; 3]>,
    pub charts: Charts,
    /// Layer of each triangle: what hangs together by place.
    pub layers: Vec<u32>,
    /// Of the nodes of the frames' trees.
    pub groups: NodeGroups,
    /// What a squared slide of the texture counts in each triangle, next to a squared distance.
    pub slide_shares: Vec<f64>,
    /// Material of each triangle.
    pub materials: Vec<u16>,
    /// What tilts count in each triangle.
    pub tilt_shares: Vec<f64>,
    pub frames: Vec<Frame<'a>>,
    /// All frames there are, those that do not count too.
    pub poses: LodPoses<'a>,
}

impl<'a> FullDetail<'a> {
    /// Poses the order's triangles in at most `frame_limit` frames.
    pub fn new(mesh: &'a LodMesh<'a>, poses: &LodPoses<'a>, order: &CollapseOrder, frame_limit: u32) -> Self {
        let triangles: Vec<[u32; 3]> = order.triangle_source.iter().map(|&t| mesh.triangles[t as usize]).collect();
        let limit = (frame_limit as usize).clamp(1, (POSED_LIMIT / mesh.positions.len().max(1)).max(1));
        let tree = ClosestTriangles::new(mesh.positions, &triangles);
        let layers = find_layers(mesh.positions, &triangles);
        let groups = tree.group_by(layers.clone());
        let frames = draw_evenly(poses.frame_weights, limit)
            .into_par_iter()
            .map(|(frame, weight)| {
                let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
                let pose = |v: usize| pose_position(mesh.positions[v], mesh.joints[v], mesh.weights[v], palette);
                let posed: Vec<[f32; 3]> = (0..mesh.positions.len()).map(pose).collect();
                let mut tree = tree.clone();
                tree.refit(&posed, &triangles);
                Frame { palette, weight: f64::from(weight), posed, tree }
            })
            .collect();
        let materials: Vec<u16> = order.triangle_source.iter().map(|&t| mesh.triangle_materials[t as usize]).collect();
        let charts = Charts::new(mesh, &triangles, &materials);
        let slide_shares = slide_shares(mesh, &triangles, &order.triangle_source);
        let is_flat = |m: &u16| mesh.appearance.flat_materials.get(usize::from(*m)).copied().unwrap_or(false);
        let tilt_shares = materials.iter().map(|m| if is_flat(m) { FLAT_TILT_SHARE } else { TILT_SHARE }).collect();
        Self { mesh, triangles, charts, layers, groups, slide_shares, materials, tilt_shares, frames, poses: *poses }
    }

    /// Colour of a vertex, linear.
    pub fn tint(&self, v: u32) -> [f32; 3] {
        let [r, g, b, _] = self.mesh.colors[v as usize].map(|c| f32::from(c) / 255.0);
        [r, g, b]
    }

    /// Whether colours between vertices are known.
    pub fn knows_colors(&self) -> bool {
        self.mesh.appearance.textures.is_some()
    }

    /// The colour that a material shows, sRGB; black where nobody knows.
    pub fn color(&self, material: u16, uv: [f32; 2], tint: [f32; 3]) -> [f32; 3] {
        self.mesh.appearance.textures.map_or([0.0; 3], |textures| textures.color(material, uv, tint))
    }

    /// The colour that full detail shows in a triangle.
    pub fn color_in(&self, triangle: u32, weights: [f32; 3]) -> [f32; 3] {
        let corners = self.triangles[triangle as usize];
        let uvs = corners.map(|v| self.mesh.uvs[v as usize]);
        let uv = [0, 1].map(|i| (0..3).map(|k| uvs[k][i] * weights[k]).sum());
        self.color(self.materials[triangle as usize], uv, mix(corners.map(|v| self.tint(v)), weights))
    }

    /// Whether a triangle shows one colour all over: no texture, and all its corners tinted alike.
    pub fn is_plain(&self, triangle: u32) -> bool {
        let material = self.materials[triangle as usize];
        let [a, b, c] = self.triangles[triangle as usize].map(|v| self.mesh.colors[v as usize]);
        a == b && b == c && self.mesh.appearance.textures.is_some_and(|t| t.differ_in_color_alone(material, material))
    }

    /// What a plain triangle shows; `None` for others.
    pub fn plain_look(&self, triangle: u32) -> Option<Look> {
        let first = self.triangles[triangle as usize][0];
        self.is_plain(triangle).then(|| (self.materials[triangle as usize], self.mesh.colors[first as usize]))
    }

    /// Whether a triangle is shaded by its own normal.
    pub fn is_flat(&self, triangle: u32) -> bool {
        let material = usize::from(self.materials[triangle as usize]);
        self.mesh.appearance.flat_materials.get(material).copied().unwrap_or(false)
    }

    /// Mean square of a length in the frames over the same length in bind space.
    pub fn scale_squared(&self) -> f64 {
        let sum = |positions: &[[f32; 3]]| -> f64 {
            let edge = |t: &[u32; 3]| {
                let along = sub(positions[t[1] as usize], positions[t[0] as usize]);
                f64::from(dot(along, along))
            };
            self.triangles.iter().map(edge).sum()
        };
        let bind = sum(self.mesh.positions);
        let posed: f64 = self.frames.iter().map(|f| f.weight * sum(&f.posed)).sum();
        if bind > 0.0 { posed / bind } else { 1.0 }
    }

    /// The texture coordinate where a pair touches full detail.
    pub fn uv_at(&self, pair: &Pair) -> [f32; 2] {
        let at = self.triangles[pair.full_triangle as usize].map(|v| self.mesh.uvs[v as usize]);
        let w = pair.full_weights;
        [0, 1].map(|i| at[0][i] * w[0] + at[1][i] * w[1] + at[2][i] * w[2])
    }

    /// The corners of the triangle where a pair touches full detail, in the pair's frame.
    pub fn corners_at(&self, pair: &Pair) -> [[f32; 3]; 3] {
        self.triangles[pair.full_triangle as usize].map(|v| self.frames[pair.frame as usize].posed[v as usize])
    }

    /// Points spread evenly over the bind pose.
    pub fn spread(&self, count: u32) -> Vec<Sample> {
        spread_samples(self.mesh.positions, &self.triangles, count)
    }
}
