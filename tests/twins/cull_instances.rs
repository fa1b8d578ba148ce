//! `cull_instances` on the GPU against its twin.

use crate::cases::{Case, case, cases, close};
use crowd_stages::{CullRecord, Weight, cpu, gpu::CullInstances};
use crowd_tests::gpu;

fn on_gpu(case: &Case) -> Vec<CullRecord> {
    let stage = CullInstances::new(&gpu::device().0);
    let culled = gpu::output::<CullRecord>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.characters),
        &gpu::storage(&case.data.clips),
        &culled,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&culled, case.instances.len())
}

/// Whether the instance's sphere touches a plane so closely that rounding decides.
fn is_borderline(case: &Case, i: usize) -> bool {
    let (center, radius) = cpu::world_sphere(case.data, &case.instances[i]);
    case.config.planes.iter().any(|plane| {
        let plane = glam::Vec4::from_array(*plane);
        let size = center.length() + plane.w.abs() + radius;
        (plane.truncate().dot(center) + plane.w + radius).abs() <= cpu::PLANE_BOUND_M * size
    })
}

fn difference(case: &Case, gpu: &[CullRecord], cpu: &[CullRecord]) -> Option<String> {
    let agrees = |i: usize| {
        let (a, b) = (gpu[i], cpu[i]);
        if a.visible != b.visible {
            return is_borderline(case, i);
        }
        let bound = cpu::FLOAT_BOUND;
        close(a.weight, b.weight, bound)
            && close(a.area_px2, b.area_px2, bound)
            && close(a.distance_m, b.distance_m, bound)
    };
    let place = (0..cpu.len()).find(|&i| !agrees(i))?;
    Some(format!("instance {place}: {:?} on the GPU, {:?} on the CPU", gpu[place], cpu[place]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn culling_agrees_for_all_sizes_and_both_weights() {
    for case in cases().chain([case(1000, 30, Weight::AreaDistance)]) {
        let expected = cpu::cull_instances(case.data, &case.instances, &case.config);
        assert_eq!(difference(&case, &on_gpu(&case), &expected), None, "{} instances", case.count());
    }
}

#[test]
fn a_changed_record_is_seen() {
    let case = case(64, 30, Weight::Area);
    let expected = cpu::cull_instances(case.data, &case.instances, &case.config);
    let seen = expected.iter().position(|cull| cull.visible != 0).expect("some are seen");
    let mut changed = expected.clone();
    changed[seen].weight *= 1.001;
    assert!(difference(&case, &changed, &expected).is_some());
    changed[seen] = CullRecord::default();
    assert!(difference(&case, &changed, &expected).is_some());
}

#[test]
fn spheres_that_only_touch_the_frustum_are_kept_and_distant_ones_are_not() {
    let mut case = case(1, 30, Weight::Area);
    let (_, radius) = cpu::world_sphere(case.data, &case.instances[0]);
    let eye = glam::Vec3::from_array(case.config.eye);
    let near_plane = glam::Vec4::from_array(case.config.planes[4]);
    let on_the_plane = eye - near_plane.truncate() * (near_plane.truncate().dot(eye) + near_plane.w);
    let behind = |metres: f32| (on_the_plane - near_plane.truncate() * metres).to_array();
    let center = case.data.clips[case.instances[0].clip as usize].sphere[1] * case.instances[0].scale;
    let mut visible = |metres: f32| {
        case.instances[0].position = behind(metres);
        case.instances[0].position[1] -= center;
        cpu::cull_instances(case.data, &case.instances, &case.config)[0].visible != 0
    };
    assert!(visible(radius * 0.9));
    assert!(!visible(radius * 1.2));
}
