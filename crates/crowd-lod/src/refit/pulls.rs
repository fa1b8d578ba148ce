//! What the fit makes least, besides the distance: textures that slide, and triangles that tilt.

use super::full_detail::FullDetail;
use super::pairs::Pair;
use super::shape::{Shape, transform};
use crate::attributes::COLOR_SHARE;
use crate::behind::diagonal;
use crate::criteria::uv_area;
use crate::quadrics::{cross, dot, sub};
use crate::{LodMesh, Mat3x4};
use rayon::prelude::*;

/// What a squared slide of the texture counts next to a squared distance where the texture is plain, or nobody looked at it.
const TEXTURE_SHARE: f64 = 0.02;
/// What a change of the shown colour costs as a distance, relative to what it costs in the collapse.
const COLOR_FACTOR: f64 = 2.0;
/// What the colours may add to a slide's share at most: single edges in a picture are no reason to leave the surface.
const MOST_COLOR_SHARE: f64 = 0.3;
/// What the squared rise of an edge over full detail's plane counts.
pub(crate) const TILT_SHARE: f64 = 0.02;
/// The same where faces are shaded by their own normals: there tilts are all that is seen.
pub(crate) const FLAT_TILT_SHARE: f64 = 0.16;
/// Rise, in mean edges of the level, at which a tilt of a flat face counts by its square as all others do: larger ones count by
/// their size, so that few faces are off and not all a little. Rises well below [`NARROW_RISE`] of it count by their square after all.
const FLAT_RISE: f64 = 0.1;
const NARROW_RISE: f64 = 0.1;
/// What a squared distance between rims counts next to one between surfaces, half an edge wide.
pub(crate) const RIM_SHARE: f64 = 0.05;
/// Cosine between faces below which their tilt tells nothing.
const SAME_SIDE_COS: f32 = 0.3;

/// Where, along full detail's surface, a pair's point of the level belongs by its texture coordinate, from where it touches.
/// `None` where charts differ, and where that is too far away to
/// be told by this triangle.
pub(crate) fn slide(full: &FullDetail<'_>, uvs: &[[f32; 2]; 3], pair: &Pair) -> Option<[f32; 3]> {
    if full.charts.of_triangle[pair.triangle as usize] != full.charts.of_triangle[pair.full_triangle as usize] {
        return None;
    }
    let there = full.uv_at(pair);
    let w = pair.weights;
    let off = [0, 1].map(|i| uvs[0][i] * w[0] + uvs[1][i] * w[1] + uvs[2][i] * w[2] - there[i]);
    let at = full.triangles[pair.full_triangle as usize].map(|v| full.mesh.uvs[v as usize]);
    let (u, v) = ([at[1][0] - at[0][0], at[1][1] - at[0][1]], [at[2][0] - at[0][0], at[2][1] - at[0][1]]);
    let area = u[0] * v[1] - u[1] * v[0];
    let corners = full.corners_at(pair);
    let (e, f) = (sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let (a, b) = ((off[0] * v[1] - off[1] * v[0]) / area, (u[0] * off[1] - u[1] * off[0]) / area);
    let slide = [0, 1, 2].map(|i| a * e[i] + b * f[i]);
    let longest = dot(e, e).max(dot(f, f));
    let length = dot(slide, slide);
    (length.is_finite() && length < longest).then_some(slide)
}

/// What the difference between black and white costs, as a distance, metres.
pub(crate) fn color_metres(mesh: &LodMesh<'_>) -> f64 {
    COLOR_FACTOR * COLOR_SHARE * f64::from(diagonal(mesh.positions))
}

/// What a squared slide counts in each triangle, next to a squared distance: a little everywhere, and as much as the colours
/// change along it where the caller knows them. `sources`: the triangle of `mesh` that each one is.
pub(crate) fn slide_shares(mesh: &LodMesh<'_>, triangles: &[[u32; 3]], sources: &[u32]) -> Vec<f64> {
    let color_metres = color_metres(mesh);
    let double_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let n = cross(sub(b, a), sub(c, a));
        f64::from(dot(n, n)).sqrt()
    };
    let double_uv_area = |t: &[u32; 3]| uv_area(t.map(|v| mesh.uvs[v as usize].map(f64::from))).abs();
    let share = |(triangle, &source): (&[u32; 3], &u32)| {
        let contrast = mesh.appearance.triangle_contrast.get(source as usize).map_or(0.0, |&c| f64::from(c));
        let metres_per_unit = contrast * color_metres;
        let colors = metres_per_unit * metres_per_unit * double_uv_area(triangle) / double_area(triangle);
        TEXTURE_SHARE + if colors.is_finite() { colors.min(MOST_COLOR_SHARE) } else { 0.0 }
    };
    triangles.iter().zip(sources).map(share).collect()
}

