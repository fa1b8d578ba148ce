//! `scan_counts` on the GPU against its twin: equal.

use crate::cases::{Case, case, cases, first_difference};
use crowd_stages::{InstanceBase, LodChoice, Weight, cpu, gpu::ScanCounts};
use crowd_tests::gpu;

fn on_gpu(case: &Case, choices: &[LodChoice]) -> (Vec<InstanceBase>, InstanceBase) {
    let stage = ScanCounts::new(&gpu::device().0);
    let bases = gpu::output::<InstanceBase>(choices.len());
    let totals = gpu::output::<InstanceBase>(1);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(choices),
        &gpu::output::<InstanceBase>(choices.len().div_ceil(256)),
        &bases,
        &totals,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    (gpu::read(&bases, choices.len()), gpu::read(&totals, 1)[0])
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn bases_are_equal_for_all_sizes_up_to_a_million() {
    for mut case in cases() {
        let choices = case.select().choices;
        check(&mut case, &choices);
    }
    let million: Vec<LodChoice> =
        (0..1_000_003).map(|i| LodChoice { vertex_count: i % 7, triangle_count: i % 11 }).collect();
    check(&mut case(1, 30, Weight::Area), &million);
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn sums_beyond_32_bits_saturate() {
    let huge = vec![LodChoice { vertex_count: 1 << 24, triangle_count: 1 << 22 }; 1000];
    check(&mut case(1, 30, Weight::Area), &huge);
    assert_eq!(cpu::scan_counts(&huge).1.vertex_base, u32::MAX);
}

fn check(case: &mut Case, choices: &[LodChoice]) {
    case.instances.resize(choices.len(), Default::default());
    case.config.instance_count = choices.len() as u32;
    let (bases, end) = on_gpu(case, choices);
    let (expected, expected_end) = cpu::scan_counts(choices);
    assert_eq!(first_difference(&bases, &expected), None, "{} instances", choices.len());
    assert_eq!(end, expected_end, "{} instances", choices.len());
}

#[test]
fn a_changed_base_is_seen() {
    let choices = case(65, 30, Weight::Area).select().choices;
    let (expected, _) = cpu::scan_counts(&choices);
    let mut changed = expected.clone();
    changed[64].triangle_base += 1;
    assert!(first_difference(&changed, &expected).is_some());
}
