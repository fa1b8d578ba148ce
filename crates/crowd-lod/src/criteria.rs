//! Which collapses are allowed: seams, borders, topology and flips (Peng 2011 §4.2).

use crate::behind::diagonal;
use crate::fan::{Fan, Lie};
use crate::find_images::{Image, Moved};
use crate::frames::draw_evenly;
use crate::quadrics::{dot, pose_position};
use crate::split_seams::SplitMesh;
use crate::topology::{Spoke, Topology};
use crate::{Criteria, LodMesh, LodPoses, Obstacle, VertexClass};
use fearless_simd::{Level as Vectors, dispatch};
use rayon::prelude::*;

/// Posed frames, besides the bind pose, in which triangles may not flip.
const FLIP_FRAMES: usize = 4;
/// Cosine of the most that a triangle may turn in one collapse.
const MIN_TURN_COS: f32 = 0.1;
/// What a triangle costs that has turned by more than a right angle since full detail, as a distance over its area, in shares of the
/// mesh's diagonal.
const TURNED_SHARE: f32 = 0.02;
/// Texture width below which a triangle has no side in the texture: two texels of 1024. Triangles that show one colour of a
/// palette are dots or threads there, and turning them shows nothing; a stricter test costs the KayKit knight 10 % of its
/// reach and a fifth of its error at 25 %.
const MIN_UV_WIDTH: f64 = 2.0 / 1024.0;
/// Positions with more triangles stay until they have fewer: to move a hub would make a fan of slivers, slowly.
pub(crate) const MAX_MOVED_VALENCE: usize = 128;
/// Two neighbours that both have more triangles than this are not asked whether they meet, which would take their product's
/// time on a hostile mesh: the collapse is refused.
const MAX_SCANNED_VALENCE: usize = 512;

/// The rules and what they look at that does not change.
#[derive(Debug, Clone)]
pub(crate) struct Rules {
    vectors: Vectors,
    criteria: Criteria,
    /// Cost of a square metre that lies more than a right angle from how it lay at full detail, m².
    turned_cost: f32,
    /// Positions that never move.
    locked: Vec<bool>,
    /// Wedges each position had at full detail, where all must keep an image (Peng 2011); else empty.
    required_wedges: Vec<u32>,
    /// Frames tested besides the bind pose.
    frame_count: usize,
    /// What each tested pose weighs in a mean over frames: the bind pose nothing.
    pose_weights: [f32; POSES],
    /// For each position its places in the tested poses: x, y, z, one lane a pose, bind pose first.
    posed: Vec<Places>,
    /// For each triangle its normals at full detail in the tested poses, twice the area long.
    first_normals: Vec<Places>,
}

/// Poses tested at once: the bind pose, the frames, and the bind pose again in the lanes left over.
pub(crate) const POSES: usize = 8;
/// A place or a direction in each tested pose.
pub(crate) type Places = [[f32; POSES]; 3];

