//! Pictures of characters that a bake has drawn from around, for characters a few pixels high: who is one, and what the GPU is told of them.
//!
//! An impostor is one picture of two triangles ([`crowd_pack::ImpostorRecord`]). Between its size and a quarter more it shares its
//! pixels with the coarsest mesh, so that nobody changes at once: that is a level of its own, of both.

use crate::dispatch::{DOT_VERTICES, IMPOSTOR_TRIANGLES, IMPOSTOR_VERTICES};
use crate::layers::LightTable;
use crate::{BudgetIn, CrowdData, Error, FrameConfig, ImpostorCorner, Result};
use crowd_pack::{CharacterRecord, ImpostorRecord, LodRecord, NONE, PackContents};
use rayon::prelude::*;

/// Area from which on nobody is an impostor, over the area below which everyone is: a quarter higher on the screen.
pub const IMPOSTOR_FADE: f32 = 1.5625;

/// Decoded impostors of a pack.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Impostors {
    /// Texels that a tile is wide and high, a power of two.
    pub tile_px: u32,
    /// Directions around; a row of tiles has so many.
    pub azimuth_count: u32,
    /// Directions upwards; a pose has so many rows.
    pub elevation_count: u32,
    /// One a character.
    pub characters: Vec<ImpostorPoses>,
}

/// Impostors of a character: poses below each other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImpostorPoses {
    /// Poses of a clip.
    pub pose_count: u32,
    /// Clips that have poses, the first ones.
    pub clip_count: u32,
    /// Linear base colour times coverage, sRGB-encoded, and coverage; row by row.
    pub color: Vec<[u8; 4]>,
    /// Normal in the character's space, 128 for 0, and the share that light changes.
    pub normal: Vec<[u8; 4]>,
}

impl Impostors {
    /// Decodes a pack's impostors; `None` where it has none.
    ///
    /// # Errors
    /// [`Error::Impostor`] where a picture does not decode, or is not of the size that its tiles need.
    pub fn of_pack(contents: &PackContents) -> Result<Option<Self>> {
        let Some(&first) = contents.impostors.first() else { return Ok(None) };
        let decode = |(index, record): (usize, &ImpostorRecord)| {
            let picture = |start: u64, count: u32| {
                let bytes = contents.impostor_bytes.get(start as usize..start as usize + count as usize);
                let (width, height) = (record.width() as u32, record.height() as u32);
                crate::layers::decode_sized(bytes.unwrap_or_default(), width, height)
                    .map_err(|problem| Error::Impostor { index, problem })
            };
            Ok(ImpostorPoses {
                pose_count: record.pose_count,
                clip_count: record.clip_count,
                color: picture(record.color_byte_offset, record.color_byte_count)?,
                normal: picture(record.normal_byte_offset, record.normal_byte_count)?,
            })
        };
        Ok(Some(Self {
            tile_px: first.tile_px,
            azimuth_count: first.azimuth_count,
            elevation_count: first.elevation_count,
            characters: contents.impostors.par_iter().enumerate().map(decode).collect::<Result<_>>()?,
        }))
    }

    /// Texels of a row.
    pub fn width(&self) -> usize {
        self.tile_px as usize * self.azimuth_count as usize
    }

    /// Texels of a pose.
    pub fn pose_texels(&self) -> usize {
        self.width() * self.tile_px as usize * self.elevation_count as usize
    }

    /// Vertices for the GPU, `VERTEX_WORDS` each: of every character the corners of its impostor, then the vertices of its coarsest mesh.
    pub fn vertices(&self, data: &CrowdData) -> Vec<[u32; VERTEX_WORDS]> {
        let mut vertices: Vec<[u32; VERTEX_WORDS]> = Vec::new();
        let mut first_pose = 0;
        for (number, (character, poses)) in (0..).zip(data.characters.iter().zip(&self.characters)) {
            let bounds = self.bounds(poses);
            vertices.extend((0..IMPOSTOR_VERTICES).map(|corner| {
                bytemuck::cast::<_, [u32; VERTEX_WORDS]>(ImpostorCorner {
                    corner,
                    character: number,
                    first_pose,
                    pose_count: poses.pose_count,
                    clip_count: poses.clip_count,
                    bounds,
                    reserved_a: 0,
                    mark: NONE,
                    reserved_b: [0; 4],
                })
            }));
            let first = character.vertex_offset as usize;
            let mesh = &data.vertices[first..first + character.min_vertex_count as usize];
            vertices.extend(mesh.iter().map(|vertex| bytemuck::cast::<_, [u32; VERTEX_WORDS]>(*vertex)));
            first_pose += poses.pose_count * poses.clip_count;
        }
        vertices
    }

