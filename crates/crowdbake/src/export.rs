//! A level of a character as binary glTF: mesh, skin over the original node tree, original curves, materials, textures.

use crate::appearance::ShownTextures;
use crate::export_materials::{Textures, material_json, used_extensions};
use crate::gather_primitives::{Primitive, gather_primitives};
use crate::glb::GlbBuffer;
use crate::ordered_mesh::OrderedMesh;
use crate::unpack::Unpacked;
use crowd_lod::{Level, LodPoses, RefitOptions};
use crowd_pack::{LevelRecord, LodRecord, ManifestClip, ManifestTrack, NONE, VertexRecord, material_flags};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// The bytes of a `.glb` with that level of the character, and what it has: a file has no vertices that no triangle uses.
pub fn export_level(character: &Unpacked<'_>, level: LodRecord) -> (Vec<u8>, LodRecord) {
    export_mesh(character, character.vertices, &character.level_triangles(level))
}

/// The bytes of a `.glb` with that level, its vertices moved to where they lie closest to full detail over all frames; and what it then has.
pub fn export_refitted(character: &Unpacked<'_>, level: LodRecord) -> (Vec<u8>, LodRecord) {
    let mesh = OrderedMesh::of_pack(character).with_textures(ShownTextures::of_pack(character));
    let palettes: Vec<_> = (0..character.clips.len()).flat_map(|clip| character.palettes(clip)).collect();
    let frame_counts: Vec<u32> = character.clips.iter().map(|clip| clip.frame_count).collect();
    let frame_weights = crate::views::frame_weights(&frame_counts);
    let poses = LodPoses { palettes: &palettes, joint_count: character.joint_count(), frame_weights: &frame_weights };
    let counts = Level { vertex_count: level.vertex_count, triangle_count: level.triangle_count, error_m: 0.0 };
    let refitted = crowd_lod::refit(&mesh.mesh(), &poses, &mesh.order, &counts, &RefitOptions::default());
    export_mesh(character, &mesh.refit_records(&refitted), &refitted.triangles)
}

/// The bytes of a `.glb` with a level as the pack stores it: its table, and its own vertices where it has some; and what it has.
pub fn export_stored(character: &Unpacked<'_>, level: &LevelRecord) -> (Vec<u8>, LodRecord) {
    export_mesh(character, character.level_vertices(level), &character.table_triangles(level))
}

/// `vertices`: those that `triangles` index. With what the file has.
fn export_mesh(character: &Unpacked<'_>, vertices: &[VertexRecord], triangles: &[[u32; 3]]) -> (Vec<u8>, LodRecord) {
    let mut buffer = GlbBuffer::default();
    let vertex_materials: Vec<u32> = vertices.iter().map(VertexRecord::material).collect();
    let primitives = gather_primitives(triangles, &vertex_materials);
    let used: Vec<u32> = primitives.iter().map(|primitive| primitive.material).collect();
    let vertex_count = primitives.iter().map(|primitive| primitive.vertices.len() as u32).sum();
    let level = LodRecord { vertex_count, triangle_count: triangles.len() as u32 };
    let mut document = Map::new();

    let mut textures = Textures::default();
    let materials: Vec<Value> = used.iter().map(|&m| material_json(character, m, &mut textures)).collect();
    let extensions = used_extensions(character, &materials, &textures);
    let skinned = needs_skin(character);
    let meshes: Vec<Value> = primitives
        .iter()
        .enumerate()
        .map(|(index, primitive)| primitive_json(character, vertices, primitive, index, skinned, &mut buffer))
        .collect();
    document.insert("meshes".into(), json!([{ "name": character.manifest.name, "primitives": meshes }]));
    document.insert("materials".into(), Value::Array(materials));

    add_nodes(character, skinned, &mut document, &mut buffer);
    let animations = animations_json(character, &mut buffer);
    if !animations.is_empty() {
        document.insert("animations".into(), Value::Array(animations));
    }
    textures.add_to(character, &mut document, &mut buffer);
    document.extend(extensions);
    document.insert("asset".into(), asset_json(character, level));
    (buffer.finish(Value::Object(document)), level)
}

/// Version and generator, what the source says of its makers, and which level this is.
fn asset_json(character: &Unpacked<'_>, level: LodRecord) -> Value {
    let credits = character.credits().cloned().unwrap_or_default();
    // A pack may come from elsewhere: what is no JSON object is nobody's extras.
    let mut extras: Map<String, Value> = serde_json::from_str(&credits.extras).unwrap_or_default();
    let own = json!({
        "character": character.manifest.name,
        "vertices": level.vertex_count,
        "triangles": level.triangle_count,
        "triangles_of_full_detail": character.record.triangle_count,
    });
    extras.insert("crowdbake".into(), own);
    let mut asset = json!({ "version": "2.0", "generator": character.contents.manifest.generator, "extras": extras });
    if !credits.copyright.is_empty() {
        asset["copyright"] = credits.copyright.into();
    }
    asset
}