impl Rules {
    /// Prepares the rules for a mesh.
    pub fn new(
        mesh: &LodMesh<'_>,
        poses: &LodPoses<'_>,
        split: &SplitMesh,
        criteria: Criteria,
        non_manifold: &[bool],
        wedge_class: &[VertexClass],
    ) -> Self {
        let mut locked = vec![false; non_manifold.len()];
        let mut required_wedges = Vec::new();
        if criteria == Criteria::Peng2011 {
            locked = non_manifold.to_vec();
            required_wedges = vec![0; locked.len()];
            for (wedge, &class) in wedge_class.iter().enumerate() {
                let p = split.wedge_position[wedge] as usize;
                locked[p] |= class == VertexClass::Fixed;
                required_wedges[p] += 1;
            }
        }
        let frames = draw_evenly(poses.frame_weights, FLIP_FRAMES);
        let place = |&v: &u32| {
            let v = v as usize;
            let mut places = mesh.positions[v].map(|c| [c; POSES]);
            for (lane, &(frame, _)) in frames.iter().enumerate() {
                let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
                let posed = pose_position(mesh.positions[v], mesh.joints[v], mesh.weights[v], palette);
                (0..3).for_each(|i| places[i][1 + lane] = posed[i]);
            }
            places
        };
        let posed: Vec<Places> = split.position_source.par_iter().map(place).collect();
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| &posed[split.position_of(v) as usize]);
            normals(a, b, c)
        };
        let first_normals = split.triangles.par_iter().map(normal).collect();
        let bind: Vec<[f32; 3]> = posed.iter().map(|places| places.map(|c| c[0])).collect();
        let mut pose_weights = [0.0; POSES];
        pose_weights[1..=frames.len()].fill(1.0 / frames.len() as f32);
        let turned = TURNED_SHARE * diagonal(&bind);
        Self {
            vectors: Vectors::new(),
            criteria,
            turned_cost: turned * turned,
            locked,
            required_wedges,
            frame_count: frames.len(),
            pose_weights,
            posed,
            first_normals,
        }
    }

    /// Which criteria these are.
    pub fn criteria(&self) -> Criteria {
        self.criteria
    }

    /// Positions in each pose in which collapses are tested, bind pose first.
    pub fn poses(&self) -> Vec<Vec<[f32; 3]>> {
        let pose = |lane: usize| self.posed.iter().map(|places| places.map(|c| c[lane])).collect();
        (0..=self.frame_count).map(pose).collect()
    }

    /// Positions in some poses, bind pose first.
    pub fn some_poses(&self) -> [Vec<[f32; 3]>; 2] {
        [0, self.frame_count.div_ceil(2)].map(|lane| self.posed.iter().map(|places| places.map(|c| c[lane])).collect())
    }

    /// Whether position `u` may move at all, wherever it goes.
    pub fn may_move(&self, topology: &Topology, u: u32) -> bool {
        !self.locked[u as usize] && topology.valence(u) <= MAX_MOVED_VALENCE
    }

    /// Squared distance of two positions in bind pose, m².
    pub fn bind_distance_squared(&self, u: u32, t: u32) -> f32 {
        let [a, b] = [t, u].map(|p| self.posed[p as usize].map(|c| c[0]));
        let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        dot(d, d)
    }

    /// What each tested pose weighs in a mean over frames: the bind pose nothing.
    pub fn pose_weights(&self) -> [f32; POSES] {
        self.pose_weights
    }

    /// A position in each tested pose.
    pub fn places(&self, p: u32) -> &Places {
        &self.posed[p as usize]
    }

    /// Whether `u` may collapse onto the other end of `edge`, which is one of `u`'s `spokes`.
    ///
    /// The paper's criteria: each wedge of `u` needs one image in a triangle on the edge. For companions
    /// that is Peng 2011's condition 2; its condition 1 lets a regular vertex go anywhere, but a slit's
    /// end that moves along its slit would leave a triangle of no width, so we ask it of regular vertices too. Link
    /// condition and flip test are ours: they keep every prefix of the order a valid mesh.
    pub fn check(
        &self,
        topology: &Topology,
        split: &SplitMesh,
        u: u32,
        spokes: &[Spoke],
        edge: &Spoke,
    ) -> Result<(), Obstacle> {
        self.check_border(topology, u, spokes, edge)?;
        self.check_wedges(topology, split, u, edge)?;
        self.check_link(topology, u, spokes, edge)?;
        self.check_flips(topology, split, u, edge)
    }

    /// Whether the centre of `fan`, which is measured, may collapse onto the other end of `edge`, and what is charged for it, m² times m²: the
    /// default criteria.
    ///
    /// Seams, charts and topology have a cost and no veto: every wedge has an image (see `find_images`), and what loses its last triangle
    /// is charged by the caller. An open border moves along itself. No triangle turns over in one step in a tested pose; one that ends up
    /// more than a right angle from how it lay at full detail, or turned over in the texture, is charged its area.
    pub fn charge(
        &self,
        split: &SplitMesh,
        fan: &Fan,
        spokes: &[Spoke],
        edge: &Spoke,
        moved: &[Moved],
    ) -> Result<f32, Obstacle> {
        let on_border = spokes.iter().any(|s| s.triangle_count == 1);
        if on_border && edge.triangle_count != 1 {
            return Err(Obstacle::Fixed);
        }
        let turned_area = dispatch!(self.vectors, _ => self.turned_area(split, fan, edge.to, moved));
        turned_area.map(|area| area * self.turned_cost).ok_or(Obstacle::Flip)
    }

    /// Area of the triangles that end up turned when the centre of `fan` moves to `t`, m²; `None` if one turns over in the step.
    #[inline(always)]
    fn turned_area(&self, split: &SplitMesh, fan: &Fan, t: u32, moved: &[Moved]) -> Option<f32> {
        let mut turned_area = 0.0;
        for (blade, lie) in fan.staying(t) {
            let corners = [t, blade.others[0], blade.others[1]].map(|p| &self.posed[p as usize]);
            let (after, turned_over) = turn(lie, corners, &self.first_normals[blade.triangle as usize])?;
            let [own, q, r] = blade.variants;
            let turned_uv = || {
                let uv = |variant: u32| split.variant_uv[variant as usize].map(f64::from);
                let image = moved.iter().find(|m| m.variant == own).map(|m| m.image);
                let shown = match image.expect("every variant was mapped") {
                    Image::Variant(image) => uv(image),
                    Image::StandIn { uv_of, .. } => uv(uv_of),
                };
                uv_loses_side(lie.uv_side, [shown, uv(q), uv(r)])
            };
            if turned_over || turned_uv() {
                turned_area += 0.5 * dot(after, after).sqrt();
            }
        }
        Some(turned_area)
    }

    /// A position on a border moves along it, and only where the border is a plain line.
    fn check_border(&self, topology: &Topology, u: u32, spokes: &[Spoke], edge: &Spoke) -> Result<(), Obstacle> {
        let border_edges = spokes.iter().filter(|s| s.triangle_count == 1).count();
        let manifold = spokes.iter().all(|s| s.triangle_count <= 2);
        let along = border_edges == 0 || (border_edges == 2 && edge.triangle_count == 1);
        if self.may_move(topology, u) && manifold && along { Ok(()) } else { Err(Obstacle::Fixed) }
    }

    /// Each wedge of `u` needs exactly one image among `t`'s wedges in the triangles on the edge.
    fn check_wedges(&self, topology: &Topology, split: &SplitMesh, u: u32, edge: &Spoke) -> Result<(), Obstacle> {
        let wedge_at = |triangle: u32, p: u32| wedge_at(topology, split, triangle, p);
        let t = edge.to;
        let mut images: [(u32, u32); 2] = [(u32::MAX, u32::MAX); 2];
        for i in 0..edge.triangle_count.min(2) as usize {
            images[i] = (wedge_at(edge.triangles[i], u), wedge_at(edge.triangles[i], t));
        }
        if images[0].0 == images[1].0 && images[0].1 != images[1].1 {
            return Err(Obstacle::Seam);
        }
        for triangle in topology.around(u) {
            let wedge = wedge_at(triangle, u);
            if wedge != images[0].0 && wedge != images[1].0 {
                return Err(Obstacle::Seam);
            }
        }
        if let Some(&required) = self.required_wedges.get(u as usize) {
            let found = if images[1].0 == u32::MAX || images[0].0 == images[1].0 { 1 } else { 2 };
            if found < required {
                return Err(Obstacle::Seam);
            }
        }
        Ok(())
    }

    /// Link condition: the ends share no neighbour but those opposite the edge, and no triangle is made twice.
    fn check_link(&self, topology: &Topology, u: u32, spokes: &[Spoke], edge: &Spoke) -> Result<(), Obstacle> {
        let t = edge.to;
        let opposite = |i: usize| {
            let corners = topology.triangle_positions[edge.triangles[i] as usize];
            corners.into_iter().find(|&p| p != u && p != t).expect("a living triangle has three positions")
        };
        let opposites = [opposite(0), opposite(1)];
        for spoke in spokes.iter().filter(|s| s.to != t) {
            if topology.valence(spoke.to).min(topology.valence(t)) > MAX_SCANNED_VALENCE {
                return Err(Obstacle::Topology);
            }
            let count_at_target = topology.edge_triangle_count(spoke.to, t);
            if !opposites.contains(&spoke.to) {
                if count_at_target > 0 {
                    return Err(Obstacle::Topology);
                }
                continue;
            }
            // The edges to u and to t become one; the triangle between them dies.
            let merged = spoke.triangle_count - 1 + count_at_target.saturating_sub(1);
            if merged == 0 || (merged > 2 && merged > count_at_target) {
                return Err(Obstacle::Topology);
            }
        }
        if edge.triangle_count == 2 {
            // Two triangles with the same three positions: collapsing would fold one onto the other.
            let between = |t: u32| topology.touches(t, opposites[0]) && topology.touches(t, opposites[1]);
            if opposites[0] == opposites[1] || topology.around(u).any(between) {
                return Err(Obstacle::Topology);
            }
        }
        Ok(())
    }

    /// No triangle that stays may turn over in a tested pose, or in the texture: neither much in one step, nor, step by
    /// step, by more than a right angle from how it lay at full detail.
    fn check_flips(&self, topology: &Topology, split: &SplitMesh, u: u32, edge: &Spoke) -> Result<(), Obstacle> {
        let t = edge.to;
        for triangle in topology.around(u).filter(|&triangle| !topology.touches(triangle, t)) {
            let corner = topology.corner_at(triangle, u);
            let positions = topology.triangle_positions[triangle as usize];
            let (a, b) = (positions[(corner + 1) % 3], positions[(corner + 2) % 3]);
            let variants = topology.triangles[triangle as usize];
            let uv = |i: usize| split.variant_uv[variants[(corner + i) % 3] as usize].map(f64::from);
            let before = normals(self.places(u), self.places(a), self.places(b));
            let uv_side = uv_side([uv(0), uv(1), uv(2)]);
            let lie = Lie { normals: before, squared: product(&before, &before), uv_side };
            if self.turn(triangle, &lie, t, [a, b]).is_none_or(|(_, turned_over)| turned_over) {
                return Err(Obstacle::Flip);
            }
            let image = image_across(topology, split, triangle, u, edge);
            let target = split.variant_uv[image as usize].map(f64::from);
            if uv_loses_side(uv_side, [target, uv(1), uv(2)]) {
                return Err(Obstacle::Flip);
            }
        }
        Ok(())
    }
}

