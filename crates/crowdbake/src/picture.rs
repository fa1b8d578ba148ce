//! Levels of detail side by side: one column a level, one row a pose.

use crate::cli::Paint;
use crate::draw_level::{Look, Scene, Surfaces, class_colors, clip_palette, frame_character, pose_character};
use crate::error::{BakeError, Cause, Step};
use crate::heat::{heat_colors, red_distance_m};
use crate::label::write_label;
use crate::pose::Mat3x4;
use crate::unpack::Unpacked;
use crowd_pack::LodRecord;
use crowd_raster::Target;
use rayon::prelude::*;

/// Samples along each side of a pixel.
const SUPERSAMPLING: u32 = 3;
/// Pixels of a whole picture: what image viewers and memory take.
const PICTURE_PX: u64 = 1 << 26;
/// Pixels of the cells that are drawn at the same time; each pixel takes 72 bytes of samples.
const CELLS_AT_ONCE_PX: u64 = 1 << 22;
/// Sides of a cell over sides of the character: a tenth of air, and the label's line above.
const MARGIN: f32 = 1.15;
const BACKGROUND: [u8; 4] = [226, 230, 234, 255];
const INK: [u8; 4] = [40, 44, 52, 255];

/// What to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureRequest {
    /// Shares of the triangles, one column each.
    pub ratios: Vec<f64>,
    /// Poses, one row each.
    pub rows: Vec<Pose>,
    /// What the colours say.
    pub paint: Paint,
    /// Pixels of one cell.
    pub size: [u32; 2],
    /// Degrees to turn.
    pub turn_deg: f32,
}

/// A moment of a character.
#[derive(Debug, Clone, PartialEq)]
pub enum Pose {
    /// The pose at rest.
    Bind,
    /// Seconds into a clip of that name; its middle where no time is given.
    Clip(String, Option<f32>),
}

/// Refuses a picture of more pixels than one may have, before anything is opened for it.
///
/// # Errors
/// [`Cause::PictureTooLarge`], with the pixels found and allowed.
pub fn refuse_large_picture(columns: usize, rows: usize, [width, height]: [u32; 2]) -> Result<(), BakeError> {
    let sides = [rows as u64, width.into(), height.into()];
    let found = sides.iter().fold(columns as u64, |product, &side| product.saturating_mul(side));
    if found <= PICTURE_PX {
        return Ok(());
    }
    let allowed = PICTURE_PX;
    Err(BakeError::whole(Step::Draw, Cause::PictureTooLarge { columns, rows, width, height, found, allowed }))
}

/// Draws the strip.
///
/// # Errors
/// A picture too large, a clip that the character does not have, an image that does not decode.
pub fn draw_picture(character: &Unpacked<'_>, request: &PictureRequest) -> Result<Target, BakeError> {
    let name = character.manifest.name.as_str();
    let fail = |cause: Cause| BakeError::of(Step::Draw, name, cause);
    refuse_large_picture(request.ratios.len(), request.rows.len(), request.size)?;
    let surfaces = Surfaces::load(character).map_err(fail)?;
    let [width, height] = request.size;
    let cells_at_once = (CELLS_AT_ONCE_PX / (u64::from(width) * u64::from(height)).max(1)).max(1) as usize;
    let columns = request.ratios.len() as u32;
    let mut strip = Target::new(width * columns, height * request.rows.len() as u32, BACKGROUND);
    for (row, pose) in request.rows.iter().enumerate() {
        let (palette, label) = pose_palette(character, pose).map_err(fail)?;
        let posed = pose_character(character, &palette);
        let view = frame_character(&posed.positions, request.size, request.turn_deg, MARGIN);
        let scene = Scene { character, surfaces: &surfaces, shown: &surfaces.shown, posed: &posed, view: &view };
        let draw = |&ratio: &f64| {
            let (level, reached) = character.level_of_ratio(ratio);
            let mut cell = draw_cell(&scene, level, request);
            let text = level_label(level, character.record.triangle_count, reached);
            write_label(&mut cell, [8, 8], &text, 2, INK);
            cell
        };
        let mut left = 0;
        for ratios in request.ratios.chunks(cells_at_once) {
            let cells: Vec<Target> = ratios.par_iter().map(draw).collect();
            for cell in &cells {
                paste(&mut strip, cell, [left, row as u32 * height]);
                left += width;
            }
        }
        write_label(&mut strip, [8, (row as u32 + 1) * height - 22], &label, 2, INK);
    }
    Ok(strip)
}

fn level_label(level: LodRecord, full_triangle_count: u32, reached: bool) -> String {
    let share = 100.0 * f64::from(level.triangle_count) / f64::from(full_triangle_count.max(1));
    let share = if share >= 99.95 { "100".to_owned() } else { format!("{share:.1}") };
    let lowest = if reached { "" } else { " LOWEST" };
    format!("{} TRI  {share}%{lowest}", level.triangle_count)
}

fn draw_cell(scene: &Scene<'_>, level: LodRecord, request: &PictureRequest) -> Target {
    let character = scene.character;
    let triangles = character.level_triangles(level);
    let [width, height] = request.size.map(|side| side * SUPERSAMPLING);
    let mut target = Target::new(width, height, BACKGROUND);
    match request.paint {
        Paint::Shaded => scene.draw(&mut target, &triangles, &Look::Textured),
        Paint::Wireframe => scene.draw(&mut target, &triangles, &Look::TexturedEdges),
        Paint::Classes => scene.draw(&mut target, &triangles, &Look::Painted(&class_colors(character))),
        Paint::Error => {
            let posed = &scene.posed.positions;
            let distances_m = crowd_lod::distances_to_surface(posed, posed, &triangles);
            let colors = heat_colors(&distances_m, red_distance_m(character.record.height_m));
            scene.draw(&mut target, character.triangles, &Look::Painted(&colors));
        }
    }
    crowd_raster::downsample(&target, SUPERSAMPLING)
}

fn pose_palette(character: &Unpacked<'_>, pose: &Pose) -> Result<(Vec<Mat3x4>, String), Cause> {
    let Pose::Clip(asked, time_s) = pose else { return Ok((character.rest_palette(), "AT REST".to_owned())) };
    let (palette, time_s) = clip_palette(character, asked, *time_s)?;
    Ok((palette, format!("{asked} {time_s:.2} S")))
}

fn paste(strip: &mut Target, cell: &Target, at: [u32; 2]) {
    for y in 0..cell.height {
        let from = (y * cell.width) as usize;
        let to = ((at[1] + y) * strip.width + at[0]) as usize;
        strip.color[to..to + cell.width as usize].copy_from_slice(&cell.color[from..from + cell.width as usize]);
    }
}
