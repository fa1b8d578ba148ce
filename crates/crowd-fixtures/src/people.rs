//! The cast: who they are, how they are built, what they wear.

use glam::Vec3;

use crate::assemble::{character, colour_png, regions_png, wedges};
use crate::atlas::{self, paint};
use crate::body::{Build, Figure, chart, cover, part, tag};
use crate::glb::Document;
use crate::human_clips::{Manner, clips};
use crate::human_rig::{skeleton, weights};
use crate::paint_human::{Cloth, Front, Look, rgb};
use crate::shape::Shape;
use crate::wear::{HairCut, Skirt, add_ears, add_hair, add_skirt, add_spindle};

/// What hangs from the back of the head.
#[derive(Clone, Debug)]
pub enum Tail {
    /// Nothing.
    None,
    /// A pony tail: length and girth in heads.
    Pony(f32, f32),
    /// A bun of this radius in heads.
    Bun(f32),
    /// Two bunches, left and right.
    Bunches(f32),
}

/// One person.
#[derive(Clone, Debug)]
pub struct Person {
    /// Name of the file and the character.
    pub name: &'static str,
    /// Measures.
    pub build: Build,
    /// Colours.
    pub look: Look,
    /// Hair.
    pub hair: HairCut,
    /// See [`Tail`].
    pub tail: Tail,
    /// Columns of an ear.
    pub ear_columns: usize,
    /// A skirt, if any.
    pub skirt: Option<Skirt>,
    /// How they move.
    pub manner: Manner,
    /// "sit" or "bend".
    pub strong: &'static str,
    /// Texture side in texels.
    pub texels: u32,
}

impl Person {
    /// Models, paints, rigs and animates the person: the document and the region map's PNG.
    pub fn make(&self) -> (Document, Vec<u8>) {
        let f = Figure::new(self.build.clone());
        let mut shape = f.model();
        add_ears(&mut shape, &f, self.ear_columns);
        add_hair(&mut shape, &f, &self.hair);
        let hair_tail = add_tail(&mut shape, &f, &self.tail, self.build.rows);
        if let Some(skirt) = &self.skirt {
            add_skirt(&mut shape, &f, skirt);
        }
        let painting = paint(&shape, atlas::HUMAN, self.texels, &|s| crate::paint_human::paint(&f, &self.look, s));
        let joints = skeleton(&f, hair_tail);
        let body = wedges(&shape, atlas::HUMAN, &|p, what| weights(&f, &joints, p, what));
        let clips = clips(&joints, &self.manner, self.strong, 2);
        (character(self.name, &joints, body, colour_png(&painting), clips), regions_png(&painting))
    }
}

fn add_tail(shape: &mut Shape, f: &Figure, tail: &Tail, rows: usize) -> Option<[Vec3; 2]> {
    let h = f.head_m();
    let columns = if rows > 1 { 16 } else { 8 };
    let back = |hy: f32, out: f32| Vec3::new(0.0, f.chin_y() + hy * h, f.head_point(hy, core::f32::consts::PI, out).z);
    match *tail {
        Tail::None => None,
        Tail::Pony(length, girth) => {
            let root = back(0.72, 0.0);
            let shapes = [(0.0, 0.0, 0.55), (0.12, 0.05, 0.62), (0.17, -0.12, 1.0), (0.16, -0.45, 1.05), (0.13, -0.75, 0.75), (0.10, -1.0, 0.25)];
            let path: Vec<(Vec3, f32, f32)> = shapes
                .iter()
                .map(|&(out, down, g)| {
                    let drop = if down < 0.0 { down * length } else { down };
                    (root + Vec3::new(0.0, drop * h, -out * h), g * girth * h, g * girth * 0.8 * h)
                })
                .collect();
            add_spindle(shape, &path, columns, chart::TAIL, part::TAIL, tag::HAIR_TAIL, false);
            Some([path[1].0, path[3].0])
        }
        Tail::Bun(r) => {
            let c = back(0.80, 0.10);
            let ring = |a: f32| {
                let (s, co) = libm::sincosf(a);
                (c + Vec3::new(0.0, 0.45 * co, -co) * (0.8 * r * h), r * s * h, r * s * h)
            };
            let n = if rows > 1 { 9 } else { 5 };
            let path: Vec<_> = (1..n).map(|i| ring(core::f32::consts::PI * (1.0 - i as f32 / n as f32))).collect();
            add_spindle(shape, &path, columns, chart::TAIL, part::TAIL, tag::HEAD, false);
            None
        }
        Tail::Bunches(length) => {
            for side in [1.0, -1.0] {
                let root = f.head_point(0.72, side * 2.0, 0.0);
                let out = Vec3::new(side * 0.8, 0.1, -0.55).normalize();
                let path: Vec<(Vec3, f32, f32)> = [(0.0, 0.0, 0.05), (0.10, 0.02, 0.06), (0.19, -0.06, 0.115), (0.24, -0.6 * length, 0.12), (0.23, -length, 0.045)]
                    .iter()
                    .map(|&(o, y, g)| (root + (out * o + Vec3::Y * y) * h, g * h, g * h))
                    .collect();
                add_spindle(shape, &path, columns, chart::TAIL, part::TAIL, tag::HEAD, side < 0.0);
            }
            None
        }
    }
}

