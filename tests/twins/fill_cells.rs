//! `fill_cells` on the GPU against its twin: equal.

use crate::cases::first_difference;
use crate::flocks::{boids, flock};
use crowd_stages::gpu::FillCells;
use crowd_stages::{SortedBoid, cpu};
use crowd_tests::gpu;
use crowdplay::simulation::flock_config;

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn starts_and_copies_are_equal_also_with_more_cells_than_boids() {
    let (device, _) = gpu::device();
    let stage = FillCells::new(device);
    for (count, time_s) in [(0, 0.0), (1, 0.0), (300, 3.0), (20_000, 0.0)] {
        let flock = flock(count, time_s);
        let (config, all) = (flock_config(&flock), boids(&flock));
        let (cells, numbers) = cpu::sort_instances(&cpu::cell_boids(&config, &all));
        let cell_count = config.columns * config.rows;
        let starts = gpu::output::<u32>(cell_count as usize + 1);
        let sorted = gpu::output::<SortedBoid>(all.len());
        let (uniform, records) = (gpu::uniform(&config), gpu::storage(&all));
        let (cells_in, numbers_in) = (gpu::storage(&cells), gpu::storage(&numbers));
        let bound = stage.bind(device, &uniform, &records, &cells_in, &numbers_in, &starts, &sorted);
        gpu::run(|pass| stage.record(pass, &bound, count, cell_count));
        let expected = cpu::fill_cells(&config, &all, &cells, &numbers);
        assert_eq!(first_difference(&gpu::read(&starts, cell_count as usize + 1), &expected.0), None, "{count} boids");
        assert_eq!(first_difference(&gpu::read(&sorted, all.len()), &expected.1), None, "{count} boids");
    }
}

#[test]
fn everyone_is_in_one_cell_and_a_moved_start_is_seen() {
    let flock = flock(500, 2.0);
    let (config, all) = (flock_config(&flock), boids(&flock));
    let (cells, numbers) = cpu::sort_instances(&cpu::cell_boids(&config, &all));
    let (starts, sorted) = cpu::fill_cells(&config, &all, &cells, &numbers);
    assert_eq!((starts[0], starts[starts.len() - 1], sorted.len()), (0, 500, 500));
    assert!(starts.windows(2).all(|pair| pair[0] <= pair[1]));
    let mut moved = starts.clone();
    moved[starts.len() / 2] += 1;
    assert!(first_difference(&moved, &starts).is_some());
}
