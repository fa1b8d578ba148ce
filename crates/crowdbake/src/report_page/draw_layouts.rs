//! Draws the seams of a character over its textures: the layout at full detail and at a tenth of the triangles.

use super::draw_sheets::{COMPANION_COLOR, Drawn, FIXED_COLOR};
use super::marks::draw_line;
use crate::draw_level::decode_image;
use crate::error::Cause;
use crate::unpack::Unpacked;
use crowd_pack::{NONE, VertexRecord};
use crowd_raster::{Target, Texture, downsample, encode_jpeg};
use glam::Vec2;
use std::collections::BTreeMap;

/// Longer side of a layout's picture, pixels.
const SIDE_PX: u32 = 440;
/// Samples along each side of a pixel.
const SUPERSAMPLING: u32 = 2;
const QUALITY: u8 = 80;
/// Share of the triangles of the second picture; the coarsest level where none is as small.
const LOW_RATIO: f64 = 0.1;
/// Textures shown of one character.
const MOST_TEXTURES: usize = 3;
/// Width of seams, pixels.
const SEAM_PX: f32 = 1.7;
/// Width of the other edges, pixels.
const EDGE_PX: f32 = 0.6;
/// The other edges and the rim of seams (sRGB), with how much they hide.
const EDGE_COLOR: [u8; 4] = [255, 255, 255, 30];
/// See [`EDGE_COLOR`].
const RIM_COLOR: [u8; 4] = [16, 18, 22, 255];
/// An edge that spans more tiles of the texture than this is left out: it would cover all of them.
const MOST_TILES: f32 = 2.0;

/// The layout over one texture.
#[derive(Debug)]
pub(crate) struct Layout {
    /// Materials that show the texture.
    pub materials: Vec<String>,
    /// Texels.
    pub texture_size: [u32; 2],
    /// Seams of full detail.
    pub seam_count: u32,
    /// Open borders of full detail.
    pub border_count: u32,
    /// Triangles of the second picture's level, over all textures.
    pub low_triangle_count: u32,
    /// Its seams.
    pub low_seam_count: u32,
    /// At full detail and at the low level.
    pub pictures: [Drawn; 2],
}

/// Layouts over the textures with the most triangles, and how many textures there are besides.
///
/// # Errors
/// An image that does not decode.
pub(crate) fn draw_layouts(character: &Unpacked<'_>, scale: f32) -> Result<(Vec<Layout>, usize), Cause> {
    let mut triangle_counts: BTreeMap<u32, u32> = BTreeMap::new();
    for corners in character.triangles {
        let image = image_of(character, corners[0]);
        if image != NONE {
            *triangle_counts.entry(image).or_default() += 1;
        }
    }
    let mut images: Vec<(u32, u32)> = triangle_counts.into_iter().collect();
    images.sort_by_key(|&(image, count)| (std::cmp::Reverse(count), image));
    let rest = images.len().saturating_sub(MOST_TEXTURES);
    images.truncate(MOST_TEXTURES);
    let layouts: Result<Vec<Layout>, Cause> =
        images.iter().map(|&(image, _)| draw_layout(character, image, scale)).collect();
    Ok((layouts?, rest))
}

fn image_of(character: &Unpacked<'_>, vertex: u32) -> u32 {
    character.materials[character.vertices[vertex as usize].material() as usize].image
}

fn draw_layout(character: &Unpacked<'_>, image: u32, scale: f32) -> Result<Layout, Cause> {
    let (low, _) = character.level_of_ratio(LOW_RATIO);
    let texture = decode_image(character, image, 2 * SIDE_PX)?;
    let longer = record_size(character, image).into_iter().max().unwrap_or(1).max(1);
    let side_px = SIDE_PX as f32 * scale.sqrt();
    let size = record_size(character, image).map(|side| (side as f32 * side_px / longer as f32).max(24.0) as u32);
    let full_edges = find_edges(character, character.triangles, image);
    let low_edges = find_edges(character, &character.level_triangles(low), image);
    let count = |edges: &[UvEdge], kind: EdgeKind| edges.iter().filter(|edge| edge.kind == kind).count() as u32;
    let materials = character.materials.iter().zip(&character.manifest.materials);
    Ok(Layout {
        materials: materials.filter(|(m, _)| m.image == image).map(|(_, name)| name.clone()).collect(),
        texture_size: record_size(character, image),
        // Each seam lies in the texture twice, once on each of its sides.
        seam_count: count(&full_edges, EdgeKind::Seam).div_ceil(2),
        border_count: count(&full_edges, EdgeKind::Border),
        low_triangle_count: low.triangle_count,
        low_seam_count: count(&low_edges, EdgeKind::Seam).div_ceil(2),
        pictures: [&full_edges, &low_edges].map(|edges| draw_edges(&texture, size, edges)),
    })
}

