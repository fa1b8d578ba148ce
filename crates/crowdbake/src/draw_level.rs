//! Draws one level in one pose: what strips and report pages are made of.

use crate::error::Cause;
use crate::pose::{Mat3x4, Posed, palette_at, pose_mesh};
use crate::unpack::Unpacked;
use crowd_pack::{MaterialRecord, NONE, VertexRecord, material_flags, vertex_class};
use crowd_raster::{Batch, Coverage, Fill, Material, Target, Texture, View, Wrap};
use glam::Vec3;
use rayon::prelude::*;

/// Textures are halved down to this many pixels a side: cells are small.
const TEXTURE_SIDE_PX: u32 = 1024;
/// Vertical field of view of a cell, radians: long enough a lens to leave proportions alone.
const FIELD_OF_VIEW_RAD: f32 = 0.35;
/// How far above the character's middle the camera looks from, as a slope.
const CAMERA_SLOPE: f32 = 0.14;
/// Linear colour of the clay that wireframes are drawn on.
const CLAY: [u8; 4] = [110, 114, 120, 255];

/// Materials and textures as the rasteriser wants them, and what the character's vertices show.
pub(crate) struct Surfaces {
    materials: Vec<Material>,
    /// The same without textures and colours.
    clay: Vec<Material>,
    textures: Vec<Texture>,
    pub(crate) shown: ShownVertices,
}

/// What vertices show, pose apart; one entry per vertex.
pub(crate) struct ShownVertices {
    uvs: Vec<[f32; 2]>,
    colors: Vec<[u8; 4]>,
    materials: Vec<u16>,
}

impl ShownVertices {
    pub(crate) fn new(vertices: &[VertexRecord]) -> Self {
        Self {
            uvs: vertices.iter().map(|vertex| vertex.uv).collect(),
            colors: vertices.iter().map(|vertex| vertex.color.to_le_bytes()).collect(),
            materials: vertices.iter().map(|vertex| vertex.material() as u16).collect(),
        }
    }
}

/// What a surface shows.
pub(crate) enum Look<'a> {
    /// Materials and light.
    Textured,
    /// Materials, light and the triangles' edges.
    TexturedEdges,
    /// The triangles' edges on clay.
    Edges,
    /// Linear colours, one a vertex, and light.
    Painted(&'a [[u8; 4]]),
    /// Materials without light.
    BaseColors,
    /// Normals as bytes, see [`Fill::Normal`].
    Normals,
}

/// A character in a pose, seen by a camera.
pub(crate) struct Scene<'a> {
    pub character: &'a Unpacked<'a>,
    pub surfaces: &'a Surfaces,
    /// What the vertices show that triangles are drawn with: the character's, or a level's own.
    pub shown: &'a ShownVertices,
    /// The same vertices, posed.
    pub posed: &'a Posed,
    pub view: &'a View,
}

impl Scene<'_> {
    /// Draws triangles over what is in `target`.
    pub(crate) fn draw(&self, target: &mut Target, triangles: &[[u32; 3]], look: &Look<'_>) {
        let surfaces = self.surfaces;
        let clay;
        let (fill, colors, materials): (Fill, &[[u8; 4]], &[Material]) = match look {
            Look::Textured => (Fill::Shaded, &self.shown.colors, &surfaces.materials),
            Look::BaseColors => (Fill::BaseColor, &self.shown.colors, &surfaces.materials),
            Look::Normals => (Fill::Normal, &self.shown.colors, &surfaces.materials),
            Look::TexturedEdges => (Fill::Wireframe, &self.shown.colors, &surfaces.materials),
            Look::Edges => {
                clay = vec![CLAY; self.posed.positions.len()];
                (Fill::Wireframe, &clay, &surfaces.clay)
            }
            Look::Painted(colors) => (Fill::Shaded, colors, &surfaces.clay),
        };
        let batch = Batch {
            positions: &self.posed.positions,
            normals: &self.posed.normals,
            uvs: &self.shown.uvs,
            colors,
            vertex_materials: &self.shown.materials,
            triangles,
            materials,
            textures: &surfaces.textures,
            fill,
        };
        crowd_raster::draw(target, self.view, &batch);
    }
}

impl Surfaces {
    /// Decodes the character's images and lists its materials.
    ///
    /// # Errors
    /// An image that does not decode.
    pub(crate) fn load(character: &Unpacked<'_>) -> Result<Self, Cause> {
        let (materials, images) = raster_materials(character);
        let decode = |(texture, &image): (usize, &u32)| {
            let show = |coverage: &mut Coverage| show_triangles(coverage, character, &materials, texture as u32);
            crowd_raster::decode_shown(image_bytes(character, image), TEXTURE_SIDE_PX, show)
        };
        let plain = |material: &Material| Material {
            base_color: [1.0; 4],
            texture: None,
            alpha_cutoff: 0.0,
            unlit: false,
            ..*material
        };
        Ok(Self {
            textures: images.par_iter().enumerate().map(decode).collect::<Result<_, _>>()?,
            clay: materials.iter().map(plain).collect(),
            materials,
            shown: ShownVertices::new(character.vertices),
        })
    }
}

/// An image of the pack, halved until it is at most `side_px` wide and high. `image`: one that a material names.
pub(crate) fn decode_image(character: &Unpacked<'_>, image: u32, side_px: u32) -> Result<Texture, Cause> {
    Ok(crowd_raster::decode_texture(image_bytes(character, image), side_px)?)
}

