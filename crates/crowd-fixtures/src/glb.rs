//! Writes a glTF 2.0 binary by hand: the same bytes for the same document, whatever features other crates turn on.

use glam::{Quat, Vec3};

/// A mesh as a file has it: one entry per wedge.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Positions in metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; may be empty.
    pub uvs: Vec<[f32; 2]>,
    /// Joint indices and weights; empty for an unskinned mesh.
    pub joints: Vec<[u8; 4]>,
    /// See `joints`.
    pub weights: Vec<[f32; 4]>,
    /// Triangles.
    pub indices: Vec<u32>,
    /// Index into the document's materials.
    pub material: usize,
}

/// One node of the scene.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Name.
    pub name: String,
    /// Children by index.
    pub children: Vec<usize>,
    /// Translation from the parent.
    pub translation: Vec3,
    /// Index of the mesh drawn here.
    pub mesh: Option<usize>,
    /// Is the mesh skinned (by the only skin)?
    pub skinned: bool,
}

/// One animated property of one node.
#[derive(Clone, Debug)]
pub enum Curve {
    /// Rotations.
    Rotation(Vec<Quat>),
    /// Translations in metres.
    Translation(Vec<Vec3>),
}

/// One clip: all curves share the same times.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Name.
    pub name: String,
    /// Key times in seconds, from 0.
    pub times: Vec<f32>,
    /// (node, curve).
    pub curves: Vec<(usize, Curve)>,
}

/// A material: a colour, perhaps with an image.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name.
    pub name: String,
    /// Linear RGBA factor.
    pub colour: [f32; 4],
    /// Image index.
    pub image: Option<usize>,
    /// Draw both sides.
    pub double_sided: bool,
}

