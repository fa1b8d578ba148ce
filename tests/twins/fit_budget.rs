//! `fit_budget` on the GPU against its twin: equal.

use crate::cases::{Case, Selected, case, cases, first_difference};
use crowd_stages::{LodChoice, Weight, WeightSums, cpu, gpu::FitBudget};
use crowd_tests::gpu;

fn on_gpu(case: &Case, selected: &Selected) -> (Vec<LodChoice>, WeightSums) {
    let stage = FitBudget::new(&gpu::device().0);
    let sums = gpu::storage(&[cpu::sum_weights(case.data, &case.instances, &selected.culled, &case.config)]);
    let choices = gpu::output::<LodChoice>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.characters),
        &gpu::storage(&case.data.lods),
        &gpu::storage(&selected.wanted),
        &gpu::output::<u32>(case.instances.len().div_ceil(256)),
        &sums,
        &choices,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    (gpu::read(&choices, case.instances.len()), gpu::read(&sums, 1)[0])
}

/// Ample, tight, below the coarsest levels, nothing, and everything.
fn budgets() -> impl Iterator<Item = Case> {
    [0, 1, 7, 12, 100, 1000].into_iter().map(|each| case(1000, each, Weight::Area))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_are_equal_for_all_sizes_and_budgets() {
    for case in cases().chain(budgets()) {
        let selected = case.select();
        let (choices, sums) = on_gpu(&case, &selected);
        let budget = case.config.budget;
        assert_eq!(first_difference(&choices, &selected.choices), None, "{} instances, {budget}", case.count());
        assert_eq!(first_difference(&[sums], &[selected.sums]), None, "{} instances, {budget}", case.count());
    }
}

#[test]
fn the_budget_holds_whenever_the_coarsest_crowd_fits() {
    let mut scaled = 0;
    for case in cases().chain(budgets()) {
        let selected = case.select();
        let sum: u32 = selected.choices.iter().map(|choice| choice.vertex_count).sum();
        let allowed = case.config.budget.max(selected.sums.min_vertex_count);
        assert!(sum <= allowed, "{sum} vertices, {allowed} allowed");
        scaled += selected.sums.is_scaled;
    }
    assert!(scaled > 3, "some budgets must be tight");
}

#[test]
fn a_changed_level_is_seen() {
    let case = case(1000, 30, Weight::Area);
    let selected = case.select();
    let mut changed = selected.choices.clone();
    changed[999].triangle_count += 1;
    assert!(first_difference(&changed, &selected.choices).is_some());
}