/// A mesh that hangs from one node as it lies needs no skin.
fn needs_skin(character: &Unpacked<'_>) -> bool {
    !matches!(character.skin_joints(), [only] if only.inverse_bind == IDENTITY)
}

fn primitive_json(
    character: &Unpacked<'_>,
    vertices: &[VertexRecord],
    primitive: &Primitive,
    material: usize,
    skinned: bool,
    buffer: &mut GlbBuffer,
) -> Value {
    let record = &character.materials[primitive.material as usize];
    let vertices: Vec<&VertexRecord> = primitive.vertices.iter().map(|&v| &vertices[v as usize]).collect();
    let mut attributes = Map::new();
    let mut set = |name: &str, accessor: usize| attributes.insert(name.to_owned(), json!(accessor));

    let positions: Vec<f32> = vertices.iter().flat_map(|vertex| vertex.position).collect();
    set("POSITION", buffer.float_attribute(&positions, 3, true));
    // Without normals glTF asks for flat shading, which is how the source asked for it.
    if record.flags & material_flags::FLAT == 0 {
        let normals: Vec<f32> = vertices.iter().flat_map(|vertex| vertex.normal()).collect();
        set("NORMAL", buffer.float_attribute(&normals, 3, false));
    }
    // Whoever gives a material its texture later needs them as well, if there are any.
    let textured = record.image != NONE || character.finish(primitive.material).textures().next().is_some();
    if textured || vertices.iter().any(|vertex| vertex.uv != [0.0; 2]) {
        let uvs: Vec<f32> = vertices.iter().flat_map(|vertex| vertex.uv).collect();
        set("TEXCOORD_0", buffer.float_attribute(&uvs, 2, false));
    }
    let colors: Vec<[u8; 4]> = vertices.iter().map(|vertex| vertex.color.to_le_bytes()).collect();
    if colors.iter().any(|color| *color != [255; 4]) {
        set("COLOR_0", buffer.byte_attribute(&colors, true));
    }
    if skinned {
        let joints: Vec<[u16; 4]> = vertices.iter().map(|vertex| listed_joints(character, vertex)).collect();
        let joints = if character.skin_joints().len() <= 256 {
            let bytes: Vec<[u8; 4]> = joints.iter().map(|joints| joints.map(|joint| joint as u8)).collect();
            buffer.byte_attribute(&bytes, false)
        } else {
            buffer.short_attribute(&joints, false)
        };
        set("JOINTS_0", joints);
        let weights: Vec<[u16; 4]> = vertices.iter().map(|vertex| vertex.weights_unorm16()).collect();
        set("WEIGHTS_0", buffer.short_attribute(&weights, true));
    }
    let indices = buffer.indices(&primitive.indices, vertices.len());
    json!({ "attributes": attributes, "indices": indices, "material": material })
}

/// The joints of a vertex as the source's skin lists them; 0 where they have no weight.
fn listed_joints(character: &Unpacked<'_>, vertex: &VertexRecord) -> [u16; 4] {
    let (joints, weights) = (vertex.joint_indices(), vertex.weights_unorm16());
    let places = character.rig().map_or(&[][..], |rig| &rig.places);
    if places.is_empty() {
        return joints;
    }
    std::array::from_fn(|slot| if weights[slot] == 0 { 0 } else { places[usize::from(joints[slot])] as u16 })
}

/// The node tree as it was, a node for the mesh, and the skin.
fn add_nodes(character: &Unpacked<'_>, skinned: bool, document: &mut Map<String, Value>, buffer: &mut GlbBuffer) {
    let manifest = character.manifest;
    let mut nodes: Vec<Value> = manifest.nodes.iter().map(node_json).collect();
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut roots = Vec::new();
    for (index, node) in manifest.nodes.iter().enumerate() {
        match node.parent {
            Some(parent) => children[parent as usize].push(index),
            None => roots.push(index),
        }
    }
    if skinned {
        let joint_nodes = joint_nodes(character, &mut nodes, &mut children);
        if roots.len() > 1 {
            // A skin's joints must have one root in common.
            nodes.push(json!({ "name": format!("{} root", manifest.name) }));
            children.push(std::mem::take(&mut roots));
            roots = vec![nodes.len() - 1];
        }
        let inverse_binds: Vec<f32> = character.skin_joints().iter().flat_map(|joint| joint.inverse_bind).collect();
        let accessor = buffer.floats(&inverse_binds, 16, false);
        let mut skin = json!({ "joints": joint_nodes, "inverseBindMatrices": accessor });
        if let Some(name) = character.skin_name() {
            skin["name"] = json!(name);
        }
        document.insert("skins".into(), json!([skin]));
        nodes.push(json!({ "name": format!("{} mesh", manifest.name), "mesh": 0, "skin": 0 }));
        children.push(Vec::new());
        roots.push(nodes.len() - 1);
    } else {
        nodes[manifest.joints[0].node as usize]["mesh"] = json!(0);
    }
    for (node, children) in nodes.iter_mut().zip(children) {
        if !children.is_empty() {
            node["children"] = json!(children);
        }
    }
    document.insert("nodes".into(), Value::Array(nodes));
    document.insert("scenes".into(), json!([{ "nodes": roots }]));
    document.insert("scene".into(), json!(0));
}

