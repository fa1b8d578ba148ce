//! A wavy tube with one seam along it, skinned to a chain of joints, and clips in which it waves.

use crowd_lod::{LodMesh, LodPoses, Mat3x4};
use std::f32::consts::TAU;

const JOINTS: usize = 60;
/// Length, metres.
const LENGTH: f32 = 2.0;

/// The tube. Two triangles a side and ring.
pub struct Snake {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    pub colors: Vec<[u8; 4]>,
    pub joints: Vec<[u16; 4]>,
    pub weights: Vec<[f32; 4]>,
    pub triangles: Vec<[u32; 3]>,
    pub materials: Vec<u16>,
}

/// Palettes of several clips of equal length, and their frames' weights.
pub struct Waves {
    pub palettes: Vec<Mat3x4>,
    pub weights: Vec<f32>,
}

impl Snake {
    /// A tube of `2 * sides * rings` triangles, with bumps of two sizes.
    pub fn new(sides: usize, rings: usize) -> Self {
        let mut snake = Self {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: vec![[255; 4]; (sides + 1) * (rings + 1)],
            joints: Vec::new(),
            weights: Vec::new(),
            triangles: Vec::new(),
            materials: vec![0; 2 * sides * rings],
        };
        let place = |along: f32, turn: f32| {
            let bumps = 0.02 * libm::sinf(along * 40.0) * libm::cosf(turn * 5.0);
            let radius = 0.2 + bumps + 0.003 * libm::sinf(along * 190.0 + turn * 9.0);
            [radius * libm::cosf(turn), radius * libm::sinf(turn), along * LENGTH]
        };
        for ring in 0..=rings {
            for side in 0..=sides {
                let along = ring as f32 / rings as f32;
                // The last column lies on the first, bit for bit.
                let turn = (side % sides) as f32 / sides as f32 * TAU;
                let at = place(along, turn);
                snake.positions.push(at);
                snake.normals.push(normal(at, place(along, turn + 0.01), place(along + 0.001, turn)));
                snake.uvs.push([side as f32 / sides as f32, along]);
                let chain = along * (JOINTS - 1) as f32;
                let joint = (chain as usize).min(JOINTS - 2) as u16;
                let upper = chain - f32::from(joint);
                snake.joints.push([joint, joint + 1, 0, 0]);
                snake.weights.push([1.0 - upper, upper, 0.0, 0.0]);
            }
        }
        for ring in 0..rings as u32 {
            for side in 0..sides as u32 {
                let a = ring * (sides as u32 + 1) + side;
                let b = a + sides as u32 + 1;
                snake.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
        snake
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
            appearance: crowd_lod::Appearance::default(),
        }
    }
}

impl Waves {
    /// Clips in which bends of different sizes and lengths run along the chain while the whole turns and walks off.
    pub fn new(clips: usize, frames_a_clip: usize) -> Self {
        let mut palettes = Vec::new();
        for clip in 0..clips {
            for frame in 0..frames_a_clip {
                let time = frame as f32 / frames_a_clip as f32;
                let (size, waves) = (0.02 + 0.02 * clip as f32, 0.1 + 0.07 * clip as f32);
                // Each joint turns about x after the one before it, through its own place.
                let mut turn = 0.2 * clip as f32 * time;
                let (mut y, mut z) = (time * clip as f32, 0.0);
                let mut place = 0.0;
                for joint in 0..JOINTS {
                    turn += size * libm::sinf(TAU * time + joint as f32 * waves);
                    let (s, c) = (libm::sinf(turn), libm::cosf(turn));
                    palettes.push([[1.0, 0.0, 0.0, 0.0], [0.0, c, -s, y + s * place], [0.0, s, c, z - c * place]]);
                    let step = LENGTH / (JOINTS - 1) as f32;
                    (y, z, place) = (y - s * step, z + c * step, place + step);
                }
            }
        }
        let count = clips * frames_a_clip;
        Self { palettes, weights: vec![1.0 / count as f32; count] }
    }

    pub fn poses(&self) -> LodPoses<'_> {
        LodPoses { palettes: &self.palettes, joint_count: JOINTS, frame_weights: &self.weights }
    }
}

fn normal(at: [f32; 3], around: [f32; 3], along: [f32; 3]) -> [f32; 3] {
    let [e, f] = [around, along].map(|p| [p[0] - at[0], p[1] - at[1], p[2] - at[2]]);
    let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    n.map(|c| c / length)
}
