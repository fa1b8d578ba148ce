//! `fill_budget` on the GPU against its twin: equal; and that the budget is spent, on the twin.

use crate::cases::{Case, Selected, buckets, case, cases, close, data, dotted, first_difference, impostored};
use crowd_pack::{CharacterRecord, LodRecord};
use crowd_stages::{
    BudgetIn, DOT_COUNTS, FillState, FrameConfig, IMPOSTOR_FADE, LodChoice, Weight, WeightSums, cpu,
    dispatch::DOT_VERTICES, dot_reach, gpu::FillBudget,
};
use crowd_tests::gpu;
use proptest::prelude::*;

fn on_gpu(case: &Case, lods: &[LodRecord], selected: &Selected) -> (Vec<LodChoice>, FillState, WeightSums) {
    on_gpu_after(case, lods, selected, 0, case.count())
}

/// The same after a frame with water so high; recorded for so many instances, of which the case has some.
fn on_gpu_after(
    case: &Case,
    lods: &[LodRecord],
    selected: &Selected,
    low_bits: u32,
    recorded: u32,
) -> (Vec<LodChoice>, FillState, WeightSums) {
    let stage = FillBudget::new(&gpu::device().0);
    let of_dots = FillBudget::with_dots(&gpu::device().0, dot_reach(&case.data.characters));
    let plain = run(&stage, case, lods, selected, low_bits, recorded, FillBudget::record);
    // The other way over the same tables. Others have no dots.
    if *lods == buckets().quantized_lods(case.data)[..] {
        let twice = run(&of_dots, case, lods, selected, low_bits, recorded, FillBudget::record_of_dots);
        assert_eq!(first_difference(&twice.0, &plain.0), None, "{} of {recorded}", case.count());
        assert_eq!((twice.1, twice.2), (plain.1, plain.2), "{} of {recorded}", case.count());
    }
    plain
}

/// One of the ways to record the stage.
type Record = fn(&FillBudget, &mut wgpu::ComputePass<'_>, &wgpu::BindGroup, &FrameConfig, u32);

fn run(
    stage: &FillBudget,
    case: &Case,
    lods: &[LodRecord],
    selected: &Selected,
    low_bits: u32,
    recorded: u32,
    record: Record,
) -> (Vec<LodChoice>, FillState, WeightSums) {
    let sums = gpu::storage(&[cpu::sum_weights(case.data, &case.instances, &selected.culled, &case.config)]);
    let choices = gpu::output::<LodChoice>(case.instances.len());
    let fill = gpu::storage(&[FillState { low_bits, ..Default::default() }]);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::storage(&case.data.characters),
        &gpu::storage(lods),
        &gpu::storage(&selected.culled),
        &gpu::output::<u32>(FillBudget::block_count_words(recorded) as usize),
        &fill,
        &sums,
        &choices,
    );
    gpu::run(|pass| record(stage, pass, &bound, &case.config, recorded));
    (gpu::read(&choices, case.instances.len()), gpu::read(&fill, 1)[0], gpu::read(&sums, 1)[0])
}

fn on_cpu(case: &Case, lods: &[LodRecord], selected: &Selected) -> (Vec<LodChoice>, FillState, WeightSums) {
    let mut sums = cpu::sum_weights(case.data, &case.instances, &selected.culled, &case.config);
    let (choices, fill) = cpu::fill_budget(case.data, lods, &case.instances, &selected.culled, &mut sums, &case.config);
    (choices, fill, sums)
}

