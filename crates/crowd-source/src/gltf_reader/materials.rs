//! Materials: base colour, its texture and how its coordinates are made, alpha, sides.

use std::collections::BTreeMap;

use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode, Material};
use gltf::json::texture::{MagFilter, MinFilter, Sampler, Texture, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Root, texture};

use super::document::describe;
use super::finish::{first_use, read_finish};
use super::images::ImageTable;
use crate::character::blend_cutoff;
use crate::names::name_or;
use crate::refusal::{Asset, Warnings};
use crate::{RawFilters, RawFinish, RawMaterial, RawMinFilter, RawTexture, RawWrap, Result};

/// Which texture coordinates a material reads, and the transform to bake into them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TextureUse {
    pub(super) textured: bool,
    pub(super) uv_set: u32,
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
}

impl Default for TextureUse {
    fn default() -> Self {
        Self { textured: false, uv_set: 0, offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] }
    }
}

impl TextureUse {
    /// Of a texture that reads that set, moved by that extension.
    pub(super) fn of(tex_coord: u32, transform: Option<&TextureTransform>) -> Self {
        let used = Self { textured: true, uv_set: tex_coord, ..Self::default() };
        let Some(transform) = transform else { return used };
        Self {
            uv_set: transform.tex_coord.unwrap_or(tex_coord),
            offset: transform.offset.0,
            rotation: transform.rotation.0,
            scale: transform.scale.0,
            ..used
        }
    }

    /// KHR_texture_transform: scale, then turn (counter-clockwise as seen with v down), then shift.
    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        if self.offset == [0.0; 2] && self.rotation == 0.0 && self.scale == [1.0; 2] {
            return [u, v];
        }
        let (u, v) = (u * self.scale[0], v * self.scale[1]);
        let (sin, cos) = libm::sincosf(self.rotation);
        [cos * u + sin * v + self.offset[0], -sin * u + cos * v + self.offset[1]]
    }
}

/// Which texture coordinates each material of the document keeps.
pub(super) fn texture_uses(root: &Root) -> Vec<TextureUse> {
    root.materials.iter().map(kept_use).collect()
}

/// Those of its base colour, or of the first texture it has.
fn kept_use(material: &Material) -> TextureUse {
    match base_color(material).1 {
        Some(info) => texture_use(Some(&info)),
        None => first_use(material).unwrap_or_default(),
    }
}

/// Base colour factor and texture. Of the archived KHR_materials_pbrSpecularGlossiness, the diffuse colour is the base
/// colour; older exports have nothing else.
fn base_color(material: &Material) -> ([f32; 4], Option<texture::Info>) {
    let pbr = &material.pbr_metallic_roughness;
    let old = material.extensions.as_ref().and_then(|e| e.others.get("KHR_materials_pbrSpecularGlossiness"));
    let Some(old) = old.filter(|_| pbr.base_color_texture.is_none()) else {
        return (pbr.base_color_factor.0, pbr.base_color_texture.clone());
    };
    let factor = old.get("diffuseFactor").and_then(|f| serde_json::from_value(f.clone()).ok());
    let info = old.get("diffuseTexture").and_then(|t| serde_json::from_value(t.clone()).ok());
    (factor.unwrap_or(pbr.base_color_factor.0), info)
}

pub(super) fn texture_use(info: Option<&texture::Info>) -> TextureUse {
    let Some(info) = info else { return TextureUse::default() };
    TextureUse::of(info.tex_coord, info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref()))
}

/// The materials that parts use, in the order of their first use.
pub(super) struct MaterialTable<'a, 'b> {
    asset: Asset<'a>,
    root: &'a Root,
    known: BTreeMap<(Option<usize>, bool), u32>,
    pub(super) materials: Vec<RawMaterial>,
    pub(super) images: ImageTable<'a, 'b>,
    /// Those that are carried to exports and not shown.
    pub(super) finish_images: ImageTable<'a, 'b>,
}

impl<'a, 'b> MaterialTable<'a, 'b> {
    pub(super) fn new(
        asset: Asset<'a>,
        root: &'a Root,
        images: ImageTable<'a, 'b>,
        finish_images: ImageTable<'a, 'b>,
    ) -> Self {
        Self { asset, root, known: BTreeMap::new(), materials: Vec::new(), images, finish_images }
    }

    /// The character's index of a material. Parts with and without normals need two materials, as the flat one is
    /// shaded by triangle.
    pub(super) fn index(&mut self, material: Option<usize>, flat: bool, warnings: &mut Warnings) -> Result<u32> {
        if let Some(index) = self.known.get(&(material, flat)) {
            return Ok(*index);
        }
        let mut made = match material {
            None => default_material(),
            Some(index) => {
                let Some(material) = self.root.materials.get(index) else {
                    let problem = format!("material {index}, the file has {}", self.root.materials.len());
                    return Err(self.asset.format("meshes", problem));
                };
                self.read_material(index, material, warnings)?
            }
        };
        made.flat_normals = flat;
        let index = self.materials.len() as u32;
        self.materials.push(made);
        self.known.insert((material, flat), index);
        Ok(index)
    }

