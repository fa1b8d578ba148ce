//! A raw character as the bake libraries want to see it: borrowed slices and their own small types.

use crowd_anim::{ClipView, Interpolation, Joint, Property, Skeleton, TrackView, Trs};
use crowd_pack::VertexRecord;
use crowd_raster::{Material, Wrap};
use crowd_source::{RawCharacter, RawClip, RawInterpolation, RawMaterial, RawMesh, RawProperty, RawWrap};
use glam::{Mat4, Quat, Vec3};

/// The node tree for `crowd-anim`.
pub fn skeleton_of(raw: &RawCharacter) -> Skeleton {
    Skeleton {
        parents: raw.nodes.iter().map(|node| node.parent).collect(),
        rest: raw
            .nodes
            .iter()
            .map(|node| Trs {
                translation: Vec3::from(node.translation),
                rotation: Quat::from_array(node.rotation),
                scale: Vec3::from(node.scale),
            })
            .collect(),
    }
}

/// The joints for `crowd-anim`.
pub fn joints_of(raw: &RawCharacter) -> Vec<Joint> {
    let joints = raw.joints.iter();
    joints.map(|j| Joint { node: j.node, inverse_bind: Mat4::from_cols_array(&j.inverse_bind) }).collect()
}

/// A clip for `crowd-anim`.
pub fn clip_view(clip: &RawClip) -> ClipView<'_> {
    let tracks = clip.tracks.iter().map(|track| TrackView {
        node: track.node,
        property: match track.property {
            RawProperty::Translation => Property::Translation,
            RawProperty::Rotation => Property::Rotation,
            RawProperty::Scale => Property::Scale,
        },
        interpolation: match track.interpolation {
            RawInterpolation::Step => Interpolation::Step,
            RawInterpolation::Linear => Interpolation::Linear,
            RawInterpolation::CubicSpline => Interpolation::CubicSpline,
        },
        times: &track.times,
        values: &track.values,
    });
    ClipView { name: &clip.name, tracks: tracks.collect() }
}

/// The last key of a clip, seconds.
pub(crate) fn clip_end_s(clip: &RawClip) -> f32 {
    clip.tracks.iter().filter_map(|track| track.times.last().copied()).fold(0.0, f32::max)
}

/// The vertices as the pack will store them, and their fields as a shader will read them: everything measured after this
/// step is measured on these, not on the file's numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QuantizedMesh {
    /// One per vertex of the source; material and class are filled in by the order.
    pub records: Vec<VertexRecord>,
    /// Bind-space positions, metres.
    pub positions: Vec<[f32; 3]>,
    /// Decoded normals.
    pub normals: Vec<[f32; 3]>,
    /// Joints, 0 where the weight is 0, none twice.
    pub joints: Vec<[u16; 4]>,
    /// Decoded weights.
    pub weights: Vec<[f32; 4]>,
}

/// Rounds every vertex to its record.
pub(crate) fn quantize(mesh: &RawMesh) -> QuantizedMesh {
    let mut out = QuantizedMesh { positions: mesh.positions.clone(), ..QuantizedMesh::default() };
    for vertex in 0..mesh.positions.len() {
        let (position, normal, uv) = (mesh.positions[vertex], mesh.normals[vertex], mesh.uvs[vertex]);
        let shape = quantize_vertex(position, normal, uv, mesh.joints[vertex], mesh.weights[vertex]);
        let record = VertexRecord { color: u32::from_le_bytes(mesh.colors[vertex]), ..shape };
        out.normals.push(record.normal());
        out.joints.push(record.joint_indices());
        out.weights.push(record.weights_f32());
        out.records.push(record);
    }
    out
}

/// A white vertex rounded to its record; material and class are left to whoever knows them.
pub(crate) fn quantize_vertex(
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    joints: [u16; 4],
    weights: [f32; 4],
) -> VertexRecord {
    let (joints, weights) = merge_repeated(joints, weights);
    let stored = crowd_pack::quantize_weights(weights);
    let weights = std::array::from_fn(|slot| if stored[slot] == 0 { 0.0 } else { weights[slot] });
    let (joints, weights) = order_by_joint(joints, weights);
    VertexRecord::new(position, normal, uv, [1.0; 4], 0, 0, joints, weights)
}

