//! Simplification of 20,000 triangles over 100 frames, and of the same mesh over its bind pose alone.
//!
//! `cargo bench -p crowd-lod`

use criterion::{Criterion, criterion_group, criterion_main};
use crowd_lod::{Criteria, LodMesh, LodOptions, LodPoses, Mat3x4, simplify};

const SIDES: usize = 100;
const RINGS: usize = 100;
const JOINTS: usize = 20;
const FRAMES: usize = 100;

/// A wavy tube with one seam along it, skinned to a chain of joints.
struct Snake {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    colors: Vec<[u8; 4]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u16>,
}

fn snake() -> Snake {
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut uvs = Vec::new();
    let mut joints = Vec::new();
    let mut weights = Vec::new();
    for ring in 0..=RINGS {
        for side in 0..=SIDES {
            let along = ring as f32 / RINGS as f32;
            let turn = (side % SIDES) as f32 / SIDES as f32 * std::f32::consts::TAU;
            let radius = 0.2 + 0.02 * libm::sinf(along * 40.0) * libm::cosf(turn * 5.0);
            positions.push([radius * libm::cosf(turn), radius * libm::sinf(turn), along * 2.0]);
            normals.push([libm::cosf(turn), libm::sinf(turn), 0.0]);
            uvs.push([side as f32 / SIDES as f32, along]);
            let place = along * (JOINTS - 1) as f32;
            let joint = (place as usize).min(JOINTS - 2) as u16;
            let upper = place - f32::from(joint);
            joints.push([joint, joint + 1, 0, 0]);
            weights.push([1.0 - upper, upper, 0.0, 0.0]);
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..RINGS as u32 {
        for side in 0..SIDES as u32 {
            let a = ring * (SIDES as u32 + 1) + side;
            let b = a + SIDES as u32 + 1;
            triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    let colors = vec![[255; 4]; positions.len()];
    let materials = vec![0; triangles.len()];
    Snake { positions, normals, uvs, colors, joints, weights, triangles, materials }
}

/// Every joint turns about x through its own place on the axis, in a wave that runs along the chain.
fn waving() -> Vec<Mat3x4> {
    let mut palettes = Vec::new();
    for frame in 0..FRAMES {
        for joint in 0..JOINTS {
            let phase = frame as f32 / FRAMES as f32 * std::f32::consts::TAU + joint as f32 * 0.5;
            let turn = 0.5 * libm::sinf(phase);
            let (s, c) = (libm::sinf(turn), libm::cosf(turn));
            let z = joint as f32 / (JOINTS - 1) as f32 * 2.0;
            palettes.push([[1.0, 0.0, 0.0, 0.0], [0.0, c, -s, s * z], [0.0, s, c, z - c * z]]);
        }
    }
    palettes
}

fn benches(c: &mut Criterion) {
    let snake = snake();
    let mesh = LodMesh {
        positions: &snake.positions,
        normals: &snake.normals,
        uvs: &snake.uvs,
        colors: &snake.colors,
        joints: &snake.joints,
        weights: &snake.weights,
        triangles: &snake.triangles,
        triangle_materials: &snake.materials,
        appearance: crowd_lod::Appearance::default(),
    };
    let palettes = waving();
    let all = vec![1.0 / FRAMES as f32; FRAMES];
    let frames_100 = LodPoses { palettes: &palettes, joint_count: JOINTS, frame_weights: &all };
    let frames_1 = LodPoses { palettes: &palettes[..JOINTS], joint_count: JOINTS, frame_weights: &[1.0] };
    let order_only = LodOptions { measured_levels: 0, ..LodOptions::default() };
    let paper = LodOptions { criteria: Criteria::Peng2011, ..order_only.clone() };

    let mut group = c.benchmark_group("simplify, 20,000 triangles");
    group.sample_size(10);
    for (name, poses, options) in [
        ("1 frame", &frames_1, &order_only),
        ("100 frames", &frames_100, &order_only),
        ("100 frames, peng2011", &frames_100, &paper),
        ("100 frames and 16 measured levels", &frames_100, &LodOptions::default()),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| simplify(&mesh, poses, options, &|_| ()).expect("the snake is a valid mesh"));
        });
    }
    group.finish();
}

criterion_group!(simplification, benches);
criterion_main!(simplification);
