//! Draws a character's pictures: each level in each pose under each look.

use super::marks::{Dot, draw_dots, project};
use super::shown_levels::ShownLevel;
use crate::draw_level::{Look, Scene, ShownVertices, Surfaces, extents, frame_character, pose_character};
use crate::explain::Stuck;
use crate::heat::{heat_colors, red_distance_m};
use crate::ordered_mesh::DecodedVertices;
use crate::pose::{Mat3x4, Posed, pose_mesh};
use crate::unpack::Unpacked;
use crowd_pack::{LodRecord, VertexRecord, obstacle, vertex_class};
use crowd_raster::{Target, View, downsample, encode_jpeg};
use rayon::prelude::*;

/// Samples along each side of a pixel.
const SUPERSAMPLING: u32 = 3;
/// Of wireframes, whose lines are one sample wide.
const WIRE_SUPERSAMPLING: u32 = 2;
/// JPEG quality of all pictures: at 82 no blocks show on plain backgrounds.
const QUALITY: u8 = 82;
/// Pixels of a textured picture, which the side-by-side view enlarges, and of the others.
const LARGE_PX: f32 = 150_000.0;
/// See [`LARGE_PX`].
const SMALL_PX: f32 = 66_000.0;
/// Sides of a picture over sides of the character.
const MARGIN: f32 = 1.07;
/// Width over height of a picture.
const ASPECTS: std::ops::RangeInclusive<f32> = 0.55..=1.5;
/// The backdrop at the top and at the bottom, sRGB: a grey that neither dark hair nor white cloth vanishes in.
const BACKDROP: [[u8; 3]; 2] = [[206, 210, 215], [170, 175, 182]];
/// Radius of a dot over the height of its picture.
const DOT_SHARE: f32 = 0.0072;
/// Companions, fixed vertices (sRGB), as in `picture --paint classes`.
pub(crate) const COMPANION_COLOR: [u8; 4] = [222, 134, 12, 255];
/// See [`COMPANION_COLOR`].
pub(crate) const FIXED_COLOR: [u8; 4] = [196, 22, 32, 255];
/// Linear colour of the surface under dots.
const GROUND: [u8; 4] = [112, 116, 122, 255];

/// What a row of pictures shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Row {
    Textured,
    Edges,
    Classes,
    Distance,
}

impl Row {
    pub(crate) const ALL: [Self; 4] = [Self::Textured, Self::Edges, Self::Classes, Self::Distance];
}

/// A picture, and where to look.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub jpeg: Vec<u8>,
    pub size: [u32; 2],
    /// Of distances: the largest one of a vertex of full detail in this pose, metres, and its place from the upper left
    /// corner in shares of the sides.
    pub furthest: Option<(f32, [f32; 2])>,
}

/// All pictures of one pose: `rows[r][l]` is row `r` of [`Row::ALL`] at level `l`.
#[derive(Debug)]
pub(crate) struct Sheet {
    pub rows: Vec<Vec<Drawn>>,
}

/// What is drawn of a level.
struct Shape<'a> {
    triangles: Vec<[u32; 3]>,
    /// The vertices that the triangles go to, as stored.
    records: &'a [VertexRecord],
    own: Option<OwnVertices>,
}

/// The vertices of a refitted level, ready to draw.
struct OwnVertices {
    shown: ShownVertices,
    posed: Posed,
}

/// A character in front of the camera.
pub(crate) struct Studio<'a> {
    character: &'a Unpacked<'a>,
    surfaces: &'a Surfaces,
    palette: Vec<Mat3x4>,
    posed: Posed,
    turn_deg: f32,
    aspect: f32,
    /// 1, or less where a page holds many characters.
    scale: f32,
}

/// The camera's turn: a character much longer than wide, as animals are, shows its side.
pub(crate) fn camera_turn_deg(at_rest: &Posed) -> f32 {
    let [width, _, depth] = extents(&at_rest.positions, 0.0);
    if depth > 1.6 * width { 58.0 } else { 25.0 }
}

impl<'a> Studio<'a> {
    pub(crate) fn new(
        character: &'a Unpacked<'a>,
        surfaces: &'a Surfaces,
        palette: &[Mat3x4],
        turn_deg: f32,
        scale: f32,
    ) -> Self {
        let posed = pose_character(character, palette);
        let [width, height, _] = extents(&posed.positions, turn_deg);
        let aspect = (width / height.max(1e-6)).clamp(*ASPECTS.start(), *ASPECTS.end());
        Self { character, surfaces, palette: palette.to_vec(), posed, turn_deg, aspect, scale }
    }

