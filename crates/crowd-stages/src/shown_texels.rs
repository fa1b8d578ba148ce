//! Which texels of a pack's images its characters show, at full detail: what mip levels are means of.

use crowd_pack::{CharacterRecord, MaterialRecord, PackContents, material_flags};
use crowd_raster::{Coverage, Wrap};

/// Of an image resampled to `side` x `side`.
pub(crate) fn shown_texels(contents: &PackContents, image: u32, side: u32) -> Coverage {
    let mut coverage = Coverage::new(side, side);
    for character in &contents.characters {
        let materials = part(&contents.materials, character.material_offset, character.material_count);
        if materials.iter().any(|material| material.image == image) {
            show(&mut coverage, contents, character, materials, image);
        }
    }
    coverage
}

fn show(
    coverage: &mut Coverage,
    contents: &PackContents,
    character: &CharacterRecord,
    materials: &[MaterialRecord],
    image: u32,
) {
    let vertices = part(&contents.vertices, character.vertex_offset, character.vertex_count);
    for corners in part(&contents.triangles, character.triangle_offset, character.triangle_count) {
        let [first, second, third] = corners.map(|corner| &vertices[corner as usize]);
        let material = materials.get(first.material() as usize).filter(|material| material.image == image);
        let Some(material) = material else { continue };
        if material.alpha_cutoff > 0.0 {
            coverage.read_alpha();
        }
        let wraps = [material_flags::WRAP_U_SHIFT, material_flags::WRAP_V_SHIFT].map(|shift| wrap(material, shift));
        coverage.add([first.uv, second.uv, third.uv], wraps);
    }
}

fn part<T>(all: &[T], offset: u32, count: u32) -> &[T] {
    &all[offset as usize..][..count as usize]
}

fn wrap(material: &MaterialRecord, shift: u32) -> Wrap {
    match (material.flags >> shift) & material_flags::WRAP_MASK {
        1 => Wrap::Clamp,
        2 => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
