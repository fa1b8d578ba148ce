//! Impostors: small pictures of a character from around, at some moments of each clip, which stand for it where it is a few pixels high.
//!
//! Drawn from what the pack stores: base colours and normals, so that light stays the player's. A texel is the mean of
//! sixteen samples.

use crate::draw_level::{Look, Scene, Surfaces, pose_character};
use crate::error::{BakeError, Cause, Step};
use crate::pose::{Mat3x4, Posed, palette_at};
use crate::unpack::Unpacked;
use crowd_pack::{ImpostorRecord, PackContents, limits};
use crowd_raster::srgb::{decode_table, encode_rgb};
use crowd_raster::{Target, View, encode_texels};
use glam::{Mat4, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, TAU};

/// Directions around a character: the next one is at most 11 degrees off, which makes an animal seen from the front a sixth wider.
const AZIMUTHS: u32 = 16;
/// Directions upwards: 11 and 56 degrees. Who is a few pixels high is far away, and is seldom seen from above.
const ELEVATIONS: u32 = 2;
/// Most moments of a clip.
const POSES_A_CLIP: u32 = 8;
/// Most poses of a character; clips beyond are shown in the first pose of all.
const MOST_POSES: u32 = 64;
/// Samples of a texel along one side.
const SAMPLES: u32 = 4;
/// Triangles that are drawn at most: a level that large is off by far less than a texel.
const MOST_TRIANGLES: u32 = 4096;
/// Normals are rounded to multiples of this, a sixteenth of what they may be: half the bytes, and no difference that can be seen.
const NORMAL_STEP: u8 = 8;

/// A character's impostors before they become a record.
#[derive(Debug, Clone)]
pub struct BakedImpostors {
    /// What the pictures hold; places are zeros.
    pub shape: ImpostorRecord,
    /// PNG: linear base colour times coverage, sRGB-encoded; alpha is coverage.
    pub color: Vec<u8>,
    /// PNG: mean normal in character space, a byte for -1 to 1; alpha is the share that light changes.
    pub normal: Vec<u8>,
}

/// Draws the impostors of every character of a pack. `tile_px`: a power of two from 8 to 128.
///
/// Clips share what a character may have: eight poses each, fewer where there are many clips.
///
/// # Errors
/// An image does not decode, or there are more texels than a pack holds.
pub fn bake_impostors(contents: &PackContents, tile_px: u32) -> Result<Vec<BakedImpostors>, BakeError> {
    let most_poses =
        poses_that_fit(contents.characters.len(), tile_px).map_err(|cause| BakeError::whole(Step::Impostors, cause))?;
    let draw = |index: usize| {
        let character = Unpacked::new(contents, index);
        let shape = shape_of(character.record.clip_count, tile_px, most_poses);
        draw_character(&character, shape)
            .map_err(|cause| BakeError::of(Step::Impostors, &character.manifest.name, cause))
    };
    (0..contents.characters.len()).map(draw).collect()
}

/// Poses a character may have so that all characters' texels stay within the limit of a pack.
fn poses_that_fit(characters: usize, tile_px: u32) -> Result<u32, Cause> {
    let pose_texels = u64::from(AZIMUTHS * ELEVATIONS) * u64::from(tile_px * tile_px);
    let least = pose_texels * characters as u64;
    if least > limits::IMPOSTOR_TEXELS {
        return Err(Cause::Limit {
            what: "texels of impostors",
            found: least,
            allowed: limits::IMPOSTOR_TEXELS,
            remedy: "bake smaller ones with --impostors PX, or fewer characters into one pack",
        });
    }
    Ok(((limits::IMPOSTOR_TEXELS / least.max(1)) as u32).min(MOST_POSES))
}

fn shape_of(clip_count: u32, tile_px: u32, most_poses: u32) -> ImpostorRecord {
    let clip_count = clip_count.min(most_poses);
    ImpostorRecord {
        tile_px,
        azimuth_count: AZIMUTHS,
        elevation_count: ELEVATIONS,
        pose_count: (most_poses / clip_count.max(1)).min(POSES_A_CLIP),
        clip_count,
        ..ImpostorRecord::default()
    }
}

/// What is drawn.
struct Drawn<'a> {
    character: &'a Unpacked<'a>,
    surfaces: &'a Surfaces,
    triangles: &'a [[u32; 3]],
}