/// Trunk rings of a slim adult: share of the way up, half width, front, back (body heights).
const TRUNK: [[f32; 4]; 10] = [
    [0.0, 0.098, 0.058, 0.070],
    [0.12, 0.104, 0.058, 0.078],
    [0.235, 0.096, 0.058, 0.066],
    [0.37, 0.080, 0.055, 0.053],
    [0.51, 0.084, 0.059, 0.056],
    [0.635, 0.090, 0.062, 0.062],
    [0.73, 0.094, 0.062, 0.066],
    [0.84, 0.098, 0.052, 0.062],
    [0.93, 0.088, 0.038, 0.050],
    [1.0, 0.047, 0.030, 0.040],
];

fn slim() -> Build {
    Build {
        height: 1.70,
        head: 0.140,
        head_width: 1.0,
        crotch: 0.475,
        neck_base: 0.833,
        shoulder: 0.094,
        trunk: TRUNK.to_vec(),
        bust: 0.022,
        neck: 0.0285,
        arm_girth: 0.92,
        leg_girth: 1.0,
        arm: 0.315,
        trunk_covers: vec![cover(0.225, 0.004, 0.0), cover(9.0, 0.008, 0.0)],
        arm_covers: vec![cover(0.50, 0.005, 0.0), cover(9.0, 0.0, 0.0)],
        leg_covers: vec![cover(0.64, 0.003, 0.0), cover(9.0, 0.008, 0.0)],
        jaw: 0.95,
        nose: 0.85,
        beard: 0.0,
        eyes: 0.0,
        columns: 16,
        rows: 1,
        hole: (2, 3),
        crotch_columns: 1,
    }
}

/// A slim woman with a pony tail, in a plaid shirt, jeans and boots: the paper's triangle count.
pub fn mara() -> Person {
    Person {
        name: "mara",
        build: slim(),
        look: Look {
            skin: rgb(0xf0c3a0),
            hair: rgb(0x9a4420),
            iris: rgb(0x3f8f62),
            lips: rgb(0xcf5b56),
            blush: 1.0,
            lashes: 1.0,
            eyes: 1.08,
            brows: 0.9,
            hairline: vec![(0.0, 0.83), (35.0, 0.80), (62.0, 0.66), (78.0, 0.52), (100.0, 0.40), (130.0, 0.16), (180.0, 0.08)],
            beard: 0.0,
            age: 0.0,
            freckles: true,
            top: Cloth::Plaid(rgb(0xb8342f), rgb(0x2a2336), rgb(0xf3e3bf), 0.125, 8.0),
            legs: Cloth::Denim(rgb(0x2f4a7a), rgb(0x7f9ec4)),
            shoes: rgb(0x6b4226),
            soles: rgb(0x2f2019),
            belt: Some(rgb(0x4a2c1a)),
            front: Front::Buttons(rgb(0xf4ead2)),
            collar: Some(rgb(0xa82c29)),
            sleeve: 0.50,
            trouser: 0.64,
            shoe: 0.64,
            hem: 0.225,
            hair_band: Some(rgb(0x2f8f8a)),
        },
        hair: HairCut {
            rim: vec![(0.0, 0.80), (30.0, 0.78), (58.0, 0.64), (74.0, 0.50), (92.0, 0.44), (110.0, 0.36), (140.0, 0.16), (180.0, 0.10)],
            thick: (0.030, 0.055),
            locks: (0.010, 7.0),
            columns: 18,
            rows: 6,
            sweep: 0.05,
        },
        tail: Tail::Pony(0.95, 0.13),
        ear_columns: 6,
        skirt: None,
        manner: Manner { walk_seconds: 1.06, step: 0.72, sway: 1.3, swing: 1.0, arms_out: 9.0, stoop: 0.0 },
        strong: "sit",
        texels: 512,
    }
}

/// Everybody, in the order of the line-up.
pub fn cast() -> Vec<Person> {
    vec![mara()]
}
