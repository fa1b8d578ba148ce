//! `recall_seen` on the GPU against its twin: equal.

use crate::cases::{Case, case, cases, first_difference, impostored};
use crowd_stages::{CullRecord, FrameConfig, SightTally, cpu, gpu::RecallSeen, sight};
use crowd_tests::{gpu, synthetic::hash};

type Recalled = (Vec<CullRecord>, SightTally, FrameConfig, [[u32; 3]; 3]);

/// Some seen, some hidden, some drawn, some of whom nothing is known; valid for `count`.
fn memory(case: &Case, count: u32) -> Vec<u32> {
    let words = [0, sight::SEEN | sight::DRAWN, sight::HIDDEN, sight::HIDDEN | sight::DRAWN];
    std::iter::once(count).chain((0..case.count()).map(|i| words[hash(i) as usize % 4])).collect()
}

fn on_gpu(case: &Case, seen: &[u32], culled: &[CullRecord]) -> Recalled {
    let stage = RecallSeen::new(&gpu::device().0);
    let (culled, tally) = (gpu::storage(culled), gpu::output::<SightTally>(1));
    let first = gpu::output::<FrameConfig>(1);
    // Of an earlier frame.
    let gate = gpu::storage(&[[7u32; 3]; 3]);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.characters),
        &gpu::storage(seen),
        &culled,
        &gpu::output::<SightTally>(case.instances.len().div_ceil(256)),
        &tally,
        &first,
        &gate,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    let gate = gpu::read(&gate, 3).try_into().expect("three");
    (gpu::read(&culled, case.instances.len()), gpu::read(&tally, 1)[0], gpu::read(&first, 1)[0], gate)
}

fn on_cpu(case: &Case, seen: &[u32], culled: &[CullRecord]) -> Recalled {
    let mut culled = culled.to_vec();
    let (tally, first, gate) = cpu::recall_seen(case.data, &case.instances, seen, &mut culled, &case.config);
    (culled, tally, first, gate)
}

fn difference(gpu: &Recalled, cpu: &Recalled) -> Option<String> {
    first_difference(&gpu.0, &cpu.0)
        .or_else(|| first_difference(&[gpu.1], &[cpu.1]))
        .or_else(|| first_difference(&[gpu.2], &[cpu.2]))
        .or_else(|| first_difference(&gpu.3, &cpu.3))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_recall_agrees_for_all_sizes() {
    for mut case in cases().chain(cases().map(impostored)) {
        case.config.slack = case.config.budget / 100;
        let culled = cpu::cull_instances(case.data, &case.instances, &case.config);
        let seen = memory(&case, case.count());
        let expected = on_cpu(&case, &seen, &culled);
        assert_eq!(difference(&on_gpu(&case, &seen, &culled), &expected), None, "{} instances", case.count());
        let nobody: Vec<u32> = std::iter::once(case.count()).chain((0..case.count()).map(|_| sight::SEEN)).collect();
        let shut = on_cpu(&case, &nobody, &culled);
        assert_eq!(shut.3, [[0; 3]; 3]);
        assert_eq!(difference(&on_gpu(&case, &nobody, &culled), &shut), None, "{} instances", case.count());
    }
}

#[test]
fn a_memory_of_another_number_of_instances_says_nothing() {
    let case = case(1000, 30, crowd_stages::Weight::Area);
    let culled = cpu::cull_instances(case.data, &case.instances, &case.config);
    let found = on_cpu(&case, &memory(&case, 999), &culled);
    assert_eq!(found, (culled, SightTally::default(), case.config, [[0; 3]; 3]));
}

#[test]
fn who_waits_keeps_the_weight_and_a_small_reserve_is_made() {
    let case = case(1000, 30, crowd_stages::Weight::Area);
    let culled = cpu::cull_instances(case.data, &case.instances, &case.config);
    let (after, tally, first, gate) = on_cpu(&case, &memory(&case, 1000), &culled);
    assert_eq!(gate, [[4, 1, 1], [1; 3], [1; 3]]);
    assert!(difference(&(after.clone(), tally, first, [[0; 3]; 3]), &(after.clone(), tally, first, gate)).is_some());
    let waiting = after.iter().zip(&culled).filter(|(a, b)| a.visible != b.visible).count() as u32;
    assert!(waiting > 100 && tally.hidden_count == waiting);
    assert!(after.iter().zip(&culled).all(|(a, b)| a.weight == b.weight));
    let kept = case.config.budget / 128;
    assert_eq!((first.budget, first.slack), (case.config.budget - kept, 0));
    // It is part of what may be left over, not added to it.
    for (slack, rest) in [(kept - 1, 0), (kept, 0), (kept + 7, 7)] {
        let mut slackened = self::case(1000, 30, crowd_stages::Weight::Area);
        slackened.config.slack = slack;
        let (_, _, first, _) = on_cpu(&slackened, &memory(&slackened, 1000), &culled);
        assert_eq!((first.budget, first.slack), (case.config.budget - kept, rest));
    }
    // A changed word is a changed outcome: the comparison can fail.
    let mut seen = memory(&case, 1000);
    let i = culled.iter().position(|cull| cull.visible != 0).expect("some are in the frustum");
    seen[1 + i] ^= sight::HIDDEN;
    assert!(difference(&on_cpu(&case, &seen, &culled), &(after, tally, first, gate)).is_some());
}
