//! Light that materials give off, added to the colour that is shown: a glowing eye is seen as one by the simplifier, in pictures, and in the
//! player, which all know base colours alone (decision 0072). The file's own base colour stays beside it, for exports.

use crate::units::counted;
use crowd_raster::srgb::{decode_table, encode};
use crowd_raster::{Mip, Texture, Wrap, sample};
use crowd_source::{ImageEncoding, RawBase, RawCharacter, RawImage, RawMaterial, RawTexture, Warning};
use glam::Vec2;
use rayon::prelude::*;

/// Longest side of a texture that is made: what is shown of a crowd's member needs no more.
const SIDE_PX: u32 = 2048;

/// Texels of all textures that are made for one character: four of the largest. Bounds time and memory, however many materials glow.
const MOST_TEXELS: u64 = 4 * (SIDE_PX as u64) * (SIDE_PX as u64);

/// Bounds what strangers' factors come to.
const BRIGHTEST: f32 = 1e9;

/// Adds the light of every material that gives some off to its base colour. Materials without stay as they are, to the bit.
pub(crate) fn show_emission(raw: &mut RawCharacter) {
    let mut made: Vec<(Recipe, u32)> = Vec::new();
    let (mut texels_left, mut unseen) = (MOST_TEXELS, 0);
    for index in 0..raw.materials.len() {
        let material = &raw.materials[index];
        let finish = &material.finish;
        // Unlit materials are their base colour and nothing else (KHR_materials_unlit); what is done is done.
        if material.unlit || finish.base.is_some() {
            continue;
        }
        let light = finish.emissive.map(|channel| channel * finish.emissive_strength);
        if light == [0.0; 3] {
            continue;
        }
        let shown = if material.texture.is_none() && finish.emissive_texture.is_none() {
            let [r, g, b, a] = material.base_color;
            let [r, g, b] = lit([r, g, b], light);
            Some(([r, g, b, a], None))
        } else {
            let recipe = Recipe {
                color: material.base_color,
                texture: material.texture,
                light,
                emissive: finish.emissive_texture,
            };
            let known = made.iter().find(|(known, _)| *known == recipe).map(|(_, image)| *image);
            let needed = texels_of(raw, &recipe);
            if known.is_none() && needed > texels_left {
                unseen += 1;
                continue;
            }
            let image = known.or_else(|| {
                texels_left -= needed;
                add_image(raw, &recipe)
            });
            image.map(|image| {
                made.push((recipe.clone(), image));
                ([1.0, 1.0, 1.0, recipe.color[3]], Some(recipe.texture_of(image)))
            })
        };
        // A texture that does not decode has been warned of; the light is not seen then.
        if let Some((color, texture)) = shown {
            keep_base(raw, index);
            let material: &mut RawMaterial = &mut raw.materials[index];
            (material.base_color, material.texture) = (color, texture);
        }
    }
    if unseen > 0 {
        raw.warnings.push(Warning {
            code: "light-not-shown",
            place: "materials".to_owned(),
            count: unseen,
            message: format!(
                "{} whose light is exported but not shown: textures for it would have more than {MOST_TEXELS} texels in all; let materials share them",
                counted(unseen as usize, "material")
            ),
        });
    }
}

/// Texels of the texture that a recipe makes, at most.
fn texels_of(raw: &RawCharacter, recipe: &Recipe) -> u64 {
    let base = recipe.texture.map(|texture| &raw.images[texture.image as usize]);
    let light = recipe.emissive.map(|texture| &raw.finish_images[texture.image as usize]);
    let side = |of: fn(&RawImage) -> u32| {
        [base, light].into_iter().flatten().map(|image| of(image).min(SIDE_PX)).max().unwrap_or(0)
    };
    u64::from(side(|image| image.width)) * u64::from(side(|image| image.height))
}