/// Everything that goes into one file.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// Nodes; those without a parent are the scene's roots.
    pub nodes: Vec<Node>,
    /// Meshes, each a list of primitives, with a name.
    pub meshes: Vec<(String, Vec<Primitive>)>,
    /// The skin's joints (nodes) and their bind positions in metres; rest rotations are none.
    pub joints: Vec<(usize, Vec3)>,
    /// Materials.
    pub materials: Vec<Material>,
    /// PNG files.
    pub images: Vec<Vec<u8>>,
    /// Clips.
    pub clips: Vec<Clip>,
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Writer {
    fn view(&mut self, bytes: &[u8], extra: &str) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.views.push(format!("{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{}{extra}}}", bytes.len()));
        self.views.len() - 1
    }

    fn floats<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str, bounds: bool, target: &str) -> usize {
        let view = self.view(bytemuck::cast_slice(rows.as_flattened()), target);
        let mut text =
            format!("{{\"bufferView\":{view},\"componentType\":5126,\"count\":{},\"type\":\"{kind}\"", rows.len());
        if bounds {
            let fold = |f: fn(f32, f32) -> f32| {
                let mut m = rows[0];
                rows.iter().for_each(|r| (0..N).for_each(|k| m[k] = f(m[k], r[k])));
                m.map(|x| x.to_string()).join(",")
            };
            text += &format!(",\"min\":[{}],\"max\":[{}]", fold(f32::min), fold(f32::max));
        }
        self.accessors.push(text + "}");
        self.accessors.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str, target: &str) -> usize {
        let view = self.view(bytes, target);
        self.accessors.push(format!(
            "{{\"bufferView\":{view},\"componentType\":{component},\"count\":{count},\"type\":\"{kind}\"}}"
        ));
        self.accessors.len() - 1
    }

    fn primitive(&mut self, p: &Primitive) -> String {
        const VERTEX: &str = ",\"target\":34962";
        let mut attributes = format!("\"POSITION\":{}", self.floats(&p.positions, "VEC3", true, VERTEX));
        if !p.normals.is_empty() {
            attributes += &format!(",\"NORMAL\":{}", self.floats(&p.normals, "VEC3", false, VERTEX));
        }
        if !p.uvs.is_empty() {
            attributes += &format!(",\"TEXCOORD_0\":{}", self.floats(&p.uvs, "VEC2", false, VERTEX));
        }
        if !p.joints.is_empty() {
            let joints = self.accessor(p.joints.as_flattened(), 5121, p.joints.len(), "VEC4", VERTEX);
            let weights = self.floats(&p.weights, "VEC4", false, VERTEX);
            attributes += &format!(",\"JOINTS_0\":{joints},\"WEIGHTS_0\":{weights}");
        }
        let index_target = ",\"target\":34963";
        let indices = if p.positions.len() < 65535 {
            let short: Vec<u16> = p.indices.iter().map(|&i| i as u16).collect();
            self.accessor(bytemuck::cast_slice(&short), 5123, short.len(), "SCALAR", index_target)
        } else {
            self.accessor(bytemuck::cast_slice(&p.indices), 5125, p.indices.len(), "SCALAR", index_target)
        };
        format!("{{\"attributes\":{{{attributes}}},\"indices\":{indices},\"material\":{}}}", p.material)
    }

    fn clip(&mut self, clip: &Clip) -> String {
        let times: Vec<[f32; 1]> = clip.times.iter().map(|&t| [t]).collect();
        let input = self.floats(&times, "SCALAR", true, "");
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (node, curve) in &clip.curves {
            let (output, path) = match curve {
                Curve::Rotation(q) => {
                    (self.floats(&q.iter().map(|q| q.to_array()).collect::<Vec<_>>(), "VEC4", false, ""), "rotation")
                }
                Curve::Translation(t) => {
                    (self.floats(&t.iter().map(|t| t.to_array()).collect::<Vec<_>>(), "VEC3", false, ""), "translation")
                }
            };
            samplers.push(format!("{{\"input\":{input},\"output\":{output},\"interpolation\":\"LINEAR\"}}"));
            let sampler = samplers.len() - 1;
            channels.push(format!("{{\"sampler\":{sampler},\"target\":{{\"node\":{node},\"path\":\"{path}\"}}}}"));
        }
        format!(
            "{{\"name\":\"{}\",\"channels\":[{}],\"samplers\":[{}]}}",
            clip.name,
            channels.join(","),
            samplers.join(",")
        )
    }
}

impl Document {
    /// The document as JSON text and its binary buffer; `uri` names the buffer where it is a file of its own.
    pub fn parts(&self, uri: Option<&str>) -> (String, Vec<u8>) {
        let mut w = Writer::default();
        let meshes: Vec<String> = self
            .meshes
            .iter()
            .map(|(name, primitives)| {
                let list: Vec<String> = primitives.iter().map(|p| w.primitive(p)).collect();
                format!("{{\"name\":\"{name}\",\"primitives\":[{}]}}", list.join(","))
            })
            .collect();
        let nodes: Vec<String> = self.nodes.iter().map(write_node).collect();
        let mut sections = vec![
            "\"asset\":{\"version\":\"2.0\",\"generator\":\"crowd-fixtures\"}".to_string(),
            format!("\"scene\":0,\"scenes\":[{{\"nodes\":[{}]}}]", self.roots().join(",")),
            format!("\"nodes\":[{}]", nodes.join(",")),
        ];
        if !meshes.is_empty() {
            sections.push(format!("\"meshes\":[{}]", meshes.join(",")));
        }
        if !self.joints.is_empty() {
            let inverse: Vec<[f32; 16]> =
                self.joints.iter().map(|(_, p)| glam::Mat4::from_translation(-*p).to_cols_array()).collect();
            let matrices = w.floats(&inverse, "MAT4", false, "");
            let list: Vec<String> = self.joints.iter().map(|j| j.0.to_string()).collect();
            sections.push(format!(
                "\"skins\":[{{\"inverseBindMatrices\":{matrices},\"skeleton\":{},\"joints\":[{}]}}]",
                self.joints[0].0,
                list.join(",")
            ));
        }
        if !self.materials.is_empty() {
            let list: Vec<String> = self.materials.iter().map(write_material).collect();
            sections.push(format!("\"materials\":[{}]", list.join(",")));
        }
        if !self.images.is_empty() {
            let list: Vec<String> = self
                .images
                .iter()
                .map(|png| format!("{{\"bufferView\":{},\"mimeType\":\"image/png\"}}", w.view(png, "")))
                .collect();
            let textures: Vec<String> = (0..list.len()).map(|i| format!("{{\"source\":{i},\"sampler\":0}}")).collect();
            sections.push(format!("\"images\":[{}]", list.join(",")));
            sections.push(format!("\"textures\":[{}]", textures.join(",")));
            sections.push(
                "\"samplers\":[{\"magFilter\":9729,\"minFilter\":9987,\"wrapS\":10497,\"wrapT\":10497}]".to_string(),
            );
        }
        if !self.clips.is_empty() {
            let list: Vec<String> = self.clips.iter().map(|c| w.clip(c)).collect();
            sections.push(format!("\"animations\":[{}]", list.join(",")));
        }
        while w.bytes.len() % 4 != 0 {
            w.bytes.push(0);
        }
        sections.push(format!("\"accessors\":[{}]", w.accessors.join(",")));
        sections.push(format!("\"bufferViews\":[{}]", w.views.join(",")));
        let name = uri.map(|u| format!("\"uri\":\"{u}\",")).unwrap_or_default();
        sections.push(format!("\"buffers\":[{{{name}\"byteLength\":{}}}]", w.bytes.len()));
        (format!("{{{}}}", sections.join(",")), w.bytes)
    }