    /// Draws all rows at all levels. `tell` hears the share that each picture adds.
    pub(crate) fn draw_sheet(&self, levels: &[ShownLevel], tell: &(dyn Fn(f32) + Sync)) -> Sheet {
        let shapes: Vec<Shape<'_>> = levels.iter().map(|shown| self.shape(shown)).collect();
        let cells: Vec<(Row, &Shape<'_>)> =
            Row::ALL.into_iter().flat_map(|row| shapes.iter().map(move |shape| (row, shape))).collect();
        let draw = |&(row, shape): &(Row, &Shape<'_>)| {
            let drawn = self.draw(row, shape);
            tell(1.0 / cells.len() as f32);
            drawn
        };
        let mut drawn: Vec<Drawn> = cells.par_iter().map(draw).collect();
        let mut rows = Vec::new();
        while !drawn.is_empty() {
            let rest = drawn.split_off(levels.len().min(drawn.len()));
            rows.push(std::mem::replace(&mut drawn, rest));
        }
        Sheet { rows }
    }

    /// A small picture for the list of characters.
    pub(crate) fn draw_thumbnail(&self) -> Drawn {
        let full = LodRecord {
            vertex_count: self.character.record.vertex_count,
            triangle_count: self.character.record.triangle_count,
        };
        let size = self.size(SMALL_PX / 3.0);
        self.shoot(size, SUPERSAMPLING, None, |scene, target| {
            scene.draw(target, &self.character.level_triangles(full), &Look::Textured);
        })
    }

    /// The coarsest level with a dot on each position that cannot move.
    pub(crate) fn draw_stuck(&self, level: LodRecord, stuck: &[Stuck]) -> Drawn {
        let dots: Vec<Dot> = stuck
            .iter()
            .map(|s| Dot { place: self.posed.positions[s.vertex as usize], color: obstacle_color(s.obstacle) })
            .collect();
        let size = self.size(LARGE_PX);
        self.shoot(size, SUPERSAMPLING, None, |scene, target| {
            let ground = vec![GROUND; self.posed.positions.len()];
            scene.draw(target, &self.character.level_triangles(level), &Look::Painted(&ground));
            self.dot(scene, target, &dots, 1.5);
        })
    }

    fn shape(&self, shown: &ShownLevel) -> Shape<'a> {
        let character = self.character;
        let Some(stored) = shown.discrete.first().map(|&number| &character.discrete_levels()[number]) else {
            return Shape { triangles: character.level_triangles(shown.level), records: character.vertices, own: None };
        };
        let records = character.level_vertices(stored);
        let own = stored.is_refit().then(|| {
            let v = DecodedVertices::new(records);
            let posed = pose_mesh(&v.positions, &v.normals, &v.joints, &v.weights, &self.palette);
            OwnVertices { shown: ShownVertices::new(records), posed }
        });
        Shape { triangles: character.table_triangles(stored), records, own }
    }

    fn draw(&self, row: Row, shape: &Shape<'_>) -> Drawn {
        let (triangles, own) = (&shape.triangles, shape.own.as_ref());
        let small = self.size(SMALL_PX);
        match row {
            Row::Textured => self.shoot(self.size(LARGE_PX), SUPERSAMPLING, own, |scene, target| {
                scene.draw(target, triangles, &Look::Textured);
            }),
            Row::Edges => self.shoot(small, WIRE_SUPERSAMPLING, own, |scene, target| {
                scene.draw(target, triangles, &Look::Edges);
            }),
            Row::Classes => {
                let dots = self.class_dots(shape);
                self.shoot(small, SUPERSAMPLING, own, |scene, target| {
                    let ground = vec![GROUND; scene.posed.positions.len()];
                    scene.draw(target, triangles, &Look::Painted(&ground));
                    self.dot(scene, target, &dots, 1.0);
                })
            }
            Row::Distance => self.draw_distance(small, shape),
        }
    }

