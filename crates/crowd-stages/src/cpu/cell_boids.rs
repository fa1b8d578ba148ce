//! In which cell everyone of a flock is.

use crate::{BoidRecord, FlockConfig};

/// Cells of the grid, row by row; outside of it the nearest one.
///
/// Paper: Park & Han 2009 §4 flock by Reynolds' rules on the CPU; a grid that is sorted is how GPUs find neighbours (Green 2008).
/// Twin: `shaders/stages/cell_boids.wgsl`. Equal unless a place lies on a cell's edge.
pub fn cell_boids(flock: &FlockConfig, boids: &[BoidRecord]) -> Vec<u32> {
    let cell = |boid: &BoidRecord| {
        let (column, row) = column_and_row(flock, boid.place);
        row * flock.columns + column
    };
    boids.iter().map(cell).collect()
}

/// Column and row of a place.
pub(super) fn column_and_row(flock: &FlockConfig, place: [f32; 2]) -> (u32, u32) {
    let at = |axis: usize, end: u32| {
        let cell = ((place[axis] - flock.low[axis]) / flock.sight_m).max(0.0) as u32;
        cell.min(end - 1)
    };
    (at(0, flock.columns), at(1, flock.rows))
}
