//! Shades one pixel of one triangle: perspective-correct attributes, texture, light.

use glam::{Vec2, Vec3, Vec4};

use crate::bin::{Bins, ScreenTriangle, WHOLE};
use crate::cover::Edges;
use crate::light;
use crate::sample::{level_of_detail, sample};
use crate::srgb::encode_rgb;
use crate::{Batch, Fill, Material};

/// Linear colour of the lines of [`Fill::Wireframe`] and how much they hide.
const WIRE_COLOR: Vec3 = Vec3::new(0.012, 0.014, 0.020);
const WIRE_STRENGTH: f32 = 0.85;

/// What stands for a material that is not there.
const PLAIN: Material = Material {
    base_color: [1.0; 4],
    texture: None,
    wrap_u: crate::Wrap::Repeat,
    wrap_v: crate::Wrap::Repeat,
    alpha_cutoff: 0.0,
    double_sided: false,
    unlit: false,
    flat: false,
};

impl Batch<'_> {
    /// The material of a triangle: its first corner's.
    pub(crate) fn material_of(&self, corners: [u32; 3]) -> &Material {
        let index = self.vertex_materials.get(corners[0] as usize).copied().unwrap_or(0);
        self.materials.get(usize::from(index)).unwrap_or(&PLAIN)
    }
}

/// A point of a triangle seen through a pixel's centre.
pub(crate) struct Surface {
    /// Perspective-correct shares of the triangle's corners.
    barycentric: Vec3,
    /// Their change a pixel to the right.
    ddx: Vec3,
    /// Their change a pixel down.
    ddy: Vec3,
}

/// The point at pixel (x, y).
pub(crate) fn surface_at(triangle: &ScreenTriangle, bins: &Bins, x: u32, y: u32) -> Surface {
    let edges = Edges::new(triangle);
    let inv_area = 1.0 / edges.area as f32;
    let vector = |values: [i64; 3]| Vec3::new(values[0] as f32, values[1] as f32, values[2] as f32) * inv_area;
    let inv_w = Vec3::from(triangle.inv_w);
    // Shares over w are linear on the screen; so is their sum, by which they are divided.
    let over_w = vector(edges.at(x, y)) * inv_w;
    let over_w_x = vector(edges.step_x) * inv_w;
    let over_w_y = vector(edges.step_y) * inv_w;
    let sum = over_w.element_sum();
    let share = over_w / sum;
    let share_x = (over_w_x - share * over_w_x.element_sum()) / sum;
    let share_y = (over_w_y - share * over_w_y.element_sum()) / sum;
    let corners: [Vec3; 3] = if triangle.piece == WHOLE {
        triangle.corners.map(|corner| Vec3::AXES[usize::from(corner)])
    } else {
        bins.pieces[triangle.piece as usize]
    };
    let of_triangle = |share: Vec3| corners[0] * share.x + corners[1] * share.y + corners[2] * share.z;
    Surface { barycentric: of_triangle(share), ddx: of_triangle(share_x), ddy: of_triangle(share_y) }
}

/// Material, texture and vertex colour, linear RGBA.
pub(crate) fn base_color(batch: &Batch<'_>, triangle: &ScreenTriangle, surface: &Surface) -> [f32; 4] {
    let corners = batch.triangles[triangle.triangle as usize];
    let material = batch.material_of(corners);
    let mut base = Vec4::from(material.base_color) * vertex_color(batch, corners, surface.barycentric);
    if let Some(texture) = material.texture.and_then(|index| batch.textures.get(index as usize)) {
        let uvs = corners.map(|corner| Vec2::from(batch.uvs.get(corner as usize).copied().unwrap_or_default()));
        let at = |share: Vec3| uvs[0] * share.x + uvs[1] * share.y + uvs[2] * share.z;
        let lod = level_of_detail(texture, at(surface.ddx), at(surface.ddy));
        base *= Vec4::from(sample(texture, material.wrap_u, material.wrap_v, at(surface.barycentric), lod));
    }
    base.to_array()
}

/// Interpolated vertex colour, 0 to 1; white where there is none.
fn vertex_color(batch: &Batch<'_>, corners: [u32; 3], share: Vec3) -> Vec4 {
    let color = |corner: u32| match batch.colors.get(corner as usize) {
        Some(&rgba) => Vec4::from(rgba.map(f32::from)),
        None => Vec4::splat(255.0),
    };
    (color(corners[0]) * share.x + color(corners[1]) * share.y + color(corners[2]) * share.z) / 255.0
}

/// The pixel's colour, encoded.
pub(crate) fn shade(batches: &[Batch<'_>], triangle: &ScreenTriangle, surface: &Surface) -> [u8; 4] {
    let batch = &batches[triangle.batch as usize];
    let corners = batch.triangles[triangle.triangle as usize];
    if batch.fill == Fill::VertexColor {
        return encode_rgb(vertex_color(batch, corners, surface.barycentric).truncate());
    }
    let material = batch.material_of(corners);
    let normal = || {
        let normal = normal_at(batch, corners, material, surface);
        if triangle.front { normal } else { -normal }
    };
    if batch.fill == Fill::Normal {
        let [x, y, z] = normal().to_array().map(|c| (c * 127.0 + 128.5) as u8);
        return [x, y, z, if material.unlit { 0 } else { 255 }];
    }
    let base = Vec4::from(base_color(batch, triangle, surface)).truncate();
    let mut color = base;
    if !material.unlit && batch.fill != Fill::BaseColor {
        color = base * light::light_at(normal());
    }
    if batch.fill == Fill::Wireframe {
        color = light::mix(color, WIRE_COLOR, WIRE_STRENGTH * wire_coverage(surface));
    }
    encode_rgb(color)
}

/// Unit normal towards the outside.
fn normal_at(batch: &Batch<'_>, corners: [u32; 3], material: &Material, surface: &Surface) -> Vec3 {
    let smooth = corners.map(|corner| batch.normals.get(corner as usize).copied().map(Vec3::from));
    if let [Some(a), Some(b), Some(c)] = smooth
        && !material.flat
    {
        let share = surface.barycentric;
        return (a * share.x + b * share.y + c * share.z).normalize_or_zero();
    }
    // Binning saw that the positions are there.
    let [a, b, c] = corners.map(|corner| Vec3::from(batch.positions[corner as usize]));
    (b - a).cross(c - a).normalize_or_zero()
}

/// How much of the pixel the lines along the triangle's edges cover: a pixel wide, half of it on each side of an edge.
fn wire_coverage(surface: &Surface) -> f32 {
    let mut nearest = f32::INFINITY;
    for i in 0..3 {
        let slope = Vec2::new(surface.ddx[i], surface.ddy[i]).length();
        if slope > 0.0 {
            nearest = nearest.min(surface.barycentric[i].abs() / slope);
        }
    }
    (1.0 - nearest).clamp(0.0, 1.0)
}