fn image_bytes<'a>(character: &Unpacked<'a>, image: u32) -> &'a [u8] {
    let record = character.contents.images[image as usize];
    &character.contents.image_bytes[record.byte_offset as usize..][..record.byte_count as usize]
}

/// What full detail shows of a texture.
fn show_triangles(coverage: &mut Coverage, character: &Unpacked<'_>, materials: &[Material], texture: u32) {
    for corners in character.triangles {
        let [first, second, third] = corners.map(|corner| &character.vertices[corner as usize]);
        let material = materials.get(first.material() as usize).filter(|material| material.texture == Some(texture));
        let Some(material) = material else { continue };
        if material.alpha_cutoff > 0.0 {
            coverage.read_alpha();
        }
        coverage.add([first.uv, second.uv, third.uv], [material.wrap_u, material.wrap_v]);
    }
}

/// Materials of a character of a pack, and the images of the pack that are their textures.
pub(crate) fn raster_materials(character: &Unpacked<'_>) -> (Vec<Material>, Vec<u32>) {
    let mut images: Vec<u32> = character.materials.iter().map(|m| m.image).filter(|&image| image != NONE).collect();
    images.sort_unstable();
    images.dedup();
    let materials = character.materials.iter().map(|record| raster_material(record, &images)).collect();
    (materials, images)
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

/// Grey regular, amber companion, red fixed; linear, one a vertex.
pub(crate) fn class_colors(character: &Unpacked<'_>) -> Vec<[u8; 4]> {
    let color = |vertex: &VertexRecord| match vertex.class() {
        vertex_class::COMPANION => [150, 70, 4, 255],
        vertex_class::FIXED => [140, 6, 10, 255],
        _ => [80, 86, 94, 255],
    };
    character.vertices.iter().map(color).collect()
}

/// The character's mesh under a palette.
pub(crate) fn pose_character(character: &Unpacked<'_>, palette: &[Mat3x4]) -> Posed {
    pose_mesh(&character.positions, &character.normals, &character.joints, &character.weights, palette)
}

/// The matrices of a clip at a time; its middle where no time is given. Gives the time too, seconds.
///
/// # Errors
/// A clip that the character does not have.
pub(crate) fn clip_palette(
    character: &Unpacked<'_>,
    asked: &str,
    time_s: Option<f32>,
) -> Result<(Vec<Mat3x4>, f32), Cause> {
    let Some(clip) = character.manifest.clips.iter().position(|clip| clip.name == asked) else {
        let names: Vec<&str> = character.manifest.clips.iter().map(|clip| clip.name.as_str()).collect();
        return Err(Cause::ClipNotFound { asked: asked.to_owned(), found: names.join(", ") });
    };
    let duration_s = character.clips[clip].duration_s;
    let time_s = time_s.unwrap_or(duration_s / 2.0);
    Ok((palette_at(&character.palettes(clip), character.joint_count(), duration_s, time_s), time_s))
}

/// How wide, high and deep a posed character is, seen by a camera turned by `turn_deg`, metres.
pub(crate) fn extents(positions: &[[f32; 3]], turn_deg: f32) -> [f32; 3] {
    axes(turn_deg).map(|axis| {
        let (low, high) = extent(positions, axis);
        (high - low).max(0.0)
    })
}

/// Right, up and back of the camera.
fn axes(turn_deg: f32) -> [Vec3; 3] {
    let turn_rad = turn_deg.to_radians();
    let back = Vec3::new(libm::sinf(turn_rad), CAMERA_SLOPE, libm::cosf(turn_rad)).normalize();
    let right = Vec3::Y.cross(back).normalize();
    [right, back.cross(right), back]
}

fn extent(positions: &[[f32; 3]], axis: Vec3) -> (f32, f32) {
    let places = positions.iter().map(|&p| axis.dot(Vec3::from(p)));
    places.fold((f32::MAX, f32::MIN), |(low, high), place| (low.min(place), high.max(place)))
}

/// A camera in front of the character that holds all of it, whatever its axes and size. `margin`: sides of the picture over
/// sides of the character, above 1.
pub(crate) fn frame_character(positions: &[[f32; 3]], size: [u32; 2], turn_deg: f32, margin: f32) -> View {
    let [right, up, back] = axes(turn_deg);
    let [x, y, z] = [right, up, back].map(|axis| extent(positions, axis));
    let middle = |(low, high): (f32, f32)| (low + high) / 2.0;
    let half = |(low, high): (f32, f32)| ((high - low) / 2.0).max(1e-6);
    let center = right * middle(x) + up * middle(y) + back * middle(z);
    let aspect = size[0] as f32 / size[1] as f32;
    let reach = margin * half(y).max(half(x) / aspect);
    let distance = reach / libm::tanf(FIELD_OF_VIEW_RAD / 2.0) + half(z);
    let eye = center + back * distance;
    let depth = half(x).max(half(y)).max(half(z)) * 4.0;
    let near = (distance - depth).max(distance * 0.01);
    let clip_from_view =
        glam::camera::rh::proj::directx::perspective(FIELD_OF_VIEW_RAD, aspect, near, distance + depth);
    View { clip_from_world: clip_from_view * glam::camera::rh::view::look_at_mat4(eye, center, Vec3::Y), eye }
}
