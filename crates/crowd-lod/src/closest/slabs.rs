//! Boxes that lie along their triangles, for meshes of needles.
//!
//! Long thin triangles around one point or on one edge lie side by side, but boxes along the axes of such neighbours hold most of the others: a search
//! looked at a share of all triangles. A box along the middle one of them is as thin as they are together (Gottschalk, Lin and Manocha 1996, *OBBTree*, section 4: the
//! tighter the boxes, the fewer are met). Meshes of other triangles have none, and pay nothing.

use super::{ClosestTriangles, corners_of};
use crate::quadrics::{cross, dot, sub};

/// A mesh is one of needles when the boxes of the leaves are this many times as large as its triangles, and as the box of all.
const BOXES_TO_TRIANGLES: f64 = 64.0;
const BOXES_TO_WHOLE: f64 = 32.0;
/// What rounding may add to a coordinate, as a share of it and of the box's, and to a square, as a share.
const ROUNDING: f32 = 2.0e-6;
const SQUARE_ROUNDING: f32 = 1.0e-4;

/// A box along three axes of its own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slab {
    base: [f32; 3],
    axes: [[f32; 3]; 3],
    low: [f32; 3],
    high: [f32; 3],
}

impl Slab {
    /// A squared distance that no point in it is nearer than.
    #[inline(never)]
    pub fn distance(&self, point: [f32; 3]) -> f32 {
        let offset = sub(point, self.base);
        let size = offset[0].abs() + offset[1].abs() + offset[2].abs();
        let mut squared = 0.0;
        for k in 0..3 {
            let at = dot(self.axes[k], offset);
            let slack = ROUNDING * (size + self.high[k] - self.low[k]);
            let outside = ((self.low[k] - at).max(at - self.high[k]) - slack).max(0.0);
            squared += outside * outside;
        }
        squared * (1.0 - SQUARE_ROUNDING)
    }
}

impl ClosestTriangles {
    /// Whether boxes along the axes are much larger than what is in them.
    pub(super) fn is_of_needles(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> bool {
        let (mut of_boxes, mut of_triangles) = (0.0_f64, 0.0_f64);
        let none = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let mut whole = none;
        let include = |(low, high): &mut ([f32; 3], [f32; 3]), place: [f32; 3]| {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(place[k]), high[k].max(place[k]));
            }
        };
        let area = |(low, high): ([f32; 3], [f32; 3])| {
            let [x, y, z] = sub(high, low);
            f64::from(x * y + y * z + z * x)
        };
        for node in self.nodes.iter().filter(|node| node.second == 0) {
            let mut leaf = none;
            for &t in &self.order[node.start as usize..node.end as usize] {
                let corners = corners_of(triangles[t as usize], positions);
                corners.iter().for_each(|&corner| include(&mut leaf, corner));
                let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
                of_triangles += f64::from(dot(normal, normal).sqrt()) / 2.0;
            }
            of_boxes += area(leaf);
            [leaf.0, leaf.1].into_iter().for_each(|corner| include(&mut whole, corner));
        }
        of_boxes > BOXES_TO_TRIANGLES * of_triangles && of_boxes > BOXES_TO_WHOLE * area(whole)
    }

    /// Fits the boxes along triangles to moved positions.
    pub(super) fn fit_slabs(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) {
        let fit = |node: &super::Node| {
            let below = &self.order[node.start as usize..node.end as usize];
            let [a, b, c] = corners_of(triangles[below[below.len() / 2] as usize], positions);
            let mut slab =
                Slab { base: a, axes: axes_along([a, b, c]), low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };
            for &t in below {
                for corner in corners_of(triangles[t as usize], positions) {
                    let offset = sub(corner, a);
                    for k in 0..3 {
                        let at = dot(slab.axes[k], offset);
                        (slab.low[k], slab.high[k]) = (slab.low[k].min(at), slab.high[k].max(at));
                    }
                }
            }
            slab
        };
        self.slabs = self.nodes.iter().map(fit).collect();
    }
}

