//! Which joint moves what each sample of a picture shows.

use crate::{Paint, SkinnedMesh};
use crowd_raster::{Batch, Fill, Target, View, draw_many, srgb};
use glam::Vec3;

/// Values that a channel tells apart after rounding to sRGB, so many apart.
const STEPS: u16 = 64;
const STEP: u16 = 4;

/// The joint that moves the nearest triangle most, for each sample of a square picture; 0 where nothing is. Holes that alpha cuts are taken for
/// surface: what is seen through them counts for the joint of what they are in.
pub(crate) fn draw(mesh: &SkinnedMesh, paint: &Paint, positions: &[Vec3], view: &View, side: u32) -> Vec<u16> {
    let corners = mesh.triangles.as_flattened();
    let places: Vec<[f32; 3]> = corners.iter().map(|&v| positions[v as usize].to_array()).collect();
    let normals: Vec<[f32; 3]> = corners.iter().map(|&v| mesh.normals[v as usize]).collect();
    let uvs: Vec<[f32; 2]> = corners.iter().map(|&v| mesh.uvs[v as usize]).collect();
    let colors: Vec<[u8; 4]> = mesh.triangles.iter().flat_map(|&t| [color_of(main_joint(mesh, t)); 3]).collect();
    let vertex_materials: Vec<u16> = mesh.triangle_materials.iter().flat_map(|&m| [m; 3]).collect();
    let triangles: Vec<[u32; 3]> = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut target = Target::new(side, side, [0, 0, 0, 255]);
    let batch = Batch {
        positions: &places,
        normals: &normals,
        uvs: &uvs,
        colors: &colors,
        vertex_materials: &vertex_materials,
        triangles: &triangles,
        materials: &paint.materials,
        textures: &paint.textures,
        fill: Fill::VertexColor,
    };
    draw_many(&mut target, view, &[batch]);
    let step_of = steps();
    target
        .color
        .iter()
        .map(|c| [0, 1].map(|i| step_of[usize::from(c[i])]))
        .map(|[low, high]| low + STEPS * high)
        .collect()
}

/// The joint with most weight over a triangle's corners; the first of equals.
fn main_joint(mesh: &SkinnedMesh, triangle: [u32; 3]) -> u16 {
    let influences =
        || triangle.into_iter().flat_map(|v| mesh.joints[v as usize].into_iter().zip(mesh.weights[v as usize]));
    let weight = |joint: u16| influences().filter(|other| other.0 == joint).map(|other| other.1).sum::<f32>();
    let (mut main, mut most) = (0, 0.0);
    for (joint, _) in influences() {
        let weight = weight(joint);
        if weight > most || (weight == most && joint < main) {
            (main, most) = (joint, weight);
        }
    }
    main
}

/// A joint as a linear colour; those beyond 4,095 begin again.
fn color_of(joint: u16) -> [u8; 4] {
    let channel = |step: u16| (STEP * (step % STEPS)) as u8;
    [channel(joint), channel(joint / STEPS), 0, 255]
}

/// For each byte of sRGB the nearest step.
fn steps() -> Vec<u16> {
    let bytes: Vec<u8> = (0..STEPS).map(|step| srgb::encode(f32::from(STEP * step) / 255.0)).collect();
    let nearest = |byte: u8| (0..STEPS).min_by_key(|&step| bytes[usize::from(step)].abs_diff(byte)).unwrap_or(0);
    (0..=u8::MAX).map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_joint_has_a_colour_of_its_own() {
        let step_of = steps();
        for joint in 0..STEPS * STEPS {
            let shown = color_of(joint).map(|linear| srgb::encode(f32::from(linear) / 255.0));
            let [low, high] = [0, 1].map(|i| step_of[usize::from(shown[i])]);
            assert_eq!(low + STEPS * high, joint);
        }
    }
}