/// Texels of a pose, row by row.
#[derive(Default)]
struct Texels {
    color: Vec<[u8; 4]>,
    normal: Vec<[u8; 4]>,
}

fn draw_character(character: &Unpacked<'_>, shape: ImpostorRecord) -> Result<BakedImpostors, Cause> {
    let surfaces = Surfaces::load(character)?;
    let (level, _) = character.largest_level(|level| level.triangle_count <= MOST_TRIANGLES);
    let drawn = Drawn { character, surfaces: &surfaces, triangles: &character.level_triangles(level) };
    let mut all = Texels::default();
    for clip in 0..shape.clip_count {
        let palettes = character.palettes(clip as usize);
        let poses: Vec<Texels> = (0..shape.pose_count)
            .into_par_iter()
            .map(|pose| draw_pose(&drawn, &palettes, clip as usize, pose, &shape))
            .collect();
        for pose in poses {
            all.color.extend(pose.color);
            all.normal.extend(pose.normal);
        }
    }
    let (width, height) = (shape.width() as u32, shape.height() as u32);
    let (color, normal) =
        rayon::join(|| encode_texels(width, height, &all.color), || encode_texels(width, height, &all.normal));
    Ok(BakedImpostors { shape, color, normal })
}

/// All tiles of a pose: the middle of its part of the clip, from every direction.
fn draw_pose(drawn: &Drawn<'_>, palettes: &[Mat3x4], clip: usize, pose: u32, shape: &ImpostorRecord) -> Texels {
    let character = drawn.character;
    let record = &character.clips[clip];
    let time_s = record.duration_s * (pose as f32 + 0.5) / shape.pose_count as f32;
    let palette = palette_at(palettes, character.joint_count(), record.duration_s, time_s);
    let posed = pose_character(character, &palette);
    let (side, width) = (shape.tile_px as usize, shape.width() as usize);
    let texel_count = width * side * shape.elevation_count as usize;
    let mut texels = Texels { color: vec![[0; 4]; texel_count], normal: vec![[0; 4]; texel_count] };
    for elevation in 0..shape.elevation_count {
        for azimuth in 0..shape.azimuth_count {
            let view = view_from(record.sphere, direction(azimuth, elevation, shape));
            let [colors, normals] =
                [Look::BaseColors, Look::Normals].map(|look| draw_tile(drawn, &posed, &view, &look, side));
            for y in 0..side {
                for x in 0..side {
                    let (color, normal) = mean_texel(&colors, &normals, x, y);
                    let at = (elevation as usize * side + y) * width + azimuth as usize * side + x;
                    (texels.color[at], texels.normal[at]) = (color, normal);
                }
            }
        }
    }
    texels
}

fn draw_tile(drawn: &Drawn<'_>, posed: &Posed, view: &View, look: &Look<'_>, side: usize) -> Target {
    let Drawn { character, surfaces, triangles } = *drawn;
    let side = side as u32 * SAMPLES;
    let mut target = Target::new(side, side, [0; 4]);
    Scene { character, surfaces, shown: &surfaces.shown, posed, view }.draw(&mut target, triangles, look);
    target
}

/// Azimuth and elevation towards the eye, radians: evenly around from the front on, evenly up from a little above the horizon on, where most
/// cameras are.
fn direction(azimuth: u32, elevation: u32, shape: &ImpostorRecord) -> [f32; 2] {
    let share = (elevation as f32 + 0.25) / shape.elevation_count as f32;
    [TAU * azimuth as f32 / shape.azimuth_count as f32, FRAC_PI_2 * share]
}

/// Parallel rays from there, the sphere as wide as the tile.
fn view_from(sphere: [f32; 4], [azimuth_rad, elevation_rad]: [f32; 2]) -> View {
    let (center, radius) = (Vec3::new(sphere[0], sphere[1], sphere[2]), sphere[3].max(1e-6));
    let ((sin_a, cos_a), (sin_e, cos_e)) = (libm::sincosf(azimuth_rad), libm::sincosf(elevation_rad));
    let right = Vec3::new(cos_a, 0.0, -sin_a);
    let up = Vec3::new(-sin_a * sin_e, cos_e, -cos_a * sin_e);
    let towards = Vec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
    let row = |axis: Vec3, scale: f32, offset: f32| (axis * scale).extend(offset - axis.dot(center) * scale);
    // Nearest is 0. A hair of room for what rounding puts outside of the sphere.
    let rows =
        [row(right, 1.0 / radius, 0.0), row(up, 1.0 / radius, 0.0), row(towards, -0.49 / radius, 0.5), glam::Vec4::W];
    let clip_from_world = Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
    View { clip_from_world, eye: center + towards * (1000.0 * radius) }
}

