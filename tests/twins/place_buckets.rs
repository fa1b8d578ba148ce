//! `place_buckets` on the GPU against its twin: equal.

use crate::cases::{buckets, case, cases, first_difference};
use crate::gather_drawn::sorted;
use crowd_stages::{
    BucketPlace, BucketRange, Buckets, Capacities, DispatchArgs, FrameTotals, Weight, cpu, gpu::PlaceBuckets, overflow,
};
use crowd_tests::gpu;

fn on_gpu(ranges: &[BucketRange], vertex_count: u32) -> (Vec<BucketPlace>, DispatchArgs, u32) {
    on_gpu_with(buckets(), ranges, vertex_count, false)
}

fn on_gpu_with(
    buckets: &Buckets,
    ranges: &[BucketRange],
    vertex_count: u32,
    draws_the_rest: bool,
) -> (Vec<BucketPlace>, DispatchArgs, u32) {
    let stage = PlaceBuckets::new(&gpu::device().0, draws_the_rest);
    let count = buckets.records.len() + 1;
    let (places, dispatch) = (gpu::output::<BucketPlace>(count), gpu::output::<DispatchArgs>(1));
    let totals = gpu::storage(&[FrameTotals { overflow: overflow::BUDGET, ..Default::default() }]);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&buckets.counts()),
        &gpu::uniform(&Capacities { vertex_count, ..Default::default() }),
        &gpu::storage(&buckets.records),
        &gpu::storage(ranges),
        &places,
        &dispatch,
        &totals,
    );
    gpu::run(|pass| stage.record(pass, &bound));
    let bits = gpu::read::<FrameTotals>(&totals, 1)[0].overflow;
    assert_eq!(bits & overflow::BUDGET, overflow::BUDGET, "what was said before stays");
    (gpu::read(&places, count), gpu::read(&dispatch, 1)[0], bits & !overflow::BUDGET)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn places_are_equal_for_all_sizes_and_capacities() {
    for case in cases() {
        let ranges = sorted(&case, 0).ranges;
        for capacity in [0, 1, case.count() * 10, u32::MAX] {
            let (gpu, cpu) = (on_gpu(&ranges, capacity), cpu::place_buckets(buckets(), &ranges, capacity));
            assert_eq!(first_difference(&gpu.0, &cpu.0), None, "{} instances, {capacity}", case.count());
            assert_eq!((gpu.1, gpu.2), (cpu.1, cpu.2), "{} instances, {capacity}", case.count());
        }
    }
    // More vertices than there are numbers.
    let many = vec![BucketRange { first: 0, end: 900_000_000 }; buckets().records.len()];
    assert_eq!(on_gpu(&many, u32::MAX - 1), cpu::place_buckets(buckets(), &many, u32::MAX - 1));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn nobody_without_a_palette_has_a_place_and_who_is_drawn_all_the_same_is_no_overflow() {
    let case = case(1000, 30, Weight::Area);
    let ranges = sorted(&case, 0).ranges;
    let end = ranges.iter().map(|range| range.end).max().expect("there are buckets");
    let mut kept = Vec::new();
    for palette_slots in [0, 1, end / 3, end - 1, end] {
        let few = Buckets { palette_slots, ..buckets().clone() };
        let of_all = cpu::place_buckets(&few, &ranges, u32::MAX - 2);
        assert_eq!(on_gpu_with(&few, &ranges, u32::MAX - 2, false), of_all, "{palette_slots}");
        let said_nothing = (of_all.0.clone(), of_all.1, 0);
        assert_eq!(on_gpu_with(&few, &ranges, u32::MAX - 2, true), said_nothing, "{palette_slots}");
        assert_eq!(of_all.2 == 0, palette_slots == end, "{palette_slots} of {end}");
        for (place, range) in of_all.0.iter().zip(&ranges).filter(|(_, range)| range.end > range.first) {
            assert_eq!(place.vertex_base == crowd_pack::NONE, range.end > palette_slots);
        }
        kept.push(of_all.0.last().map_or(0, |last| last.vertex_base));
    }
    assert!(kept[0] == 0 && kept[2] > 0 && kept[2] < kept[3] && kept[3] < kept[4], "{kept:?}");
}

#[test]
fn buckets_lie_side_by_side_and_what_does_not_fit_is_said() {
    let case = case(1000, 30, Weight::Area);
    let ranges = sorted(&case, 0).ranges;
    let (places, dispatch, bits) = cpu::place_buckets(buckets(), &ranges, u32::MAX);
    let mut end = 0;
    for (place, range) in places.iter().zip(&ranges).take(buckets().mesh_count as usize) {
        assert_eq!((place.vertex_base, place.first), (end, range.first));
        end += (range.end - range.first) * place.vertex_count;
    }
    assert_eq!((places.last().map(|last| last.vertex_base), bits), (Some(end), 0));
    assert!(end > 1000 && (dispatch.x * dispatch.y - 1) * 256 < end && dispatch.x * dispatch.y * 256 >= end);

    let (fewer, _, bits) = cpu::place_buckets(buckets(), &ranges, end / 2);
    let without = fewer.iter().filter(|place| place.vertex_base == crowd_pack::NONE).count();
    assert!(bits == overflow::VERTICES && without > 0 && without < fewer.len());
    assert!(fewer.last().is_some_and(|last| last.vertex_base <= end / 2));
    assert!(first_difference(&fewer, &places).is_some());
}
