//! `place_boids` on the GPU against its twin, and against the scene's cast.

use crate::cases::data;
use crate::flocks::{boids, cast, flock, traits_and_movers};
use crowd_scene::Walker;
use crowd_stages::gpu::PlaceBoids;
use crowd_stages::{FlockConfig, InstanceRecord, cpu};
use crowd_tests::gpu;
use crowdplay::simulation::flock_config;

const CLIP_S: f32 = 1.2;

/// Whether two instances show the same: phases go round.
fn shows_the_same(a: &InstanceRecord, b: &InstanceRecord, bound: f32) -> bool {
    let phase = (a.phase_s - b.phase_s).abs();
    let near = |a: f32, b: f32, bound: f32| (a - b).abs() <= bound;
    // A turn's end and the next one's start are a whole displacement apart.
    let wraps = (phase - CLIP_S).abs() < 1e-3;
    let places = a.position.iter().zip(b.position).all(|(a, b)| near(*a, b, if wraps { 2.0 } else { bound }));
    places
        && (phase < 1e-3 || wraps)
        && near(a.yaw_rad, b.yaw_rad, 1e-6)
        && near(a.scale, b.scale, 1e-6)
        && (a.character, a.clip) == (b.character, b.clip)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn instances_are_those_of_the_twin() {
    let (device, _) = gpu::device();
    let stage = PlaceBoids::new(device);
    for count in [0, 1, 1000] {
        let flock = flock(count, 4.0);
        let config = FlockConfig { time_s: 4.0, ..flock_config(&flock) };
        let all = boids(&flock);
        let (traits, movers) = traits_and_movers(count);
        let instances = gpu::output::<InstanceRecord>(all.len());
        let (uniform, records) = (gpu::uniform(&config), gpu::storage(&all));
        let bound = stage.bind(device, &uniform, &records, &gpu::storage(&traits), &gpu::storage(&movers), &instances);
        gpu::run(|pass| stage.record(pass, &bound, count));
        let gpu: Vec<InstanceRecord> = gpu::read(&instances, all.len());
        let cpu = cpu::place_boids(&config, &all, &traits, &movers);
        let differ = gpu.iter().zip(&cpu).find(|(a, b)| !shows_the_same(a, b, 3e-3));
        assert_eq!(differ, None);
        assert!(data().check_instances(&gpu).is_ok());
        let late = cpu::place_boids(&FlockConfig { time_s: 4.3, ..config }, &all, &traits, &movers);
        assert!(count == 0 || gpu.iter().zip(&late).any(|(a, b)| !shows_the_same(a, b, 3e-3)), "another time is seen");
    }
}

#[test]
fn the_twin_casts_as_the_scene_does() {
    let flock = flock(400, 6.0);
    let config = FlockConfig { time_s: 6.0, ..flock_config(&flock) };
    let (traits, movers) = traits_and_movers(400);
    let placed = cpu::place_boids(&config, &boids(&flock), &traits, &movers);
    let mut walkers: Vec<Walker> = Vec::new();
    flock.people(&mut walkers);
    let cast = cast();
    for (walker, placed) in walkers.iter().zip(&placed) {
        let one = cast.instance(walker, 6.0);
        let expected = InstanceRecord {
            position: one.position.to_array(),
            yaw_rad: one.yaw_rad,
            scale: one.scale * cast.movers[one.character as usize].scale,
            character: one.character,
            clip: data().characters[one.character as usize].clip_offset + one.clip,
            phase_s: one.phase_s,
        };
        assert!(shows_the_same(placed, &expected, 1e-4), "{placed:?} is not {expected:?}");
    }
}
