//! What colour a character's surface has at a point, for what stands in its place far away.

use crate::{CrowdData, TextureLayer};
use crowd_pack::{CharacterRecord, MaterialRecord, VertexRecord, material_flags};
use glam::{Vec2, Vec3, Vec4};

/// Of a point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfaceColor {
    /// Linear, alpha last.
    pub(crate) color: Vec4,
    /// Below which the point is not there.
    pub(crate) alpha_cutoff: f32,
    /// Light does not change it.
    pub(crate) is_unlit: bool,
    /// The back is seen, too.
    pub(crate) is_double_sided: bool,
}

/// The colour at a point of a triangle. `shares`: of its corners, sum 1; `texels`: that the point stands for.
pub(crate) fn color_at(
    data: &CrowdData,
    character: &CharacterRecord,
    corners: &[u32; 3],
    shares: Vec3,
    texels: f32,
) -> SurfaceColor {
    let vertices = vertices_of(data, character, corners);
    let Some(material) = material_of(data, character, &vertices) else {
        return SurfaceColor { color: Vec4::ONE, alpha_cutoff: 0.0, is_unlit: false, is_double_sided: false };
    };
    let corner_color = |vertex: &VertexRecord| Vec4::from(vertex.color.to_le_bytes().map(f32::from)) / 255.0;
    let shared = vertices.into_iter().zip(shares.to_array());
    let mut color = Vec4::from_array(material.base_color);
    color *= shared.clone().map(|(vertex, share)| corner_color(vertex) * share).sum::<Vec4>();
    if let Some(layer) = data.layers.get(material.image as usize) {
        let uv = shared.map(|(vertex, share)| Vec2::from_array(vertex.uv) * share).sum();
        color *= texel(layer, uv, texels, data.layer_side);
    }
    SurfaceColor {
        color,
        alpha_cutoff: material.alpha_cutoff,
        is_unlit: material.flags & material_flags::UNLIT != 0,
        is_double_sided: material.flags & material_flags::DOUBLE_SIDED != 0,
    }
}

/// Texels of a triangle.
pub(crate) fn texels_of(data: &CrowdData, character: &CharacterRecord, corners: &[u32; 3]) -> f32 {
    let [a, b, c] = vertices_of(data, character, corners).map(|vertex| Vec2::from_array(vertex.uv));
    (b - a).perp_dot(c - a).abs() * 0.5 * (data.layer_side * data.layer_side) as f32
}

/// Square roots of a linear colour, 0 to 255: steps that the eye sees as even.
pub(crate) fn roots(color: Vec3) -> [u8; 3] {
    color.to_array().map(|c| (c.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8)
}

fn vertices_of<'a>(data: &'a CrowdData, character: &CharacterRecord, corners: &[u32; 3]) -> [&'a VertexRecord; 3] {
    corners.map(|corner| &data.vertices[(character.vertex_offset + corner) as usize])
}

fn material_of<'a>(
    data: &'a CrowdData,
    character: &CharacterRecord,
    vertices: &[&VertexRecord; 3],
) -> Option<&'a MaterialRecord> {
    data.materials.get((character.material_offset + (vertices[0].material_class & 0xffff)) as usize)
}

/// The texel there, of the mip level whose texels are about as large as `texels` of the finest.
fn texel(layer: &TextureLayer, uv: Vec2, texels: f32, side: u32) -> Vec4 {
    let level = (0.5 * libm::log2f(texels.max(1.0))) as usize;
    let level = level.min(layer.mips.len().saturating_sub(1));
    let side = (side as usize >> level).max(1);
    let at = |u: f32| ((u.rem_euclid(1.0) * side as f32) as usize).min(side - 1);
    let texel = layer.mips.get(level).and_then(|mip| mip.get(at(uv.y) * side + at(uv.x)));
    let Some([r, g, b, a]) = texel else { return Vec4::ONE };
    Vec4::new(linear(*r), linear(*g), linear(*b), f32::from(*a) / 255.0)
}

fn linear(srgb: u8) -> f32 {
    let value = f32::from(srgb) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { libm::powf((value + 0.055) / 1.055, 2.4) }
}
