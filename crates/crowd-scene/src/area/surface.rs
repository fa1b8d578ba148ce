//! The area as triangles: its ground, and walls around it.

use glam::{DVec2, Vec3};

use super::WalkableArea;
use crate::{Error, Result};

/// Trapezoids of one ground: those of any floor plan, not those of a hostile comb.
const MOST_TRAPEZOIDS: usize = 400_000;
/// A little under the soles, as the endless ground plane is, and above that: nothing flickers.
const GROUND_LIFT_M: f32 = -0.008;

/// Triangles with one normal a vertex, counterclockwise seen from the side that is to be drawn; metres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Unit normals, one a corner.
    pub normals: Vec<Vec3>,
    /// Indices of corners.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// A flat polygon of three or four corners.
    fn push(&mut self, corners: &[Vec3], normal: Vec3) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(corners);
        self.normals.extend(std::iter::repeat_n(normal, corners.len()));
        self.triangles.extend((2..corners.len() as u32).map(|i| [first, first + i - 1, first + i]));
    }
}

impl WalkableArea {
    /// The ground, seen from above.
    ///
    /// Cut into trapezoids between the heights of all corners, by the even-odd rule: holes, several polygons and damaged
    /// rings need no care, and nothing is triangulated that could fail.
    ///
    /// # Errors
    /// [`Error::Content`] past 400,000 trapezoids.
    pub fn ground(&self) -> Result<Surface> {
        let rings = || self.polygons.iter().flat_map(|polygon| &polygon.rings);
        // Every edge from low to high; level ones bound nothing.
        let upwards = |a: DVec2, b: DVec2| if a.y <= b.y { (a, b) } else { (b, a) };
        let mut edges: Vec<(DVec2, DVec2)> =
            rings().flat_map(|ring| edges_of(ring)).map(|(a, b)| upwards(a, b)).filter(|(a, b)| a.y < b.y).collect();
        edges.sort_by(|a, b| a.0.y.total_cmp(&b.0.y));
        let mut heights: Vec<f64> = rings().flatten().map(|point| point.y).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let mut surface = Surface::default();
        let (mut next, mut crossing): (usize, Vec<(DVec2, DVec2)>) = (0, Vec::new());
        let (mut trapezoids, mut looked_at) = (0, 0);
        for slab in heights.windows(2) {
            let (low, high) = (slab[0], slab[1]);
            crossing.retain(|(_, b)| b.y > low);
            while next < edges.len() && edges[next].0.y <= low {
                crossing.push(edges[next]);
                next += 1;
            }
            let mut sides: Vec<(f64, f64)> =
                crossing.iter().map(|&(a, b)| (x_at(a, b, low), x_at(a, b, high))).collect();
            sides.sort_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1)));
            looked_at += sides.len();
            trapezoids += sides.len() / 2;
            if trapezoids > MOST_TRAPEZOIDS || looked_at > 4 * MOST_TRAPEZOIDS {
                return Err(Error::content("walkable area", "too many pieces", format!("at most {MOST_TRAPEZOIDS}")));
            }
            for pair in sides.chunks_exact(2) {
                let ((left_low, left_high), (right_low, right_high)) = (pair[0], pair[1]);
                let at = |x: f64, y: f64| on_ground(DVec2::new(x, y), GROUND_LIFT_M);
                let mut corners = vec![at(left_low, low)];
                if right_low > left_low {
                    corners.push(at(right_low, low));
                }
                corners.push(at(right_high, high));
                if right_high > left_high {
                    corners.push(at(left_high, high));
                }
                surface.push(&corners, Vec3::Y);
            }
        }
        Ok(surface)
    }

    /// A wall `height_m` high on every edge, seen from the walkable side alone: who looks in from outside sees through it.
    pub fn walls(&self, height_m: f32) -> Surface {
        let mut surface = Surface::default();
        for ring in self.polygons.iter().flat_map(|polygon| &polygon.rings) {
            for (a, b) in edges_of(ring) {
                let inwards = (b - a).perp().normalize_or_zero();
                let normal = Vec3::new(inwards.x as f32, 0.0, -inwards.y as f32);
                let corners = [on_ground(b, 0.0), on_ground(a, 0.0), on_ground(a, height_m), on_ground(b, height_m)];
                surface.push(&corners, normal);
            }
        }
        surface
    }
}

fn edges_of(ring: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

fn x_at(a: DVec2, b: DVec2, y: f64) -> f64 {
    a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y))
}

fn on_ground(point: DVec2, height_m: f32) -> Vec3 {
    Vec3::new(point.x as f32, height_m, -point.y as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square metres seen from above, and whether every triangle's winding agrees with its normal.
    fn measure(surface: &Surface) -> (f32, bool) {
        let (mut area, mut agrees) = (0.0, true);
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|i| surface.positions[i as usize]);
            let cross = (b - a).cross(c - a);
            area += 0.5 * cross.y;
            agrees &= cross.dot(surface.normals[triangle[0] as usize]) > 0.0;
        }
        (area, agrees)
    }

    #[test]
    fn the_ground_is_as_large_as_the_area() {
        for text in [
            "POLYGON ((0 18, 0 12, 12 12, 12 0, 18 0, 18 12, 30 12, 30 18, 18 18, 18 30, 12 30, 12 18, 0 18))",
            "POLYGON ((0 0, 9 1, 10 9, 1 10), (3 3, 5 4, 4 6), (6 6, 7 6, 7 8))",
            "MULTIPOLYGON (((0 0, 1 0, 0.5 1)), ((2 0, 4 0, 4 1, 3 0.5, 2 2)))",
        ] {
            let area = WalkableArea::parse(text).expect("good");
            let (found, agrees) = measure(&area.ground().expect("few pieces"));
            assert!((f64::from(found) - area.square_metres()).abs() < 1e-3 * area.square_metres(), "{text}: {found}");
            assert!(agrees, "{text}");
        }
    }

    #[test]
    fn walls_face_those_who_walk() {
        let area = WalkableArea::parse("POLYGON ((0 0, 4 0, 4 4, 0 4), (1 1, 2 1, 2 2, 1 2))").expect("good");
        let walls = area.walls(2.5);
        assert_eq!(walls.triangles.len(), 8 * 2);
        assert!(measure(&walls).1);
        // The outer wall on x = 0 looks to +X, the hole's side on x = 1 to -X, away from the hole.
        let normal_at = |x: f32| {
            let is_there = |i: &usize| walls.triangles[*i].iter().all(|&c| walls.positions[c as usize].x == x);
            let i = (0..walls.triangles.len()).find(is_there).expect("a wall stands there");
            walls.normals[walls.triangles[i][0] as usize]
        };
        assert_eq!((normal_at(0.0), normal_at(1.0)), (Vec3::X, Vec3::NEG_X));
    }

    #[test]
    fn a_hostile_comb_is_refused() {
        let teeth: Vec<String> = (0..9000)
            .map(|i| format!("{i} {}", if i % 2 == 0 { i as f64 * 1e-3 } else { 99.0 + i as f64 * 1e-3 }))
            .collect();
        let area = WalkableArea::parse(&format!("POLYGON (({}))", teeth.join(", "))).expect("a polygon");
        assert!(area.ground().is_err());
    }
}
