//! What materials have beside their base colour, from the source into the pack.

use crate::assemble::{encoding_code, name_image, sampler_code};
use crowd_pack::{Finish, FinishBase, FinishTexture, PackContents};
use crowd_source::{RawFinish, RawImage, RawTexture};

/// The finish of a material as the pack has it, its images added.
pub(crate) fn finish_of(contents: &mut PackContents, raw: &RawFinish, images: &[RawImage]) -> Finish {
    let mut texture = |texture: RawTexture, weight: f32| {
        let image = &images[texture.image as usize];
        let encoding = encoding_code(image.encoding);
        let index = contents.add_finish_image(&image.bytes, image.width, image.height, encoding);
        name_image(&mut contents.finishes.finish_image_names, index, image);
        FinishTexture { image: index, sampler: sampler_code(texture), weight }
    };
    Finish {
        metallic: raw.metallic,
        roughness: raw.roughness,
        metallic_roughness: raw.metallic_roughness.map(|t| texture(t, 1.0)),
        normal: raw.normal.map(|(t, scale)| texture(t, scale)),
        occlusion: raw.occlusion.map(|(t, strength)| texture(t, strength)),
        emissive: raw.emissive,
        emissive_strength: raw.emissive_strength,
        emissive_texture: raw.emissive_texture.map(|t| texture(t, 1.0)),
        ior: raw.ior,
        specular: raw.specular.map(|(factor, [r, g, b])| [factor, r, g, b]),
        specular_texture: raw.specular_texture.map(|t| texture(t, 1.0)),
        specular_color_texture: raw.specular_color_texture.map(|t| texture(t, 1.0)),
        blend: raw.blend,
        base: raw
            .base
            .as_ref()
            .map(|base| FinishBase { color: base.color, texture: base.texture.map(|t| texture(t, 1.0)) }),
    }
}