/// Along a triangle's longest edge, across it, and along its normal: unit vectors at right angles, whatever the triangle is.
fn axes_along([a, b, c]: [[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let unit = |v: [f32; 3]| {
        let size = v.iter().fold(0.0_f32, |size, c| size.max(c.abs()));
        if !(size > 0.0 && v.iter().all(|c| c.is_finite())) {
            return None;
        }
        let v = v.map(|c| c / size);
        let length = dot(v, v).sqrt();
        Some(v.map(|c| c / length))
    };
    let longest = [sub(b, a), sub(c, b), sub(a, c)]
        .into_iter()
        .max_by(|v, w| dot(*v, *v).total_cmp(&dot(*w, *w)))
        .expect("three edges");
    let Some(along) = unit(longest) else { return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };
    // A thread has no normal: any direction does that is not along it.
    let sides = [unit(sub(b, a)), unit(sub(c, b)), unit(sub(a, c))];
    let across = |from: [f32; 3]| {
        let rest = [0, 1, 2].map(|k| from[k] - dot(from, along) * along[k]);
        (dot(rest, rest) > 1.0e-12).then(|| unit(rest)).flatten()
    };
    let least = (0..3).min_by(|&i, &j| along[i].abs().total_cmp(&along[j].abs())).expect("three coordinates");
    let mut any = [0.0; 3];
    any[least] = 1.0;
    let across_it = sides.into_iter().flatten().find_map(across).or_else(|| across(any)).expect("not all are along it");
    // Once more: what is left of a needle's side is short, and not quite across.
    let across_it = across(across_it).expect("it is across");
    [along, across_it, cross(along, across_it)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closest::triangle_distance_squared;
    use std::f32::consts::TAU;

    /// Needles around one point, on a wavy disc; or pages on one edge.
    fn needles(count: usize, pages: bool) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mut positions = vec![[0.0; 3], [0.0, 0.0, 1.0]];
        let rim = |i: usize| {
            let (sin, cos) = libm::sincosf(i as f32 / count as f32 * TAU);
            [cos, sin, if pages { 0.5 } else { 0.05 * libm::sinf(7.0 * i as f32 / count as f32 * TAU) }]
        };
        positions.extend((0..count).map(rim));
        let at = |i: usize| (i % count + 2) as u32;
        let triangle = |i: usize| if pages { [0, 1, at(i)] } else { [0, at(i), at(i + 1)] };
        (positions, (0..count).map(triangle).collect())
    }

    /// Points just off needles, all over them.
    fn points_near(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
        let point = |i: usize| {
            let [a, b, c] = corners_of(triangles[i * 7919 % triangles.len()], positions);
            let share = 0.2 + 0.8 * (i as f32 * 0.618).fract();
            let middle = [0, 1, 2].map(|k| a[k] + share * ((b[k] + c[k]) / 2.0 - a[k]));
            [middle[0], middle[1], middle[2] + 1.0e-3]
        };
        (0..200).map(point).collect()
    }

    /// Leaves that a search goes to, on average.
    fn leaves_met(tree: &ClosestTriangles, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> usize {
        let points = points_near(positions, triangles);
        let mut met = 0;
        for &point in &points {
            let mut best = f32::INFINITY;
            tree.descend(
                point,
                best,
                |_| true,
                |leaf| {
                    met += 1;
                    let squares = leaf
                        .iter()
                        .map(|&t| triangle_distance_squared(point, corners_of(triangles[t as usize], positions)));
                    best = squares.fold(best, f32::min);
                    best
                },
            );
        }
        met / points.len()
    }

    #[test]
    fn a_search_among_needles_meets_a_few_of_them_however_many_there_are() {
        for count in [8_000, 32_000] {
            let (positions, triangles) = needles(count, false);
            let mut tree = ClosestTriangles::new(&positions, &triangles);
            assert!(tree.needles, "{count}");
            tree.refit(&positions, &triangles);
            let met = leaves_met(&tree, &positions, &triangles);
            assert!(met <= 40, "{met} leaves of {count} triangles");
            // Without, a share of all: the count can tell.
            tree.needles = false;
            let met = leaves_met(&tree, &positions, &triangles);
            assert!(met > count / 100, "{met} leaves of {count} triangles");
        }
    }

    #[test]
    fn needles_are_found_as_trying_all_finds_them() {
        for pages in [false, true] {
            let (rest, triangles) = needles(1_000, pages);
            let mut tree = ClosestTriangles::new(&rest, &triangles);
            // Too few to be worth it, but enough to try it.
            tree.needles = true;
            let bent: Vec<[f32; 3]> = rest.iter().map(|p| [p[0] * 3.0 + 100.0, p[1], p[2] + p[0] * p[0]]).collect();
            for positions in [&rest, &bent] {
                tree.refit(positions, &triangles);
                for point in points_near(positions, &triangles) {
                    let all = triangles.iter().map(|&t| triangle_distance_squared(point, corners_of(t, positions)));
                    let least = all.fold(f32::INFINITY, f32::min);
                    let found = tree.closest(point, positions, &triangles, u32::MAX).expect("a triangle").1;
                    assert!(found <= least * 1.001 + 1.0e-12, "{found} {least}");
                    let hit = tree.closest_point(point, positions, &triangles, None, None).expect("a triangle");
                    assert!((hit.distance_squared - least).abs() <= 0.01 * least + 1.0e-9, "{hit:?} {least}");
                }
            }
        }
    }

    #[test]
    fn a_box_lies_along_any_triangle_and_no_triangle_of_a_body_is_a_needle() {
        let p = [1.0, 2.0, 3.0];
        for triangle in [
            [p, p, p],
            [p, [2.0, 2.0, 3.0], [5.0, 2.0, 3.0]],
            [p, p, [1.0, 2.0, 4.0]],
            [p, [1.0e-20, 0.0, 0.0], [1.0e20, 0.0, 0.0]],
            [p, [4.0, 2.5, 3.0], [4.0, 2.5001, 3.0]],
            [p, [f32::INFINITY, 0.0, 0.0], p],
            [[f32::INFINITY, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0], [f32::INFINITY, 0.0, 1.0]],
            [[f32::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ] {
            let axes = axes_along(triangle);
            for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)] {
                let wanted = if i == j { 1.0 } else { 0.0 };
                assert!((dot(axes[i], axes[j]) - wanted).abs() < 1.0e-6, "{triangle:?} {axes:?}");
            }
        }
        let sphere = crate::test_meshes::uv_sphere(64, 64);
        assert!(!ClosestTriangles::new(&sphere.positions, &sphere.triangles).needles);
    }
}
