//! Meshes that tests draw, and what must hold for the order of any mesh.

use crate::criteria::{uv_loses_side, uv_side};
use crate::quadrics::{cross, dot, pose_position, sub};
use crate::split_seams::cos_between;
use crate::{CollapseOrder, Criteria, LodMesh, LodOptions, LodPoses, Mat3x4, reform, simplify};
use proptest::strategy::Strategy;
use std::collections::{BTreeMap, BTreeSet};

pub(crate) const REST: Mat3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A mesh that owns its arrays, skinned to joint 0 unless a test says otherwise.
#[derive(Debug, Clone, Default)]
pub(crate) struct TestMesh {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    pub colors: Vec<[u8; 4]>,
    pub joints: Vec<[u16; 4]>,
    pub weights: Vec<[f32; 4]>,
    pub triangles: Vec<[u32; 3]>,
    pub materials: Vec<u16>,
}

impl TestMesh {
    pub fn vertex(&mut self, position: [f32; 3], uv: [f32; 2]) -> u32 {
        self.positions.push(position);
        self.normals.push([0.0, 0.0, 1.0]);
        self.uvs.push(uv);
        self.colors.push([255; 4]);
        self.joints.push([0; 4]);
        self.weights.push([1.0, 0.0, 0.0, 0.0]);
        self.positions.len() as u32 - 1
    }

    pub fn triangle(&mut self, corners: [u32; 3]) {
        self.triangles.push(corners);
        self.materials.push(0);
    }

    /// Two triangles, counter-clockwise corners.
    pub fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    pub fn mesh(&self) -> LodMesh<'_> {
        LodMesh {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            colors: &self.colors,
            joints: &self.joints,
            weights: &self.weights,
            triangles: &self.triangles,
            triangle_materials: &self.materials,
            appearance: crate::Appearance::default(),
        }
    }

    pub fn append(&mut self, other: &TestMesh) {
        let base = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.uvs.extend(&other.uvs);
        self.colors.extend(&other.colors);
        self.joints.extend(&other.joints);
        self.weights.extend(&other.weights);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
        self.materials.extend(&other.materials);
    }
}

/// Poses that own their arrays.
#[derive(Debug, Clone)]
pub(crate) struct TestPoses {
    pub palettes: Vec<Mat3x4>,
    pub joint_count: usize,
    pub frame_weights: Vec<f32>,
}

impl TestPoses {
    /// One frame in bind pose.
    pub fn rest() -> Self {
        Self { palettes: vec![REST], joint_count: 1, frame_weights: vec![1.0] }
    }

    /// Frames of equal weight.
    pub fn even(palettes: Vec<Mat3x4>, joint_count: usize) -> Self {
        let frames = palettes.len() / joint_count;
        Self { palettes, joint_count, frame_weights: vec![1.0 / frames as f32; frames] }
    }

    pub fn poses(&self) -> LodPoses<'_> {
        LodPoses { palettes: &self.palettes, joint_count: self.joint_count, frame_weights: &self.frame_weights }
    }
}

/// A `width` x `height` grid of quads with unit texture square; `lift` gives the height over a vertex. Vertices on a cut
/// (`cut(column, row)`: the grid edge from vertex (column, row) to (column, row + 1)) are split: what lies right of it has its
/// texture coordinates moved by one.
pub(crate) fn grid(
    width: usize,
    height: usize,
    lift: impl Fn(usize, usize) -> f32,
    cut: impl Fn(usize, usize) -> bool,
) -> TestMesh {
    let mut mesh = TestMesh::default();
    // Fans around a vertex between two cuts share a wedge: above and below, left and right quads.
    let mut made: BTreeMap<(usize, usize, bool), u32> = BTreeMap::new();
    let mut at = |mesh: &mut TestMesh, column: usize, row: usize, right: bool| {
        // A vertex is split when the cut passes through; where a slit ends inside, the sides still meet.
        let above = row < height && cut(column, row);
        let below = row > 0 && cut(column, row - 1);
        let split = (above || row == height) && (below || row == 0);
        let right = right && split;
        *made.entry((column, row, right)).or_insert_with(|| {
            let place = [column as f32, row as f32, lift(column, row)];
            let shift = if right { 2.0 } else { 0.0 };
            mesh.vertex(place, [column as f32 / width as f32 + shift, row as f32 / height as f32])
        })
    };
    for row in 0..height {
        for column in 0..width {
            // A quad lies right of its first column only if the cut is there in its own row.
            let left_is_cut = cut(column, row);
            let corner = |mesh: &mut TestMesh, at: &mut dyn FnMut(&mut TestMesh, usize, usize, bool) -> u32| {
                let a = at(mesh, column, row, left_is_cut);
                let b = at(mesh, column + 1, row, false);
                let c = at(mesh, column + 1, row + 1, false);
                let d = at(mesh, column, row + 1, left_is_cut);
                [a, b, c, d]
            };
            let corners = corner(&mut mesh, &mut at);
            mesh.quad(corners);
        }
    }
    mesh
}