    /// Left, top, right and bottom of what is seen in any of a character's tiles, texels, and one more on each side.
    fn bounds(&self, poses: &ImpostorPoses) -> [u8; 4] {
        let side = self.tile_px as usize;
        let (mut low, mut high) = ([side; 2], [0; 2]);
        for (at, _) in poses.color.iter().enumerate().filter(|(_, texel)| texel[3] > 0) {
            let place = [at % self.width() % side, at / self.width() % side];
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis] + 1);
            }
        }
        let [left, top] = low.map(|texel| texel.saturating_sub(1) as u8);
        let [right, bottom] = high.map(|texel| (texel + 1).min(side) as u8);
        [left, top, right, bottom]
    }

    /// All poses of all characters below each other, and the mip levels of that down to tiles of two texels.
    pub fn mips(&self) -> Vec<ImpostorMip> {
        let all = |of: fn(&ImpostorPoses) -> &[[u8; 4]]| self.characters.iter().flat_map(of).copied().collect();
        let mut mips =
            vec![ImpostorMip { color: all(|poses| &poses.color), normal: all(|poses| &poses.normal) }.covered()];
        let light = LightTable::new();
        let mut width = self.width();
        for _ in 1..self.tile_px.max(2).ilog2() {
            mips.push(mips[mips.len() - 1].halve(&light, width));
            width /= 2;
        }
        mips
    }
}

/// Words of a vertex.
pub const VERTEX_WORDS: usize = 12;

/// Texels of a mip level, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpostorMip {
    /// As in [`ImpostorPoses`].
    pub color: Vec<[u8; 4]>,
    /// Normal (128 is 0) and lit share, both times coverage: so their means, of filters too, are of what is there.
    pub normal: Vec<[u8; 4]>,
}

impl ImpostorMip {
    /// Normals and lit shares times coverage.
    fn covered(mut self) -> Self {
        self.normal.par_iter_mut().zip(&self.color).for_each(|(normal, color)| {
            let coverage = i32::from(color[3]);
            let [x, y, z, lit] = *normal;
            // Rounded to the nearest; what is added keeps the number above zero.
            let times = |byte: u8| (((i32::from(byte) - 128) * coverage + 255 * 128 + 127) / 255) as u8;
            *normal = [times(x), times(y), times(z), ((i32::from(lit) * coverage + 127) / 255) as u8];
        });
        self
    }

    /// Means of four texels each. No tile reaches into another: their sides are powers of two.
    fn halve(&self, light: &LightTable, width: usize) -> Self {
        let half = width / 2;
        let texel = |i: usize| {
            let corner = i / half * 2 * width + i % half * 2;
            let block = [corner, corner + 1, corner + width, corner + width + 1];
            let coverage: u32 = block.iter().map(|at| u32::from(self.color[*at][3])).sum();
            let color = |c: usize| light.mean(block.map(|at| self.color[at][c]));
            let normal = |c: usize| {
                let sum: u32 = block.iter().map(|at| u32::from(self.normal[*at][c])).sum();
                ((sum + 2) / 4) as u8
            };
            let alpha = ((coverage + 2) / 4) as u8;
            ([color(0), color(1), color(2), alpha], [normal(0), normal(1), normal(2), normal(3)])
        };
        let (color, normal) = (0..self.color.len() / 4).into_par_iter().map(texel).unzip();
        Self { color, normal }
    }
}

/// Whether an instance is its impostor, or crosses over to it. Of those on their way, `area_px2` is at least `impostor_area_px2`.
pub(crate) fn stands_in(min_vertex_count: u32, area_px2: f32, impostor_area_px2: f32) -> bool {
    min_vertex_count > IMPOSTOR_VERTICES && area_px2 < IMPOSTOR_FADE * impostor_area_px2
}

/// Whether somebody is drawn as their impostor, alone or with the coarsest mesh, where nobody is dots.
///
/// `area_px2`: of the instance, as [`crate::cpu::cull_instances`] says; `config`: with impostors below some area.
pub fn is_impostor(character: &CharacterRecord, area_px2: f32, config: &FrameConfig) -> bool {
    stands_in(character.min_vertex_count, area_px2, config.impostor_area_px2)
}

/// The share of its pixels that an impostor has on the way from the mesh.
pub(crate) fn impostor_share(area_px2: f32, impostor_area_px2: f32) -> f32 {
    let room = (IMPOSTOR_FADE - 1.0) * impostor_area_px2;
    ((IMPOSTOR_FADE * impostor_area_px2 - area_px2) / room).clamp(0.0, 1.0)
}

