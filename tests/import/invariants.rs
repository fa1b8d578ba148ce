//! What every loaded character promises (the documentation of `RawCharacter`), as one check that names what is broken.

use std::collections::BTreeSet;

use crowd_source::{RawCharacter, RawInterpolation, RawProperty};

/// The first broken promise, if any.
pub fn broken_promise(character: &RawCharacter) -> Option<String> {
    mesh_promise(character).or_else(|| skeleton_promise(character)).or_else(|| clip_promise(character))
}

/// False for what is no number, too.
fn is_one(value: f32, tolerance: f32) -> bool {
    (value - 1.0).abs() < tolerance
}

fn mesh_promise(character: &RawCharacter) -> Option<String> {
    let mesh = &character.mesh;
    let count = mesh.positions.len();
    let lengths = [mesh.normals.len(), mesh.uvs.len(), mesh.colors.len(), mesh.joints.len(), mesh.weights.len()];
    if lengths != [count; 5] {
        return Some(format!("{count} positions, other attributes {lengths:?}"));
    }
    for v in 0..count {
        if !mesh.positions[v].iter().chain(&mesh.uvs[v]).all(|n| n.is_finite()) {
            return Some(format!("vertex {v} is not finite"));
        }
        let length = mesh.normals[v].iter().map(|n| n * n).sum::<f32>();
        if !is_one(length, 1e-4) {
            return Some(format!("vertex {v}: normal {:?}", mesh.normals[v]));
        }
        let (joints, weights) = (mesh.joints[v], mesh.weights[v]);
        let sum = weights.iter().sum::<f32>();
        if !is_one(sum, 1e-5) || !weights.is_sorted_by(|a, b| a >= b) || weights[3] < 0.0 {
            return Some(format!("vertex {v}: weights {weights:?}"));
        }
        for slot in 0..4 {
            if joints[slot] as usize >= character.joints.len() || (weights[slot] == 0.0 && joints[slot] != 0) {
                return Some(format!("vertex {v}: joints {joints:?} with {weights:?}"));
            }
        }
    }
    let mut used = vec![false; count];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle;
        if a == b || b == c || a == c || triangle.iter().any(|v| *v as usize >= count) {
            return Some(format!("triangle {t}: {triangle:?} of {count} vertices"));
        }
        triangle.iter().for_each(|v| used[*v as usize] = true);
    }
    if let Some(v) = used.iter().position(|u| !u) {
        return Some(format!("vertex {v} is in no triangle"));
    }
    let mut next = 0;
    for part in &mesh.parts {
        if part.first_triangle != next || part.triangle_count == 0 {
            return Some(format!("part `{}` begins at {}, expected {next}", part.name, part.first_triangle));
        }
        if part.material as usize >= character.materials.len() {
            return Some(format!("part `{}`: material {}", part.name, part.material));
        }
        next += part.triangle_count;
    }
    if next as usize != mesh.triangles.len() || next == 0 {
        return Some(format!("parts cover {next} of {} triangles", mesh.triangles.len()));
    }
    let texture_missing =
        |m: &crowd_source::RawMaterial| m.texture.is_some_and(|t| t.image as usize >= character.images.len());
    character.materials.iter().find(|m| texture_missing(m)).map(|m| format!("material `{}`: no such image", m.name))
}

fn skeleton_promise(character: &RawCharacter) -> Option<String> {
    for (n, node) in character.nodes.iter().enumerate() {
        if node.parent.is_some_and(|p| p as usize >= n) {
            return Some(format!("node {n} comes before its parent"));
        }
        let length = node.rotation.iter().map(|r| r * r).sum::<f32>();
        if !is_one(length, 1e-5) || !node.translation.iter().chain(&node.scale).all(|x| x.is_finite()) {
            return Some(format!("node {n}: {node:?}"));
        }
    }
    let mut used = vec![false; character.joints.len()];
    for (joints, weights) in character.mesh.joints.iter().zip(&character.mesh.weights) {
        (0..4).filter(|s| weights[*s] > 0.0).for_each(|s| used[joints[s] as usize] = true);
    }
    for (j, joint) in character.joints.iter().enumerate() {
        if joint.node as usize >= character.nodes.len() || !joint.inverse_bind.iter().all(|x| x.is_finite()) || !used[j]
        {
            return Some(format!("joint {j}: {joint:?}, used: {}", used[j]));
        }
    }
    None
}

fn clip_promise(character: &RawCharacter) -> Option<String> {
    let names: BTreeSet<&str> = character.clips.iter().map(|c| c.name.as_str()).collect();
    if names.len() != character.clips.len() {
        return Some("two clips of one name".to_owned());
    }
    for clip in &character.clips {
        let mut moved = BTreeSet::new();
        for track in &clip.tracks {
            let width = if track.property == RawProperty::Rotation { 4 } else { 3 };
            let per_key = if track.interpolation == RawInterpolation::CubicSpline { 3 } else { 1 };
            let sound = moved.insert((track.node, track.property))
                && (track.node as usize) < character.nodes.len()
                && !track.times.is_empty()
                && track.times.is_sorted_by(|a, b| a < b)
                && track.times.iter().chain(&track.values).all(|x| x.is_finite())
                && track.values.len() == track.times.len() * width * per_key;
            if !sound {
                return Some(format!("clip `{}`: node {} {:?}", clip.name, track.node, track.property));
            }
        }
    }
    None
}

/// Each promise, broken on purpose, is found.
#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn every_broken_promise_is_found() {
    let sound = crate::assets::load("khronos-fox/Fox.glb");
    assert_eq!(broken_promise(&sound), None);
    let breaks: [(&str, fn(&mut RawCharacter)); 14] = [
        ("a normal too many", |c| c.mesh.normals.push([0., 0., 1.])),
        ("a position that is none", |c| c.mesh.positions[7][1] = f32::NAN),
        ("a long normal", |c| c.mesh.normals[7] = [0., 2., 0.]),
        ("weights of two", |c| c.mesh.weights[7] = [1., 1., 0., 0.]),
        ("weights upside down", |c| c.mesh.weights[7] = [0., 0., 0., 1.]),
        ("a joint out of range", |c| c.mesh.joints[7][0] = 999),
        ("a vertex out of range", |c| c.mesh.triangles[7][0] = 99_999),
        ("a vertex twice", |c| c.mesh.triangles[7] = [1, 1, 2]),
        ("a gap in the parts", |c| c.mesh.parts[0].triangle_count -= 1),
        ("a material out of range", |c| c.mesh.parts[0].material = 9),
        ("a child before its parent", |c| c.nodes[1].parent = Some(5)),
        ("a joint without a node", |c| c.joints[0].node = 999),
        ("a clip twice", |c| c.clips[1].name = c.clips[0].name.clone()),
        ("keys out of order", |c| c.clips[0].tracks[0].times[0] = 1e9),
    ];
    for (what, break_it) in breaks {
        let mut broken = sound.clone();
        break_it(&mut broken);
        assert!(broken_promise(&broken).is_some(), "{what} was not found");
    }
}