/// A tube along z of `rings` rings with `sides` sides and one seam along it, closed with fans when `caps`.
pub(crate) fn tube(sides: usize, rings: usize, length: f32, caps: bool) -> TestMesh {
    let mut mesh = TestMesh::default();
    let mut ring_starts = Vec::new();
    for ring in 0..=rings {
        ring_starts.push(mesh.positions.len() as u32);
        let along = ring as f32 / rings as f32;
        for side in 0..=sides {
            let turn = (side % sides) as f32 / sides as f32 * std::f32::consts::TAU;
            let (x, y) = (libm::cosf(turn), libm::sinf(turn));
            let v = mesh.vertex([x, y, along * length], [side as f32 / sides as f32, along]);
            mesh.normals[v as usize] = [x, y, 0.0];
        }
    }
    for ring in 0..rings {
        for side in 0..sides as u32 {
            let (a, b) = (ring_starts[ring] + side, ring_starts[ring + 1] + side);
            mesh.quad([a, a + 1, b + 1, b]);
        }
    }
    if caps {
        for (start, z, v) in [(ring_starts[0], 0.0, -1.0), (ring_starts[rings], length, 2.0)] {
            let centre = mesh.vertex([0.0, 0.0, z], [0.5, v]);
            for side in 0..sides as u32 {
                let edge = if z == 0.0 { [start + side + 1, start + side] } else { [start + side, start + side + 1] };
                mesh.triangle([centre, edge[0], edge[1]]);
            }
        }
    }
    mesh
}

/// A sphere with meridians, a seam along one of them, and one wedge a meridian at each pole.
pub(crate) fn uv_sphere(columns: usize, rows: usize) -> TestMesh {
    let mut mesh = TestMesh::default();
    for row in 0..=rows {
        let tilt = row as f32 / rows as f32 * std::f32::consts::PI;
        for column in 0..=columns {
            let turn = (column % columns) as f32 / columns as f32 * std::f32::consts::TAU;
            let around = if row == 0 || row == rows { 0.0 } else { libm::sinf(tilt) };
            let place = [around * libm::cosf(turn), around * libm::sinf(turn), libm::cosf(tilt)];
            let v = mesh.vertex(place, [column as f32 / columns as f32, row as f32 / rows as f32]);
            mesh.normals[v as usize] = place;
        }
    }
    let at = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (at(column, row), at(column, row + 1));
            if row + 1 < rows {
                mesh.triangle([a, b, b + 1]);
            }
            if row > 0 {
                mesh.triangle([a, b + 1, a + 1]);
            }
        }
    }
    mesh
}

