//! `cull_by_depth` on the GPU against its twin: equal but where a plane or a threshold is touched.

use crate::cases::{Case, buckets, case, cases, data};
use crowd_stages::{FrameConfig, Weight, cpu, discrete_config, gpu::CullByDepth};
use crowd_tests::gpu;
use glam::{Mat4, Vec4};

fn on_gpu(case: &Case, levels: &[u32]) -> Vec<u32> {
    let stage = CullByDepth::new(&gpu::device().0);
    let keys = gpu::output::<u32>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&buckets().counts()),
        &gpu::uniform(&discrete_config(&data().characters)),
        &gpu::storage(&case.instances),
        &gpu::storage(&data().characters),
        &gpu::storage(levels),
        &keys,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&keys, case.instances.len())
}

fn on_cpu(case: &Case, levels: &[u32]) -> Vec<u32> {
    let discrete = discrete_config(&data().characters);
    cpu::cull_by_depth(data(), buckets(), levels, &discrete, &case.instances, &case.config)
}

/// Near and far enough that all three levels occur.
fn with_depths(mut case: Case) -> Case {
    let far = (case.count() as f32).sqrt();
    case.config.lod_depths_m = [0.4 * far, 0.9 * far];
    case
}

/// Whether an instance is so near to a plane or a threshold that roundings may decide.
fn is_close_call(case: &Case, i: usize) -> bool {
    let config: &FrameConfig = &case.config;
    let center = cpu::box_center(data(), &case.instances[i]);
    let reach = discrete_config(&data().characters).half_diagonal_m * case.instances[i].scale;
    let bound = cpu::PLANE_BOUND_M * (1.0 + center.abs().max_element() + reach);
    let of_plane = |plane: &[f32; 4]| Vec4::from_array(*plane).dot(center.extend(1.0)) + reach;
    let depth_m = (Mat4::from_cols_array_2d(&config.clip_from_world) * center.extend(1.0)).w;
    config.planes.iter().any(|plane| of_plane(plane).abs() < bound)
        || config.lod_depths_m.iter().any(|threshold| (depth_m - threshold).abs() < bound)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn keys_agree_for_all_sizes() {
    let levels = buckets().discrete_levels();
    for case in cases().map(with_depths) {
        let (gpu, cpu) = (on_gpu(&case, &levels), on_cpu(&case, &levels));
        let unexplained = (0..gpu.len()).find(|i| gpu[*i] != cpu[*i] && !is_close_call(&case, *i));
        assert_eq!(unexplained, None, "{} instances", case.count());
    }
}

#[test]
fn three_levels_by_depth_and_nobody_seen_is_culled() {
    let levels = buckets().discrete_levels();
    let case = with_depths(case(1000, 30, Weight::Area));
    let keys = on_cpu(&case, &levels);
    let culled = cpu::cull_instances(data(), &case.instances, &case.config);
    let mut seen = [0; 4];
    for (i, key) in keys.iter().enumerate() {
        let character = case.instances[i].character as usize;
        let level = levels[character * 3..][..3].iter().position(|bucket| bucket == key).unwrap_or(3);
        seen[level] += 1;
        // The box's centre and half the largest diagonal hold less than a clip's sphere may reach, but here they do not.
        assert!(level < 3 || culled[i].visible == 0, "instance {i} is seen");
    }
    assert!(seen.iter().all(|count| *count > 50), "{seen:?}");
    let triangles = |level: usize| buckets().records[levels[6 + level] as usize].triangle_count;
    assert!(triangles(0) > 2 * triangles(1) && triangles(1) > 2 * triangles(2));
    assert!((0..1000).filter(|i| is_close_call(&case, *i)).count() < 10, "the exception is one");
}