/// The node of each joint. Two joints on one node (skins with bind spaces of their own) need two nodes in glTF: the
/// second gets a child that stays where its parent is.
fn joint_nodes(character: &Unpacked<'_>, nodes: &mut Vec<Value>, children: &mut Vec<Vec<usize>>) -> Vec<usize> {
    let mut taken = BTreeSet::new();
    let mut joint_nodes = Vec::new();
    for joint in character.skin_joints() {
        let node = joint.node as usize;
        if taken.insert(node) {
            joint_nodes.push(node);
            continue;
        }
        nodes.push(json!({ "name": format!("{} again", character.manifest.nodes[node].name) }));
        children.push(Vec::new());
        children[node].push(nodes.len() - 1);
        joint_nodes.push(nodes.len() - 1);
    }
    joint_nodes
}

fn node_json(node: &crowd_pack::ManifestNode) -> Value {
    let mut json = json!({ "name": node.name });
    if node.translation != [0.0; 3] {
        json["translation"] = json!(node.translation);
    }
    if node.rotation != [0.0, 0.0, 0.0, 1.0] {
        json["rotation"] = json!(unit(node.rotation));
    }
    if node.scale != [1.0; 3] {
        json["scale"] = json!(node.scale);
    }
    json
}

/// A quaternion made unit in double precision: validators measure it.
fn unit(q: [f32; 4]) -> [f32; 4] {
    let length = q.iter().map(|&c| f64::from(c) * f64::from(c)).sum::<f64>().sqrt();
    if length > 0.0 { q.map(|c| (f64::from(c) / length) as f32) } else { [0.0, 0.0, 0.0, 1.0] }
}

fn animations_json(character: &Unpacked<'_>, buffer: &mut GlbBuffer) -> Vec<Value> {
    let mut shared = BTreeMap::new();
    let clips = character.manifest.clips.iter().enumerate().filter(|(_, clip)| !clip.tracks.is_empty());
    // Curves of joints that move nothing of this mesh may move something of another one under the same skeleton.
    let spare = |index: usize| character.rig().and_then(|rig| rig.tracks.get(index)).map_or(&[][..], Vec::as_slice);
    clips.map(|(index, clip)| animation_json(character, clip, spare(index), &mut shared, buffer)).collect()
}

/// Curves share accessors as they share floats in the pack: key (offset, count, floats an element).
type SharedAccessors = BTreeMap<(u32, u32, usize), usize>;

fn animation_json(
    character: &Unpacked<'_>,
    clip: &ManifestClip,
    spare: &[ManifestTrack],
    shared: &mut SharedAccessors,
    buffer: &mut GlbBuffer,
) -> Value {
    let floats = &character.contents.track_values;
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for track in clip.tracks.iter().chain(spare) {
        let times = &floats[track.time_offset as usize..][..track.key_count as usize];
        let input =
            *shared.entry((track.time_offset, track.key_count, 1)).or_insert_with(|| buffer.floats(times, 1, true));
        let lanes = if track.property == 1 { 4 } else { 3 };
        let output = *shared
            .entry((track.value_offset, track.value_count, lanes))
            .or_insert_with(|| buffer.floats(&curve_values(floats, track), lanes, false));
        let interpolation = ["STEP", "LINEAR", "CUBICSPLINE"][usize::from(track.interpolation)];
        let path = ["translation", "rotation", "scale"][usize::from(track.property)];
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": track.node, "path": path } }));
        samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
    }
    json!({ "name": clip.name, "samplers": samplers, "channels": channels })
}

fn curve_values(floats: &[f32], track: &ManifestTrack) -> Vec<f32> {
    let values = &floats[track.value_offset as usize..][..track.value_count as usize];
    let is_spline = track.interpolation == 2;
    if track.property != 1 || is_spline {
        return values.to_vec();
    }
    values.as_chunks::<4>().0.iter().flat_map(|&q| unit(q)).collect()
}