/// Influences by joint, those without weight last: the vertices on the two sides of a seam then add the same numbers in the
/// same order, and land on the same bits wherever they are posed.
fn order_by_joint(joints: [u16; 4], weights: [f32; 4]) -> ([u16; 4], [f32; 4]) {
    let mut slots = [0, 1, 2, 3];
    slots.sort_by_key(|&slot: &usize| (weights[slot] <= 0.0, joints[slot]));
    let joint = |slot: usize| if weights[slot] > 0.0 { joints[slot] } else { 0 };
    (slots.map(joint), slots.map(|slot| weights[slot]))
}

/// A joint named twice gets the sum of its weights once: glTF allows each joint once a vertex.
fn merge_repeated(joints: [u16; 4], mut weights: [f32; 4]) -> ([u16; 4], [f32; 4]) {
    for later in 1..4 {
        for earlier in 0..later {
            if joints[later] == joints[earlier] && weights[earlier] > 0.0 {
                weights[earlier] += weights[later];
                weights[later] = 0.0;
            }
        }
    }
    (joints, weights)
}

/// A material for `crowd-raster`; its texture is the image's index in the character.
pub(crate) fn raster_material(material: &RawMaterial) -> Material {
    let wrap = |wrap: RawWrap| match wrap {
        RawWrap::Repeat => Wrap::Repeat,
        RawWrap::Clamp => Wrap::Clamp,
        RawWrap::Mirror => Wrap::Mirror,
    };
    Material {
        base_color: material.base_color,
        texture: material.texture.map(|texture| texture.image),
        wrap_u: material.texture.map_or(Wrap::Repeat, |texture| wrap(texture.wrap_u)),
        wrap_v: material.texture.map_or(Wrap::Repeat, |texture| wrap(texture.wrap_v)),
        alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
        double_sided: material.double_sided,
        unlit: material.unlit,
        flat: material.flat_normals,
    }
}

/// Material of each triangle. Parts cover all triangles, as the reader promises.
pub(crate) fn triangle_materials(mesh: &RawMesh) -> Vec<u16> {
    let mut materials = vec![0_u16; mesh.triangles.len()];
    for part in &mesh.parts {
        let start = part.first_triangle as usize;
        materials[start..start + part.triangle_count as usize].fill(part.material as u16);
    }
    materials
}

/// Weight of each frame: clips weigh equally, and frames equally within their clip, so that a long idle does not outvote
/// a short punch.
pub(crate) fn frame_weights(frame_counts: &[u32]) -> Vec<f32> {
    let clips = frame_counts.len() as f32;
    let weights = frame_counts.iter().map(|&frames| (1.0 / (clips * frames as f32), frames));
    weights.flat_map(|(weight, frames)| std::iter::repeat_n(weight, frames as usize)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_weigh_equally() {
        assert_eq!(frame_weights(&[1, 4]), [0.5, 0.125, 0.125, 0.125, 0.125]);
        assert_eq!(frame_weights(&[1]), [1.0]);
    }

    #[test]
    fn a_joint_named_twice_counts_once() {
        let (_, weights) = merge_repeated([3, 5, 3, 0], [0.5, 0.3, 0.2, 0.0]);
        assert_eq!(weights, [0.7, 0.3, 0.0, 0.0]);
    }

    #[test]
    fn two_sides_of_a_seam_list_their_joints_alike() {
        let one = order_by_joint([9, 2, 0, 0], [0.5, 0.5, 0.0, 0.0]);
        let other = order_by_joint([2, 9, 0, 0], [0.5, 0.5, 0.0, 0.0]);
        assert_eq!(one, other);
        assert_eq!(one.0[..2], [2, 9]);
    }

    #[test]
    fn what_is_measured_is_what_is_stored() {
        let mesh = RawMesh {
            positions: vec![[1.0, 2.0, 3.0]],
            normals: vec![[0.6, 0.64, 0.48]],
            uvs: vec![[0.1, 0.9]],
            colors: vec![[1, 128, 255, 0]],
            joints: vec![[7, 9, 2, 4]],
            weights: vec![[0.7, 0.299_999, 0.000_001, 0.0]],
            ..RawMesh::default()
        };
        let quantized = quantize(&mesh);
        let record = quantized.records[0];
        assert_eq!(record.color, u32::from_le_bytes([1, 128, 255, 0]));
        assert_eq!(quantized.weights[0], record.weights_f32());
        assert_eq!(quantized.normals[0], record.normal());
        assert_eq!(quantized.joints[0], [7, 9, 0, 0], "joints without weight are 0");
    }
}
