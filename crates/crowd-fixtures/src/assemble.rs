//! From clay to file: wedges, weights, images.

use std::collections::BTreeMap;
use std::io::Cursor;

use glam::Vec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::atlas::{Painting, texture_uv};
use crate::glb::{Clip, Document, Material, Node, Primitive};
use crate::human_rig::Joint;
use crate::shape::Shape;

/// Makes one wedge for each distinct (position, texture coordinate) and triangles over them.
///
/// `weigh(position, tag)`: at most four (joint, weight); an empty list makes an unskinned mesh.
pub fn wedges(shape: &Shape, rects: &[[u8; 4]], weigh: &dyn Fn(Vec3, u16) -> Vec<(usize, f32)>) -> Primitive {
    let normals = shape.normals();
    let mut out = Primitive::default();
    let mut known: BTreeMap<(u32, u32, u32), u32> = BTreeMap::new();
    for (face, t) in shape.triangles() {
        let p = t.map(|c| shape.positions[c.position as usize]);
        if (p[1] - p[0]).cross(p[2] - p[0]).length() < 1e-10 {
            continue;
        }
        for c in t {
            let uv = texture_uv(rects, shape.faces[face].chart, c.chart_uv);
            let key = (c.position, uv.x.to_bits(), uv.y.to_bits());
            let next = out.positions.len() as u32;
            let index = *known.entry(key).or_insert(next);
            if index == next {
                let p = shape.positions[c.position as usize];
                out.positions.push(p.to_array());
                out.normals.push(normals[c.position as usize].to_array());
                out.uvs.push(uv.to_array());
                let list = weigh(p, shape.tags[c.position as usize]);
                if !list.is_empty() {
                    let (mut j, mut w) = ([0_u8; 4], [0.0_f32; 4]);
                    for (k, (joint, weight)) in list.iter().enumerate() {
                        j[k] = *joint as u8;
                        w[k] = *weight;
                    }
                    out.joints.push(j);
                    out.weights.push(w);
                }
            }
            out.indices.push(index);
        }
    }
    out
}

/// The painting's base colour as PNG bytes.
pub fn colour_png(p: &Painting) -> Vec<u8> {
    png(&p.colour, p.size, ExtendedColorType::Rgb8)
}

/// The region map as grey PNG bytes: region id times 16, so that people can see it too.
pub fn regions_png(p: &Painting) -> Vec<u8> {
    let grey: Vec<u8> = p.regions.iter().map(|r| r * 16).collect();
    png(&grey, p.size, ExtendedColorType::L8)
}

/// PNG bytes of a square image.
pub fn png(bytes: &[u8], size: u32, kind: ExtendedColorType) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive)
        .write_image(bytes, size, size, kind)
        .expect("memory takes every byte, and the length is size * size texels");
    out.into_inner()
}

/// A whole character: a root with the skeleton below it, and the skinned mesh beside it.
pub fn character(name: &str, joints: &[Joint], body: Primitive, png: Vec<u8>, clips: Vec<Clip>) -> Document {
    let mut nodes = vec![
        Node { name: name.to_string(), children: vec![2], ..Node::default() },
        Node { name: format!("{name}_body"), mesh: Some(0), skinned: true, ..Node::default() },
    ];
    for (i, j) in joints.iter().enumerate() {
        let parent = j.parent.map_or(Vec3::ZERO, |p| joints[p].position);
        let children = (0..joints.len()).filter(|&k| joints[k].parent == Some(i)).map(|k| k + 2).collect();
        nodes.push(Node { name: j.name.clone(), children, translation: j.position - parent, ..Node::default() });
    }
    Document {
        nodes,
        meshes: vec![(format!("{name}_body"), vec![body])],
        joints: joints.iter().enumerate().map(|(i, j)| (i + 2, j.position)).collect(),
        materials: vec![Material { name: "painted".into(), colour: [1.0; 4], image: Some(0), double_sided: false }],
        images: vec![png],
        clips,
    }
}
