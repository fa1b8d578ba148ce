//! What a material has beside its base colour: carried from the source to exports, for whoever lights it better than we do.

use crate::RawTexture;

/// The rest of a material. The default is what a material without any of it is exported as: no metal, rough, dark.
///
/// Textures point into [`crate::RawCharacter::finish_images`] and read the mesh's one set of texture coordinates; those that use others are left
/// out with the warning `material-reduced`.
#[derive(Debug, Clone, PartialEq)]
pub struct RawFinish {
    /// Metalness, 0 to 1; times the texture's blue.
    pub metallic: f32,
    /// Roughness, 0 to 1; times the texture's green.
    pub roughness: f32,
    /// Metalness and roughness.
    pub metallic_roughness: Option<RawTexture>,
    /// Tangent-space normals (tangents as MikkTSpace makes them), and the factor on their x and y.
    pub normal: Option<(RawTexture, f32)>,
    /// Ambient occlusion in red, and its strength, 0 to 1.
    pub occlusion: Option<(RawTexture, f32)>,
    /// Light of its own, linear RGB, 0 to 1; times the texture.
    pub emissive: [f32; 3],
    /// `KHR_materials_emissive_strength`: a factor on it, at least 0.
    pub emissive_strength: f32,
    /// Colour of that light, sRGB.
    pub emissive_texture: Option<RawTexture>,
    /// `KHR_materials_ior`: 0, or at least 1.
    pub ior: Option<f32>,
    /// `KHR_materials_specular`: factor, 0 to 1, and linear colour, at least 0.
    pub specular: Option<(f32, [f32; 3])>,
    /// The same: factor in alpha.
    pub specular_texture: Option<RawTexture>,
    /// The same: colour, sRGB.
    pub specular_color_texture: Option<RawTexture>,
    /// The file says BLEND; what is drawn is a mask.
    pub blend: bool,
    /// The base colour as the file has it, where the material's own differs: light of its own has been added to what is shown.
    pub base: Option<RawBase>,
}

/// A base colour: linear RGBA factor, and a texture in [`crate::RawCharacter::finish_images`].
#[derive(Debug, Clone, PartialEq)]
pub struct RawBase {
    /// Linear RGBA.
    pub color: [f32; 4],
    /// Texture.
    pub texture: Option<RawTexture>,
}

impl Default for RawFinish {
    fn default() -> Self {
        Self {
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness: None,
            normal: None,
            occlusion: None,
            emissive: [0.0; 3],
            emissive_strength: 1.0,
            emissive_texture: None,
            ior: None,
            specular: None,
            specular_texture: None,
            specular_color_texture: None,
            blend: false,
            base: None,
        }
    }
}
