//! Draws both sides with one camera and compares what is seen.

use crate::{Paint, SkinnedMesh, joints};
use crowd_raster::{Batch, Fill, Target, View, downsample, draw_many};
use glam::Vec3;

/// Pixels a side.
const SIDE_PX: u32 = 256;
/// Samples along each side of a pixel.
const SUPERSAMPLING: u32 = 3;
/// Around the character.
pub(crate) const VIEWS: u32 = 6;
/// In motion, spread over the moving poses; at rest where nothing moves.
pub(crate) const PICTURED_POSES: usize = 5;
/// Degrees above the horizon.
const ELEVATION_DEG: f32 = 10.0;
/// Vertical field of view, radians.
const FIELD_OF_VIEW_RAD: f32 = 0.35;
/// Black, so that what sticks out or is missing counts by how bright it is.
const BACKGROUND: [u8; 4] = [0, 0, 0, 255];
/// Share of the silhouettes that a joint shows at least to count as one of the limbs.
const LEAST_SHOWN: f64 = 0.005;

/// One picture of a side.
#[derive(Debug)]
pub(crate) struct Picture {
    /// sRGB, a pixel each.
    colors: Vec<[u8; 4]>,
    /// Whether each sample shows the character.
    covered: Vec<bool>,
    /// The joint that each sample shows most of, where the character is shown; empty where nobody asks.
    joints: Vec<u16>,
}

/// What the pictures of a level differ by, summed over pictures.
#[derive(Debug, Default, Clone)]
pub(crate) struct PictureSums {
    squares: f64,
    channels: u64,
    covered_by_one: u64,
    covered: u64,
    /// For each joint, the samples in which the original shows it, and those of them in which the level shows nothing.
    by_joint: Vec<[u64; 2]>,
}

impl PictureSums {
    /// Adds another sum.
    pub fn add(&mut self, other: &Self) {
        self.squares += other.squares;
        self.channels += other.channels;
        self.covered_by_one += other.covered_by_one;
        self.covered += other.covered;
        self.by_joint.resize(self.by_joint.len().max(other.by_joint.len()), [0; 2]);
        for (sum, more) in self.by_joint.iter_mut().zip(&other.by_joint) {
            (0..2).for_each(|i| sum[i] += more[i]);
        }
    }

    /// Root mean square difference over the union of the silhouettes, 0 to 1.
    pub fn rmse(&self) -> f64 {
        (self.squares / (self.channels.max(1)) as f64).sqrt()
    }

    /// What only one silhouette covers, in percent of their union.
    pub fn silhouette_xor(&self) -> f64 {
        100.0 * self.covered_by_one as f64 / self.covered.max(1) as f64
    }

    /// What the level misses of the original's silhouette, in percent of that.
    pub fn missed(&self) -> f64 {
        let [shown, missed] = self.by_joint.iter().fold([0; 2], |sum, joint| [sum[0] + joint[0], sum[1] + joint[1]]);
        100.0 * missed as f64 / shown.max(1) as f64
    }

    /// The same as a mean over the joints, so that a shin counts as much as a belly. Joints that hardly show are left out.
    pub fn missed_of_limbs(&self) -> f64 {
        let all: u64 = self.by_joint.iter().map(|joint| joint[0]).sum();
        let shares = self.by_joint.iter().filter(|joint| joint[0] > 0 && joint[0] as f64 >= LEAST_SHOWN * all as f64);
        let (sum, count) =
            shares.fold((0.0, 0), |(sum, count), joint| (sum + joint[1] as f64 / joint[0] as f64, count + 1));
        100.0 * sum / f64::from(count.max(1))
    }
}

/// A camera that holds all of a posed mesh, from one of the views around it.
pub(crate) fn frame(positions: &[Vec3], triangles: &[[u32; 3]], view: u32) -> View {
    let turn_rad = (360.0 / VIEWS as f32 * view as f32).to_radians();
    let lift_rad = ELEVATION_DEG.to_radians();
    let level = libm::cosf(lift_rad);
    let back = Vec3::new(libm::sinf(turn_rad) * level, libm::sinf(lift_rad), libm::cosf(turn_rad) * level);
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let extent = |axis: Vec3| {
        let places = triangles.as_flattened().iter().map(|&v| axis.dot(positions[v as usize]));
        places.fold((f32::MAX, f32::MIN), |(low, high), place| (low.min(place), high.max(place)))
    };
    let [x, y, z] = [extent(right), extent(up), extent(back)];
    let middle = |(low, high): (f32, f32)| (low + high) / 2.0;
    let half = |(low, high): (f32, f32)| ((high - low) / 2.0).max(1e-6);
    let center = right * middle(x) + up * middle(y) + back * middle(z);
    let reach = 1.05 * half(x).max(half(y));
    let distance = reach / libm::tanf(FIELD_OF_VIEW_RAD / 2.0) + half(z);
    let eye = center + back * distance;
    // A level may stick out of the original: twice its depth is kept.
    let depth = reach.max(half(z)) * 2.0;
    let near = (distance - depth).max(distance * 0.01);
    let clip_from_view = glam::camera::rh::proj::directx::perspective(FIELD_OF_VIEW_RAD, 1.0, near, distance + depth);
    View { clip_from_world: clip_from_view * glam::camera::rh::view::look_at_mat4(eye, center, Vec3::Y), eye }
}