impl Rules {
    /// The normal in bind pose, twice the area long, of a triangle that lies as `lie` says, after its corner beside the two `others` moved to
    /// `t`, and whether it lies in some pose more than a right angle from how it lay at full detail; `None` if it turns over.
    fn turn(&self, triangle: u32, lie: &Lie, t: u32, others: [u32; 2]) -> Option<([f32; 3], bool)> {
        let corners = [t, others[0], others[1]].map(|p| &self.posed[p as usize]);
        dispatch!(self.vectors, _ => turn(lie, corners, &self.first_normals[triangle as usize]))
    }

    /// What the machine can do at once.
    pub fn vectors(&self) -> Vectors {
        self.vectors
    }
}

/// The normal in bind pose and whether it turned far, from where a triangle lay, where its corners are now, and its first normals.
#[inline(always)]
fn turn(lie: &Lie, [t, a, b]: [&Places; 3], first: &Places) -> Option<([f32; 3], bool)> {
    let after = normals(t, a, b);
    let (after_squared, along) = (product(&after, &after), product(&lie.normals, &after));
    let mut over = 0_u32;
    for i in 0..POSES {
        let limit = MIN_TURN_COS * (lie.squared[i] * after_squared[i]).sqrt();
        over |= u32::from(lie.squared[i] > 0.0) & u32::from(along[i] <= limit);
    }
    if over != 0 {
        return None;
    }
    let (first_squared, along_first) = (product(first, first), product(first, &after));
    let mut far = 0_u32;
    for i in 0..POSES {
        far |= u32::from(first_squared[i] > 0.0) & u32::from(along_first[i] <= 0.0);
    }
    Some(([after[0][0], after[1][0], after[2][0]], far != 0))
}

