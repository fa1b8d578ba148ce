//! `steer_boids` on the GPU against its twin: within [`cpu::STEER_BOUND`], but where a distance lies on a rule's edge.

use crate::flocks::{boids, filled, flock};
use crowd_stages::gpu::SteerBoids;
use crowd_stages::{BoidRecord, FlockConfig, cpu};
use crowd_tests::gpu;
use crowdplay::simulation::flock_config;

fn on_gpu(config: &FlockConfig, all: &[BoidRecord]) -> Vec<BoidRecord> {
    let (device, _) = gpu::device();
    let stage = SteerBoids::new(device);
    let (starts, numbers, sorted) = filled(config, all);
    let records = gpu::storage(all);
    let (uniform, numbers) = (gpu::uniform(config), gpu::storage(&numbers));
    let bound = stage.bind(device, &uniform, &numbers, &gpu::storage(&sorted), &gpu::storage(&starts), &records);
    gpu::run(|pass| stage.record(pass, &bound, all.len() as u32));
    gpu::read(&records, all.len())
}

fn by_twin(config: &FlockConfig, all: &[BoidRecord]) -> Vec<BoidRecord> {
    let (starts, numbers, sorted) = filled(config, all);
    cpu::steer_boids(config, all, &starts, &numbers, &sorted)
}

/// Boids that are apart by more than the bound, or in another gait.
fn apart(gpu: &[BoidRecord], cpu: &[BoidRecord]) -> usize {
    let near = |a: f32, b: f32| (a - b).abs() <= cpu::STEER_BOUND;
    let same = |(a, b): &(&BoidRecord, &BoidRecord)| {
        let turned = (a.yaw_rad - b.yaw_rad).abs();
        near(a.place[0], b.place[0])
            && near(a.place[1], b.place[1])
            && near(a.velocity[0], b.velocity[0])
            && near(a.velocity[1], b.velocity[1])
            && near(a.walked_m, b.walked_m)
            && (turned <= 1e-3 || (turned - std::f32::consts::TAU).abs() <= 1e-3)
            && near(a.ran_m, b.ran_m)
            && near(a.changed_s, b.changed_s)
            && (a.pace_m_s, a.gait, a.gait_before) == (b.pace_m_s, b.gait, b.gait_before)
    };
    gpu.iter().zip(cpu).filter(|pair| !same(pair)).count()
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_step_is_the_same_within_roundings() {
    for (count, time_s) in [(0, 0.0), (1, 1.0), (64, 20.0), (3000, 0.0), (3000, 10.0)] {
        let flock = flock(count, time_s);
        let (config, all) = (flock_config(&flock), boids(&flock));
        let (gpu, cpu) = (on_gpu(&config, &all), by_twin(&config, &all));
        assert!(apart(&gpu, &cpu) <= count as usize / 500, "{} of {count}", apart(&gpu, &cpu));
        if count == 3000 {
            let narrow: Vec<BoidRecord> = all.iter().map(|boid| BoidRecord { wider_m: 0.0, ..*boid }).collect();
            let seen = apart(&gpu, &by_twin(&config, &narrow));
            assert!(seen > 300, "other bodies are seen in {seen} of {count}");
            let other = FlockConfig { alignment: config.alignment * 1.5, ..config };
            let seen = apart(&gpu, &by_twin(&other, &all));
            assert!(seen > 300, "another rule is seen in {seen} of {count}");
        }
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn two_in_one_spot_part() {
    let config = flock_config(&flock(2, 0.0));
    let one = BoidRecord { velocity: [0.0, 1.0], pace_m_s: 1.0, gait: 1, gait_before: 1, ..Default::default() };
    let (gpu, cpu) = (on_gpu(&config, &[one, one]), by_twin(&config, &[one, one]));
    assert_eq!(apart(&gpu, &cpu), 0, "{gpu:?} against {cpu:?}");
    assert!(gpu[0].place[0] != gpu[1].place[0]);
}