/// Colour and light together. What is brighter than white is made darker as a whole, so that a yellow light on white stays yellow.
fn lit(base: [f32; 3], light: [f32; 3]) -> [f32; 3] {
    let sum = [0, 1, 2].map(|c| base[c].clamp(0.0, BRIGHTEST) + light[c].min(BRIGHTEST));
    let most = sum.into_iter().fold(1.0, f32::max);
    sum.map(|channel| channel / most)
}

/// What a shown texture is made of.
#[derive(Debug, Clone, PartialEq)]
struct Recipe {
    color: [f32; 4],
    texture: Option<RawTexture>,
    light: [f32; 3],
    emissive: Option<RawTexture>,
}

impl Recipe {
    /// The texture that it becomes: wrapped as the base colour's is, which the eye knows the surface by.
    fn texture_of(&self, image: u32) -> RawTexture {
        let wraps = self.texture.or(self.emissive).expect("a recipe has a texture");
        RawTexture { image, ..wraps }
    }
}

fn add_image(raw: &mut RawCharacter, recipe: &Recipe) -> Option<u32> {
    let decode = |images: &[RawImage], texture: Option<RawTexture>| match texture {
        None => Some(Texture::default()),
        Some(texture) => crowd_raster::decode_texture(&images[texture.image as usize].bytes, SIDE_PX).ok(),
    };
    let base = decode(&raw.images, recipe.texture)?;
    let emissive = decode(&raw.finish_images, recipe.emissive)?;
    let side = |of: fn(&Mip) -> u32| [&base, &emissive].into_iter().filter_map(|t| t.mips.first()).map(of).max();
    let (width, height) = (side(|mip| mip.width)?, side(|mip| mip.height)?);
    let mut texels = vec![[0_u8; 4]; width as usize * height as usize];
    texels.par_chunks_mut(width as usize).enumerate().for_each(|(row, texels)| {
        for (column, texel) in texels.iter_mut().enumerate() {
            let uv = Vec2::new((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32);
            let shown = texel_at(&base, column, row, uv, [width, height]);
            let light = texel_at(&emissive, column, row, uv, [width, height]);
            let base = [0, 1, 2].map(|c| shown[c] * recipe.color[c]);
            let [r, g, b] = lit(base, [0, 1, 2].map(|c| light[c] * recipe.light[c])).map(encode);
            *texel = [r, g, b, (shown[3] * 255.0 + 0.5) as u8];
        }
    });
    let index = raw.images.len() as u32;
    raw.images.push(RawImage {
        name: String::new(),
        named: false,
        encoding: ImageEncoding::Png,
        width,
        height,
        bytes: crowd_raster::encode_texels_soon(width, height, &texels),
    });
    Some(index)
}

/// Linear RGBA of a texture at a texel of a picture of that size: the very texel where both have one size. White where there is no texture.
fn texel_at(texture: &Texture, column: usize, row: usize, uv: Vec2, size: [u32; 2]) -> [f32; 4] {
    match texture.mips.first() {
        Some(mip) if [mip.width, mip.height] == size => {
            let [r, g, b, a] = mip.texels[row * mip.width as usize + column];
            let linear = decode_table();
            [linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)], f32::from(a) / 255.0]
        }
        _ => sample(texture, Wrap::Clamp, Wrap::Clamp, uv, 0.0),
    }
}