/// A variant of the wedge that the wedge of `triangle` at `u` becomes; only for edges that passed the wedge test.
fn image_across(topology: &Topology, split: &SplitMesh, triangle: u32, u: u32, edge: &Spoke) -> u32 {
    let wedge = wedge_at(topology, split, triangle, u);
    let first = edge.triangles[0];
    let on_edge = if wedge_at(topology, split, first, u) == wedge { first } else { edge.triangles[1] };
    topology.triangles[on_edge as usize][topology.corner_at(on_edge, edge.to)]
}

fn wedge_at(topology: &Topology, split: &SplitMesh, triangle: u32, p: u32) -> u32 {
    let corner = topology.corner_at(triangle, p);
    split.variant_wedge[topology.triangles[triangle as usize][corner] as usize]
}

/// Scalar products in each pose.
#[inline(always)]
pub(crate) fn product(a: &Places, b: &Places) -> [f32; POSES] {
    let mut products = [0.0; POSES];
    for i in 0..POSES {
        products[i] = a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
    }
    products
}

/// Normals of a triangle in each pose, twice the area long.
#[inline(always)]
pub(crate) fn normals(a: &Places, b: &Places, c: &Places) -> Places {
    let (mut x, mut y, mut z) = ([0.0; POSES], [0.0; POSES], [0.0; POSES]);
    for i in 0..POSES {
        let (ex, ey, ez) = (b[0][i] - a[0][i], b[1][i] - a[1][i], b[2][i] - a[2][i]);
        let (fx, fy, fz) = (c[0][i] - a[0][i], c[1][i] - a[1][i], c[2][i] - a[2][i]);
        x[i] = ey * fz - ez * fy;
        y[i] = ez * fx - ex * fz;
        z[i] = ex * fy - ey * fx;
    }
    [x, y, z]
}

/// Twice the signed area of a triangle in the texture, if it has a side there.
pub(crate) fn uv_side([a, b, c]: [[f64; 2]; 3]) -> Option<f64> {
    let area = uv_area([a, b, c]);
    let longest = uv_length(a, b).max(uv_length(b, c)).max(uv_length(c, a));
    (area.abs() > MIN_UV_WIDTH * longest).then_some(area)
}

/// Whether a triangle that had a side loses it or shows the other one.
pub(crate) fn uv_loses_side(side: Option<f64>, after: [[f64; 2]; 3]) -> bool {
    side.is_some_and(|area| area * uv_area(after) <= 0.0)
}

/// Twice the signed area of a triangle in the texture.
pub(crate) fn uv_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn uv_length(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    (x * x + y * y).sqrt()
}
