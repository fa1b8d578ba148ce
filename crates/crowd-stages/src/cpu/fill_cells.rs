//! Where each cell's boids begin, and their places side by side.

use crate::{BoidRecord, FlockConfig, SortedBoid};

/// First entry of each cell in the sorted list, and the end; and what neighbours need to know, in that list's order.
///
/// `sorted_cells` and `sorted_numbers`: of [`super::sort_instances`] over [`super::cell_boids`].
///
/// Twin: `shaders/stages/fill_cells.wgsl`. Equal.
pub fn fill_cells(
    flock: &FlockConfig,
    boids: &[BoidRecord],
    sorted_cells: &[u32],
    sorted_numbers: &[u32],
) -> (Vec<u32>, Vec<SortedBoid>) {
    let first_of = |cell: u32| sorted_cells.partition_point(|other| *other < cell) as u32;
    let starts = (0..=flock.columns * flock.rows).map(first_of).collect();
    let copy = |number: &u32| {
        let BoidRecord { place, velocity, wider_m, .. } = boids[*number as usize];
        SortedBoid { place, velocity, wider_m, reserved: 0 }
    };
    (starts, sorted_numbers.iter().map(copy).collect())
}
