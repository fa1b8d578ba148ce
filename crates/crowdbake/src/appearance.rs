//! What a character's textures show, as the simplifier wants to know it: colours at the vertices, and how fast they change.

use crate::draw_level::{decode_image, raster_materials};
use crate::unpack::Unpacked;
use crate::views;
use crowd_raster::srgb::srgb_from_linear_rgb;
use crowd_raster::{Material, Texture, sample};
use crowd_source::RawCharacter;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Longest side of a texture that is looked at: a crowd's members are rarely seen closer.
const TEXTURE_SIDE_PX: u32 = 512;
/// The step over which a change of colour counts, in texture coordinates: eight texels of that size.
const STEP: f32 = 8.0 / 512.0;
/// Mip level that fits the step.
const STEP_LOD: f32 = 2.0;
/// Where a triangle's texture is looked at: weights of its corners.
const LOOKED_AT: [[f32; 3]; 4] =
    [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.7, 0.15, 0.15], [0.15, 0.7, 0.15], [0.15, 0.15, 0.7]];

/// Owned form of [`crowd_lod::Appearance`].
#[derive(Debug, Clone, Default)]
pub(crate) struct ShownTextures {
    surfaces: Vec<Surface>,
    flat_materials: Vec<bool>,
    vertex_colors: Vec<[f32; 3]>,
    triangle_contrast: Vec<f32>,
}

impl ShownTextures {
    /// Looks at the textures of a character. One that does not decode counts as white: the reader has warned of it, or the first picture will.
    pub fn of(raw: &RawCharacter, triangle_materials: &[u16]) -> Self {
        let decode = |image: &crowd_source::RawImage| crowd_raster::decode_texture(&image.bytes, TEXTURE_SIDE_PX).ok();
        let textures: Vec<Option<Texture>> = raw.images.par_iter().map(decode).collect();
        let mesh = &raw.mesh;
        let surfaces = surfaces(raw.materials.iter().map(views::raster_material).collect(), textures);
        let mut material_of = vec![0_u16; mesh.positions.len()];
        for (triangle, &material) in mesh.triangles.iter().zip(triangle_materials) {
            triangle.iter().for_each(|&v| material_of[v as usize] = material);
        }
        let vertex_color = |v: usize| {
            let tint = mesh.colors[v].map(|channel| f32::from(channel) / 255.0);
            let shown = surfaces[usize::from(material_of[v])].at(mesh.uvs[v], Vec3::new(tint[0], tint[1], tint[2]));
            shown.to_array()
        };
        Self {
            vertex_colors: (0..mesh.positions.len()).into_par_iter().map(vertex_color).collect(),
            triangle_contrast: contrast(&surfaces, &mesh.triangles, triangle_materials, |v| mesh.uvs[v as usize]),
            flat_materials: surfaces.iter().map(|surface| surface.material.flat).collect(),
            surfaces,
        }
    }

    /// Looks at those of a character of a pack, by the order of its triangles: the same numbers that its bake found.
    pub fn of_pack(character: &Unpacked<'_>) -> Self {
        let (materials, images) = raster_materials(character);
        let decode = |&image: &u32| decode_image(character, image, TEXTURE_SIDE_PX).ok();
        let surfaces = surfaces(materials, images.par_iter().map(decode).collect());
        let material = |triangle: &[u32; 3]| character.vertices[triangle[0] as usize].material() as u16;
        let triangle_materials: Vec<u16> = character.triangles.iter().map(material).collect();
        let uv = |v: u32| character.vertices[v as usize].uv;
        Self {
            vertex_colors: Vec::new(),
            triangle_contrast: contrast(&surfaces, character.triangles, &triangle_materials, uv),
            flat_materials: surfaces.iter().map(|surface| surface.material.flat).collect(),
            surfaces,
        }
    }