/// Vertices that an instance has at least: of one dot where it may be dots, of its impostor where it is that, with the coarsest mesh where it
/// crosses over, else of the coarsest mesh.
///
/// `area_px2`: of the instance; `config`: says below which area it may be dots, and below which it is its impostor.
pub(crate) fn least_count(character: &CharacterRecord, area_px2: f32, config: &FrameConfig) -> u32 {
    let coarsest = character.min_vertex_count;
    if area_px2 < config.dot_area_px2 {
        return coarsest.min(DOT_VERTICES);
    }
    if stands_in(coarsest, area_px2, config.impostor_area_px2) {
        return IMPOSTOR_VERTICES + if area_px2 >= config.impostor_area_px2 { coarsest } else { 0 };
    }
    coarsest
}

/// What an instance takes of the budget at least: the same, or triangles where the budget counts those.
pub(crate) fn least_spent(character: &CharacterRecord, area_px2: f32, config: &FrameConfig) -> u32 {
    if config.budget_in != BudgetIn::Triangles as u32 {
        return least_count(character, area_px2, config);
    }
    let coarsest = character.min_triangle_count;
    if area_px2 < config.dot_area_px2 {
        return coarsest.min(1);
    }
    if stands_in(character.min_vertex_count, area_px2, config.impostor_area_px2) {
        return IMPOSTOR_TRIANGLES + if area_px2 >= config.impostor_area_px2 { coarsest } else { 0 };
    }
    coarsest
}

/// The level of an instance that is its impostor or crosses over to it, whatever the water: but where it may be dots and the water is too
/// low, one dot. `product`: weight times water. `None`: it is large enough for a mesh.
pub(crate) fn impostor_level(
    character: &CharacterRecord,
    area_px2: f32,
    product: f32,
    config: &FrameConfig,
) -> Option<LodRecord> {
    if !stands_in(character.min_vertex_count, area_px2, config.impostor_area_px2) {
        return None;
    }
    let may_be_dots = area_px2 < config.dot_area_px2;
    let is_short = may_be_dots && product < character.min_vertex_count as f32;
    if area_px2 >= config.impostor_area_px2 && !is_short {
        return Some(fade_level(character));
    }
    if may_be_dots && product < IMPOSTOR_VERTICES as f32 {
        return Some(LodRecord { vertex_count: DOT_VERTICES, triangle_count: 1 });
    }
    Some(LodRecord { vertex_count: IMPOSTOR_VERTICES, triangle_count: IMPOSTOR_TRIANGLES })
}

