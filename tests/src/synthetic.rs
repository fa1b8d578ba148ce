//! A crowd made of numbers alone: swaying barrels with a checkered texture, each with a whole collapse order.
//!
//! No bake is needed, so that the runtime can be tested without it. The collapses are valid but not clever.

use crowd_pack::{
    CharacterRecord, ClipRecord, JointStorage, LevelRecord, LevelSetRecord, LodRecord, MaterialRecord, NONE,
    VertexRecord, encode_normal, material_flags, store_frame, stored_frames,
};
use crowd_stages::{CrowdData, FrameConfig, FrameView, ImpostorPoses, Impostors, InstanceRecord, TextureLayer, Weight};
use glam::{Mat4, Vec3};

/// Joints of every barrel: base, middle, top.
const JOINTS: usize = 3;
/// Frames of a clip; the last shows the first pose again.
const FRAMES: u32 = 9;
/// Levels of more vertices than this have 32-bit indices.
const WIDE_FROM: u32 = 300;
/// Side of the texture layers, texels.
const LAYER_SIDE: u32 = 64;

/// A barrel's measures.
struct Barrel {
    segments: u32,
    rings: u32,
    height_m: f32,
    radius_m: f32,
    material: MaterialRecord,
    /// Levels come in steps of this many vertices, as where companions go together.
    level_step: u32,
}

/// Three barrels of 45, 153 and 561 vertices, two clips each, one material each: textured, double-sided with holes, flat.
pub fn crowd() -> CrowdData {
    let material = |image, flags, alpha_cutoff| MaterialRecord {
        base_color: [0.9, 0.8, 0.7, 1.0],
        image,
        flags,
        alpha_cutoff,
        reserved: 0,
    };
    let barrels = [
        Barrel {
            segments: 8,
            rings: 5,
            height_m: 1.2,
            radius_m: 0.3,
            material: material(NONE, material_flags::FLAT, 0.0),
            level_step: 1,
        },
        Barrel { segments: 16, rings: 9, height_m: 1.7, radius_m: 0.35, material: material(0, 0, 0.0), level_step: 2 },
        Barrel {
            segments: 32,
            rings: 17,
            height_m: 2.0,
            radius_m: 0.4,
            material: material(1, material_flags::DOUBLE_SIDED | (2 << material_flags::WRAP_U_SHIFT), 0.5),
            level_step: 3,
        },
    ];
    let mut data = CrowdData { layers: vec![checker(255), checker(0)], layer_side: LAYER_SIDE, ..Default::default() };
    for barrel in &barrels {
        add_barrel(&mut data, barrel);
    }
    data.impostors = Some(plain_impostors(barrels.len()));
    data
}

/// Grey pictures: for stages that ask whether there are any.
fn plain_impostors(characters: usize) -> Impostors {
    let (color, normal) = (vec![[150, 150, 150, 255]; 256], vec![[128, 128, 255, 255]; 256]);
    let poses = ImpostorPoses { pose_count: 1, clip_count: 2, color, normal };
    Impostors { tile_px: 8, azimuth_count: 2, elevation_count: 1, characters: vec![poses; characters] }
}

/// Instances on a disc, the same for the same count: place, yaw, size, character, clip and phase from a hash of the number.
/// Every other one fades between two clips.
pub fn instances(data: &CrowdData, count: u32) -> Vec<InstanceRecord> {
    let radius = (count as f32).sqrt() * 0.9;
    let place = |i: u32| {
        let unit = |salt: u32| hash(i.wrapping_mul(8).wrapping_add(salt)) as f32 / u32::MAX as f32;
        let character = hash(i.wrapping_mul(8).wrapping_add(5)) % data.characters.len() as u32;
        let record = &data.characters[character as usize];
        let distance = unit(0).sqrt() * radius;
        let (s, c) = libm::sincosf(unit(1) * std::f32::consts::TAU);
        InstanceRecord {
            position: [distance * c, 0.0, distance * s],
            yaw_rad: (unit(2) - 0.5) * std::f32::consts::TAU,
            scale: 0.7 + 0.6 * unit(3),
            character,
            clip: record.clip_offset + hash(i.wrapping_mul(8).wrapping_add(6)) % record.clip_count,
            phase_s: unit(4) * 2.0,
            leaving_clip: record.clip_offset + hash(i.wrapping_mul(8).wrapping_add(7)) % record.clip_count,
            leaving_phase_s: unit(1) * 2.0,
            leaving_share: (unit(7) * 2.0 - 1.0).max(0.0),
            held_s: 0.0,
        }
    };
    (0..count).map(place).collect()
}