    /// The same in the order of a pack: without vertices, for its triangles and materials. `triangles`, `materials`: the number here of
    /// each one there.
    pub fn reordered(&self, triangles: &[u32], materials: &[u16]) -> Self {
        let surfaces: Vec<Surface> = materials.iter().map(|&m| self.surfaces[usize::from(m)].clone()).collect();
        Self {
            vertex_colors: Vec::new(),
            triangle_contrast: triangles.iter().map(|&t| self.triangle_contrast[t as usize]).collect(),
            flat_materials: surfaces.iter().map(|surface| surface.material.flat).collect(),
            surfaces,
        }
    }

    /// For the simplifier.
    pub fn view(&self) -> crowd_lod::Appearance<'_> {
        crowd_lod::Appearance {
            shown_colors: &self.vertex_colors,
            triangle_contrast: &self.triangle_contrast,
            textures: Some(self),
            flat_materials: &self.flat_materials,
        }
    }
}

impl crowd_lod::ShownColors for ShownTextures {
    fn color(&self, material: u16, uv: [f32; 2], tint: [f32; 3]) -> [f32; 3] {
        self.surfaces[usize::from(material)].at(uv, Vec3::from(tint)).to_array()
    }

    fn differ_in_color_alone(&self, a: u16, b: u16) -> bool {
        let [a, b] = [a, b].map(|m| &self.surfaces[usize::from(m)].material);
        let plain = a.texture.is_none() && b.texture.is_none() && a.base_color[3] == b.base_color[3];
        plain && Material { base_color: b.base_color, ..*a } == *b
    }

    fn is_opaque(&self, material: u16) -> bool {
        self.surfaces[usize::from(material)].material.alpha_cutoff <= 0.0
    }
}

fn contrast(
    surfaces: &[Surface],
    triangles: &[[u32; 3]],
    triangle_materials: &[u16],
    uv: impl Fn(u32) -> [f32; 2] + Sync,
) -> Vec<f32> {
    let of = |(triangle, &material): (&[u32; 3], &u16)| {
        surfaces[usize::from(material)].contrast(triangle.map(|v| Vec2::from(uv(v))))
    };
    triangles.par_iter().zip(triangle_materials).map(of).collect()
}

/// A material with its texture, if it has one that decodes.
#[derive(Debug, Clone)]
struct Surface {
    material: Material,
    texture: Option<Arc<Texture>>,
}

fn surfaces(materials: Vec<Material>, textures: Vec<Option<Texture>>) -> Vec<Surface> {
    let textures: Vec<Option<Arc<Texture>>> = textures.into_iter().map(|texture| texture.map(Arc::new)).collect();
    let with_texture = |material: Material| {
        let texture = material.texture.and_then(|texture| textures[texture as usize].clone());
        Surface { material, texture }
    };
    materials.into_iter().map(with_texture).collect()
}

impl Surface {
    /// The colour shown at a texture coordinate, sRGB. `tint`: the vertex colour, linear.
    fn at(&self, uv: [f32; 2], tint: Vec3) -> Vec3 {
        let texel = match &self.texture {
            Some(texture) => {
                let (wrap_u, wrap_v) = (self.material.wrap_u, self.material.wrap_v);
                let [r, g, b, _] = sample(texture, wrap_u, wrap_v, Vec2::from(uv), STEP_LOD);
                Vec3::new(r, g, b)
            }
            None => Vec3::ONE,
        };
        let [r, g, b, _] = self.material.base_color;
        srgb_from_linear_rgb((texel * Vec3::new(r, g, b) * tint).clamp(Vec3::ZERO, Vec3::ONE).to_array()).into()
    }

    /// RMS change of the colour for a small step, per unit of texture coordinate.
    fn contrast(&self, corners: [Vec2; 3]) -> f32 {
        if self.texture.is_none() {
            return 0.0;
        }
        let mut squares = 0.0;
        for weights in LOOKED_AT {
            let uv = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
            let here = self.at(uv.to_array(), Vec3::ONE);
            for step in [Vec2::new(STEP, 0.0), Vec2::new(0.0, STEP)] {
                squares += (self.at((uv + step).to_array(), Vec3::ONE) - here).length_squared();
            }
        }
        let mean = squares / (2 * LOOKED_AT.len()) as f32;
        if mean.is_finite() { mean.sqrt() / STEP } else { 0.0 }
    }
}