/// Keeps the base colour as the file has it, its image among those of the finishes.
fn keep_base(raw: &mut RawCharacter, index: usize) {
    let RawMaterial { base_color: color, texture, .. } = raw.materials[index];
    let texture = texture.map(|texture| {
        let image = &raw.images[texture.image as usize];
        let known = raw.finish_images.iter().position(|known| known == image);
        let kept = known.unwrap_or_else(|| {
            raw.finish_images.push(image.clone());
            raw.finish_images.len() - 1
        });
        RawTexture { image: kept as u32, ..texture }
    });
    raw.materials[index].finish.base = Some(RawBase { color, texture });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_source::{Limits, RawFilters, RawFinish, RawWrap};

    fn image(texels: &[[u8; 4]]) -> RawImage {
        let bytes = crowd_raster::encode_texels(texels.len() as u32, 1, texels);
        RawImage {
            name: "i".into(),
            named: true,
            encoding: ImageEncoding::Png,
            width: texels.len() as u32,
            height: 1,
            bytes,
        }
    }

    fn character(finish: RawFinish) -> RawCharacter {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/good/straight_tube_should_keep_its_elbow.glb");
        let mut raw = crowd_source::load_character(path.as_ref(), &Limits::default()).expect("a good fixture");
        raw.materials.truncate(1);
        raw.images = vec![image(&[[0, 0, 0, 255], [255, 0, 0, 128]])];
        raw.materials[0].base_color = [1.0, 1.0, 1.0, 0.5];
        raw.materials[0].texture = Some(RawTexture {
            image: 0,
            wrap_u: RawWrap::Clamp,
            wrap_v: RawWrap::Repeat,
            filters: RawFilters::default(),
        });
        raw.materials[0].finish = finish;
        raw
    }

    fn shown_texels(raw: &RawCharacter) -> Vec<[u8; 4]> {
        let texture = raw.materials[0].texture.expect("it has one");
        let decoded = crowd_raster::decode_picture(&raw.images[texture.image as usize].bytes).expect("it decodes");
        decoded.color
    }

    #[test]
    fn a_dark_material_stays_as_it_is() {
        for finish in [
            RawFinish::default(),
            RawFinish { emissive: [1.0; 3], emissive_strength: 0.0, ..RawFinish::default() },
            RawFinish { metallic: 1.0, ..RawFinish::default() },
        ] {
            let mut raw = character(finish);
            let before = raw.clone();
            show_emission(&mut raw);
            assert_eq!(raw, before);
        }
        let mut raw = character(RawFinish { emissive: [1.0; 3], ..RawFinish::default() });
        raw.materials[0].unlit = true;
        let before = raw.clone();
        show_emission(&mut raw);
        assert_eq!(raw, before);
    }

    #[test]
    fn light_is_added_texel_by_texel_and_the_base_colour_kept() {
        let texture =
            RawTexture { image: 0, wrap_u: RawWrap::Repeat, wrap_v: RawWrap::Repeat, filters: RawFilters::default() };
        let finish = RawFinish { emissive: [0.0, 1.0, 1.0], emissive_texture: Some(texture), ..RawFinish::default() };
        let mut raw = character(finish);
        raw.finish_images = vec![image(&[[255, 255, 0, 255], [0, 0, 255, 0]])];
        let (before, original) = (raw.materials[0].clone(), raw.images[0].clone());
        show_emission(&mut raw);
        assert_eq!(shown_texels(&raw), [[0, 255, 0, 255], [255, 0, 255, 128]]);
        let material = &raw.materials[0];
        assert_eq!(material.base_color, [1.0, 1.0, 1.0, 0.5]);
        assert_eq!(material.texture.map(|t| (t.wrap_u, t.wrap_v)), Some((RawWrap::Clamp, RawWrap::Repeat)));
        let base = material.finish.base.as_ref().expect("it is kept");
        assert_eq!(base.color, before.base_color);
        assert_eq!(raw.finish_images[base.texture.expect("it had one").image as usize], original);
        let once = raw.clone();
        show_emission(&mut raw);
        assert_eq!(raw, once, "light is added once");
    }

    #[test]
    fn a_plain_colour_glows_without_a_texture() {
        let mut raw =
            character(RawFinish { emissive: [0.25, 0.5, 1.0], emissive_strength: 2.0, ..RawFinish::default() });
        raw.materials[0].texture = None;
        raw.materials[0].base_color = [0.25, 0.0, 0.5, 1.0];
        show_emission(&mut raw);
        assert_eq!((raw.materials[0].base_color, raw.materials[0].texture), ([0.3, 0.4, 1.0, 1.0], None));
        assert_eq!(raw.images.len(), 1);
    }
}