/// A camera that sees about half of [`instances`], with the budget given.
pub fn config(count: u32, budget: u32, weight: Weight) -> FrameConfig {
    let radius = (count as f32).sqrt() * 0.9 + 2.0;
    let eye = Vec3::new(radius * 0.3, 2.5, radius * 0.8);
    let mut config = FrameConfig::from_camera(&view(eye, Vec3::new(0.0, 0.5, 0.0), budget, weight, 360));
    config.instance_count = count;
    config
}

/// A 16:9 view of that height.
pub fn view(eye: Vec3, target: Vec3, budget: u32, weight: Weight, height_px: u32) -> FrameView {
    let fov_y_rad = 0.9;
    let view = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y);
    let projection = glam::camera::rh::proj::directx::perspective(fov_y_rad, 16.0 / 9.0, 0.1, 1000.0);
    FrameView {
        clip_from_world: projection * view,
        eye,
        fov_y_rad,
        viewport_height_px: height_px as f32,
        time_s: 1.3,
        budget,
        alpha: 3.0,
        weight,
    }
}

/// A well-mixed number.
pub fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

fn checker(dark_alpha: u8) -> TextureLayer {
    let image = image::RgbaImage::from_fn(LAYER_SIDE, LAYER_SIDE, |x, y| {
        let is_dark = (x / 8 + y / 8) % 2 == 0;
        image::Rgba(if is_dark { [60, 40, 120, dark_alpha] } else { [230, (x * 4) as u8, (y * 4) as u8, 255] })
    });
    TextureLayer::from_image(image, LAYER_SIDE)
}

fn add_barrel(data: &mut CrowdData, barrel: &Barrel) {
    let (vertices, triangles) = barrel_mesh(barrel);
    let order = collapse_all(&triangles, &vertices);
    // All storages stand side by side.
    let storage = JointStorage::ALL[data.characters.len() % 3];
    let mut character = CharacterRecord {
        joint_storage: storage.code(),
        vertex_offset: data.vertices.len() as u32,
        vertex_count: vertices.len() as u32,
        triangle_offset: data.triangles.len() as u32,
        triangle_count: order.triangles.len() as u32,
        lod_offset: data.lods.len() as u32,
        min_vertex_count: order.min_vertex_count,
        min_triangle_count: order.triangle_counts[order.min_vertex_count as usize],
        joint_count: JOINTS as u32,
        clip_offset: data.clips.len() as u32,
        clip_count: 2,
        material_offset: data.materials.len() as u32,
        material_count: 1,
        height_m: barrel.height_m,
        ..Default::default()
    };
    let vertices: Vec<VertexRecord> = order.sources.iter().map(|source| vertices[*source as usize]).collect();
    for bend_rad in [0.5, 1.1] {
        let clip = add_clip(data, storage, barrel, &vertices, bend_rad);
        data.clips.push(clip);
    }
    for k in 0..=character.vertex_count {
        let above = k.max(order.min_vertex_count) - order.min_vertex_count;
        let whole_steps = above - above % barrel.level_step;
        let is_full = k == character.vertex_count;
        let vertex_count = if is_full { k } else { order.min_vertex_count + whole_steps };
        let triangle_count = order.triangle_counts[vertex_count as usize];
        data.lods.push(LodRecord { vertex_count, triangle_count });
    }
    let reach = barrel.height_m + barrel.radius_m;
    character.sphere = [0.0, reach * 0.5, 0.0, reach];
    character.box_min = [-reach; 3];
    character.box_max = [reach; 3];
    data.vertices.extend(vertices);
    data.triangles.extend(order.triangles);
    data.collapse_map.extend(order.collapse_map);
    data.materials.push(barrel.material);
    data.characters.push(character);
    add_tables(data, &character);
}

