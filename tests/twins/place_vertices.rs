//! `place_vertices` on the GPU against its twin: equal.

use crate::cases::{Case, ample_and_scarce, case, cases, first_difference};
use crowd_stages::{Capacities, LodChoice, Weight, cpu, gpu::PlaceVertices};
use crowd_tests::gpu;

fn on_gpu(case: &Case, choices: &[LodChoice], capacities: &Capacities, count: usize) -> Vec<u32> {
    let stage = PlaceVertices::new(&gpu::device().0);
    let (bases, _) = cpu::scan_counts(choices);
    let slot_instances = gpu::output::<u32>(capacities.vertex_count as usize);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(capacities),
        &gpu::storage(choices),
        &gpu::storage(&bases),
        &slot_instances,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&slot_instances, count)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn vertex_lists_are_equal_for_all_sizes_and_capacities() {
    for case in cases() {
        let choices = case.select().choices;
        let (bases, _) = cpu::scan_counts(&choices);
        for capacities in ample_and_scarce(&choices) {
            let expected = cpu::place_vertices(&choices, &bases, &capacities);
            let gpu = on_gpu(&case, &choices, &capacities, expected.len());
            assert_eq!(first_difference(&gpu, &expected), None, "{} instances, {capacities:?}", case.count());
        }
    }
}

#[test]
fn a_changed_owner_is_seen() {
    let case = case(65, 30, Weight::Area);
    let choices = case.select().choices;
    let (bases, _) = cpu::scan_counts(&choices);
    let expected = cpu::place_vertices(&choices, &bases, &ample_and_scarce(&choices)[0]);
    let mut changed = expected.clone();
    changed[100] += 1;
    assert!(first_difference(&changed, &expected).is_some());
}
