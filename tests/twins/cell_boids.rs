//! `cell_boids` on the GPU against its twin: equal unless a place lies on a cell's edge.

use crate::cases::first_difference;
use crate::flocks::{boids, flock};
use crowd_stages::gpu::CellBoids;
use crowd_stages::{BoidRecord, FlockConfig, cpu};
use crowd_tests::gpu;
use crowdplay::simulation::flock_config;

fn on_gpu(config: &FlockConfig, boids: &[BoidRecord]) -> Vec<u32> {
    let (device, _) = gpu::device();
    let stage = CellBoids::new(device);
    let cells = gpu::output::<u32>(boids.len());
    let bound = stage.bind(device, &gpu::uniform(config), &gpu::storage(boids), &cells);
    gpu::run(|pass| stage.record(pass, &bound, boids.len() as u32));
    gpu::read(&cells, boids.len())
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn cells_are_equal_inside_and_outside_the_grid() {
    for (count, time_s) in [(0, 0.0), (1, 0.0), (300, 5.0), (70_000, 0.0)] {
        let flock = flock(count, time_s);
        let config = flock_config(&flock);
        let mut all = boids(&flock);
        let far = [[-1e9, 0.1], [0.1, 1e9], [1e9, -1e9], [f32::MAX, f32::MIN]];
        all.extend(far.map(|place| BoidRecord { place, ..Default::default() }));
        let config = FlockConfig { boid_count: all.len() as u32, ..config };
        let cells = on_gpu(&config, &all);
        assert_eq!(first_difference(&cells, &cpu::cell_boids(&config, &all)), None, "{count} boids");
        assert!(cells.iter().all(|cell| *cell < config.columns * config.rows));
        let other = FlockConfig { sight_m: 2.9, ..config };
        assert!(count < 300 || cells != cpu::cell_boids(&other, &all), "other cells are seen");
    }
}