/// What is made least: squared distances, slides of the texture, and tilts of the triangles; a mean over both sides.
pub(crate) fn objective(
    full: &FullDetail<'_>,
    shape: &Shape,
    corner_uvs: &[[[f32; 2]; 3]],
    matrices: &[Vec<Mat3x4>],
    pairs: &[Pair],
) -> f64 {
    let one = |pair: &Pair| {
        let slide = slide(full, &corner_uvs[pair.triangle as usize], pair).map_or(0.0, |s| f64::from(dot(s, s)));
        let corners = shape.triangles[pair.triangle as usize];
        let places = shape.corner_places(pair.triangle as usize).map(|p| shape.places[p]);
        let tilt = tilts(full, pair, corners, places, matrices)
            .map_or(0.0, |(_, rises)| tilt_cost(full, shape, pair, mean_square(rises)));
        f64::from(pair.share)
            * (f64::from(dot(pair.offset, pair.offset))
                + full.slide_shares[pair.full_triangle as usize] * slide
                + full.tilt_shares[pair.full_triangle as usize] * tilt)
    };
    let parts: Vec<f64> = pairs.par_chunks(4096).map(|chunk| chunk.iter().map(one).sum()).collect();
    parts.iter().sum::<f64>() / 2.0
}

/// Mean square of the rises of a triangle's edges.
pub(crate) fn mean_square(rises: [f64; 3]) -> f64 {
    rises.iter().map(|rise| rise * rise).sum::<f64>() / 3.0
}

/// What a tilt costs, m². `squared`: mean square of the rises.
fn tilt_cost(full: &FullDetail<'_>, shape: &Shape, pair: &Pair, squared: f64) -> f64 {
    if !counts_by_size(full, shape, pair) {
        return squared;
    }
    let (unit, rise) = (FLAT_RISE * shape.mean_edge, squared.sqrt());
    let narrow = NARROW_RISE * unit;
    2.0 * unit * (rise - narrow * libm::log(1.0 + rise / narrow))
}

/// The same as a weight of the square.
pub(crate) fn tilt_heed(full: &FullDetail<'_>, shape: &Shape, pair: &Pair, squared: f64) -> f64 {
    let unit = FLAT_RISE * shape.mean_edge;
    if counts_by_size(full, shape, pair) { unit / (squared.sqrt() + NARROW_RISE * unit) } else { 1.0 }
}

fn counts_by_size(full: &FullDetail<'_>, shape: &Shape, pair: &Pair) -> bool {
    shape.mean_edge > 0.0 && full.is_flat(pair.full_triangle)
}

/// Full detail's unit normal at a pair, and how far each edge of the level's triangle rises along it, metres. `None` where the
/// two do not look the same way.
pub(crate) fn tilts(
    full: &FullDetail<'_>,
    pair: &Pair,
    corners: [u32; 3],
    places: [[f32; 3]; 3],
    matrices: &[Vec<Mat3x4>],
) -> Option<([f32; 3], [f64; 3])> {
    let [a, b, c] = full.corners_at(pair);
    let n = cross(sub(b, a), sub(c, a));
    let length = dot(n, n).sqrt();
    let posed = [0, 1, 2].map(|k| transform(&matrices[pair.frame as usize][corners[k] as usize], places[k]));
    let own = cross(sub(posed[1], posed[0]), sub(posed[2], posed[0]));
    let same_side = length > f32::MIN_POSITIVE && dot(own, n) > SAME_SIDE_COS * length * dot(own, own).sqrt();
    let n = n.map(|c| c / length);
    same_side.then(|| (n, [0, 1, 2].map(|k| f64::from(dot(n, sub(posed[(k + 1) % 3], posed[k]))))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refit::pairs::Contact;
    use crate::test_meshes::{TestPoses, grid, quick};
    use crate::{Appearance, level_mesh, simplify};

    #[test]
    fn tilts_of_flat_faces_count_by_their_size_and_weights_are_slopes() {
        let mesh = grid(2, 2, |_, _| 0.0, |_, _| false);
        for flat in [true, false] {
            let appearance = Appearance { flat_materials: &[flat], ..Appearance::default() };
            let lod_mesh = LodMesh { appearance, ..mesh.mesh() };
            let poses = TestPoses::rest();
            let order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
            let full = FullDetail::new(&lod_mesh, &poses.poses(), &order, 1);
            let shape = Shape::new(&level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail")));
            let (frame, triangle, full_triangle) = (0, 0, 0);
            let (weights, full_weights, offset) = ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]);
            let contact = Contact::Corner;
            let pair = Pair { frame, triangle, weights, full_triangle, full_weights, offset, contact, share: 1.0 };
            let cost = |squared| tilt_cost(&full, &shape, &pair, squared);
            for rise in [0.001, 0.1, 2.0] {
                let squared = rise * rise;
                let slope = (cost(squared * 1.001) - cost(squared * 0.999)) / (squared * 0.002);
                let heed = tilt_heed(&full, &shape, &pair, squared);
                assert!((slope / heed - 1.0).abs() < 1.0e-3, "{flat} {rise}: {slope} {heed}");
            }
            let growth = cost(4.0) / cost(1.0);
            assert!(if flat { growth < 2.2 } else { growth == 4.0 }, "{flat}: {growth}");
        }
    }
}