/// Means over a texel's samples: colour times coverage and coverage; the normal of what is there and how much of it is lit.
fn mean_texel(colors: &Target, normals: &Target, x: usize, y: usize) -> ([u8; 4], [u8; 4]) {
    let linear = decode_table();
    let side = SAMPLES as usize;
    let (mut color, mut normal, mut lit, mut count) = (Vec3::ZERO, Vec3::ZERO, 0, 0);
    for row in y * side..(y + 1) * side {
        for at in row * colors.width as usize + x * side..row * colors.width as usize + (x + 1) * side {
            if colors.depth[at] < 1.0 {
                let [r, g, b, _] = colors.color[at].map(usize::from);
                color += Vec3::new(linear[r], linear[g], linear[b]);
                let [x, y, z, light] = normals.color[at];
                normal += Vec3::new(x.into(), y.into(), z.into());
                lit += u32::from(light);
                count += 1;
            }
        }
    }
    if count == 0 {
        return ([0; 4], [128, 128, 128, 0]);
    }
    let all = SAMPLES * SAMPLES;
    let [r, g, b, _] = encode_rgb(color / all as f32);
    let [x, y, z] = (normal / count as f32).to_array().map(rounded);
    ([r, g, b, ((count * 255 + all / 2) / all) as u8], [x, y, z, (lit / count) as u8])
}

fn rounded(byte: f32) -> u8 {
    let step = f32::from(NORMAL_STEP);
    ((byte / step + 0.5).floor() * step).min(255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_share_the_poses() {
        let counts = |clips, most| {
            let shape = shape_of(clips, 32, most);
            (shape.clip_count, shape.pose_count)
        };
        assert_eq!(counts(4, 64), (4, 8));
        assert_eq!(counts(20, 64), (20, 3));
        assert_eq!(counts(100, 64), (64, 1));
        assert_eq!(counts(3, 1), (1, 1));
    }

    #[test]
    fn characters_share_the_texels_and_too_many_are_refused() {
        assert_eq!(poses_that_fit(7, 32).expect("few"), 64);
        assert_eq!(poses_that_fit(100, 32).expect("some"), 20);
        let error = poses_that_fit(4096, 128).expect_err("two billion texels").to_string();
        assert!(error.contains("--impostors"), "{error}");
    }

    #[test]
    fn the_view_from_the_front_has_the_left_hand_right() {
        let shape = ImpostorRecord { azimuth_count: 4, elevation_count: 2, ..ImpostorRecord::default() };
        let at = |azimuth: u32, elevation_rad: f32, p: Vec3| {
            let [azimuth_rad, _] = direction(azimuth, 0, &shape);
            view_from([1.0, 2.0, 3.0, 2.0], [azimuth_rad, elevation_rad]).clip_from_world.project_point3(p)
        };
        // Characters face +Z, their left hand is at +X: from the front that is to the right.
        let front = at(0, 0.0, Vec3::new(3.0, 2.0, 3.0));
        assert!(front.abs_diff_eq(Vec3::new(1.0, 0.0, 0.5), 1e-6), "{front}");
        let top = at(0, 0.0, Vec3::new(1.0, 4.0, 3.0));
        assert!(top.abs_diff_eq(Vec3::new(0.0, 1.0, 0.5), 1e-6), "{top}");
        // From +X the front is to the left.
        let side = at(1, 0.0, Vec3::new(1.0, 2.0, 5.0));
        assert!(side.abs_diff_eq(Vec3::new(-1.0, 0.0, 0.5), 1e-5), "{side}");
        // What is nearer has less depth, and from above that is what is higher.
        assert!(at(0, 0.0, Vec3::new(1.0, 2.0, 4.0)).z < 0.5 && at(0, 0.8, Vec3::new(1.0, 3.0, 3.0)).z < 0.5);
        assert_eq!(direction(0, 1, &shape), [0.0, FRAC_PI_2 * 0.625]);
    }
}
