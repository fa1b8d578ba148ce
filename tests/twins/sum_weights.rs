//! `sum_weights` on the GPU against its twin: equal, float sums too.

use crate::cases::{Case, cases, dotted, first_difference, impostored};
use crowd_stages::{CullRecord, WeightSums, cpu, gpu::SumWeights};
use crowd_tests::gpu;

fn on_gpu(case: &Case, culled: &[CullRecord]) -> WeightSums {
    let stage = SumWeights::new(&gpu::device().0);
    let sums = gpu::output::<WeightSums>(1);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(&case.data.characters),
        &gpu::storage(culled),
        &gpu::output::<WeightSums>(case.instances.len().div_ceil(256)),
        &sums,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&sums, 1)[0]
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn sums_are_equal_for_all_sizes() {
    for case in cases().chain(cases().map(dotted)).chain(cases().map(impostored)) {
        let culled = cpu::cull_instances(case.data, &case.instances, &case.config);
        let expected = cpu::sum_weights(case.data, &case.instances, &culled, &case.config);
        assert_eq!(first_difference(&[on_gpu(&case, &culled)], &[expected]), None, "{} instances", case.count());
    }
}

#[test]
fn the_tree_sums_as_exactly_as_a_sum_in_double_precision() {
    for case in cases() {
        let culled = cpu::cull_instances(case.data, &case.instances, &case.config);
        let exact: f64 = culled.iter().map(|cull| f64::from(cull.weight)).sum();
        let sum = f64::from(cpu::sum_weights(case.data, &case.instances, &culled, &case.config).weight);
        // 24 additions deep at most, half an ulp each.
        assert!((sum - exact).abs() <= exact * 12.0 * f64::from(f32::EPSILON), "{sum} for {exact}");
    }
}

#[test]
fn one_changed_weight_is_seen() {
    let case = cases().nth(5).expect("seven sizes");
    let mut culled = cpu::cull_instances(case.data, &case.instances, &case.config);
    let expected = cpu::sum_weights(case.data, &case.instances, &culled, &case.config);
    let seen = culled.iter().position(|cull| cull.visible != 0).expect("some are seen");
    culled[seen].weight *= 1.01;
    let changed = cpu::sum_weights(case.data, &case.instances, &culled, &case.config);
    assert!(first_difference(&[changed], &[expected]).is_some());
}