fn record_size(character: &Unpacked<'_>, image: u32) -> [u32; 2] {
    let record = character.contents.images[image as usize];
    [record.width, record.height]
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum EdgeKind {
    Inner,
    Seam,
    Border,
}

/// An edge of a triangle in the texture.
#[derive(Debug, Clone, Copy)]
struct UvEdge {
    kind: EdgeKind,
    ends: [[f32; 2]; 2],
}

/// Edges of the triangles that show `image`: those within a chart once, seams once for each side.
fn find_edges(character: &Unpacked<'_>, triangles: &[[u32; 3]], image: u32) -> Vec<UvEdge> {
    let position = |v: u32| {
        let vertex = &character.vertices[v as usize];
        (vertex.position.map(f32::to_bits), vertex.joints, vertex.weights)
    };
    let chart = |vertex: &VertexRecord| (vertex.uv.map(f32::to_bits), vertex.material());
    // Sides of an edge by the places of its ends: corners in the order of the places.
    let mut sides: BTreeMap<_, Vec<[u32; 2]>> = BTreeMap::new();
    for corners in triangles {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (mut a, mut b) = (corners[from], corners[to]);
            if position(b) < position(a) {
                std::mem::swap(&mut a, &mut b);
            }
            sides.entry((position(a), position(b))).or_default().push([a, b]);
        }
    }
    let mut edges = Vec::new();
    for sides in sides.values() {
        let charts = |side: &[u32; 2]| side.map(|v| chart(&character.vertices[v as usize]));
        let first = charts(&sides[0]);
        let kind = match sides.len() {
            1 => EdgeKind::Border,
            _ if sides.iter().any(|side| charts(side) != first) => EdgeKind::Seam,
            _ => EdgeKind::Inner,
        };
        let drawn = if kind == EdgeKind::Seam { sides.as_slice() } else { &sides[..1] };
        for side in drawn.iter().filter(|side| image_of(character, side[0]) == image) {
            edges.push(UvEdge { kind, ends: side.map(|v| character.vertices[v as usize].uv) });
        }
    }
    // Inner edges first, so that seams lie on top; places in the texture make the order the same everywhere.
    edges.sort_by_key(|edge| (edge.kind, edge.ends.map(|end| end.map(f32::to_bits))));
    edges
}

fn draw_edges(texture: &Texture, size: [u32; 2], edges: &[UvEdge]) -> Drawn {
    let [width, height] = size.map(|side| side * SUPERSAMPLING);
    let mut target = Target::new(width, height, [128, 128, 128, 255]);
    paint_texture(&mut target, texture);
    let scale = Vec2::new(width as f32, height as f32);
    let per_px = SUPERSAMPLING as f32;
    let passes = [
        (EdgeKind::Inner, EDGE_PX, EDGE_COLOR),
        (EdgeKind::Seam, SEAM_PX + 1.2, RIM_COLOR),
        (EdgeKind::Border, SEAM_PX + 1.2, RIM_COLOR),
        (EdgeKind::Seam, SEAM_PX, COMPANION_COLOR),
        (EdgeKind::Border, SEAM_PX, FIXED_COLOR),
    ];
    for (kind, width_px, color) in passes {
        for edge in edges.iter().filter(|edge| edge.kind == kind) {
            for [from, to] in tiles(edge.ends) {
                draw_line(&mut target, from * scale, to * scale, width_px * per_px, color);
            }
        }
    }
    let picture = downsample(&target, SUPERSAMPLING);
    Drawn { jpeg: encode_jpeg(&picture, QUALITY), size, furthest: None }
}

/// The edge moved into the texture's first tile: once, or once for each tile that it reaches into.
fn tiles(ends: [[f32; 2]; 2]) -> Vec<[Vec2; 2]> {
    let [a, b] = ends.map(Vec2::from);
    let (low, high) = (a.min(b).floor(), a.max(b).floor());
    // Differences of finite numbers: infinite at most.
    if (high - low).max_element() > MOST_TILES {
        return Vec::new();
    }
    let mut moved = Vec::new();
    let [columns, rows] = (high - low).to_array().map(|count| count as u32);
    for row in 0..=rows {
        for column in 0..=columns {
            let tile = low + Vec2::new(column as f32, row as f32);
            moved.push([a - tile, b - tile]);
        }
    }
    moved
}

/// The texture over the whole target, a little paler, so that lines stand out.
fn paint_texture(target: &mut Target, texture: &Texture) {
    let Some(mip) = texture.mips.first() else { return };
    for y in 0..target.height {
        for x in 0..target.width {
            let texel_x = (u64::from(x) * u64::from(mip.width) / u64::from(target.width)) as usize;
            let texel_y = (u64::from(y) * u64::from(mip.height) / u64::from(target.height)) as usize;
            let [r, g, b, _] = mip.texels[texel_y * mip.width as usize + texel_x];
            let pale = |channel: u8| ((u32::from(channel) * 3 + 150) / 4) as u8;
            target.color[(y * target.width + x) as usize] = [pale(r), pale(g), pale(b), 255];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_moved_into_the_texture() {
        let [from, to] = tiles([[3.25, -0.75], [3.5, -0.5]])[0];
        assert_eq!((from.to_array(), to.to_array()), ([0.25, 0.25], [0.5, 0.5]));
        assert_eq!(tiles([[0.9, 0.1], [1.1, 0.1]]).len(), 2, "across a border: once on each side");
        assert!(tiles([[0.0, 0.0], [1e9, 0.0]]).is_empty());
        assert!(tiles([[f32::MAX, 0.0], [f32::MIN, 0.0]]).is_empty());
    }
}
