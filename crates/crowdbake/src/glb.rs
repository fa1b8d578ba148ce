//! Writes binary glTF 2.0: a growing buffer with views and accessors, and the container around it.

use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The binary chunk and the lists that describe it.
#[derive(Debug, Default)]
pub(crate) struct GlbBuffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbBuffer {
    /// Floats without a target (times, values, matrices). `lanes`: floats an element.
    pub(crate) fn floats(&mut self, values: &[f32], lanes: usize, bounded: bool) -> usize {
        let view = self.view(bytemuck::cast_slice(values), None);
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / lanes, "type": type_name(lanes),
        });
        if bounded {
            set_bounds(&mut accessor, values, lanes);
        }
        self.accessor(accessor)
    }

    /// A float vertex attribute; positions need their bounds.
    pub(crate) fn float_attribute(&mut self, values: &[f32], lanes: usize, bounded: bool) -> usize {
        let view = self.view(bytemuck::cast_slice(values), Some(ARRAY_BUFFER));
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / lanes, "type": type_name(lanes),
        });
        if bounded {
            set_bounds(&mut accessor, values, lanes);
        }
        self.accessor(accessor)
    }

    /// A vertex attribute of four bytes.
    pub(crate) fn byte_attribute(&mut self, values: &[[u8; 4]], normalized: bool) -> usize {
        let view = self.view(values.as_flattened(), Some(ARRAY_BUFFER));
        self.integer_accessor(view, UNSIGNED_BYTE, values.len(), normalized)
    }

    /// A vertex attribute of four 16-bit numbers.
    pub(crate) fn short_attribute(&mut self, values: &[[u16; 4]], normalized: bool) -> usize {
        let view = self.view(bytemuck::cast_slice(values), Some(ARRAY_BUFFER));
        self.integer_accessor(view, UNSIGNED_SHORT, values.len(), normalized)
    }

    /// Indices, 16 bits where they fit (65535 is kept free: it restarts primitives).
    pub(crate) fn indices(&mut self, indices: &[u32], vertex_count: usize) -> usize {
        let (view, component) = if vertex_count <= 65_535 {
            let short: Vec<u16> = indices.iter().map(|&index| index as u16).collect();
            (self.view(bytemuck::cast_slice(&short), Some(ELEMENT_ARRAY_BUFFER)), UNSIGNED_SHORT)
        } else {
            (self.view(bytemuck::cast_slice(indices), Some(ELEMENT_ARRAY_BUFFER)), UNSIGNED_INT)
        };
        self.accessor(
            json!({ "bufferView": view, "componentType": component, "count": indices.len(), "type": "SCALAR" }),
        )
    }

    /// Raw bytes (an image); gives the view.
    pub(crate) fn raw(&mut self, bytes: &[u8]) -> usize {
        self.view(bytes, None)
    }

    /// The file: `document` with buffers, views and accessors filled in, then the binary chunk.
    pub(crate) fn finish(mut self, mut document: Value) -> Vec<u8> {
        pad(&mut self.bytes, 0);
        document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        document["bufferViews"] = Value::Array(self.views);
        document["accessors"] = Value::Array(self.accessors);
        let mut text = document.to_string().into_bytes();
        pad(&mut text, b' ');
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        let mut file = Vec::with_capacity(total);
        file.extend_from_slice(b"glTF");
        file.extend_from_slice(&2_u32.to_le_bytes());
        file.extend_from_slice(&(total as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            file.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
            file.extend_from_slice(kind);
            file.extend_from_slice(chunk);
        }
        file
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        pad(&mut self.bytes, 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn integer_accessor(&mut self, view: usize, component: u32, count: usize, normalized: bool) -> usize {
        let mut accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": "VEC4" });
        if normalized {
            accessor["normalized"] = json!(true);
        }
        self.accessor(accessor)
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().next_multiple_of(4), with);
}

fn type_name(lanes: usize) -> &'static str {
    match lanes {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}

fn set_bounds(accessor: &mut Value, values: &[f32], lanes: usize) {
    let lane = |lane: usize| values.iter().skip(lane).step_by(lanes).copied();
    let least: Vec<f32> = (0..lanes).map(|l| lane(l).fold(f32::INFINITY, f32::min)).collect();
    let greatest: Vec<f32> = (0..lanes).map(|l| lane(l).fold(f32::NEG_INFINITY, f32::max)).collect();
    accessor["min"] = json!(least);
    accessor["max"] = json!(greatest);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_aligned_and_lengths_add_up() {
        let mut buffer = GlbBuffer::default();
        buffer.raw(&[1, 2, 3]);
        buffer.float_attribute(&[1.0, 2.0, 3.0, -1.0, 5.0, 0.5], 3, true);
        buffer.indices(&[0, 1, 0], 2);
        let file = buffer.finish(json!({ "asset": { "version": "2.0" } }));
        assert_eq!(file.len() % 4, 0);
        assert_eq!(u32::from_le_bytes(file[8..12].try_into().unwrap()) as usize, file.len());
        let text_bytes = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
        let document: Value = serde_json::from_slice(&file[20..20 + text_bytes]).unwrap();
        assert_eq!(document["bufferViews"][1]["byteOffset"], 4);
        assert_eq!(document["accessors"][0]["min"], json!([-1.0, 2.0, 0.5]));
        assert_eq!(document["buffers"][0]["byteLength"], 36);
    }
}
