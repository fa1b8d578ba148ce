//! One character put through one feature each: all must look like the plain one.

use crowd_source::{RawCharacter, RawInterpolation};
use glam::{DMat4, DQuat, DVec3};

use crate::assets::load;

/// Posed at rest: position and texture coordinate of each vertex.
fn posed(character: &RawCharacter) -> Vec<(DVec3, [f64; 2])> {
    let mut world: Vec<DMat4> = Vec::new();
    for node in &character.nodes {
        let local = DMat4::from_scale_rotation_translation(
            DVec3::from_array(node.scale.map(f64::from)),
            DQuat::from_array(node.rotation.map(f64::from)),
            DVec3::from_array(node.translation.map(f64::from)),
        );
        world.push(node.parent.map_or(local, |p| world[p as usize] * local));
    }
    let palette: Vec<DMat4> = character
        .joints
        .iter()
        .map(|j| world[j.node as usize] * DMat4::from_cols_array(&j.inverse_bind.map(f64::from)))
        .collect();
    let mesh = &character.mesh;
    (0..mesh.positions.len())
        .map(|v| {
            let position = DVec3::from_array(mesh.positions[v].map(f64::from));
            let joints = mesh.joints[v].iter().zip(mesh.weights[v]);
            let sum = joints.map(|(j, w)| palette[*j as usize].transform_point3(position) * f64::from(w)).sum();
            (sum, mesh.uvs[v].map(f64::from))
        })
        .collect()
}

/// How far the vertices of `one` are from the nearest of `other` at worst, where texture coordinates count as metres.
fn farthest(one: &[(DVec3, [f64; 2])], other: &[(DVec3, [f64; 2])]) -> f64 {
    let gap = |(p, s): &(DVec3, [f64; 2]), (q, t): &(DVec3, [f64; 2])| {
        // Texture coordinates a whole tile apart show the same.
        let around = |d: f64| (d - d.round()).abs();
        let shift = around(s[0] - t[0]) + around(s[1] - t[1]);
        (*p - *q).length_squared() + shift * shift
    };
    let nearest = |v| other.iter().map(|w| gap(v, w)).fold(f64::INFINITY, f64::min);
    one.iter().map(nearest).fold(0.0, f64::max).sqrt()
}

fn apart(one: &RawCharacter, other: &RawCharacter) -> f64 {
    let (one, other) = (posed(one), posed(other));
    farthest(&one, &other).max(farthest(&other, &one))
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn features_do_not_change_what_is_seen_at_rest() {
    let plain = load("khronos-cesium-man/CesiumMan.glb");
    // Metres; the man is 1.5 m high. Quantised positions have 14 bits of his largest side.
    for (name, allowed) in [
        ("meshopt", 2e-3),
        ("quantized", 2e-3),
        ("nonindexed", 1e-6),
        ("step_cubic_mix", 1e-6),
        ("texture_transform", 1e-4),
    ] {
        let other = load(&format!("nasty/valid/cesium_man_{name}.glb"));
        let apart = apart(&plain, &other);
        assert!(apart <= allowed, "cesium_man_{name}: {apart} m apart, allowed {allowed}");
        assert_eq!(other.mesh.triangles.len(), plain.mesh.triangles.len());
        assert_eq!(other.clips.len(), plain.clips.len());
        assert_eq!(other.joints.len(), plain.joints.len());
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn a_man_with_a_lifted_arm_is_seen_as_different() {
    let plain = load("khronos-cesium-man/CesiumMan.glb");
    let mut other = plain.clone();
    let arm = other.nodes.iter().position(|n| n.name.contains("arm")).expect("the man has arms");
    other.nodes[arm].rotation = [0.1, 0.0, 0.0, 0.995];
    assert!(apart(&plain, &other) > 0.01);
    let mut other = plain.clone();
    other.mesh.uvs.iter_mut().for_each(|uv| uv[0] += 0.25);
    assert!(apart(&plain, &other) > 0.01);
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn the_mixed_file_has_all_three_interpolations() {
    let mixed = load("nasty/valid/cesium_man_step_cubic_mix.glb");
    for kind in [RawInterpolation::Step, RawInterpolation::Linear, RawInterpolation::CubicSpline] {
        assert!(mixed.clips[0].tracks.iter().any(|t| t.interpolation == kind), "{kind:?}");
    }
}
