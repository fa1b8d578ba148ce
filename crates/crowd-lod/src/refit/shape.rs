//! The level while it is fitted: places that move, and the skins on them.

use super::full_detail::Frame;
use crate::quadrics::{dot, sub};
use crate::split_seams::{skinning_key, zero_signless_bits};
use crate::{LevelMesh, Mat3x4};
use rayon::prelude::*;

/// What moves one or more vertices of a level: a place and a skinning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Skin {
    /// Place it belongs to.
    pub place: u32,
    pub joints: [u16; 4],
    pub weights: [f32; 4],
}

/// A level's triangles over places and skins that its vertices share.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Corners in skins.
    pub triangles: Vec<[u32; 3]>,
    /// Bind-space places, metres.
    pub places: Vec<[f32; 3]>,
    pub skins: Vec<Skin>,
    /// Skin of each vertex of the level.
    pub skin_of: Vec<u32>,
    /// Mean edge of the triangles in bind space as they were at first, metres.
    pub mean_edge: f64,
}

impl Shape {
    /// Vertices with the same place become one place; of these, those with the same skinning one skin.
    pub fn new(level: &LevelMesh) -> Self {
        let count = level.positions.len();
        let keys: Vec<_> = (0..count)
            .map(|v| (level.positions[v].map(zero_signless_bits), skinning_key(level.joints[v], level.weights[v])))
            .collect();
        let mut by_key: Vec<u32> = (0..count as u32).collect();
        by_key.par_sort_unstable_by_key(|&v| (keys[v as usize], v));
        let (mut places, mut skins, mut skin_of) = (Vec::new(), Vec::new(), vec![0_u32; count]);
        for at_place in by_key.chunk_by(|&a, &b| keys[a as usize].0 == keys[b as usize].0) {
            for alike in at_place.chunk_by(|&a, &b| keys[a as usize] == keys[b as usize]) {
                let first = alike[0] as usize;
                alike.iter().for_each(|&v| skin_of[v as usize] = skins.len() as u32);
                let place = places.len() as u32;
                skins.push(Skin { place, joints: level.joints[first], weights: level.weights[first] });
            }
            places.push(level.positions[at_place[0] as usize]);
        }
        let triangles = level.triangles.iter().map(|t| t.map(|v| skin_of[v as usize])).collect();
        let mean_edge = mean_edge(level);
        Self { triangles, places, skins, skin_of, mean_edge }
    }

    /// Place of each corner of a triangle.
    pub fn corner_places(&self, triangle: usize) -> [usize; 3] {
        self.triangles[triangle].map(|s| self.skins[s as usize].place as usize)
    }

    /// Each skin's own matrix in each frame: `matrices[frame][skin]`.
    pub fn blend(&self, frames: &[Frame<'_>]) -> Vec<Vec<Mat3x4>> {
        frames.par_iter().map(|f| self.skins.iter().map(|skin| blend_skin(skin, f.palette)).collect()).collect()
    }

    /// Each skin's place in one frame.
    pub fn pose(&self, matrices: &[Mat3x4]) -> Vec<[f32; 3]> {
        self.skins.iter().zip(matrices).map(|(skin, m)| transform(m, self.places[skin.place as usize])).collect()
    }

    /// Each skin's place in bind space.
    pub fn bind(&self) -> Vec<[f32; 3]> {
        self.skins.iter().map(|skin| self.places[skin.place as usize]).collect()
    }

    /// Gives the level's vertices their places and skins back. Vertices of one skin get the same bits.
    pub fn write(&self, level: &mut LevelMesh) {
        for (v, &skin) in self.skin_of.iter().enumerate() {
            let skin = &self.skins[skin as usize];
            level.positions[v] = self.places[skin.place as usize];
            level.joints[v] = skin.joints;
            level.weights[v] = skin.weights;
        }
    }
}

fn mean_edge(level: &LevelMesh) -> f64 {
    let edge = |a: u32, b: u32| {
        let along = sub(level.positions[b as usize], level.positions[a as usize]);
        f64::from(dot(along, along).sqrt())
    };
    let sum: f64 = level.triangles.iter().map(|&[a, b, c]| edge(a, b) + edge(b, c) + edge(c, a)).sum();
    sum / (3 * level.triangles.len()).max(1) as f64
}

/// The matrix of a skin.
pub(crate) fn blend_skin(skin: &Skin, palette: &[Mat3x4]) -> Mat3x4 {
    let mut out = [[0.0; 4]; 3];
    for k in 0..4 {
        if skin.weights[k] != 0.0 {
            let m = &palette[skin.joints[k] as usize];
            for row in 0..3 {
                for column in 0..4 {
                    out[row][column] += skin.weights[k] * m[row][column];
                }
            }
        }
    }
    out
}

/// `m` applied to a point.
pub(crate) fn transform(m: &Mat3x4, [x, y, z]: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3])
}