/// From below the coarsest levels to more than everything.
fn budgets() -> impl Iterator<Item = Case> {
    [0, 1, 7, 12, 100, 300, 1000].into_iter().map(|each| case(1000, each, Weight::Area))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_are_equal_for_all_sizes_budgets_and_tables() {
    let quantized = buckets().quantized_lods(data());
    for case in cases().chain(budgets()) {
        let selected = case.select();
        for lods in [&data().lods, &quantized] {
            let (choices, fill, sums) = on_gpu(&case, lods, &selected);
            let expected = on_cpu(&case, lods, &selected);
            let budget = case.config.budget;
            assert_eq!(first_difference(&choices, &expected.0), None, "{} instances, {budget}", case.count());
            let heights = |f: FillState| (f.low_bits, f.high_bits, f.low_count);
            assert_eq!(heights(fill), heights(expected.1), "{} instances, {budget}", case.count());
            // A quotient decides it; some instances may be one level apart.
            assert!(close(sums.wanted_count as f32, expected.2.wanted_count as f32, 1e-3), "{sums:?}");
        }
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_with_dots_and_impostors_are_equal_for_all_sizes_and_budgets() {
    let lods = buckets().quantized_lods(data());
    for case in cases().chain(budgets()).map(dotted).chain(cases().chain(budgets()).map(impostored)) {
        let selected = case.select();
        let (choices, fill, sums) = on_gpu(&case, &lods, &selected);
        let expected = on_cpu(&case, &lods, &selected);
        assert_eq!(first_difference(&choices, &expected.0), None, "{} of {}", case.config.budget, case.count());
        assert_eq!((fill.low_bits, fill.low_count), (expected.1.low_bits, expected.1.low_count));
        assert_eq!(sums.min_vertex_count, expected.2.min_vertex_count);
    }
}

/// The search begins where the water was, finds the same from anywhere, and knows when it has.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_are_those_of_a_search_from_the_beginning_wherever_the_water_was() {
    let quantized = buckets().quantized_lods(data());
    for case in [case(1000, 30, Weight::Area), case(65, 90, Weight::AreaDistance), dotted(case(1000, 7, Weight::Area))]
    {
        let selected = case.select_culled();
        let expected = on_cpu(&case, &quantized, &selected);
        let top = f32::from_bits(expected.1.low_bits);
        let factors = [1e-30, 0.1, 0.7, 0.96, 0.999, 1.0, 1.001, 1.02, 1.3, 3.0, 1e9, 1e24];
        for hint in factors.map(|factor| (top * factor).to_bits()).into_iter().chain([1, u32::MAX]) {
            let (choices, fill, sums) = on_gpu_after(&case, &quantized, &selected, hint, case.count());
            assert_eq!(first_difference(&choices, &expected.0), None, "{hint:#x}");
            let of = |f: FillState| (f.low_bits, f.high_bits, f.low_count, f.high_count);
            assert_eq!(of(fill), of(expected.1), "{hint:#x}");
            assert!(fill.smooth_bits.abs_diff(expected.1.smooth_bits) <= 2, "{fill:?}, {:?}", expected.1);
            assert_eq!(fill.high_cell, fill.low_cell + 1, "{hint:#x}: found");
            let is_close = (0.999..1.001).contains(&(f32::from_bits(hint) / top));
            assert!(fill.pass_number <= if is_close { 2 } else { 5 }, "{hint:#x}: {} looks", fill.pass_number);
            assert_eq!(sums.water_bits, expected.2.water_bits);
        }
    }
}

/// Below it nobody has to look into a table of anybody.
#[test]
fn below_the_reach_of_dots_all_tables_are_alike() {
    let lods = buckets().quantized_lods(data());
    let reach = dot_reach(&data().characters);
    assert!(reach > 2 * DOT_VERTICES, "a reach of {reach}: the case is not worth running");
    let dots =
        |k: u32| DOT_COUNTS.into_iter().rfind(|dots| dots * DOT_VERTICES <= k).expect("k is of one dot at least");
    let as_dots = |k: u32, character: &CharacterRecord| {
        let LodRecord { vertex_count, triangle_count } = lods[(character.lod_offset + k) as usize];
        (vertex_count, triangle_count) == (dots(k) * DOT_VERTICES, dots(k))
    };
    let characters = || data().characters.iter();
    assert!((DOT_VERTICES..reach).all(|k| characters().all(|character| as_dots(k, character))));
    assert!(!characters().all(|character| as_dots(reach, character)), "none lies farther");
    // One without dots has them nowhere; one of few triangles has as many dots at most.
    let with = |min_vertex_count, min_triangle_count| {
        let own = CharacterRecord { min_vertex_count, min_triangle_count, ..data().characters[0] };
        dot_reach(&[data().characters[0], own])
    };
    assert_eq!([with(3, 1), with(4, 2), with(200, 3), with(200, 1)], [0, 4, 12, 6].map(|r: u32| r.min(reach)));
    assert_eq!(dot_reach(&[]), 0);
}

/// Some are dots whose number is worked out, some dots and meshes from the table; with a reach that is too far the levels are others.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn dots_beyond_the_reach_would_be_seen() {
    let lods = buckets().quantized_lods(data());
    let reach = dot_reach(&data().characters);
    let run_to = |reach, case: &Case, selected: &Selected| {
        let stage = FillBudget::with_dots(&gpu::device().0, reach);
        run(&stage, case, &lods, selected, 0, case.count(), FillBudget::record_of_dots).0
    };
    for (each, lacks_meshes) in [(7, true), (60, false)] {
        let case = dotted(case(1000, each, Weight::Area));
        let selected = case.select_culled();
        let expected = on_cpu(&case, &lods, &selected).0;
        let below = expected.iter().filter(|choice| (1..reach).contains(&choice.vertex_count)).count();
        let others = expected.iter().filter(|choice| choice.vertex_count >= reach).count();
        assert!(others > 20 && (below > 20 || !lacks_meshes), "{below} below {reach}, {others} others");
        assert_eq!(first_difference(&run_to(reach, &case, &selected), &expected), None);
        assert!(lacks_meshes || first_difference(&run_to(1 << 20, &case, &selected), &expected).is_some());
    }
}

/// What the coarsest levels alone exceed is known after one look.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_budget_below_the_coarsest_levels_takes_one_look() {
    let quantized = buckets().quantized_lods(data());
    let case = case(1000, 1, Weight::Area);
    let selected = case.select_culled();
    let (choices, fill, _) = on_gpu_after(&case, &quantized, &selected, 0, case.count());
    let expected = on_cpu(&case, &quantized, &selected);
    assert_eq!(first_difference(&choices, &expected.0), None);
    assert!(expected.1.low_count > case.config.budget, "the case is not worth running");
    assert_eq!((fill.low_bits, fill.low_count, fill.pass_number), (0, expected.1.low_count, 1));
}