    fn draw_distance(&self, size: [u32; 2], shape: &Shape<'_>) -> Drawn {
        let posed = &self.posed.positions;
        let level = &self.posed_vertices(shape).positions;
        let distances_m = crowd_lod::distances_to_surface(posed, level, &shape.triangles);
        let colors = heat_colors(&distances_m, red_distance_m(self.character.record.height_m));
        let mut drawn = self.shoot(size, SUPERSAMPLING, None, |scene, target| {
            scene.draw(target, self.character.triangles, &Look::Painted(&colors));
        });
        let furthest = (0..posed.len()).fold(0, |best, v| if distances_m[v] > distances_m[best] { v } else { best });
        let place = posed.get(furthest).and_then(|&place| project(&self.view(size), size, place));
        drawn.furthest = place
            .map(|place| (distances_m[furthest], [place.x / size[0] as f32, place.y / size[1] as f32]))
            .filter(|(distance_m, _)| distance_m.is_finite());
        drawn
    }

    /// Vertices of the level on seams and of class fixed; the fixed ones last, so that they lie on top.
    fn class_dots(&self, shape: &Shape<'_>) -> Vec<Dot> {
        let mut used = vec![false; shape.records.len()];
        shape.triangles.iter().flatten().for_each(|&corner| used[corner as usize] = true);
        let places = &self.posed_vertices(shape).positions;
        let of_class = |class: u32, color: [u8; 4]| {
            let vertices = (0..used.len()).filter(|&v| used[v] && shape.records[v].class() == class);
            let dots: Vec<Dot> = vertices.map(|v| Dot { place: places[v], color }).collect();
            dots
        };
        let mut dots = of_class(vertex_class::COMPANION, COMPANION_COLOR);
        dots.extend(of_class(vertex_class::FIXED, FIXED_COLOR));
        dots
    }

    fn posed_vertices<'b>(&'b self, shape: &'b Shape<'_>) -> &'b Posed {
        shape.own.as_ref().map_or(&self.posed, |own| &own.posed)
    }

    fn dot(&self, scene: &Scene<'_>, target: &mut Target, dots: &[Dot], factor: f32) {
        let radius_px = factor * DOT_SHARE * target.height as f32;
        draw_dots(target, scene.view, dots, radius_px, 0.012 * self.character.record.height_m);
    }

    /// Sides of a picture of about so many pixels.
    fn size(&self, pixels: f32) -> [u32; 2] {
        let height = (pixels * self.scale / self.aspect).sqrt();
        [(height * self.aspect) as u32, height as u32].map(|side| side.max(16))
    }

    fn view(&self, size: [u32; 2]) -> View {
        frame_character(&self.posed.positions, size, self.turn_deg, MARGIN)
    }

    /// `own`: the vertices that `draw` draws with; the character's where there are none. The camera is the same for both.
    fn shoot(
        &self,
        size: [u32; 2],
        supersampling: u32,
        own: Option<&OwnVertices>,
        draw: impl FnOnce(&Scene<'_>, &mut Target),
    ) -> Drawn {
        let mut target = backdrop(size.map(|side| side * supersampling));
        let view = self.view(size);
        let (shown, posed) = own.map_or((&self.surfaces.shown, &self.posed), |own| (&own.shown, &own.posed));
        let scene = Scene { character: self.character, surfaces: self.surfaces, shown, posed, view: &view };
        draw(&scene, &mut target);
        let picture = downsample(&target, supersampling);
        Drawn { jpeg: encode_jpeg(&picture, QUALITY), size, furthest: None }
    }
}

/// The colour of an obstacle's dots and bars, sRGB.
pub(crate) fn obstacle_color(obstacle: u8) -> [u8; 4] {
    match obstacle {
        obstacle::SEAM => COMPANION_COLOR,
        obstacle::TOPOLOGY => [124, 58, 190, 255],
        obstacle::FLIP => [20, 120, 190, 255],
        _ => FIXED_COLOR,
    }
}

fn backdrop([width, height]: [u32; 2]) -> Target {
    let mut target = Target::new(width, height, [0, 0, 0, 255]);
    for (y, row) in target.color.chunks_exact_mut(width as usize).enumerate() {
        let share = y as f32 / height as f32;
        let [top, bottom] = BACKDROP;
        let channel = |c: usize| (f32::from(top[c]) + (f32::from(bottom[c]) - f32::from(top[c])) * share) as u8;
        row.fill([channel(0), channel(1), channel(2), 255]);
    }
    target
}
