//! Accessors as flat numbers: every component type, normalisation, strides, sparse parts, all within bounds.

use gltf::json::Root;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::buffers::Buffers;
use crate::Result;
use crate::refusal::Asset;

/// An accessor whose every element is known to lie inside its view.
pub(super) struct Elements<'a> {
    pub(super) count: usize,
    /// Numbers an element: 1 to 4, 16.
    pub(super) width: usize,
    pub(super) kind: ComponentType,
    pub(super) normalized: bool,
    place: String,
    asset: Asset<'a>,
    /// First byte of the first element, and the distance to the next; `None` for all zeros.
    base: Option<(&'a [u8], usize)>,
    sparse: Option<Sparse<'a>>,
}

struct Sparse<'a> {
    count: usize,
    indices: &'a [u8],
    index_kind: ComponentType,
    values: &'a [u8],
}

/// Opens accessor `index` for `place`. `allowed` bounds the element count before anything is allocated.
pub(super) fn open_accessor<'a>(
    asset: Asset<'a>,
    root: &Root,
    buffers: &'a Buffers<'_>,
    place: &str,
    index: usize,
    allowed: (&'static str, u64),
) -> Result<Elements<'a>> {
    let Some(accessor) = root.accessors.get(index) else {
        return Err(asset.format(place, format!("accessor {index}, the file has {}", root.accessors.len())));
    };
    let place = format!("{place}: accessor {index}");
    let Checked::Valid(kind) = accessor.component_type else {
        return Err(asset.format(place, "`componentType` is none of 5120 to 5123, 5125, 5126"));
    };
    let Checked::Valid(shape) = accessor.type_ else {
        return Err(asset.format(place, "`type` is none of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4"));
    };
    let width = match shape {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 => 4,
        Type::Mat4 => 16,
        // Nothing that we read is a MAT2 or MAT3 (whose columns may be padded).
        Type::Mat2 | Type::Mat3 => return Err(asset.format(place, format!("`type` is {shape:?}, expected another"))),
    };
    let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
    let element_bytes = width * component_bytes(kind.0);
    let base = match accessor.buffer_view {
        None => None,
        Some(view) => {
            let view = buffers.view(&place, view.value())?;
            let stride = view.stride.unwrap_or(element_bytes);
            if stride < element_bytes {
                return Err(asset.format(place, format!("byteStride {stride}, an element has {element_bytes} bytes")));
            }
            let offset = accessor.byte_offset.map_or(0, |o| o.0);
            let bytes = check_range(asset, &place, view.bytes, offset, count, stride, element_bytes)?;
            Some((bytes, stride))
        }
    };
    // A count that the bytes bear out may still be more than we take; one without bytes behind it means that many zeros.
    asset.check_limit(&place, allowed.0, accessor.count.0, allowed.1)?;
    let sparse = match &accessor.sparse {
        None => None,
        Some(sparse) => {
            let Checked::Valid(index_kind) = sparse.indices.component_type else {
                return Err(asset.format(place, "sparse: index `componentType` is none of 5121, 5123, 5125"));
            };
            let changed = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            if changed > count {
                return Err(asset.format(place, format!("sparse: {changed} changed elements of {count}")));
            }
            let index_bytes = component_bytes(index_kind.0);
            let view = buffers.view(&place, sparse.indices.buffer_view.value())?;
            let offset = sparse.indices.byte_offset.0;
            let indices = check_range(asset, &place, view.bytes, offset, changed, index_bytes, index_bytes)?;
            let view = buffers.view(&place, sparse.values.buffer_view.value())?;
            let offset = sparse.values.byte_offset.0;
            let values = check_range(asset, &place, view.bytes, offset, changed, element_bytes, element_bytes)?;
            Some(Sparse { count: changed, indices, index_kind: index_kind.0, values })
        }
    };
    Ok(Elements { count, width, kind: kind.0, normalized: accessor.normalized, place, asset, base, sparse })
}

