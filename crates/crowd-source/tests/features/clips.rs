//! Animations: interpolations, checks on keys, names, what is left out.

use crowd_source::{RawInterpolation, RawProperty};
use serde_json::{Value, json};

use crate::builder::*;

/// A triangle whose node has one curve.
fn animated(path: &str, interpolation: &str, times: &[f32], shape: &str, values: &[f32]) -> Doc {
    let mut doc = Doc::triangle();
    let animation = animation(&mut doc, path, interpolation, times, shape, values);
    doc.push("animations", animation);
    doc
}

fn animation(doc: &mut Doc, path: &str, interpolation: &str, times: &[f32], shape: &str, values: &[f32]) -> Value {
    let input = doc.floats("SCALAR", times);
    let output = doc.floats(shape, values);
    json!({
        "name": "walk",
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
    })
}

#[test]
fn the_three_interpolations_come_through() {
    let one = animated("translation", "STEP", &[0., 2.], "VEC3", &[1., 2., 3., 4., 5., 6.]).load();
    let track = &one.clips[0].tracks[0];
    assert_eq!((track.property, track.interpolation), (RawProperty::Translation, RawInterpolation::Step));
    assert_eq!((&track.times[..], track.values.len()), (&[0f32, 2.][..], 6));

    let spline: Vec<f32> = (0..18).map(|n| n as f32).collect();
    let two = animated("scale", "CUBICSPLINE", &[0., 1.], "VEC3", &spline).load();
    assert_eq!(two.clips[0].tracks[0].values, spline);
    assert_eq!(two.clips[0].tracks[0].interpolation, RawInterpolation::CubicSpline);

    let three = animated("rotation", "LINEAR", &[0., 1.], "VEC4", &[0., 0., 0., 2., 0., 0., 0., 0.]).load();
    assert_eq!(three.clips[0].tracks[0].values, [0., 0., 0., 1., 0., 0., 0., 1.]);
    assert_eq!(warning(&three, "rotation-keys-repaired").map(|w| w.count), Some(1));
}

#[test]
fn only_the_values_of_rotation_splines_are_made_unit() {
    let spline = [7., 0., 0., 0., 0., 0., 3., 0., 9., 0., 0., 0.];
    let clip = animated("rotation", "CUBICSPLINE", &[0.5], "VEC4", &spline).load().clips.remove(0);
    assert_eq!(clip.tracks[0].values, [7., 0., 0., 0., 0., 0., 1., 0., 9., 0., 0., 0.]);
}

#[test]
fn rotations_in_16_bits_are_normalised_numbers() {
    let mut doc = animated("rotation", "LINEAR", &[0.], "VEC4", &[0.; 4]);
    let output = doc.accessor(I16, "VEC4", 1, bytemuck::cast_slice(&[0i16, 0, -32768, 0]), true);
    doc.json["animations"][0]["samplers"][0]["output"] = json!(output);
    assert_eq!(doc.load().clips[0].tracks[0].values, [0., 0., -1., 0.]);
}

#[test]
fn times_that_do_not_increase_are_refused() {
    for (times, words) in
        [([0., 1., 1.], "key 2 is at 1 s, key 1 before it at 1 s"), ([0., f32::INFINITY, 2.], "key 1 is at inf s")]
    {
        let refusal = animated("scale", "LINEAR", &times, "VEC3", &[1.; 9]).refusal();
        assert!(refusal.contains("animation 0 `walk` channel 0: input") && refusal.contains(words), "{refusal}");
    }
}

#[test]
fn values_must_match_the_keys() {
    let refusal = animated("scale", "CUBICSPLINE", &[0., 1.], "VEC3", &[1.; 6]).refusal();
    assert!(refusal.contains("2 values for 2 keys, expected 3 a key"), "{refusal}");
}

#[test]
fn clip_names_are_unique_and_made_up_where_missing() {
    let mut doc = Doc::triangle();
    for name in [json!("walk"), json!("walk"), json!(""), json!("walk")] {
        let mut animation = animation(&mut doc, "scale", "LINEAR", &[0.], "VEC3", &[1.; 3]);
        animation["name"] = name;
        doc.push("animations", animation);
    }
    let character = doc.load();
    let names: Vec<&str> = character.clips.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["walk", "walk (2)", "clip 2", "walk (3)"]);
    let renamed: Vec<_> = character.warnings.iter().filter(|w| w.code == "clip-renamed").collect();
    assert_eq!(renamed.len(), 3);
    assert!(renamed[0].message.contains("`walk (2)`") && renamed[0].message.contains("another clip has its name"));
}

#[test]
fn curves_of_other_things_are_left_out() {
    let mut doc = animated("scale", "LINEAR", &[0.], "VEC3", &[1.; 3]);
    let idle = doc.scene_node(json!({"name": "camera"}));
    doc.json["animations"][0]["channels"] = json!([
        {"sampler": 0, "target": {"node": 0, "path": "weights"}},
        {"sampler": 0, "target": {"path": "translation"}},
        {"sampler": 0, "target": {"node": 0, "path": "pointer"}},
        {"sampler": 0, "target": {"node": idle, "path": "scale"}},
        {"sampler": 0, "target": {"node": 0, "path": "scale"}},
        {"sampler": 0, "target": {"node": 0, "path": "scale"}},
    ]);
    let character = doc.load();
    assert_eq!(character.clips[0].tracks.len(), 1);
    let spare: Vec<u32> = character.clips[0].spare_tracks.iter().map(|track| track.node).collect();
    assert_eq!(character.nodes[spare[0] as usize].name, "camera");
    assert_eq!(spare.len(), 1);
    for code in ["morph-curves-ignored", "unknown-curves-ignored", "double-curves-ignored"] {
        assert_eq!(warning(&character, code).map(|w| w.count), Some(1), "{code}");
    }
    doc.json["animations"][0]["channels"] = json!([{"sampler": 0, "target": {"node": idle, "path": "scale"}}]);
    let character = doc.load();
    assert!(character.clips.is_empty());
    assert!(warning(&character, "clip-without-tracks").is_some());
}
