//! `write_draw_args` on the GPU against its twin: equal, overflow bits too.

use crate::cases::{Case, Selected, ample_and_scarce, case, cases, first_difference};
use crowd_stages::{Capacities, DrawArgs, FrameTotals, InstanceBase, Weight, cpu, gpu::WriteDrawArgs, overflow};
use crowd_tests::gpu;

fn on_gpu(
    case: &Case,
    selected: &Selected,
    bases: &[InstanceBase],
    end: InstanceBase,
    capacities: &Capacities,
) -> (DrawArgs, FrameTotals) {
    let stage = WriteDrawArgs::new(&gpu::device().0);
    let (draw_args, totals) = (gpu::output::<DrawArgs>(1), gpu::output::<FrameTotals>(1));
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(capacities),
        &gpu::storage(&[selected.sums]),
        &gpu::storage(&selected.choices),
        &gpu::storage(bases),
        &gpu::storage(&[end]),
        &draw_args,
        &totals,
    );
    gpu::run(|pass| stage.record(pass, &bound));
    (gpu::read(&draw_args, 1)[0], gpu::read(&totals, 1)[0])
}

fn scarcities(selected: &Selected) -> Vec<Capacities> {
    let mut all = ample_and_scarce(&selected.choices).to_vec();
    all.push(Capacities { vertex_count: 1 << 25, triangle_count: 10, ..Default::default() });
    all.push(Capacities { vertex_count: 0, triangle_count: 0, ..Default::default() });
    all
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn arguments_and_totals_are_equal_for_all_sizes_and_capacities() {
    for case in cases().chain([case(1000, 3, Weight::Area)]) {
        let selected = case.select();
        let (bases, end) = cpu::scan_counts(&selected.choices);
        for capacities in scarcities(&selected) {
            let expected =
                cpu::write_draw_args(&selected.choices, &bases, end, &selected.sums, &capacities, &case.config);
            let gpu = on_gpu(&case, &selected, &bases, end, &capacities);
            assert_eq!(first_difference(&[gpu], &[expected]), None, "{} instances, {capacities:?}", case.count());
        }
    }
}

#[test]
fn each_overflow_sets_its_bit_and_says_what_is_needed() {
    let case = case(1000, 3, Weight::Area);
    let selected = case.select();
    let (bases, end) = cpu::scan_counts(&selected.choices);
    let bits: Vec<u32> = scarcities(&selected)
        .iter()
        .map(|capacities| {
            let (args, totals) =
                cpu::write_draw_args(&selected.choices, &bases, end, &selected.sums, capacities, &case.config);
            assert_eq!((totals.needed_vertices, totals.needed_triangles), (end.vertex_base, end.triangle_base));
            assert!(
                totals.vertex_count <= capacities.vertex_count && totals.triangle_count <= capacities.triangle_count
            );
            assert_eq!(args.index_count, totals.triangle_count * 3);
            totals.overflow & !overflow::BUDGET
        })
        .collect();
    assert_eq!(bits, [0, overflow::VERTICES, overflow::TRIANGLES, overflow::VERTICES | overflow::TRIANGLES]);
    assert!(selected.sums.min_vertex_count > case.config.budget, "three vertices each are below the coarsest levels");
}

#[test]
fn a_changed_argument_is_seen() {
    let a = DrawArgs { index_count: 30, instance_count: 1, ..Default::default() };
    let b = DrawArgs { index_count: 33, ..a };
    assert!(first_difference(&[(a, FrameTotals::default())], &[(b, FrameTotals::default())]).is_some());
}
