//! `place_boids` on the GPU against its twin, and against the scene's cast.

use crate::cases::data;
use crate::flocks::{boids, cast, flock, traits_and_movers};
use crowd_scene::{Gait, Walker};
use crowd_stages::gpu::PlaceBoids;
use crowd_stages::{FlockConfig, InstanceRecord, cpu};
use crowd_tests::gpu;
use crowdplay::simulation::flock_config;

const CLIP_S: f32 = 1.2;

/// Whether two instances show the same: phases go round.
fn shows_the_same(a: &InstanceRecord, b: &InstanceRecord, bound: f32) -> bool {
    let near = |a: f32, b: f32, bound: f32| (a - b).abs() <= bound;
    // A turn's end and the next one's start are a whole displacement apart.
    let around = |a: f32, b: f32| near((a - b).abs(), CLIP_S, 1e-3);
    let fades = a.leaving_share > 0.0;
    let wraps = around(a.phase_s, b.phase_s) || (fades && around(a.leaving_phase_s, b.leaving_phase_s));
    let same_phase = |a: f32, b: f32| near(a, b, 1e-3) || around(a, b);
    let same_fade = !fades || (a.leaving_clip == b.leaving_clip && same_phase(a.leaving_phase_s, b.leaving_phase_s));
    let places = a.position.iter().zip(b.position).all(|(a, b)| near(*a, b, if wraps { 2.0 } else { bound }));
    places
        && same_phase(a.phase_s, b.phase_s)
        && same_fade
        && near(a.leaving_share, b.leaving_share, 1e-5)
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
        let config = FlockConfig { time_s: 4.0, fade_s: cast().fade_s, ..flock_config(&flock) };
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
        let mut even = movers.clone();
        even.iter_mut().flat_map(|mover| &mut mover.clips).for_each(|clip| clip.root_path_m = Default::default());
        let even = cpu::place_boids(&config, &all, &traits, &even);
        assert!(
            count < 2 || gpu.iter().zip(&even).any(|(a, b)| !shows_the_same(a, b, 3e-3)),
            "root paths are gone along"
        );
        let late = cpu::place_boids(&FlockConfig { time_s: 4.3, ..config }, &all, &traits, &movers);
        assert!(count == 0 || gpu.iter().zip(&late).any(|(a, b)| !shows_the_same(a, b, 3e-3)), "another time is seen");
    }
}

#[test]
fn the_twin_casts_as_the_scene_does() {
    let flock = flock(400, 6.0);
    let config = FlockConfig { time_s: 6.0, fade_s: cast().fade_s, ..flock_config(&flock) };
    let (traits, movers) = traits_and_movers(400);
    let (mut all, mut walkers): (_, Vec<Walker>) = (boids(&flock), Vec::new());
    flock.people(&mut walkers);
    // Some have just ceased to run.
    for (boid, walker) in all.iter_mut().zip(&mut walkers).step_by(5) {
        (boid.gait_before, boid.changed_s) = (2, 0.1);
        (walker.gait_before, walker.changed_s) = (Gait::Run, 0.1);
    }
    let placed = cpu::place_boids(&config, &all, &traits, &movers);
    let cast = cast();
    assert!(placed.iter().any(|one| one.leaving_share > 0.0), "someone fades");
    for (walker, placed) in walkers.iter().zip(&placed) {
        let one = cast.instance(walker, 6.0);
        let expected = InstanceRecord {
            position: one.position.to_array(),
            yaw_rad: one.yaw_rad,
            scale: one.scale * cast.movers[one.character as usize].scale,
            character: one.character,
            clip: data().characters[one.character as usize].clip_offset + one.clip,
            phase_s: one.phase_s,
            leaving_clip: data().characters[one.character as usize].clip_offset + one.leaving.clip,
            leaving_phase_s: one.leaving.phase_s,
            leaving_share: one.leaving.share,
            held_s: 0.0,
        };
        assert!(shows_the_same(placed, &expected, 1e-4), "{placed:?} is not {expected:?}");
    }
}
