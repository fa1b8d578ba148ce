//! A flock to run the stages on, and the whole of it: on the GPU, by the twins, and as the scene has it.

use crate::cases::data;
use crowd_scene::{Cast, Flock, FlockRules, Mover};
use crowd_stages::gpu::GpuFlock;
use crowd_stages::{BoidRecord, BoidTraits, FlockConfig, InstanceRecord, MoverRecord, SortedBoid, cpu};
use crowd_tests::gpu;
use crowdplay::simulation::{boid_record, boid_traits, flock_config, mover_record};

/// A flock after some seconds, by the scene.
pub fn flock(count: u32, time_s: f32) -> Flock {
    // Some are animals, wider than a person.
    let radius_m = |number: u32| if number.is_multiple_of(5) { 0.9 } else { 0.3 };
    let mut flock = Flock::of_bodies(count, 7, FlockRules::default(), radius_m);
    flock.advance_to(time_s);
    flock
}

pub fn boids(flock: &Flock) -> Vec<BoidRecord> {
    flock.boids().iter().map(boid_record).collect()
}

/// The twins' cells of a flock, sorted and filled: starts, numbers, copies.
pub fn filled(config: &FlockConfig, boids: &[BoidRecord]) -> (Vec<u32>, Vec<u32>, Vec<SortedBoid>) {
    let (cells, numbers) = cpu::sort_instances(&cpu::cell_boids(config, boids));
    let (starts, sorted) = cpu::fill_cells(config, boids, &cells, &numbers);
    (starts, numbers, sorted)
}

/// A root path, metres.
const SWAY: [[f32; 2]; 5] = [[0.0, 0.0], [0.05, 0.1], [0.0, 0.02], [-0.05, -0.1], [0.0, 0.0]];

/// A cast of the barrels: the first clip stands and walks, the second runs; one of them moves by itself.
pub fn cast() -> Cast {
    let clip = |clip: u32, speed: f32, moved: f32| crowd_scene::GaitClip {
        clip,
        duration_s: 1.2,
        ground_speed_m_s: speed,
        displacement_m: glam::Vec3::new(0.1, 0.0, moved),
        // Walks and runs sway a little.
        root_path: crowd_scene::RootPath::of(if speed > 0.0 { &SWAY } else { &[] }),
    };
    let mover = |moved: f32| Mover {
        clips: [clip(0, 0.0, 0.0), clip(0, 1.2, moved), clip(1, 2.5, 0.0)],
        scale: 0.9,
        run_ahead_turns: 0.2,
    };
    Cast { movers: vec![mover(0.0), mover(1.4), mover(0.0)], seed: 5, fade_s: 0.4 }
}

pub fn traits_and_movers(count: u32) -> (Vec<BoidTraits>, Vec<MoverRecord>) {
    let cast = cast();
    let traits = (0..count).map(|id| boid_traits(&cast.traits_of(id))).collect();
    let movers = (0..3).map(|character| mover_record(data(), &cast.movers[character as usize], character)).collect();
    (traits, movers)
}

/// The farthest that anyone of one flock is from where the other has them, metres.
fn farthest(a: &[BoidRecord], b: &[BoidRecord]) -> f32 {
    let apart = |(a, b): (&BoidRecord, &BoidRecord)| {
        let [x, z] = [a.place[0] - b.place[0], a.place[1] - b.place[1]];
        (x * x + z * z).sqrt()
    };
    a.iter().zip(b).map(apart).fold(0.0, f32::max)
}

#[test]
fn the_twins_follow_the_scenes_rules() {
    for count in [0, 1, 2, 700] {
        let mut scene = flock(count, 0.0);
        let config = flock_config(&scene);
        let mut now = boids(&scene);
        for _ in 0..60 {
            let (starts, numbers, sorted) = filled(&config, &now);
            now = cpu::steer_boids(&config, &now, &starts, &numbers, &sorted);
        }
        scene.advance_to(60.5 / 30.0);
        assert_eq!(now, boids(&scene), "{count} boids");
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_flock_on_the_gpu_goes_where_the_scenes_flock_goes_and_the_same_every_time() {
    let (device, queue) = gpu::device();
    let count = 3000;
    let start = flock(count, 0.0);
    let (traits, movers) = traits_and_movers(count);
    let new = || GpuFlock::new(device, queue, flock_config(&start), &boids(&start), &traits, &movers).expect("it fits");
    let (mut one, mut other) = (new(), new());
    one.advance_to(device, queue, 30, 1.0);
    let after_a_second: Vec<BoidRecord> = gpu::read(one.boids(), count as usize);
    let scene = boids(&flock(count, 30.5 / 30.0));
    // A neighbour on the edge of sight may count here and not there, and then ways part slowly.
    let apart = farthest(&after_a_second, &scene);
    assert!(apart < 0.02, "{apart} m");
    assert!(farthest(&after_a_second, &boids(&start)) > 0.5, "they went somewhere");
    // Forwards in other strides, and back by a new start.
    for steps in [7, 30, 100, 30] {
        other.advance_to(device, queue, steps, 1.0);
    }
    let again: Vec<BoidRecord> = gpu::read(other.boids(), count as usize);
    assert_eq!(after_a_second, again);
    let instances = one.read_instances(device, queue).expect("it can be read");
    let same: Vec<InstanceRecord> = gpu::read(other.instances(), count as usize);
    assert_eq!(instances, same);
    assert!(data().check_instances(&instances).is_ok());
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_does_not_fit_together_is_refused() {
    let (device, queue) = gpu::device();
    let start = flock(4, 0.0);
    let (traits, movers) = traits_and_movers(4);
    let (config, good) = (flock_config(&start), boids(&start));
    let refused = |config: FlockConfig, boids: &[BoidRecord], traits: &[BoidTraits]| {
        GpuFlock::new(device, queue, config, boids, traits, &movers).err().map(|error| error.to_string())
    };
    assert_eq!(refused(config, &good, &traits), None);
    assert!(refused(config, &good, &traits[1..]).is_some());
    assert!(refused(config, &good, &[BoidTraits { mover: 3, ..traits[0] }; 4]).is_some());
    assert!(refused(config, &[BoidRecord { gait: 3, ..good[0] }; 4], &traits).is_some());
    assert!(refused(config, &[BoidRecord { place: [f32::NAN, 0.0], ..good[0] }; 4], &traits).is_some());
    assert!(refused(FlockConfig { sight_m: 2.0, ..config }, &good, &traits).is_some(), "the widest are seen too late");
    assert!(refused(config, &[BoidRecord { wider_m: f32::NAN, ..good[0] }; 4], &traits).is_some());
    assert!(refused(config, &[BoidRecord { wider_m: -0.1, ..good[0] }; 4], &traits).is_some());
    let slow_first = [config.speed_m_s[1], config.speed_m_s[0]];
    for rules in [
        FlockConfig { cohesion: f32::NAN, ..config },
        FlockConfig { low: [0.0, f32::INFINITY], ..config },
        FlockConfig { speed_m_s: slow_first, ..config },
        FlockConfig { speed_m_s: [-1.0, 1.0], ..config },
        FlockConfig { step_s: 0.0, ..config },
        FlockConfig { fade_s: -1.0, ..config },
    ] {
        assert!(refused(rules, &good, &traits).is_some(), "{rules:?}");
    }
    assert!(refused(config, &good, &[BoidTraits { scale: f32::NAN, ..traits[0] }; 4]).is_some());
    for columns in [0, u32::MAX] {
        assert!(refused(FlockConfig { columns, rows: 2, ..config }, &good, &traits).is_some());
    }
}
