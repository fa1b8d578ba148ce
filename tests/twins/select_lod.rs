//! `select_lod` (Eq. 1) on the GPU against its twin.

use crate::cases::{Case, Selected, case, cases};
use crowd_stages::{Weight, cpu, gpu::SelectLod};
use crowd_tests::gpu;

fn on_gpu(case: &Case, selected: &Selected) -> Vec<u32> {
    let stage = SelectLod::new(&gpu::device().0);
    let wanted = gpu::output::<u32>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.characters),
        &gpu::storage(&selected.culled),
        &gpu::storage(&[selected.sums]),
        &wanted,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&wanted, case.instances.len())
}

/// Equal, or one apart where the quotient straddles an integer within the division's error.
fn difference(case: &Case, selected: &Selected, gpu: &[u32], cpu: &[u32]) -> Option<String> {
    let agrees = |i: usize| {
        if gpu[i] == cpu[i] {
            return true;
        }
        let share = f64::from(selected.culled[i].weight) / f64::from(selected.sums.weight);
        let exact = f64::from(case.config.budget) * share;
        let bound = exact * f64::from(cpu::QUOTIENT_BOUND);
        gpu[i].abs_diff(cpu[i]) == 1 && (exact - exact.round()).abs() <= bound
    };
    let place = (0..cpu.len()).find(|&i| !agrees(i))?;
    Some(format!("instance {place}: {} on the GPU, {} on the CPU", gpu[place], cpu[place]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn counts_agree_for_all_sizes_budgets_and_weights() {
    let others =
        [case(1000, 0, Weight::Area), case(1000, 3, Weight::Area), case(1000, 4_000_000, Weight::AreaDistance)];
    for case in cases().chain(others) {
        let selected = case.select();
        let gpu = on_gpu(&case, &selected);
        let budget = case.config.budget;
        assert_eq!(difference(&case, &selected, &gpu, &selected.wanted), None, "{} instances, {budget}", case.count());
    }
}

#[test]
fn a_changed_count_is_seen() {
    let case = case(1000, 30, Weight::Area);
    let selected = case.select();
    assert_eq!(difference(&case, &selected, &selected.wanted, &selected.wanted), None);
    let mut changed = selected.wanted.clone();
    changed[17] += 1;
    assert!(difference(&case, &selected, &changed, &selected.wanted).is_some());
}