/// Quantised levels in steps of about an eighth, their triangles in another order than that of the collapses, beginning at
/// any corner. The third barrel's finer levels have wide indices, as those of characters with more vertices do.
fn add_tables(data: &mut CrowdData, character: &CharacterRecord) {
    let mut wanted = character.vertex_count;
    let mut counts = vec![character.vertex_count];
    while wanted > character.min_vertex_count {
        wanted = (wanted - 1 - wanted / 8).max(character.min_vertex_count);
        counts.push(data.lods[(character.lod_offset + wanted) as usize].vertex_count);
    }
    counts.reverse();
    counts.dedup();
    data.level_sets.push(LevelSetRecord {
        level_offset: data.levels.len() as u32,
        quantized_count: counts.len() as u32,
        ..Default::default()
    });
    for vertex_count in counts {
        let LodRecord { triangle_count, .. } = data.lods[(character.lod_offset + vertex_count) as usize];
        let choice = crowd_stages::LodChoice { vertex_count, triangle_count };
        let mut triangles = crowd_stages::cpu::reform_level(data, character, choice);
        triangles.sort_by_key(|t| hash(t[0] ^ (t[1] << 10) ^ (t[2] << 20)));
        let turned = triangles.iter().map(|&[a, b, c]| match hash(a ^ b ^ c) % 3 {
            0 => [a, b, c],
            1 => [b, c, a],
            _ => [c, a, b],
        });
        let corners: Vec<u32> = turned.flatten().collect();
        let is_wide = vertex_count > WIDE_FROM;
        data.levels.push(LevelRecord {
            vertex_count,
            triangle_count,
            index_offset: if is_wide { data.indices_32.len() } else { data.indices_16.len() } as u32,
            index_bytes: if is_wide { 4 } else { 2 },
            refit_vertex_offset: NONE,
            bound_m: 0.5 / vertex_count as f32 - 0.5 / character.vertex_count as f32,
        });
        match is_wide {
            true => data.indices_32.extend(corners),
            false => data.indices_16.extend(corners.into_iter().map(|corner| corner as u16)),
        }
    }
}

