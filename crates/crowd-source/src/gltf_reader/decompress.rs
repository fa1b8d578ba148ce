//! EXT_meshopt_compression and KHR_meshopt_compression: compressed buffer views.

use gltf::json::buffer;
use serde_json::Value;

use crate::Result;
use crate::names::shorten;
use crate::refusal::Asset;

/// What the extension says about a view.
pub(super) struct Compressed {
    pub(super) buffer: usize,
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) stride: usize,
    pub(super) count: usize,
    mode: Mode,
    filter: Filter,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// The codec's best case is one byte for 1,024 (a block of equal vertices): whoever claims more is refused before
/// anything is allocated.
const BEST_RATIO: u64 = 1024;
const BEST_RATIO_SLACK: u64 = 64 * 1024;

/// The extension on a view, checked; `None` for a plain view.
pub(super) fn find_compression(asset: Asset<'_>, here: &str, view: &buffer::View) -> Result<Option<Compressed>> {
    let found = view.extensions.as_ref().and_then(|extensions| {
        ["KHR_meshopt_compression", "EXT_meshopt_compression"].iter().find_map(|name| extensions.others.get(*name))
    });
    let Some(extension) = found else { return Ok(None) };
    let number = |key: &str, default: Option<u64>| -> Result<u64> {
        match (extension.get(key), default) {
            (Some(value), _) => {
                value.as_u64().ok_or_else(|| asset.format(here, format!("meshopt compression: `{key}` is {value}")))
            }
            (None, Some(default)) => Ok(default),
            (None, None) => Err(asset.format(here, format!("meshopt compression: no `{key}`"))),
        }
    };
    let word = |key: &str| extension.get(key).and_then(Value::as_str);
    let mode = match word("mode") {
        Some("ATTRIBUTES") => Mode::Attributes,
        Some("TRIANGLES") => Mode::Triangles,
        Some("INDICES") => Mode::Indices,
        other => {
            let other = shorten(other.unwrap_or("nothing"));
            return Err(asset.format(here, format!("meshopt compression: mode `{other}` is not known")));
        }
    };
    let filter = match word("filter") {
        None | Some("NONE") => Filter::None,
        Some("OCTAHEDRAL") => Filter::Octahedral,
        Some("QUATERNION") => Filter::Quaternion,
        Some("EXPONENTIAL") => Filter::Exponential,
        Some("COLOR") => Filter::Color,
        Some(other) => {
            return Err(asset.format(here, format!("meshopt compression: filter `{}` is not known", shorten(other))));
        }
    };
    let stride = number("byteStride", None)?;
    let stride_fits = match (mode, filter) {
        (Mode::Attributes, Filter::Octahedral | Filter::Color) => stride == 4 || stride == 8,
        (Mode::Attributes, Filter::Quaternion) => stride == 8,
        (Mode::Attributes, _) => stride != 0 && stride <= 256 && stride % 4 == 0,
        (_, Filter::None) => stride == 2 || stride == 4,
        _ => false,
    };
    let count = number("count", None)?;
    if !stride_fits || (mode == Mode::Triangles && count % 3 != 0) {
        let what = format!("meshopt compression: {count} elements of {stride} bytes do not fit its mode and filter");
        return Err(asset.format(here, what));
    }
    let byte_length = number("byteLength", None)?;
    let allowed = byte_length.saturating_mul(BEST_RATIO).saturating_add(BEST_RATIO_SLACK);
    if count.checked_mul(stride).is_none_or(|bytes| bytes > allowed) {
        let what =
            format!("meshopt compression: {count} elements of {stride} bytes cannot come out of {byte_length} bytes");
        return Err(asset.format(here, what));
    }
    Ok(Some(Compressed {
        buffer: usize::try_from(number("buffer", None)?).unwrap_or(usize::MAX),
        byte_offset: number("byteOffset", Some(0))?,
        byte_length,
        stride: stride as usize,
        count: count as usize,
        mode,
        filter,
    }))
}

/// The view's uncompressed bytes: `count * stride` of them.
pub(super) fn decompress_view(asset: Asset<'_>, here: &str, compressed: &Compressed, source: &[u8]) -> Result<Vec<u8>> {
    let broken = |e: meshopt::Error| asset.format(here, format!("meshopt compression: the bytes do not decode: {e}"));
    let Compressed { stride, count, .. } = *compressed;
    let mut bytes = match (compressed.mode, stride) {
        (Mode::Triangles, 2) => to_bytes(&meshopt::decode_index_buffer::<u16>(source, count).map_err(broken)?),
        (Mode::Triangles, _) => to_bytes(&meshopt::decode_index_buffer::<u32>(source, count).map_err(broken)?),
        (Mode::Indices, 2) => to_bytes(&meshopt::decode_index_sequence::<u16>(source, count).map_err(broken)?),
        (Mode::Indices, _) => to_bytes(&meshopt::decode_index_sequence::<u32>(source, count).map_err(broken)?),
        (Mode::Attributes, _) => decode_vertices(source, count, stride).map_err(broken)?,
    };
    apply_filter(compressed, &mut bytes);
    Ok(bytes)
}

fn to_bytes<T: bytemuck::Pod>(elements: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(elements).to_vec()
}

/// The binding takes the element size from a type, so each of the 64 strides needs its own.
fn decode_vertices(source: &[u8], count: usize, stride: usize) -> meshopt::Result<Vec<u8>> {
    fn decode<const WORDS: usize>(source: &[u8], count: usize) -> meshopt::Result<Vec<u8>> {
        #[derive(Clone, Copy)]
        struct Element<const WORDS: usize>([u32; WORDS]);
        impl<const WORDS: usize> Default for Element<WORDS> {
            fn default() -> Self {
                Self([0; WORDS])
            }
        }
        let elements: Vec<Element<WORDS>> = meshopt::decode_vertex_buffer(source, count)?;
        Ok(elements.iter().flat_map(|e| e.0).flat_map(u32::to_le_bytes).collect())
    }
    macro_rules! by_stride {
        ($($words:literal)*) => {
            match stride / 4 {
                $($words => decode::<$words>(source, count),)*
                _ => unreachable!("find_compression allows strides of 4 to 256 in steps of 4"),
            }
        };
    }
    by_stride!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

fn apply_filter(compressed: &Compressed, bytes: &mut [u8]) {
    // The bytes come from a `Vec<u8>`, which may be aligned to one byte only; hence the copies.
    fn filtered<T: bytemuck::Pod>(bytes: &mut [u8], filter: impl FnOnce(&mut [T])) {
        let mut elements: Vec<T> = bytemuck::pod_collect_to_vec(bytes);
        filter(&mut elements);
        bytes.copy_from_slice(bytemuck::cast_slice(&elements));
    }
    match (compressed.filter, compressed.stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => filtered::<[i8; 4]>(bytes, meshopt::decode_filter_oct),
        (Filter::Octahedral, _) => filtered::<[i16; 4]>(bytes, meshopt::decode_filter_oct),
        (Filter::Quaternion, _) => filtered::<[i16; 4]>(bytes, meshopt::decode_filter_quat),
        (Filter::Exponential, _) => filtered::<[u32; 1]>(bytes, meshopt::decode_filter_exp),
        (Filter::Color, 4) => filtered::<[u8; 4]>(bytes, meshopt::decode_filter_color),
        (Filter::Color, _) => filtered::<[u16; 4]>(bytes, meshopt::decode_filter_color),
    }
}
