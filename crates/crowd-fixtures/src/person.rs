//! One person of the cast: measures, colours and hair in, a character out.

use glam::Vec3;

use crate::assemble::{character, colour_png, regions_png, wedges};
use crate::atlas::{self, paint};
use crate::body::{Build, Figure, chart, part, tag};
use crate::glb::Document;
use crate::human_clips::{Manner, clips};
use crate::human_rig::{skeleton, weights};
use crate::paint_human::Look;
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
        let rects = if self.skirt.is_some() { atlas::SKIRTED } else { atlas::HUMAN };
        let painting = paint(&shape, rects, self.texels, &|s| crate::paint_human::paint(&f, &self.look, s));
        let joints = skeleton(&f, hair_tail);
        let body = wedges(&shape, rects, &|p, what| weights(&f, &joints, p, what));
        let clips = clips(&joints, &self.manner, self.strong, 2);
        (character(self.name, &joints, body, colour_png(&painting), clips), regions_png(&painting))
    }
}

fn add_tail(shape: &mut Shape, f: &Figure, tail: &Tail, rows: usize) -> Option<[Vec3; 2]> {
    let h = f.head_m();
    let columns = if rows > 1 { 16 } else { 6 };
    let back = |hy: f32, out: f32| Vec3::new(0.0, f.chin_y() + hy * h, f.head_point(hy, core::f32::consts::PI, out).z);
    match *tail {
        Tail::None => None,
        Tail::Pony(length, girth) => {
            let root = back(0.72, 0.0);
            let shapes = [
                (-0.03, -0.02, 0.85),
                (0.06, 0.03, 0.66),
                (0.105, -0.14, 1.0),
                (0.10, -0.45, 1.05),
                (0.09, -0.75, 0.75),
                (0.08, -1.0, 0.25),
            ];
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
                let path: Vec<(Vec3, f32, f32)> = [
                    (0.0, 0.0, 0.05),
                    (0.10, 0.02, 0.06),
                    (0.19, -0.06, 0.115),
                    (0.24, -0.6 * length, 0.12),
                    (0.23, -length, 0.045),
                ]
                .iter()
                .map(|&(o, y, g)| (root + (out * o + Vec3::Y * y) * h, g * h, g * h))
                .collect();
                add_spindle(shape, &path, columns, chart::TAIL, part::TAIL, tag::HEAD, side < 0.0);
            }
            None
        }
    }
}
