//! `reform_triangles` on the GPU against its twin: equal.

use crate::cases::{Case, ample_and_scarce, case, cases, first_difference};
use crowd_stages::{Capacities, LodChoice, Weight, cpu, gpu::ReformTriangles};
use crowd_tests::gpu;

fn on_gpu(case: &Case, choices: &[LodChoice], capacities: &Capacities, count: usize) -> Vec<u32> {
    let stage = ReformTriangles::new(&gpu::device().0);
    let (bases, _) = cpu::scan_counts(choices);
    let indices = gpu::output::<u32>(capacities.triangle_count as usize * 3);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(capacities),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.characters),
        &gpu::storage(&case.data.triangles),
        &gpu::storage(&case.data.collapse_map),
        &gpu::storage(choices),
        &gpu::storage(&bases),
        indices.as_entire_buffer_binding(),
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&indices, count)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn index_buffers_are_equal_for_all_sizes_and_capacities() {
    for case in cases() {
        let choices = case.select().choices;
        let (bases, _) = cpu::scan_counts(&choices);
        for capacities in ample_and_scarce(&choices) {
            let expected = cpu::reform_triangles(case.data, &case.instances, &choices, &bases, &capacities);
            let gpu = on_gpu(&case, &choices, &capacities, expected.len());
            assert_eq!(first_difference(&gpu, &expected), None, "{} instances, {capacities:?}", case.count());
        }
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn parts_of_an_index_buffer_are_equal_and_make_up_the_whole() {
    for case in cases() {
        let choices = case.select().choices;
        let (bases, end) = cpu::scan_counts(&choices);
        let whole = ample_and_scarce(&choices)[0];
        let expected = cpu::reform_triangles(case.data, &case.instances, &choices, &bases, &whole);
        let mut parts = Vec::new();
        let window_count = (end.triangle_base / 3).max(1);
        for window_first in (0..end.triangle_base).step_by(window_count as usize) {
            let window = Capacities { window_first, window_count, ..whole };
            let part = cpu::reform_triangles(case.data, &case.instances, &choices, &bases, &window);
            let gpu = on_gpu(&case, &choices, &window, part.len());
            assert_eq!(first_difference(&gpu, &part), None, "{} instances, {window:?}", case.count());
            parts.extend(part);
        }
        assert_eq!(first_difference(&parts, &expected), None, "{} instances", case.count());
    }
}

#[test]
fn a_changed_index_is_seen() {
    let case = case(65, 30, Weight::Area);
    let choices = case.select().choices;
    let (bases, _) = cpu::scan_counts(&choices);
    let capacities = ample_and_scarce(&choices)[0];
    let expected = cpu::reform_triangles(case.data, &case.instances, &choices, &bases, &capacities);
    let mut changed = expected.clone();
    changed[100] += 1;
    assert!(first_difference(&changed, &expected).is_some());
}