/// A cube with `n` x `n` quads a side, each side with its own chart and normal.
pub(crate) fn cube(n: usize) -> TestMesh {
    let mut mesh = TestMesh::default();
    let sides: [([f32; 3], [f32; 3]); 6] = [
        ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        ([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
    ];
    for (chart, (normal, across)) in sides.into_iter().enumerate() {
        let up = cross(normal, across);
        let base = mesh.positions.len() as u32;
        for row in 0..=n {
            for column in 0..=n {
                let (s, t) = (2.0 * column as f32 / n as f32 - 1.0, 2.0 * row as f32 / n as f32 - 1.0);
                let place = [0, 1, 2].map(|i| normal[i] + s * across[i] + t * up[i]);
                let uv = [chart as f32 * 2.0 + column as f32 / n as f32, row as f32 / n as f32];
                let v = mesh.vertex(place, uv);
                mesh.normals[v as usize] = normal;
            }
        }
        let at = |column: usize, row: usize| base + (row * (n + 1) + column) as u32;
        for row in 0..n {
            for column in 0..n {
                mesh.quad([at(column, row), at(column + 1, row), at(column + 1, row + 1), at(column, row + 1)]);
            }
        }
    }
    mesh
}

/// Any place near the origin.
pub(crate) fn place() -> impl Strategy<Value = [f32; 3]> {
    [-4.0_f32..4.0, -4.0_f32..4.0, -4.0_f32..4.0]
}

/// Triangles over three vertices each, none shared.
pub(crate) fn loose_triangles(count: usize) -> Vec<[u32; 3]> {
    (0..count as u32).map(|i| [i * 3, i * 3 + 1, i * 3 + 2]).collect()
}

pub(crate) fn quick() -> LodOptions {
    LodOptions::default()
}

/// The mesh with its vertices in the order's sequence, as levels share them.
pub(crate) fn in_order(mesh: &TestMesh, order: &CollapseOrder) -> TestMesh {
    let places = || order.vertex_source.iter().map(|&v| v as usize);
    TestMesh {
        positions: places().map(|v| mesh.positions[v]).collect(),
        normals: order.normal_source.iter().map(|&v| mesh.normals[v as usize]).collect(),
        uvs: order.attribute_source.iter().map(|&v| mesh.uvs[v as usize]).collect(),
        colors: order.attribute_source.iter().map(|&v| mesh.colors[v as usize]).collect(),
        joints: places().map(|v| mesh.joints[v]).collect(),
        weights: places().map(|v| mesh.weights[v]).collect(),
        triangles: order.triangles.clone(),
        materials: order.triangle_source.iter().map(|&t| mesh.materials[t as usize]).collect(),
    }
}

/// Simplifies and checks that every level is what it should be.
pub(crate) fn simplify_checked(mesh: &TestMesh, poses: &TestPoses, options: &LodOptions) -> CollapseOrder {
    let order = simplify(&mesh.mesh(), &poses.poses(), options, &|_| ()).expect("the test mesh is valid");
    check_order(mesh, poses, &order, options.criteria);
    order
}

/// Panics unless every level of the order is a valid, unflipped prefix without new open edges; under the paper's criteria also one of the
/// same topology, in which every vertex is used and no texture triangle turns over.
pub(crate) fn check_order(mesh: &TestMesh, poses: &TestPoses, order: &CollapseOrder, criteria: Criteria) {
    let paper = criteria == Criteria::Peng2011;
    let vertex_count = order.vertex_source.len();
    assert_eq!(order.collapse_map.len(), vertex_count);
    assert_eq!(order.vertex_materials.len(), vertex_count);
    assert_eq!(order.vertex_classes.len(), vertex_count);
    assert_eq!(order.triangle_source.len(), order.triangles.len());
    let full = order.levels.last().expect("full detail is a level");
    assert_eq!((full.vertex_count as usize, full.triangle_count as usize), (vertex_count, order.triangles.len()));
    assert!(order.levels.windows(2).all(|w| w[0].vertex_count < w[1].vertex_count));
    assert!(order.levels.windows(2).all(|w| w[0].triangle_count < w[1].triangle_count));
    assert!(order.levels.windows(2).all(|w| w[0].error_m >= w[1].error_m));
    let coarsest = order.levels[0].vertex_count as usize;
    for (v, &target) in order.collapse_map.iter().enumerate() {
        assert!(if v < coarsest { target as usize == v } else { (target as usize) < v }, "vertex {v} maps to {target}");
    }
    for (triangle, &source) in order.triangles.iter().zip(&order.triangle_source) {
        let corners = mesh.triangles[source as usize];
        for (&v, &s) in triangle.iter().zip(&corners) {
            let carried = order.vertex_source[v as usize] as usize;
            assert_eq!(mesh.positions[carried], mesh.positions[s as usize]);
            let shown = order.attribute_source[v as usize] as usize;
            assert_eq!(mesh.uvs[shown], mesh.uvs[s as usize]);
            let lit = order.normal_source[v as usize] as usize;
            assert!(cos_between(mesh.normals[lit], mesh.normals[s as usize]) > 0.999);
        }
    }

    let places = name_places(mesh, order);
    let posed = pose_source(mesh, poses, order);
    let mut one_by_one = order.triangles.clone();
    let mut place_now: Vec<u32> = (0..vertex_count as u32).collect();
    let euler = euler_number(&order.triangles, &places);
    let open = open_edges(&order.triangles, &places);
    let mut finer: Option<Vec<[u32; 3]>> = None;
    let mut ever_used = BTreeSet::new();
    for level in order.levels.iter().rev() {
        // One step: its triangles go, its vertices are looked up once.
        let limit = level.vertex_count;
        one_by_one.truncate(level.triangle_count as usize);
        for v in one_by_one.as_flattened_mut().iter_mut().chain(&mut place_now) {
            if *v >= limit {
                *v = order.collapse_map[*v as usize];
            }
            assert!(*v < limit, "one lookup leaves the level");
        }
        let reformed = reform(&order.triangles, &order.collapse_map, limit, level.triangle_count);
        assert_eq!(reformed, one_by_one, "reforming equals collapsing one by one");

        let used: BTreeSet<u32> = reformed.iter().flatten().copied().collect();
        if paper {
            assert_eq!(used.len(), limit as usize, "every vertex of a level is used");
        }
        ever_used.extend(used);
        for t in &reformed {
            let [a, b, c] = t.map(|v| places[v as usize]);
            assert!(a != b && b != c && c != a, "degenerate triangle {t:?}");
        }
        for group in group_by_place(&places).values() {
            let now: BTreeSet<u32> = group.iter().map(|&v| places[place_now[v as usize] as usize]).collect();
            assert_eq!(now.len(), 1, "vertices at one place stay together");
        }
        if paper {
            assert_eq!(euler_number(&reformed, &places), euler, "the surface keeps its topology");
        }
        // A pillow of two triangles that stood on a page may vanish, and leaves the page's edge open.
        if order.seams.non_manifold_edge_count == 0 {
            assert!(open_edges(&reformed, &places) <= open, "no new open edges");
        }
        if let Some(finer) = &finer {
            check_no_flip(finer, &reformed, &posed, mesh, order, paper);
        }
        finer = Some(reformed);
    }
    assert_eq!(ever_used.len(), vertex_count, "every vertex is used in some level");
}

/// For each vertex, a number for its place and skinning.
fn name_places(mesh: &TestMesh, order: &CollapseOrder) -> Vec<u32> {
    let mut names = BTreeMap::new();
    let name = |&v: &u32| {
        let v = v as usize;
        let key = (mesh.positions[v].map(|c| (c + 0.0).to_bits()), mesh.joints[v], mesh.weights[v].map(f32::to_bits));
        let next = names.len() as u32;
        *names.entry(key).or_insert(next)
    };
    order.vertex_source.iter().map(name).collect()
}

fn group_by_place(places: &[u32]) -> BTreeMap<u32, Vec<u32>> {
    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (v, &place) in places.iter().enumerate() {
        groups.entry(place).or_default().push(v as u32);
    }
    groups
}

fn pose_source(mesh: &TestMesh, poses: &TestPoses, order: &CollapseOrder) -> Vec<Vec<[f32; 3]>> {
    let mut posed = vec![order.vertex_source.iter().map(|&v| mesh.positions[v as usize]).collect::<Vec<_>>()];
    if poses.frame_weights.len() <= 4 {
        for palette in poses.palettes.chunks(poses.joint_count) {
            let pose = |&v: &u32| {
                let v = v as usize;
                pose_position(mesh.positions[v], mesh.joints[v], mesh.weights[v], palette)
            };
            posed.push(order.vertex_source.iter().map(pose).collect());
        }
    }
    posed
}

fn edge_counts(triangles: &[[u32; 3]], places: &[u32]) -> BTreeMap<(u32, u32), u32> {
    let mut counts = BTreeMap::new();
    for t in triangles {
        let [a, b, c] = t.map(|v| places[v as usize]);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *counts.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    counts
}

fn euler_number(triangles: &[[u32; 3]], places: &[u32]) -> i64 {
    let corners: BTreeSet<u32> = triangles.iter().flatten().map(|&v| places[v as usize]).collect();
    corners.len() as i64 - edge_counts(triangles, places).len() as i64 + triangles.len() as i64
}

pub(crate) fn open_edges(triangles: &[[u32; 3]], places: &[u32]) -> usize {
    edge_counts(triangles, places).values().filter(|&&count| count == 1).count()
}

fn check_no_flip(
    finer: &[[u32; 3]],
    coarser: &[[u32; 3]],
    posed: &[Vec<[f32; 3]>],
    mesh: &TestMesh,
    order: &CollapseOrder,
    paper: bool,
) {
    for ((before_corners, after_corners), first_corners) in finer.iter().zip(coarser).zip(&order.triangles) {
        for pose in posed {
            let normal = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| pose[v as usize]);
                cross(sub(b, a), sub(c, a))
            };
            let (before, after) = (normal(before_corners), normal(after_corners));
            assert!(dot(before, before) == 0.0 || dot(before, after) > 0.0, "a triangle turned over");
            let first = normal(first_corners);
            let stays = !paper || dot(first, first) == 0.0 || dot(first, after) > 0.0;
            assert!(stays, "a triangle turned over step by step");
        }
        let uvs = |t: &[u32; 3]| t.map(|v| mesh.uvs[order.attribute_source[v as usize] as usize].map(f64::from));
        assert!(
            !paper || !uv_loses_side(uv_side(uvs(before_corners)), uvs(after_corners)),
            "a texture triangle turned over"
        );
    }
}

/// Materials are gray steps and nothing else.
#[derive(Debug)]
pub(crate) struct PlainGrays;

impl crate::ShownColors for PlainGrays {
    fn color(&self, material: u16, _: [f32; 2], _: [f32; 3]) -> [f32; 3] {
        [f32::from(material) * 0.5; 3]
    }

    fn differ_in_color_alone(&self, _: u16, _: u16) -> bool {
        true
    }
}
