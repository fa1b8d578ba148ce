//! Levels of detail side by side: one column a level, one row a pose.

use crate::cli::Paint;
use crate::error::{BakeError, Cause, Step};
use crate::label::write_label;
use crate::paint_error::paint_error;
use crate::pose::{Mat3x4, Posed, palette_at, pose_mesh};
use crate::unpack::Unpacked;
use crowd_pack::{LodRecord, MaterialRecord, NONE, VertexRecord, material_flags, vertex_class};
use crowd_raster::{Batch, Fill, Material, Target, Texture, View, Wrap};
use glam::Vec3;
use rayon::prelude::*;

/// Samples along each side of a pixel.
const SUPERSAMPLING: u32 = 3;
/// Pixels of a whole picture: what image viewers and memory take.
const PICTURE_PX: u64 = 1 << 26;
/// Pixels of the cells that are drawn at the same time; each pixel takes 72 bytes of samples.
const CELLS_AT_ONCE_PX: u64 = 1 << 22;
/// Textures are halved down to this many pixels a side: cells are small.
const TEXTURE_SIDE_PX: u32 = 1024;
/// Vertical field of view of a cell, radians: long enough a lens to leave proportions alone.
const FIELD_OF_VIEW_RAD: f32 = 0.35;
const BACKGROUND: [u8; 4] = [226, 230, 234, 255];
const INK: [u8; 4] = [40, 44, 52, 255];
/// Distance that is painted red, as a share of the height.
const RED_SHARE: f32 = 0.02;

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
        let posed =
            pose_mesh(&character.positions, &character.normals, &character.joints, &character.weights, &palette);
        let view = frame_character(&posed.positions, request.size, request.turn_deg);
        let draw = |&ratio: &f64| {
            let (level, reached) = character.level_of_ratio(ratio);
            let mut cell = draw_cell(character, &surfaces, &posed, level, &view, request);
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

fn draw_cell(
    character: &Unpacked<'_>,
    surfaces: &Surfaces,
    posed: &Posed,
    level: LodRecord,
    view: &View,
    request: &PictureRequest,
) -> Target {
    let triangles = character.level_triangles(level);
    let (fill, colors, triangles) = match request.paint {
        Paint::Shaded => (Fill::Shaded, surfaces.colors.clone(), triangles),
        Paint::Wireframe => (Fill::Wireframe, surfaces.colors.clone(), triangles),
        Paint::Classes => (Fill::VertexColor, class_colors(character), triangles),
        Paint::Error => {
            let red_at_m = RED_SHARE * character.record.height_m.max(1e-6);
            let colors =
                paint_error(&posed.positions, character.collapse_map, &triangles, level.vertex_count, red_at_m);
            (Fill::VertexColor, colors, character.triangles.to_vec())
        }
    };
    let [width, height] = request.size.map(|side| side * SUPERSAMPLING);
    let mut target = Target::new(width, height, BACKGROUND);
    let batch = Batch {
        positions: &posed.positions,
        normals: &posed.normals,
        uvs: &surfaces.uvs,
        colors: &colors,
        vertex_materials: &surfaces.vertex_materials,
        triangles: &triangles,
        materials: &surfaces.materials,
        textures: &surfaces.textures,
        fill,
    };
    crowd_raster::draw(&mut target, view, &batch);
    crowd_raster::downsample(&target, SUPERSAMPLING)
}

/// Grey regular, amber companion, red fixed; linear.
fn class_colors(character: &Unpacked<'_>) -> Vec<[u8; 4]> {
    let color = |vertex: &VertexRecord| match vertex.class() {
        vertex_class::COMPANION => [235, 130, 10, 255],
        vertex_class::FIXED => [190, 12, 20, 255],
        _ => [90, 105, 120, 255],
    };
    character.vertices.iter().map(color).collect()
}

fn pose_palette(character: &Unpacked<'_>, pose: &Pose) -> Result<(Vec<Mat3x4>, String), Cause> {
    let Pose::Clip(asked, time_s) = pose else { return Ok((character.rest_palette(), "AT REST".to_owned())) };
    let Some(clip) = character.manifest.clips.iter().position(|clip| clip.name == *asked) else {
        let names: Vec<&str> = character.manifest.clips.iter().map(|clip| clip.name.as_str()).collect();
        return Err(Cause::ClipNotFound { asked: asked.clone(), found: names.join(", ") });
    };
    let duration_s = character.clips[clip].duration_s;
    let time_s = time_s.unwrap_or(duration_s / 2.0);
    let palette = palette_at(&character.palettes(clip), character.joint_count(), duration_s, time_s);
    Ok((palette, format!("{asked} {time_s:.2} S")))
}

/// A camera in front of the character that holds all of it, whatever its axes and size.
fn frame_character(positions: &[[f32; 3]], size: [u32; 2], turn_deg: f32) -> View {
    let turn_rad = turn_deg.to_radians();
    let back = Vec3::new(libm::sinf(turn_rad), 0.14, libm::cosf(turn_rad)).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let extent = |axis: Vec3| {
        let places = positions.iter().map(|&p| axis.dot(Vec3::from(p)));
        places.fold((f32::MAX, f32::MIN), |(low, high), place| (low.min(place), high.max(place)))
    };
    let [x, y, z] = [extent(right), extent(up), extent(back)];
    let middle = |(low, high): (f32, f32)| (low + high) / 2.0;
    let half = |(low, high): (f32, f32)| ((high - low) / 2.0).max(1e-6);
    let center = right * middle(x) + up * middle(y) + back * middle(z);
    let aspect = size[0] as f32 / size[1] as f32;
    // A tenth of air, and the label's line above.
    let reach = 1.15 * half(y).max(half(x) / aspect);
    let distance = reach / libm::tanf(FIELD_OF_VIEW_RAD / 2.0) + half(z);
    let eye = center + back * distance;
    let depth = half(x).max(half(y)).max(half(z)) * 4.0;
    let near = (distance - depth).max(distance * 0.01);
    let clip_from_view =
        glam::camera::rh::proj::directx::perspective(FIELD_OF_VIEW_RAD, aspect, near, distance + depth);
    View { clip_from_world: clip_from_view * glam::camera::rh::view::look_at_mat4(eye, center, Vec3::Y), eye }
}

/// Materials, textures and vertex attributes as the rasteriser wants them.
struct Surfaces {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    uvs: Vec<[f32; 2]>,
    colors: Vec<[u8; 4]>,
    vertex_materials: Vec<u16>,
}

impl Surfaces {
    fn load(character: &Unpacked<'_>) -> Result<Self, Cause> {
        let mut images: Vec<u32> = character.materials.iter().map(|m| m.image).filter(|&image| image != NONE).collect();
        images.sort_unstable();
        images.dedup();
        let decode = |&image: &u32| {
            let record = character.contents.images[image as usize];
            let bytes = &character.contents.image_bytes[record.byte_offset as usize..][..record.byte_count as usize];
            crowd_raster::decode_texture(bytes, TEXTURE_SIDE_PX)
        };
        Ok(Self {
            textures: images.par_iter().map(decode).collect::<Result<_, _>>()?,
            materials: character.materials.iter().map(|record| raster_material(record, &images)).collect(),
            uvs: character.vertices.iter().map(|vertex| vertex.uv).collect(),
            colors: character.vertices.iter().map(|vertex| vertex.color.to_le_bytes()).collect(),
            vertex_materials: character.vertices.iter().map(|vertex| vertex.material() as u16).collect(),
        })
    }
}

fn raster_material(record: &MaterialRecord, images: &[u32]) -> Material {
    use material_flags::{DOUBLE_SIDED, FLAT, UNLIT, WRAP_MASK, WRAP_U_SHIFT, WRAP_V_SHIFT};
    let wrap = |shift: u32| match (record.flags >> shift) & WRAP_MASK {
        1 => Wrap::Clamp,
        2 => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    Material {
        base_color: record.base_color,
        texture: images.binary_search(&record.image).ok().map(|place| place as u32),
        wrap_u: wrap(WRAP_U_SHIFT),
        wrap_v: wrap(WRAP_V_SHIFT),
        alpha_cutoff: record.alpha_cutoff,
        double_sided: record.flags & DOUBLE_SIDED != 0,
        unlit: record.flags & UNLIT != 0,
        flat: record.flags & FLAT != 0,
    }
}

fn paste(strip: &mut Target, cell: &Target, at: [u32; 2]) {
    for y in 0..cell.height {
        let from = (y * cell.width) as usize;
        let to = ((at[1] + y) * strip.width + at[0]) as usize;
        strip.color[to..to + cell.width as usize].copy_from_slice(&cell.color[from..from + cell.width as usize]);
    }
}