/// Chunks of more than one block, and a frame of fewer people than it is recorded for, who are then in more chunks.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_of_a_large_crowd_are_equal() {
    let quantized = buckets().quantized_lods(data());
    for (count, recorded) in [(300_000, 300_000), (262_144, 262_145), (200_000, 600_000)] {
        let case = dotted(case(count, 6, Weight::Area));
        let selected = case.select_culled();
        let (choices, fill, _) = on_gpu_after(&case, &quantized, &selected, 0, recorded);
        let expected = on_cpu(&case, &quantized, &selected);
        assert_eq!(first_difference(&choices, &expected.0), None, "{count} of {recorded}");
        assert_eq!((fill.low_bits, fill.low_count), (expected.1.low_bits, expected.1.low_count));
        assert!(fill.edge < 1024 && expected.1.low_count > 0, "somebody takes a step: {fill:?}");
    }
}

/// A budget that the coarsest meshes alone exceed holds with dots, which only small ones become.
#[test]
fn dots_make_a_small_budget_hold() {
    let (plain, with_dots) = (case(1000, 7, Weight::Area), dotted(case(1000, 7, Weight::Area)));
    let budget = u64::from(plain.config.budget);
    let spent = |case: &Case, lods: &[LodRecord]| {
        let selected = case.select();
        let (choices, _, _) = on_cpu(case, lods, &selected);
        (choices.iter().map(|choice| u64::from(choice.vertex_count)).sum::<u64>(), choices, selected)
    };
    assert!(spent(&plain, &buckets().quantized_lods(data())).0 > budget, "the case is not worth running");
    let (vertices, choices, selected) = spent(&with_dots, &buckets().quantized_lods(data()));
    assert!(vertices <= budget && vertices + budget / 50 > budget, "{vertices} of {budget}");
    let mut dots = 0;
    for ((instance, choice), cull) in with_dots.instances.iter().zip(&choices).zip(&selected.culled) {
        let is_dots = buckets().fitting(instance.character, choice.vertex_count) >= buckets().mesh_count;
        if cull.visible != 0 && is_dots {
            assert!(cull.area_px2 < with_dots.config.dot_area_px2, "{cull:?} is too large for dots");
            assert_eq!(choice.vertex_count, 3 * choice.triangle_count);
            dots += 1;
        }
    }
    assert!(dots > 50, "{dots} became dots");
}

