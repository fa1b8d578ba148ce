//! A contact sheet of a document: poses it by its own clips and draws it with a plain z-buffer.

use glam::{Mat4, Quat, Vec2, Vec3};

use crate::glb::{Curve, Document};

/// One picture on the sheet: which clip at which phase, seen from where.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Clip name; empty for the bind pose.
    pub clip: String,
    /// 0..1.
    pub phase: f32,
    /// Degrees round the character from the front, and height of view in degrees.
    pub yaw: f32,
    /// See `yaw`.
    pub pitch: f32,
    /// Height of the picture in metres, and the point in its middle.
    pub span: f32,
    /// See `span`.
    pub middle: Vec3,
}

/// Draws the shots side by side, `size` pixels each; sRGB bytes, width = shots * size.
pub fn sheet(doc: &Document, shots: &[Shot], size: usize) -> Vec<u8> {
    let images: Vec<image::RgbImage> =
        doc.images.iter().filter_map(|png| image::load_from_memory(png).ok()).map(|i| i.to_rgb8()).collect();
    let width = size * shots.len();
    let mut out = vec![0_u8; width * size * 3];
    for (n, shot) in shots.iter().enumerate() {
        let picture = draw(doc, &images, shot, size);
        for y in 0..size {
            let from = y * size * 3;
            let to = (y * width + n * size) * 3;
            out[to..to + size * 3].copy_from_slice(&picture[from..from + size * 3]);
        }
    }
    out
}

fn globals(doc: &Document, shot: &Shot) -> Vec<Mat4> {
    let clip = doc.clips.iter().find(|c| c.name == shot.clip);
    let mut local: Vec<(Vec3, Quat)> = doc.nodes.iter().map(|n| (n.translation, Quat::IDENTITY)).collect();
    if let Some(clip) = clip {
        let x = shot.phase * (clip.times.len() - 1) as f32;
        let i = (x as usize).min(clip.times.len() - 2);
        let t = x - i as f32;
        for (node, curve) in &clip.curves {
            match curve {
                Curve::Rotation(q) => local[*node].1 = q[i].lerp(q[i + 1], t),
                Curve::Translation(p) => local[*node].0 = p[i].lerp(p[i + 1], t),
            }
        }
    }
    let mut out = vec![Mat4::IDENTITY; doc.nodes.len()];
    let child = |i: &usize| doc.nodes.iter().any(|n| n.children.contains(i));
    let mut stack: Vec<(usize, Mat4)> =
        (0..doc.nodes.len()).filter(|i| !child(i)).map(|i| (i, Mat4::IDENTITY)).collect();
    while let Some((i, parent)) = stack.pop() {
        out[i] = parent * Mat4::from_rotation_translation(local[i].1, local[i].0);
        stack.extend(doc.nodes[i].children.iter().map(|&c| (c, out[i])));
    }
    out
}

fn draw(doc: &Document, images: &[image::RgbImage], shot: &Shot, size: usize) -> Vec<u8> {
    let globals = globals(doc, shot);
    let palette: Vec<Mat4> = doc.joints.iter().map(|(n, p)| globals[*n] * Mat4::from_translation(-*p)).collect();
    let view = Quat::from_rotation_x(shot.pitch.to_radians()) * Quat::from_rotation_y(-shot.yaw.to_radians());
    let mut colour = vec![Vec3::new(0.80, 0.84, 0.88); size * size];
    let mut depth = vec![f32::MIN; size * size];
    for (n, node) in doc.nodes.iter().enumerate() {
        let Some(mesh) = node.mesh else { continue };
        for prim in &doc.meshes[mesh].1 {
            let corner = |i: usize| {
                let (p, nn) = (Vec3::from(prim.positions[i]), Vec3::from(prim.normals[i]));
                let m = if node.skinned {
                    (0..4).fold(Mat4::ZERO, |m, k| m + palette[prim.joints[i][k] as usize] * prim.weights[i][k])
                } else {
                    globals[n]
                };
                (view * (m.transform_point3(p) - shot.middle), view * m.transform_vector3(nn), m.transform_vector3(nn))
            };
            let material = &doc.materials[prim.material];
            for t in prim.indices.chunks_exact(3) {
                let c = [0, 1, 2].map(|k| corner(t[k] as usize));
                let s = c.map(|c| Vec2::new(0.5 + c.0.x / shot.span, 0.5 - c.0.y / shot.span) * size as f32);
                let area = (s[1] - s[0]).perp_dot(s[2] - s[0]);
                if area >= 0.0 {
                    continue;
                }
                let low = s[0].min(s[1]).min(s[2]).max(Vec2::ZERO);
                let high = s[0].max(s[1]).max(s[2]).min(Vec2::splat(size as f32 - 1.0));
                for y in low.y as usize..=high.y.max(0.0) as usize {
                    for x in low.x as usize..=high.x.max(0.0) as usize {
                        let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                        let b = [0, 1, 2].map(|k| (s[(k + 1) % 3] - p).perp_dot(s[(k + 2) % 3] - p) / area);
                        if b.iter().any(|&w| w < 0.0) {
                            continue;
                        }
                        let z = b[0] * c[0].0.z + b[1] * c[1].0.z + b[2] * c[2].0.z;
                        if z <= depth[y * size + x] {
                            continue;
                        }
                        depth[y * size + x] = z;
                        let normal = (c[0].2 * b[0] + c[1].2 * b[1] + c[2].2 * b[2]).normalize_or_zero();
                        let sun = normal.dot(Vec3::new(0.45, 0.65, 0.6).normalize()).max(0.0);
                        let mut base = Vec3::from_slice(&material.colour[..3]);
                        if let (Some(i), false) = (material.image, prim.uvs.is_empty()) {
                            let uv = (0..3).map(|k| Vec2::from(prim.uvs[t[k] as usize]) * b[k]).sum::<Vec2>();
                            base *= texel(&images[i], uv);
                        }
                        colour[y * size + x] = base * (0.55 + 0.12 * normal.y + 0.42 * sun);
                    }
                }
            }
        }
    }
    colour.iter().flat_map(|c| c.to_array().map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)).collect()
}

fn texel(image: &image::RgbImage, uv: Vec2) -> Vec3 {
    let (w, h) = image.dimensions();
    let (x, y) = (uv.x * w as f32 - 0.5, uv.y * h as f32 - 0.5);
    let (fx, fy) = (x - libm::floorf(x), y - libm::floorf(y));
    let at = |dx: f32, dy: f32| {
        let px = (libm::floorf(x) + dx).rem_euclid(w as f32) as u32;
        let py = (libm::floorf(y) + dy).rem_euclid(h as f32) as u32;
        Vec3::from(image.get_pixel(px.min(w - 1), py.min(h - 1)).0.map(|b| b as f32 / 255.0))
    };
    at(0.0, 0.0).lerp(at(1.0, 0.0), fx).lerp(at(0.0, 1.0).lerp(at(1.0, 1.0), fx), fy)
}
