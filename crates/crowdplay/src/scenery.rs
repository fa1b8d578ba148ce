//! What stands still around a crowd: where a simulator lets people walk, as ground and walls.

use crowd_scene::{Surface, WalkableArea};
use crowd_stages::SceneryVertex;

/// A little above the tallest: who looks from inside sees no open horizon, and from above the crowd stays visible.
const WALL_M: f32 = 2.4;
/// Linear RGB of the ground people walk on: lighter than the endless plane.
const GROUND: [u8; 3] = [112, 106, 94];
/// Linear RGB of walls.
const WALL: [u8; 3] = [150, 138, 120];

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