    /// Nodes that are nobody's children.
    fn roots(&self) -> Vec<String> {
        let child = |i: &usize| self.nodes.iter().any(|n| n.children.contains(i));
        (0..self.nodes.len()).filter(|i| !child(i)).map(|i| i.to_string()).collect()
    }

    /// The document as one `.glb` file.
    pub fn to_glb(&self) -> Vec<u8> {
        let (json, bytes) = self.parts(None);
        pack_glb(&json, &bytes)
    }
}

/// Wraps JSON text and a buffer into the binary container.
pub fn pack_glb(json: &str, bytes: &[u8]) -> Vec<u8> {
    let mut text = json.as_bytes().to_vec();
    while !text.len().is_multiple_of(4) {
        text.push(b' ');
    }
    let mut out = Vec::new();
    out.extend(b"glTF");
    for word in [2, (12 + 8 + text.len() + 8 + bytes.len()) as u32, text.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&text);
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bytes);
    out
}

fn write_node(n: &Node) -> String {
    let mut parts = vec![format!("\"name\":\"{}\"", n.name)];
    if n.translation != Vec3::ZERO {
        parts.push(format!("\"translation\":[{},{},{}]", n.translation.x, n.translation.y, n.translation.z));
    }
    if !n.children.is_empty() {
        let list: Vec<String> = n.children.iter().map(usize::to_string).collect();
        parts.push(format!("\"children\":[{}]", list.join(",")));
    }
    if let Some(mesh) = n.mesh {
        parts.push(format!("\"mesh\":{mesh}"));
        if n.skinned {
            parts.push("\"skin\":0".to_string());
        }
    }
    format!("{{{}}}", parts.join(","))
}

fn write_material(m: &Material) -> String {
    let image = m.image.map(|i| format!("\"baseColorTexture\":{{\"index\":{i}}},")).unwrap_or_default();
    let colour = m.colour.map(|x| x.to_string()).join(",");
    let sides = if m.double_sided { ",\"doubleSided\":true" } else { "" };
    format!(
        "{{\"name\":\"{}\",\"pbrMetallicRoughness\":{{{image}\"baseColorFactor\":[{colour}],\"metallicFactor\":0,\"roughnessFactor\":0.9}}{sides}}}",
        m.name
    )
}
