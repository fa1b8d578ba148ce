//! What stands still around a crowd: where a simulator lets people walk, as ground and walls; the steps that seats stand on.

use crowd_scene::{SeatStep, Surface, WalkableArea};
use crowd_stages::SceneryVertex;

/// A little above the tallest: who looks from inside sees no open horizon, and from above the crowd stays visible.
const WALL_M: f32 = 2.4;
/// Linear RGB of the ground people walk on: lighter than the endless plane.
const GROUND: [u8; 3] = [112, 106, 94];
/// Linear RGB of walls.
const WALL: [u8; 3] = [150, 138, 120];
/// Under the soles by this much, as the ground of walkable areas.
const STEP_LIFT_M: f32 = -0.008;
/// A circle's edges lie at most this share of a step's depth inside it.
const ROUND_SHARE: f32 = 0.04;

/// Triangles of one colour a corner.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scenery {
    /// Corners.
    pub vertices: Vec<SceneryVertex>,
    /// Indices of corners, counterclockwise seen from the side that is drawn.
    pub triangles: Vec<[u32; 3]>,
}

impl Scenery {
    /// The ground of an area and walls around it, which are seen from the walkable side alone.
    ///
    /// # Errors
    /// [`crowd_scene::Error`] for an area of too many pieces.
    pub fn of_area(area: &WalkableArea) -> crowd_scene::Result<Self> {
        let mut scenery = Self::default();
        scenery.push(&area.ground()?, GROUND);
        scenery.push(&area.walls(WALL_M), WALL);
        Ok(scenery)
    }

    /// Adds rings of steps: their tops, what one sees of each from the step below, and the back of the last from outside.
    pub fn add_steps(&mut self, steps: &[SeatStep]) {
        let Some(last) = steps.last() else { return };
        // Of a circle cut into n the edges' middles lie r (1 - cos(pi / n)) inside, about r (pi / n)^2 / 2.
        let out = last.outer_m / (ROUND_SHARE * (last.outer_m - last.inner_m).max(1e-3));
        let sides = (std::f32::consts::PI * libm::sqrtf(0.5 * out)).ceil().clamp(48.0, 512.0) as u32;
        let mut below_m = 0.0;
        for step in steps {
            let height_m = step.height_m + STEP_LIFT_M;
            self.add_ring(sides, [(step.inner_m, height_m), (step.outer_m, height_m)], GROUND);
            self.add_ring(sides, [(step.inner_m, below_m), (step.inner_m, height_m)], WALL);
            below_m = height_m;
        }
        self.add_ring(sides, [(last.outer_m, below_m), (last.outer_m, 0.0)], WALL);
    }

    /// A band around the vertical axis between two edges of (radius, height), seen from above where it goes outwards, from inside where it
    /// goes up, from outside where it goes down.
    fn add_ring(&mut self, sides: u32, [near, far]: [(f32, f32); 2], [r, g, b]: [u8; 3]) {
        let (across, up) = (far.0 - near.0, far.1 - near.1);
        let length = libm::hypotf(across, up).max(1e-6);
        for side in 0..sides {
            let at = |turn: u32| libm::sincosf((turn % sides) as f32 / sides as f32 * std::f32::consts::TAU);
            let (from, to) = (at(side), at(side + 1));
            let corner = |(sin, cos): (f32, f32), (radius, height): (f32, f32)| [sin * radius, height, cos * radius];
            let normal = |(sin, cos): (f32, f32)| [-up / length * sin, across / length, -up / length * cos];
            let first = self.vertices.len() as u32;
            let corners = [(from, near), (from, far), (to, far), (to, near)];
            self.vertices.extend(corners.map(|(turn, edge)| SceneryVertex {
                position: corner(turn, edge),
                color: [r, g, b, 255],
                normal: normal(turn),
            }));
            self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }

    fn push(&mut self, surface: &Surface, [r, g, b]: [u8; 3]) {
        let first = self.vertices.len() as u32;
        let corners = surface.positions.iter().zip(&surface.normals);
        self.vertices.extend(corners.map(|(position, normal)| SceneryVertex {
            position: position.to_array(),
            color: [r, g, b, 255],
            normal: normal.to_array(),
        }));
        self.triangles.extend(surface.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn steps() -> Vec<SeatStep> {
        [(4.0, 0.5), (6.0, 1.0)]
            .map(|(inner_m, height_m)| SeatStep { inner_m, outer_m: inner_m + 2.0, height_m })
            .to_vec()
    }

    #[test]
    fn steps_are_seen_from_where_people_look() {
        let mut scenery = Scenery::default();
        scenery.add_steps(&[]);
        assert_eq!(scenery, Scenery::default());
        scenery.add_steps(&steps());
        let mut seen = [0; 3];
        for triangle in &scenery.triangles {
            let [a, b, c] = triangle.map(|corner| Vec3::from(scenery.vertices[corner as usize].position));
            let normal = Vec3::from(scenery.vertices[triangle[0] as usize].normal);
            assert!((b - a).cross(c - a).normalize().dot(normal) > 0.99, "counterclockwise from its front");
            let middle = (a + b + c) / 3.0;
            let outwards = normal.dot(Vec3::new(middle.x, 0.0, middle.z).normalize());
            seen[if normal.y > 0.9 { 0 } else { 1 + usize::from(outwards > 0.0) }] += 1;
        }
        let [tops, risers, back] = seen;
        assert!(tops == 2 * back && risers == 2 * back && back >= 96, "{seen:?}");
    }

    #[test]
    fn steps_are_about_round() {
        let mut scenery = Scenery::default();
        scenery.add_steps(&steps());
        let tops = scenery.triangles.iter().filter(|t| scenery.vertices[t[0] as usize].normal[1] > 0.9);
        for triangle in tops {
            let [a, b, c] = triangle.map(|corner| Vec3::from(scenery.vertices[corner as usize].position));
            for middle in [a + b, b + c, c + a].map(|sum| 0.5 * sum) {
                let out = libm::hypotf(middle.x, middle.z);
                assert!(out > 4.0 - 0.09 && out < 8.001, "{out}");
            }
        }
    }
}