/// Triangles by material, as the rasteriser wants them.
#[derive(Debug)]
pub(crate) struct Painted {
    groups: Vec<(Vec<u16>, Vec<[u32; 3]>)>,
}

impl Painted {
    /// Sorts the triangles of a mesh by material.
    pub fn new(mesh: &SkinnedMesh) -> Self {
        let mut materials = mesh.triangle_materials.clone();
        materials.sort_unstable();
        materials.dedup();
        let group = |&material: &u16| {
            let pairs = mesh.triangles.iter().zip(&mesh.triangle_materials);
            let triangles = pairs.filter(|(_, other)| **other == material).map(|(triangle, _)| *triangle).collect();
            (vec![material; mesh.positions.len()], triangles)
        };
        Self { groups: materials.iter().map(group).collect() }
    }

    /// Draws a posed mesh.
    pub fn draw(
        &self,
        mesh: &SkinnedMesh,
        paint: &Paint,
        positions: &[Vec3],
        normals: &[Vec3],
        view: &View,
    ) -> Picture {
        let side = SIDE_PX * SUPERSAMPLING;
        let mut target = Target::new(side, side, BACKGROUND);
        let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.to_array()).collect();
        let normals: Vec<[f32; 3]> = normals.iter().map(|n| n.to_array()).collect();
        let groups = self.groups.iter();
        let batches: Vec<Batch<'_>> = groups
            .map(|(vertex_materials, triangles)| Batch {
                positions: &positions,
                normals: &normals,
                uvs: &mesh.uvs,
                colors: &mesh.colors,
                vertex_materials,
                triangles,
                materials: &paint.materials,
                textures: &paint.textures,
                fill: Fill::Shaded,
            })
            .collect();
        draw_many(&mut target, view, &batches);
        let covered = target.depth.iter().map(|&depth| depth < 1.0).collect();
        Picture { colors: downsample(&target, SUPERSAMPLING).color, covered, joints: Vec::new() }
    }
}

impl Picture {
    /// The same with the joints that its samples show; everything else as it was drawn.
    pub fn with_joints(self, mesh: &SkinnedMesh, paint: &Paint, positions: &[Vec3], view: &View) -> Self {
        let side = SIDE_PX * SUPERSAMPLING;
        Self { joints: joints::draw(mesh, paint, positions, view, side), ..self }
    }
}

/// Compares two pictures from one camera; the joints are those of the first.
pub(crate) fn compare(a: &Picture, b: &Picture) -> PictureSums {
    let mut sums = PictureSums::default();
    let side = (SIDE_PX * SUPERSAMPLING) as usize;
    let mut shown = vec![false; a.colors.len()];
    let joints = &a.joints;
    for (i, (&a, &b)) in a.covered.iter().zip(&b.covered).enumerate() {
        if a || b {
            let (x, y) = (i % side / SUPERSAMPLING as usize, i / side / SUPERSAMPLING as usize);
            shown[y * SIDE_PX as usize + x] = true;
            sums.covered += 1;
            sums.covered_by_one += u64::from(a != b);
        }
        if let (true, Some(&joint)) = (a, joints.get(i)) {
            let joint = usize::from(joint);
            sums.by_joint.resize(sums.by_joint.len().max(joint + 1), [0; 2]);
            sums.by_joint[joint][0] += 1;
            sums.by_joint[joint][1] += u64::from(!b);
        }
    }
    for ((a, b), _) in a.colors.iter().zip(&b.colors).zip(&shown).filter(|(_, shown)| **shown) {
        for channel in 0..3 {
            let difference = (f64::from(a[channel]) - f64::from(b[channel])) / 255.0;
            sums.squares += difference * difference;
        }
        sums.channels += 3;
    }
    sums
}