/// The coarsest mesh and the impostor.
pub(crate) fn fade_level(character: &CharacterRecord) -> LodRecord {
    LodRecord {
        vertex_count: character.min_vertex_count + IMPOSTOR_VERTICES,
        triangle_count: character.min_triangle_count + IMPOSTOR_TRIANGLES,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn character(min_vertex_count: u32) -> CharacterRecord {
        CharacterRecord { min_vertex_count, min_triangle_count: 16, vertex_count: 900, ..CharacterRecord::default() }
    }

    #[test]
    fn levels_go_from_the_mesh_over_both_to_the_impostor_and_one_dot() {
        let config = FrameConfig { impostor_area_px2: 100.0, dot_area_px2: 50.0, ..FrameConfig::default() };
        let level = |area_px2, product| {
            impostor_level(&character(30), area_px2, product, &config).map(|lod| (lod.vertex_count, lod.triangle_count))
        };
        assert_eq!(level(156.25, 1.0), None);
        assert_eq!(level(156.0, 1.0), Some((34, 18)));
        assert_eq!(level(100.0, 1e9), Some((34, 18)));
        assert_eq!(level(99.0, 1.0), Some((4, 2)));
        assert_eq!((level(49.0, 3.9), level(49.0, 4.0), level(49.0, 1e9)), (Some((3, 1)), Some((4, 2)), Some((4, 2))));
        let few = impostor_level(&character(4), 1.0, 9.0, &config);
        assert_eq!(few, None, "what has no more vertices than an impostor is no impostor");
    }

    #[test]
    fn levels_never_fall_with_the_water_and_begin_at_the_least() {
        for dot_area_px2 in [0.0, 40.0, 120.0, 400.0] {
            let config = FrameConfig { impostor_area_px2: 100.0, dot_area_px2, ..FrameConfig::default() };
            for area_px2 in [1.0, 39.0, 41.0, 99.0, 100.0, 130.0, 156.0] {
                let counts = [0.0, 3.0, 3.9, 4.0, 20.0, 30.0, 1e6].map(|product| {
                    impostor_level(&character(30), area_px2, product, &config).expect("it is small").vertex_count
                });
                assert!(counts.is_sorted(), "{counts:?}");
                assert_eq!(counts[0], least_count(&character(30), area_px2, &config), "{area_px2} of {dot_area_px2}");
                let in_triangles = FrameConfig { budget_in: BudgetIn::Triangles as u32, ..config };
                let lowest = impostor_level(&character(30), area_px2, 0.0, &config).expect("it is small");
                assert_eq!(lowest.triangle_count, least_spent(&character(30), area_px2, &in_triangles));
            }
        }
    }

    #[test]
    fn the_share_goes_from_all_to_nothing() {
        assert_eq!([90.0, 100.0, 156.25, 200.0].map(|area| impostor_share(area, 100.0)), [1.0, 1.0, 0.0, 0.0]);
        assert!((impostor_share(128.125, 100.0) - 0.5).abs() < 1e-6);
    }

    /// One pose of 2 x 1 tiles: the left one white, half covered and facing the front, the right one empty but for a corner.
    fn sheet() -> Impostors {
        let mut color = vec![[0; 4]; 128];
        let mut normal = vec![[128, 128, 128, 0]; 128];
        for at in (0..128).filter(|at| at % 16 < 8 && at % 2 == 0) {
            (color[at], normal[at]) = ([188, 188, 188, 128], [128, 128, 255, 255]);
        }
        (color[16 * 7 + 15], normal[16 * 7 + 15]) = ([255; 4], [255, 128, 128, 255]);
        let poses = ImpostorPoses { pose_count: 1, clip_count: 1, color, normal };
        Impostors { tile_px: 8, azimuth_count: 2, elevation_count: 1, characters: vec![poses] }
    }

    #[test]
    fn mips_keep_light_and_coverage_and_the_normals_of_what_is_there() {
        let mips = sheet().mips();
        assert_eq!(mips.iter().map(|mip| mip.color.len()).collect::<Vec<_>>(), [128, 32, 8]);
        for mip in &mips[1..] {
            let [r, _, _, alpha] = mip.color[0];
            assert!(r.abs_diff(137) <= 1 && alpha == 64, "half of the light and of the coverage: {:?}", mip.color[0]);
            assert_eq!(mip.normal[0], [128, 128, 160, 64], "a quarter of a normal to the front, a quarter lit");
        }
        assert_eq!(mips[1].color[7], [0; 4], "tiles do not reach into each other");
        assert_eq!((mips[1].color[31][3], mips[1].normal[31]), (64, [160, 128, 128, 64]));
    }

    #[test]
    fn pictures_that_do_not_decode_or_are_of_another_size_are_refused() {
        let png = |width, height| {
            let mut bytes = std::io::Cursor::new(Vec::new());
            let picture = image::RgbaImage::new(width, height);
            picture.write_to(&mut bytes, image::ImageFormat::Png).expect("memory takes every byte");
            bytes.into_inner()
        };
        let shape = ImpostorRecord {
            tile_px: 8,
            azimuth_count: 2,
            elevation_count: 1,
            pose_count: 3,
            clip_count: 1,
            ..ImpostorRecord::default()
        };
        let decode = |color: &[u8], normal: &[u8]| {
            let mut contents = PackContents::default();
            contents.add_impostors(shape, color, normal);
            Impostors::of_pack(&contents)
        };
        let good = decode(&png(16, 24), &png(16, 24)).expect("they fit").expect("there are some");
        assert_eq!((good.characters[0].color.len(), good.pose_texels() * 3), (16 * 24, 16 * 24));
        for (color, normal) in [
            (png(16, 24), png(16, 16)),
            (png(24, 16), png(16, 24)),
            (png(4000, 4000), png(16, 24)),
            (b"hello".to_vec(), png(16, 24)),
            (png(16, 24), png(16, 24)[..60].to_vec()),
        ] {
            let error = decode(&color, &normal).expect_err("not what the tiles need").to_string();
            assert!(error.starts_with("impostors 0 of the pack: "), "{error}");
        }
        assert_eq!(Impostors::of_pack(&PackContents::default()).expect("nothing to decode"), None);
    }

    #[test]
    fn bounds_hold_what_is_seen_in_any_tile() {
        let mut impostors = sheet();
        assert_eq!(impostors.bounds(&impostors.characters[0]), [0, 0, 8, 8]);
        let poses = &mut impostors.characters[0];
        poses.color.fill([0; 4]);
        poses.color[16 * 3 + 10][3] = 1;
        assert_eq!(impostors.bounds(&impostors.characters[0]), [1, 2, 4, 5]);
    }
}