/// A lathed barrel, closed to a small hole at both ends, with a seam of doubled vertices at the back.
fn barrel_mesh(barrel: &Barrel) -> (Vec<VertexRecord>, Vec<[u32; 3]>) {
    let columns = barrel.segments + 1;
    let mut vertices = Vec::new();
    for ring in 0..barrel.rings {
        let up = ring as f32 / (barrel.rings - 1) as f32;
        let bulge = libm::sinf((up * 0.96 + 0.02) * std::f32::consts::PI).sqrt();
        for column in 0..columns {
            let around = column as f32 / barrel.segments as f32;
            let (s, c) = libm::sincosf(around * std::f32::consts::TAU);
            let out = Vec3::new(-s, (up - 0.5) * 1.5, -c);
            vertices.push(VertexRecord {
                position: [-s * bulge * barrel.radius_m, up * barrel.height_m, -c * bulge * barrel.radius_m],
                normal_oct: encode_normal(out.normalize().to_array()),
                uv: [around * 2.0, 1.0 - up],
                color: 0xffff_ffff,
                material_class: 0,
                joints: [u32::from(up >= 0.5) | ((1 + u32::from(up >= 0.5)) << 16), 0],
                weights: blend_weights(up),
            });
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..barrel.rings - 1 {
        for column in 0..barrel.segments {
            let v = ring * columns + column;
            triangles.push([v, v + columns, v + 1]);
            triangles.push([v + 1, v + columns, v + columns + 1]);
        }
    }
    (vertices, triangles)
}

/// Weights of the two joints around a height: the first fades into the second.
fn blend_weights(up: f32) -> [u32; 2] {
    let within = (up * 2.0).fract();
    let second = if up >= 1.0 { 65_535 } else { (within * 65_535.0) as u32 };
    [(65_535 - second) | (second << 16), 0]
}

/// Texels of a swaying clip, and its record with a sphere that holds every vertex of every frame.
fn add_clip(
    data: &mut CrowdData,
    storage: JointStorage,
    barrel: &Barrel,
    vertices: &[VertexRecord],
    bend_rad: f32,
) -> ClipRecord {
    let texel_offset = data.animation.len() as u32;
    let mut radius = 0.0f32;
    let center = Vec3::new(0.0, barrel.height_m * 0.5, 0.0);
    for frame in 0..FRAMES {
        let turn = (frame % (FRAMES - 1)) as f32 / (FRAMES - 1) as f32 * std::f32::consts::TAU;
        let bend = Mat4::from_rotation_x(libm::sinf(turn) * bend_rad) * Mat4::from_rotation_y(libm::cosf(turn) * 0.3);
        let about = |height: f32, m: Mat4| {
            let pivot = Vec3::new(0.0, height * barrel.height_m, 0.0);
            Mat4::from_translation(pivot) * m * Mat4::from_translation(-pivot)
        };
        let middle = about(0.3, bend);
        let joints = [Mat4::IDENTITY, middle, middle * about(0.7, bend)];
        let first = data.animation.len();
        let rows = |m: Mat4| m.transpose().to_cols_array_2d();
        let exact = joints.map(|joint| [rows(joint)[0], rows(joint)[1], rows(joint)[2]]);
        store_frame(storage, &exact, &mut data.animation);
        let joints: Vec<Mat4> = stored_frames(storage, &data.animation[first..], JOINTS as u32)
            .into_iter()
            .map(|[x, y, z]| Mat4::from_cols_array_2d(&[x, y, z, [0.0, 0.0, 0.0, 1.0]]).transpose())
            .collect();
        for vertex in vertices {
            let position = Vec3::from_array(vertex.position);
            let joint = (vertex.joints[0] & 0xffff) as usize;
            for m in &joints[joint..joint + 2] {
                radius = radius.max(m.transform_point3(position).distance(center));
            }
        }
    }
    ClipRecord {
        texel_offset,
        frame_count: FRAMES,
        duration_s: 1.25 + bend_rad,
        sphere: center.extend(radius).to_array(),
        ..Default::default()
    }
}

struct Order {
    /// Source vertex of each vertex of the order.
    sources: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    collapse_map: Vec<u32>,
    /// Triangles left with that many vertices, for each count from the coarsest on.
    triangle_counts: Vec<u32>,
    min_vertex_count: u32,
}

/// Collapses the shortest edge, one after the other, until a dozen vertices are left.
fn collapse_all(triangles: &[[u32; 3]], vertices: &[VertexRecord]) -> Order {
    let vertex_count = vertices.len();
    let place = |v: u32| Vec3::from_array(vertices[v as usize].position);
    let mut live: Vec<(usize, [u32; 3])> = triangles.iter().copied().enumerate().collect();
    let mut waiting: Vec<u32> = (0..vertex_count as u32).collect();
    let mut removed: Vec<(u32, u32)> = Vec::new();
    let mut removed_triangles: Vec<usize> = Vec::new();
    let mut counts = vec![live.len() as u32];
    while waiting.len() > 12 && live.len() > 8 {
        let edges = live.iter().flat_map(|(_, t)| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
        let ordered = edges.map(|(a, b)| (place(a).distance_squared(place(b)), a.min(b), a.max(b)));
        let shorter = |a: &(f32, u32, u32), b: &(f32, u32, u32)| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2)));
        let (_, target, gone) = ordered.min_by(shorter).expect("some triangles are left");
        waiting.retain(|v| *v != gone);
        removed.push((gone, target));
        for (source, triangle) in &mut live {
            *triangle = triangle.map(|v| if v == gone { target } else { v });
            if has_double(triangle) {
                removed_triangles.push(*source);
            }
        }
        live.retain(|(_, triangle)| !has_double(triangle));
        counts.push(live.len() as u32);
    }

    let mut sources = waiting.clone();
    sources.extend(removed.iter().rev().map(|(v, _)| *v));
    let mut places = vec![0; vertex_count];
    for (place, source) in sources.iter().enumerate() {
        places[*source as usize] = place as u32;
    }
    let mut collapse_map: Vec<u32> = (0..vertex_count as u32).collect();
    for (v, target) in &removed {
        collapse_map[places[*v as usize] as usize] = places[*target as usize];
    }
    let kept = live.iter().map(|(source, _)| *source);
    let order: Vec<usize> = kept.chain(removed_triangles.iter().rev().copied()).collect();
    let renamed = order.iter().map(|source| triangles[*source].map(|v| places[v as usize])).collect();
    let mut triangle_counts = vec![live.len() as u32; waiting.len()];
    triangle_counts.extend(counts.iter().rev());
    Order { sources, triangles: renamed, collapse_map, triangle_counts, min_vertex_count: waiting.len() as u32 }
}

fn has_double(t: &[u32; 3]) -> bool {
    t[0] == t[1] || t[1] == t[2] || t[2] == t[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_a_mesh_of_its_own_vertices() {
        let data = crowd();
        for character in &data.characters {
            for k in character.min_vertex_count..=character.vertex_count {
                let level = data.lods[(character.lod_offset + k) as usize];
                let choice =
                    crowd_stages::LodChoice { vertex_count: level.vertex_count, triangle_count: level.triangle_count };
                let triangles = crowd_stages::cpu::reform_level(&data, character, choice);
                assert!(level.vertex_count <= k && level.triangle_count > 0);
                assert!(triangles.iter().all(|t| !has_double(t) && t.iter().all(|v| *v < level.vertex_count)), "{k}");
            }
        }
    }
}
