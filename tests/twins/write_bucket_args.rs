//! `write_bucket_args` on the GPU against its twin: equal.

use crate::cases::{Case, buckets, case, cases, data, dotted, first_difference, impostored};
use crowd_stages::{
    BucketRange, DrawArgs, DrawCounts, FillState, FrameTotals, Weight, WeightSums, cpu, gpu::WriteBucketArgs,
};
use crowd_tests::gpu;

type Written = (Vec<BucketRange>, Vec<DrawArgs>, DrawCounts, FrameTotals);

fn on_gpu(case: &Case, sorted_keys: &[u32], sums: &WeightSums) -> Written {
    let stage = WriteBucketArgs::new(&gpu::device().0);
    let count = buckets().records.len();
    // What an earlier frame left must not stay.
    let ranges = gpu::storage(&vec![BucketRange { first: 7, end: 9 }; count]);
    let draw_args = gpu::storage(&vec![DrawArgs { instance_count: 5, ..Default::default() }; count]);
    let (draw_counts, totals) = (gpu::output::<DrawCounts>(1), gpu::output::<FrameTotals>(1));
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&buckets().counts()),
        &gpu::storage(&[*sums]),
        &gpu::storage(&buckets().records),
        &gpu::storage(sorted_keys),
        &ranges,
        &draw_args,
        &draw_counts,
        &totals,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count(), count as u32));
    (gpu::read(&ranges, count), gpu::read(&draw_args, count), gpu::read(&draw_counts, 1)[0], gpu::read(&totals, 1)[0])
}

/// With dots where the case has them.
fn sorted_keys(case: &Case) -> (Vec<u32>, WeightSums) {
    let mut selected = case.select();
    let mut fill = FillState::default();
    if case.config.dot_area_px2 > 0.0 {
        let lods = buckets().quantized_lods(data());
        (selected.choices, fill) =
            cpu::fill_budget(case.data, &lods, &case.instances, &selected.culled, &mut selected.sums, &case.config);
    }
    let (keys, _) =
        cpu::key_instances(buckets(), &case.instances, &selected.culled, &selected.choices, &fill, &case.config);
    (cpu::sort_instances(&keys).0, selected.sums)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn arguments_and_totals_are_equal_for_all_sizes() {
    let with_dots = cases().chain([2, 200].map(|each| case(1000, each, Weight::Area))).map(dotted);
    let with_impostors = [2, 60].map(|each| impostored(case(1000, each, Weight::Area)));
    let plain = cases().chain([2, 200].map(|each| case(1000, each, Weight::Area)));
    for case in plain.chain(with_dots).chain(with_impostors) {
        let (keys, sums) = sorted_keys(&case);
        let (ranges, args, counts, totals) = on_gpu(&case, &keys, &sums);
        let expected = cpu::write_bucket_args(buckets(), &keys, &sums, &case.config);
        assert_eq!(first_difference(&ranges, &expected.0), None, "{} instances", case.count());
        assert_eq!(first_difference(&args, &expected.1), None, "{} instances", case.count());
        assert_eq!((counts, totals), (expected.2, expected.3), "{} instances", case.count());
    }
}

#[test]
fn draws_cover_the_sorted_list_once_and_empty_ones_come_last() {
    let with_impostors = impostored(case(1000, 12, Weight::Area));
    for case in [case(1000, 200, Weight::Area), dotted(case(1000, 12, Weight::Area)), with_impostors] {
        let (keys, sums) = sorted_keys(&case);
        let (_, args, counts, totals) = cpu::write_bucket_args(buckets(), &keys, &sums, &case.config);
        let (meshes, stand_ins) = args.split_at(buckets().mesh_count as usize);
        let (dots, impostors) = stand_ins.split_at((buckets().first_impostor - buckets().mesh_count) as usize);
        let (alone, fading) = impostors.split_at((buckets().first_fade - buckets().first_impostor) as usize);
        let (narrow, wide) = meshes.split_at(buckets().count_16 as usize);
        let mut drawn = Vec::new();
        let has_dots = case.config.dot_area_px2 > 0.0;
        let has_impostors = case.config.impostor_area_px2 > 0.0;
        let kinds = [counts.count_16 > 0, counts.count_32 > 0, counts.dot_count > 0];
        assert!(has_impostors || kinds == [true, !has_dots, has_dots], "{counts:?}");
        assert_eq!([counts.impostor_count > 0, counts.fade_count > 0], [has_impostors; 2]);
        for (list, count) in [
            (narrow, counts.count_16),
            (wide, counts.count_32),
            (dots, counts.dot_count),
            (alone, counts.impostor_count),
            (fading, counts.fade_count),
        ] {
            let (full, empty) = list.split_at(count as usize);
            assert!(full.iter().all(|a| a.instance_count > 0) && empty.iter().all(|a| *a == DrawArgs::default()));
            drawn.extend(full.iter().flat_map(|a| a.first_instance..a.first_instance + a.instance_count));
        }
        drawn.sort_unstable();
        assert_eq!(drawn, (0..totals.visible_count).collect::<Vec<u32>>());
        assert_eq!(
            totals.draw_count,
            counts.count_16 + counts.count_32 + counts.dot_count + counts.impostor_count + counts.fade_count
        );
    }
}