    fn read_material(&mut self, index: usize, material: &Material, warnings: &mut Warnings) -> Result<RawMaterial> {
        let place = describe("material", index, material.name.as_ref());
        let (base_color, texture) = base_color(material);
        if base_color.iter().any(|c| !c.is_finite()) {
            return Err(self.asset.format(place, format!("baseColorFactor is not finite: {base_color:?}")));
        }
        let alpha_cutoff = match material.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => None,
            Checked::Valid(AlphaMode::Mask) => Some(material.alpha_cutoff.map_or(0.5, |c| c.0)),
            Checked::Valid(AlphaMode::Blend) => {
                let cutoff = blend_cutoff(base_color[3]);
                let message = format!(
                    "alpha mode BLEND is drawn as MASK with cutoff {cutoff}: pixels are there or not. Use MASK to choose the cutoff yourself"
                );
                warnings.add("alpha-blend-as-mask", &place, 1, message);
                Some(cutoff)
            }
            Checked::Invalid => {
                return Err(self.asset.format(place, "`alphaMode` is none of OPAQUE, MASK, BLEND"));
            }
        };
        let texture = match texture {
            None => None,
            Some(info) => {
                let index = info.index.value();
                Some(read_texture(self.asset, self.root, &mut self.images, (&place, index), warnings)?)
            }
        };
        let (images, kept) = (&mut self.finish_images, kept_use(material));
        let finish = read_finish(self.asset, self.root, images, (&place, material), &kept, warnings);
        Ok(RawMaterial {
            name: name_or(material.name.as_deref(), || format!("material {index}")),
            base_color,
            texture,
            alpha_cutoff,
            double_sided: material.double_sided,
            unlit: material.extensions.as_ref().is_some_and(|e| e.unlit.is_some()),
            flat_normals: false,
            finish,
        })
    }
}

/// Texture `index` of the document, its image put into that table.
pub(super) fn read_texture(
    asset: Asset<'_>,
    root: &Root,
    images: &mut ImageTable<'_, '_>,
    (place, index): (&str, usize),
    warnings: &mut Warnings,
) -> Result<RawTexture> {
    let Some(texture) = root.textures.get(index) else {
        let problem = format!("texture {index}, the file has {}", root.textures.len());
        return Err(asset.format(place, problem));
    };
    let place = describe("texture", index, texture.name.as_ref());
    let image = images.index(&place, image_of(asset, &place, texture)?)?;
    let sampler = match texture.sampler {
        None => None,
        Some(sampler) => Some(root.samplers.get(sampler.value()).ok_or_else(|| {
            let problem = format!("sampler {}, the file has {}", sampler.value(), root.samplers.len());
            asset.format(&place, problem)
        })?),
    };
    let mut wrap = |mode: Option<Checked<WrappingMode>>| match mode {
        None | Some(Checked::Valid(WrappingMode::Repeat)) => RawWrap::Repeat,
        Some(Checked::Valid(WrappingMode::ClampToEdge)) => RawWrap::Clamp,
        Some(Checked::Valid(WrappingMode::MirroredRepeat)) => RawWrap::Mirror,
        Some(Checked::Invalid) => {
            warnings.add("wrap-mode-unknown", &place, 1, "an unknown wrap mode was taken as REPEAT");
            RawWrap::Repeat
        }
    };
    let (wrap_u, wrap_v) = (wrap(sampler.map(|s| s.wrap_s)), wrap(sampler.map(|s| s.wrap_t)));
    let filters = sampler.map(|sampler| filters_of(sampler, &place, warnings)).unwrap_or_default();
    Ok(RawTexture { image, wrap_u, wrap_v, filters })
}

fn filters_of(sampler: &Sampler, place: &str, warnings: &mut Warnings) -> RawFilters {
    let unknown = u64::from(matches!(sampler.mag_filter, Some(Checked::Invalid)))
        + u64::from(matches!(sampler.min_filter, Some(Checked::Invalid)));
    warnings.add("filter-unknown", place, unknown, "an unknown filter was taken as a linear one");
    let min = match sampler.min_filter {
        None | Some(Checked::Invalid | Checked::Valid(MinFilter::LinearMipmapLinear)) => {
            RawMinFilter::LinearMipmapLinear
        }
        Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => RawMinFilter::NearestMipmapNearest,
        Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => RawMinFilter::LinearMipmapNearest,
        Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => RawMinFilter::NearestMipmapLinear,
        Some(Checked::Valid(MinFilter::Nearest)) => RawMinFilter::Nearest,
        Some(Checked::Valid(MinFilter::Linear)) => RawMinFilter::Linear,
    };
    RawFilters { mag_nearest: sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)), min }
}

/// The image behind a texture: the WebP one where there is one, else the plain one.
fn image_of(asset: Asset<'_>, place: &str, texture: &Texture) -> Result<usize> {
    let extension = |name: &str| -> Option<usize> {
        let source = texture.extensions.as_ref()?.others.get(name)?.get("source")?.as_u64()?;
        usize::try_from(source).ok()
    };
    if let Some(webp) = extension("EXT_texture_webp") {
        return Ok(webp);
    }
    // The document types stand in u32::MAX for a texture without an image.
    match texture.source.value() {
        source if source != u32::MAX as usize => Ok(source),
        _ if extension("KHR_texture_basisu").is_some() => Err(asset.unsupported(
            place,
            "a KTX2 image (KHR_texture_basisu)",
            "convert the KTX2 textures to PNG, JPEG or WebP",
        )),
        _ => Err(asset.format(place, "the texture has no image")),
    }
}

/// What glTF draws where a primitive names no material.
pub(crate) fn default_material() -> RawMaterial {
    RawMaterial {
        name: "default".to_owned(),
        base_color: [1.0; 4],
        texture: None,
        alpha_cutoff: None,
        double_sided: false,
        unlit: false,
        flat_normals: false,
        finish: RawFinish::default(),
    }
}