/// Impostors are counted: what they save goes to those who are nearer, and the budget holds.
#[test]
fn impostors_leave_their_vertices_to_the_others() {
    let (plain, with_impostors) = (case(1000, 60, Weight::Area), impostored(case(1000, 60, Weight::Area)));
    let lods = buckets().quantized_lods(data());
    let near = |case: &Case| {
        let selected = case.select();
        let (choices, _, _) = on_cpu(case, &lods, &selected);
        let all = choices.iter().map(|choice| u64::from(choice.vertex_count)).sum::<u64>();
        assert!(all <= u64::from(case.config.budget), "{all} of {}", case.config.budget);
        let largest = IMPOSTOR_FADE * with_impostors.config.impostor_area_px2;
        let seen = choices.iter().zip(&selected.culled).filter(|(_, cull)| cull.area_px2 >= largest);
        seen.map(|(choice, _)| u64::from(choice.vertex_count)).sum::<u64>()
    };
    let (without, with) = (near(&plain), near(&with_impostors));
    assert!(with > without + without / 20, "{with} with impostors, {without} without");
}

/// Vertices of the levels, of the coarsest and of full detail of the visible.
fn used(case: &Case, choices: &[LodChoice]) -> (u64, u64, u64) {
    let mut sums = (0, 0, 0);
    for (instance, choice) in case.instances.iter().zip(choices).filter(|(_, c)| c.vertex_count > 0) {
        let character = &case.data.characters[instance.character as usize];
        sums.0 += u64::from(choice.vertex_count);
        sums.1 += u64::from(character.min_vertex_count);
        sums.2 += u64::from(character.vertex_count);
    }
    sums
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_by_error_are_equal_for_all_sizes_and_budgets() {
    let by_error = buckets().error_lods();
    for case in [0, 12, 50, 100, 1000].map(|each| case(1000, each, Weight::Error)).into_iter().chain([case(
        65,
        90,
        Weight::Error,
    )]) {
        let selected = case.select_culled();
        let (choices, fill, sums) = on_gpu(&case, &by_error, &selected);
        let expected = on_cpu(&case, &by_error, &selected);
        assert_eq!(first_difference(&choices, &expected.0), None, "{}", case.config.budget);
        assert_eq!((fill.low_bits, fill.high_bits), (expected.1.low_bits, expected.1.high_bits));
        assert_eq!((sums.water_bits, sums.wanted_count), (expected.2.water_bits, 0));
    }
}

/// No level's bound takes more pixels than the threshold, and the levels just coarser would, or the budget is not used up.
#[test]
fn one_threshold_in_pixels_holds_for_all_and_the_budget_is_used() {
    let by_error = buckets().error_lods();
    let case = case(1000, 60, Weight::Error);
    let selected = case.select_culled();
    let (choices, _, sums) = on_cpu(&case, &by_error, &selected);
    let threshold_px = 1.0 / f32::from_bits(sums.water_bits);
    assert!((0.01..100.0).contains(&threshold_px), "{threshold_px}");
    let mut coarser_would_not_do = 0;
    for ((instance, choice), cull) in case.instances.iter().zip(&choices).zip(&selected.culled) {
        if choice.vertex_count == 0 {
            continue;
        }
        let bucket = buckets().fitting(instance.character, choice.vertex_count);
        let error_px = buckets().bounds_m[bucket as usize] * cull.weight;
        assert!(error_px <= threshold_px * 1.001, "{error_px} pixels, {threshold_px} allowed");
        let coarser = buckets().fitting(instance.character, choice.vertex_count - 1);
        let coarser_px = buckets().bounds_m[coarser as usize] * cull.weight;
        coarser_would_not_do += u32::from(coarser_px * 1.05 > threshold_px);
    }
    assert!(coarser_would_not_do > selected.sums.visible_count / 2);
    assert_eq!(misspent(&case, &choices, u64::from(case.config.budget) / 100), None);
}

/// Why the budget of a case is not well spent, if it is not. `allowance`: vertices that may be left over.
fn misspent(case: &Case, choices: &[LodChoice], allowance: u64) -> Option<String> {
    let (used, least, full) = used(case, choices);
    let n = u64::from(case.config.budget);
    let expected = n.clamp(least, full.max(least));
    (used > n.max(least) || used + allowance < expected).then(|| format!("{used} of {n} used, {least} to {full}"))
}

#[test]
fn at_least_99_percent_is_used_when_more_is_wanted() {
    let quantized = buckets().quantized_lods(data());
    for weight in [Weight::Area, Weight::AreaDistance] {
        for each in [20, 50, 100, 150, 400] {
            let case = case(1000, each, weight);
            let selected = case.select();
            for lods in [&data().lods, &quantized] {
                let (choices, _, _) = on_cpu(&case, lods, &selected);
                assert_eq!(misspent(&case, &choices, u64::from(case.config.budget) / 100), None, "{each} each");
            }
        }
    }
    // Plain Eq. 1 leaves more over, so the check can fail.
    let case = case(1000, 150, Weight::Area);
    let plain = case.select().choices;
    assert!(misspent(&case, &plain, u64::from(case.config.budget) / 100).is_some());
}

/// The same case with a budget of triangles.
fn in_triangles(mut case: Case) -> Case {
    case.config.budget_in = BudgetIn::Triangles as u32;
    case
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_by_triangles_are_equal_and_others_than_by_vertices() {
    let quantized = buckets().quantized_lods(data());
    for case in cases().chain(budgets()).chain(budgets().map(dotted)).map(in_triangles) {
        let selected = case.select_culled();
        let (choices, fill, sums) = on_gpu(&case, &quantized, &selected);
        let expected = on_cpu(&case, &quantized, &selected);
        let budget = case.config.budget;
        assert_eq!(first_difference(&choices, &expected.0), None, "{} instances, {budget}", case.count());
        assert_eq!((fill.low_bits, fill.low_count, fill.goal), (expected.1.low_bits, expected.1.low_count, budget));
        assert_eq!((sums.min_vertex_count, sums.wanted_count), (expected.2.min_vertex_count, 0));
    }
    let by_vertices = case(1000, 30, Weight::Area);
    let by_triangles = in_triangles(case(1000, 30, Weight::Area));
    let of = |case: &Case| on_cpu(case, &quantized, &case.select_culled()).0;
    assert_ne!(of(&by_vertices), of(&by_triangles));
}

/// Triangles of the levels, of the coarsest and of full detail of the visible, against the budget: as [`misspent`].
fn misspent_triangles(case: &Case, choices: &[LodChoice], allowance: u64) -> Option<String> {
    let (mut used, mut least, mut full) = (0, 0, 0);
    for (instance, choice) in case.instances.iter().zip(choices).filter(|(_, c)| c.vertex_count > 0) {
        let character = &case.data.characters[instance.character as usize];
        used += u64::from(choice.triangle_count);
        least += u64::from(character.min_triangle_count);
        full += u64::from(character.triangle_count);
    }
    let n = u64::from(case.config.budget);
    let expected = n.clamp(least, full.max(least));
    (used > n.max(least) || used + allowance < expected).then(|| format!("{used} of {n} used, {least} to {full}"))
}

#[test]
fn at_least_99_percent_of_a_budget_of_triangles_is_used_when_more_is_wanted() {
    let quantized = buckets().quantized_lods(data());
    for weight in [Weight::Area, Weight::AreaDistance] {
        for each in [20, 50, 100, 150, 400, 900] {
            let case = in_triangles(case(1000, each, weight));
            for lods in [&data().lods, &quantized] {
                let (choices, _, _) = on_cpu(&case, lods, &case.select_culled());
                let allowance = u64::from(case.config.budget) / 100;
                assert_eq!(misspent_triangles(&case, &choices, allowance), None, "{each} each");
            }
        }
    }
    // A budget of vertices is another one, so the check can fail.
    let case = case(1000, 150, Weight::Area);
    let (choices, _, _) = on_cpu(&case, &quantized, &case.select_culled());
    assert!(misspent_triangles(&case, &choices, u64::from(case.config.budget) / 100).is_some());
}

/// A case whose water may stay, after a frame that had it so high.
fn after(mut case: Case, slack: u32, water_before_bits: u32) -> Case {
    (case.config.slack, case.config.water_before_bits) = (slack, water_before_bits);
    case
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn water_that_may_stay_is_equally_high_on_both_sides() {
    let quantized = buckets().quantized_lods(data());
    let budget = case(1000, 60, Weight::Area).config.budget;
    let case_of = |before: u32| after(case(1000, 60, Weight::Area), budget / 100, before);
    let first = case_of(0);
    let selected = first.select_culled();
    let (_, fill, _) = on_cpu(&first, &quantized, &selected);
    assert_eq!(fill.goal, budget, "nobody was there before");
    for factor in [0.0, 0.3, 0.97, 0.995, 1.0, 1.004, 1.1, 40.0] {
        let before = (f32::from_bits(fill.low_bits) * factor).to_bits();
        for case in [case_of(before), in_triangles(case_of(before))] {
            let selected = case.select_culled();
            let (choices, gpu_fill, _) = on_gpu(&case, &quantized, &selected);
            let expected = on_cpu(&case, &quantized, &selected);
            assert_eq!(first_difference(&choices, &expected.0), None, "{factor}");
            let of = |f: FillState| (f.low_bits, f.high_bits, f.low_count, f.goal);
            assert_eq!(of(gpu_fill), of(expected.1), "{factor}");
            assert!(gpu_fill.smooth_bits.abs_diff(expected.1.smooth_bits) <= 2, "{gpu_fill:?}, {:?}", expected.1);
        }
    }
}

/// It stays while what it comes to is between the budget less the slack and the budget; else it goes to the nearer of the two and a little beyond.
#[test]
fn water_stays_or_goes_just_beyond_the_nearer_edge_of_the_slack_and_stays_there() {
    let quantized = buckets().quantized_lods(data());
    let plain = case(1000, 60, Weight::Area);
    let (budget, selected) = (plain.config.budget, plain.select_culled());
    let slack = budget / 50;
    let of = |before: u32| {
        let case = after(case(1000, 60, Weight::Area), slack, before);
        let (choices, fill, _) = on_cpu(&case, &quantized, &selected);
        (choices.iter().map(|choice| choice.vertex_count).sum::<u32>(), fill)
    };
    let (full, top) = of(0);
    let height = |factor: f32| (f32::from_bits(top.low_bits) * factor).to_bits();
    let (kept, fill) = of(height(0.99));
    assert_eq!((fill.low_bits, fill.high_bits, fill.smooth_bits), (height(0.99), height(0.99), height(0.99)));
    assert!((budget - slack..full).contains(&kept), "{kept}");
    let (risen, fill) = of(height(0.5));
    assert!(fill.low_bits > height(0.5) && fill.low_bits < top.low_bits);
    let edge = budget - slack + slack / 8;
    assert!(risen <= edge && risen + budget / 100 > edge, "{risen}: only as far as it must");
    let (fallen, fill_after) = of(height(1.5));
    assert!(fallen <= budget - slack / 8 && fallen + slack > budget, "{fallen} of {budget}");
    // Nothing is searched for, and nobody moves, in the frame after either.
    for bits in [fill.smooth_bits, fill_after.smooth_bits] {
        let (kept, fill) = of(bits);
        assert_eq!((fill.low_bits, fill.high_bits, fill.smooth_bits), (bits, bits, bits));
        assert!((budget - slack..=budget).contains(&kept), "{kept} of {budget}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    /// Never above N; what is left over is less than one instance's step between quantised levels, or than 3 % of a large
    /// level where the table is continuous.
    #[test]
    fn the_budget_is_never_exceeded_and_only_a_step_is_left_over(
        count in 1u32..400, budget in 0u32..120_000, far in 0.2f32..3.0, area_distance: bool, quantized: bool,
    ) {
        let weight = if area_distance { Weight::AreaDistance } else { Weight::Area };
        let mut case = case(count, 1, weight);
        case.config.budget = budget;
        case.config.eye = case.config.eye.map(|axis| axis * far);
        let selected = case.select();
        let tables = buckets().quantized_lods(data());
        let lods = if quantized { &tables } else { &data().lods };
        let (choices, _, _) = on_cpu(&case, lods, &selected);
        prop_assert_eq!(misspent(&case, &choices, largest_step()), None);
    }
}

/// Most vertices between two neighbouring quantised levels of a character.
fn largest_step() -> u64 {
    let step = |b: &crowd_stages::BucketRecord| u64::from(b.vertex_count - b.coarser_vertex_count);
    buckets().records.iter().map(step).max().expect("there are levels")
}
