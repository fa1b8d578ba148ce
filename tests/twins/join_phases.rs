//! `join_phases` on the GPU against its twins: equal.

use crate::cases::first_difference;
use crowd_stages::{FillState, FrameConfig, FrameTotals, SightTally, WeightSums, cpu, gpu::JoinPhases, overflow};
use crowd_tests::gpu;

struct Phases {
    config: FrameConfig,
    sums: WeightSums,
    second_sums: WeightSums,
    fill: FillState,
    tally: SightTally,
    first: FrameTotals,
    second: FrameTotals,
}

fn phases(budget: u32) -> Phases {
    let totals = |visible_count, vertex_count, triangle_count, draw_count| FrameTotals {
        visible_count,
        vertex_count,
        triangle_count,
        draw_count,
        wanted_count: 7 * vertex_count,
        threshold_px: 0.75,
        ..Default::default()
    };
    Phases {
        config: FrameConfig { budget, instance_count: 200, ..Default::default() },
        sums: WeightSums { min_vertex_count: 400, visible_count: 30, ..Default::default() },
        second_sums: WeightSums { min_vertex_count: 80, visible_count: 5, ..Default::default() },
        fill: FillState { low_bits: 0x4000_1234, high_bits: 0x4000_1235, low_count: 990, ..Default::default() },
        tally: SightTally { hidden_min_count: 900, hidden_count: 60 },
        first: totals(30, 1000, 1500, 4),
        second: totals(5, 100, 130, 2),
    }
}

/// The water of the second phase, and the sum of both.
fn on_gpu(p: &Phases) -> (FillState, FrameTotals) {
    let stage = JoinPhases::new(&gpu::device().0);
    let (second_fill, totals) = (gpu::output::<FillState>(1), gpu::storage(&[p.second]));
    let first_totals = gpu::storage(&[p.first]);
    let [sums, second_sums] = [p.sums, p.second_sums].map(|sums| gpu::storage(&[sums]));
    let (config, fill, tally) = (gpu::uniform(&p.config), gpu::storage(&[p.fill]), gpu::storage(&[p.tally]));
    let device = &gpu::device().0;
    let bound = stage.bind(device, &config, &sums, &second_sums, &fill, &tally, &second_fill, &first_totals, &totals);
    gpu::run(|pass| stage.record_begin(pass, &bound));
    gpu::run(|pass| stage.record_join(pass, &bound));
    (gpu::read(&second_fill, 1)[0], gpu::read(&totals, 1)[0])
}

fn on_cpu(p: &Phases) -> (FillState, FrameTotals) {
    let totals = cpu::join_phases(&p.first, &p.second, &p.sums, &p.second_sums, &p.tally, &p.config);
    (cpu::begin_second(&p.first, &p.second_sums, &p.fill, &p.config), totals)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn both_steps_agree_within_and_beyond_the_budget() {
    for budget in [2000, 1100, 1099] {
        let p = phases(budget);
        assert_eq!(first_difference(&[on_gpu(&p)], &[on_cpu(&p)]), None, "{budget}");
    }
}

#[test]
fn what_both_drew_is_added_and_the_rest_is_occluded() {
    let (fill, totals) = on_cpu(&phases(1100));
    assert_eq!((fill.low_bits, fill.high_bits, fill.low_count), (0, 0x4000_1234, 1080));
    assert_eq!((totals.visible_count, totals.vertex_count, totals.triangle_count), (35, 1100, 1630));
    assert_eq!((totals.min_vertex_count, totals.draw_count, totals.occluded_count), (480, 6, 55));
    assert_eq!((totals.overflow, totals.wanted_count, totals.outside_count), (0, 7000, 110));
    assert_eq!(on_cpu(&phases(1099)).1.overflow, overflow::BUDGET);
    assert!(first_difference(&[on_cpu(&phases(1099))], &[on_cpu(&phases(1100))]).is_some());
}
