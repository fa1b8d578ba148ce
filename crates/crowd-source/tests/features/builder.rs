//! Small glTF documents, written value by value, and a folder to put them into.

use crowd_source::{Error, Limits, RawCharacter, load_character};
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const I8: u32 = 5120;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const F32: u32 = 5126;

/// The smallest PNG: one white pixel.
pub const PNG: &[u8] = &[
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x00,
    0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00, 0x00, 0x1f, 0x15, 0xc4, 0x89, 0x00, 0x00, 0x00, 0x0d, 0x49,
    0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8, 0xff, 0xff, 0xff, 0x7f, 0x00, 0x09, 0xfb, 0x03, 0xfd, 0x2a, 0x86, 0xe3,
    0x8a, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
];

/// A document under construction: JSON and one binary buffer.
pub struct Doc {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Doc {
    /// No nodes, no meshes.
    pub fn empty() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}],
            "nodes": [], "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
        });
        Self { json, bin: Vec::new() }
    }

    /// One triangle in the xy plane under one node.
    pub fn triangle() -> Self {
        let mut doc = Self::empty();
        let positions = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}}));
        doc.scene_node(json!({"mesh": mesh}));
        doc
    }

    /// Appends to a top-level list and returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// A buffer view over new bytes, aligned to four.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bin.len();
        self.bin.extend(bytes);
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn accessor(&mut self, kind: u32, shape: &str, count: usize, bytes: &[u8], normalized: bool) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": kind, "type": shape, "count": count, "normalized": normalized
        });
        self.push("accessors", accessor)
    }

    pub fn floats(&mut self, shape: &str, numbers: &[f32]) -> usize {
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(F32, shape, numbers.len() / width, bytemuck::cast_slice(numbers), false)
    }

    pub fn indices(&mut self, indices: &[u16]) -> usize {
        self.accessor(U16, "SCALAR", indices.len(), bytemuck::cast_slice(indices), false)
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({"name": "torso", "primitives": [primitive]}))
    }

    pub fn node(&mut self, node: Value) -> usize {
        self.push("nodes", node)
    }

    /// A node at the top of the scene.
    pub fn scene_node(&mut self, node: Value) -> usize {
        let node = self.node(node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(node));
        node
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() + 8 + self.bin.len();
        let mut bytes = b"glTF".to_vec();
        for word in [2, total as u32, text.len() as u32] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(b"JSON");
        bytes.extend(&text);
        bytes.extend((self.bin.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(&self.bin);
        bytes
    }

    pub fn try_load(&self) -> Result<RawCharacter, Error> {
        load_bytes("character.glb", &self.glb())
    }

    #[track_caller]
    pub fn load(&self) -> RawCharacter {
        self.try_load().unwrap_or_else(|e| panic!("{e}"))
    }

    /// The words of the refusal.
    #[track_caller]
    pub fn refusal(&self) -> String {
        self.try_load().expect_err("must be refused").to_string()
    }
}

pub fn load_bytes(name: &str, bytes: &[u8]) -> Result<RawCharacter, Error> {
    load_files(&[(name, bytes)])
}

/// Writes files into a fresh folder and loads the first.
pub fn load_files(files: &[(&str, &[u8])]) -> Result<RawCharacter, Error> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("inside the folder")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }
    load_character(&folder.path().join(files[0].0), &Limits::default())
}

/// The warning with a code, if there is one.
pub fn warning<'a>(character: &'a RawCharacter, code: &str) -> Option<&'a crowd_source::Warning> {
    character.warnings.iter().find(|w| w.code == code)
}

/// Positions by posed joints: `world[n]` for each node.
pub fn pose(character: &RawCharacter, world: &[glam::DMat4]) -> Vec<glam::DVec3> {
    let palette: Vec<glam::DMat4> = character
        .joints
        .iter()
        .map(|j| world[j.node as usize] * glam::DMat4::from_cols_array(&j.inverse_bind.map(f64::from)))
        .collect();
    let mesh = &character.mesh;
    (0..mesh.positions.len())
        .map(|v| {
            let position = glam::DVec3::from_array(mesh.positions[v].map(f64::from));
            (0..4)
                .map(|s| palette[mesh.joints[v][s] as usize].transform_point3(position) * f64::from(mesh.weights[v][s]))
                .sum()
        })
        .collect()
}

/// World transforms of the nodes at rest.
pub fn rest(character: &RawCharacter) -> Vec<glam::DMat4> {
    let mut world: Vec<glam::DMat4> = Vec::new();
    for node in &character.nodes {
        let local = glam::DMat4::from_scale_rotation_translation(
            glam::DVec3::from_array(node.scale.map(f64::from)),
            glam::DQuat::from_array(node.rotation.map(f64::from)),
            glam::DVec3::from_array(node.translation.map(f64::from)),
        );
        world.push(node.parent.map_or(local, |p| world[p as usize] * local));
    }
    world
}