/// The bytes from the first element on, once `count` elements are known to fit.
fn check_range<'a>(
    asset: Asset<'_>,
    place: &str,
    bytes: &'a [u8],
    offset: u64,
    count: usize,
    stride: usize,
    element_bytes: usize,
) -> Result<&'a [u8]> {
    let needed = match count {
        0 => Some(0),
        _ => (count as u64 - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(element_bytes as u64)),
    };
    let end = needed.and_then(|n| n.checked_add(offset)).filter(|end| *end <= bytes.len() as u64);
    match end {
        Some(end) => Ok(&bytes[offset as usize..end as usize]),
        None => Err(asset.format(
            place,
            format!(
                "{count} elements of {element_bytes} bytes, {stride} apart from byte {offset}, the view has {} bytes",
                bytes.len()
            ),
        )),
    }
}

fn component_bytes(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

impl Elements<'_> {
    /// Refuses accessors of another shape or component type than the glTF tables allow.
    pub(super) fn expect(&self, widths: &[usize], kinds: &[ComponentType]) -> Result<()> {
        if !widths.contains(&self.width) {
            return Err(self
                .asset
                .format(&self.place, format!("{} numbers an element, expected one of {widths:?}", self.width)));
        }
        if !kinds.contains(&self.kind) {
            return Err(self
                .asset
                .format(&self.place, format!("component type {:?}, expected one of {kinds:?}", self.kind)));
        }
        Ok(())
    }

    /// All numbers as floats, `count * width` of them. Integers are mapped to 0..1 or -1..1 when `normalized`, else kept.
    pub(super) fn read_floats(&self, normalized: bool) -> Result<Vec<f32>> {
        let kind = self.kind;
        self.read(|bytes| decode_float(kind, normalized, bytes))
    }

    /// All numbers as unsigned integers; floats and signed integers are refused by `expect` before.
    pub(super) fn read_integers(&self) -> Result<Vec<u32>> {
        let kind = self.kind;
        self.read(|bytes| decode_integer(kind, bytes))
    }

    fn read<T: Copy + Default>(&self, decode: impl Fn(&[u8]) -> T) -> Result<Vec<T>> {
        let size = component_bytes(self.kind);
        let mut numbers = match self.base {
            None => vec![T::default(); self.count * self.width],
            Some((bytes, stride)) => {
                let mut numbers = Vec::with_capacity(self.count * self.width);
                for element in 0..self.count {
                    let from = element * stride;
                    numbers.extend(bytes[from..from + self.width * size].chunks_exact(size).map(&decode));
                }
                numbers
            }
        };
        let Some(sparse) = &self.sparse else { return Ok(numbers) };
        let index_size = component_bytes(sparse.index_kind);
        for changed in 0..sparse.count {
            let index = decode_integer(sparse.index_kind, &sparse.indices[changed * index_size..][..index_size]);
            let index = index as usize;
            if index >= self.count {
                return Err(self
                    .asset
                    .format(&self.place, format!("sparse: index {index}, the accessor has {} elements", self.count)));
            }
            let from = changed * self.width * size;
            let values = sparse.values[from..from + self.width * size].chunks_exact(size).map(&decode);
            for (number, value) in numbers[index * self.width..].iter_mut().zip(values) {
                *number = value;
            }
        }
        Ok(numbers)
    }
}

fn decode_float(kind: ComponentType, normalized: bool, bytes: &[u8]) -> f32 {
    match (kind, normalized) {
        (ComponentType::F32, _) => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        (ComponentType::I8, false) => f32::from(bytes[0] as i8),
        (ComponentType::U8, false) => f32::from(bytes[0]),
        (ComponentType::I16, false) => f32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        (ComponentType::U16, false) => f32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        (ComponentType::U32, false) => decode_integer(kind, bytes) as f32,
        // glTF 2.0 §3.6.2.2: f = max(c / 127, -1) and so on.
        (ComponentType::I8, true) => (f32::from(bytes[0] as i8) / 127.0).max(-1.0),
        (ComponentType::U8, true) => f32::from(bytes[0]) / 255.0,
        (ComponentType::I16, true) => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])) / 32767.0).max(-1.0),
        (ComponentType::U16, true) => f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65535.0,
        (ComponentType::U32, true) => (f64::from(decode_integer(kind, bytes)) / f64::from(u32::MAX)) as f32,
    }
}

fn decode_integer(kind: ComponentType, bytes: &[u8]) -> u32 {
    match kind {
        ComponentType::I8 | ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::I16 | ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U32 | ComponentType::F32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}
