//! `key_instances` on the GPU against its twins: equal.

use crate::cases::{Case, Selected, buckets, case, cases, data, dotted, first_difference, impostored};
use crowd_stages::{Buckets, FillState, IMPOSTOR_FADE, MorphRecord, Weight, cpu, dot_reach, gpu::KeyInstances};
use crowd_tests::gpu;

fn on_gpu(case: &Case, selected: &Selected, fill: FillState, full_detail: bool) -> (Vec<u32>, Vec<MorphRecord>) {
    let reach = dot_reach(&case.data.characters);
    let plain = run(&KeyInstances::new(&gpu::device().0), case, selected, fill, full_detail);
    let dots_first = run(&KeyInstances::with_dots(&gpu::device().0, reach), case, selected, fill, full_detail);
    assert_eq!(first_difference(&dots_first.0, &plain.0), None, "{}", case.count());
    if !full_detail {
        assert_eq!(first_difference(&dots_first.1, &plain.1), None, "{}", case.count());
    }
    plain
}

fn run(
    stage: &KeyInstances,
    case: &Case,
    selected: &Selected,
    fill: FillState,
    full_detail: bool,
) -> (Vec<u32>, Vec<MorphRecord>) {
    let (keys, morphs) = (gpu::output::<u32>(case.instances.len()), gpu::output::<MorphRecord>(case.instances.len()));
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&buckets().counts()),
        &gpu::storage(&case.instances),
        &gpu::storage(&buckets().sets),
        &gpu::storage(&buckets().records),
        &gpu::storage(&selected.culled),
        &gpu::storage(&selected.choices),
        &gpu::storage(&[fill]),
        &keys,
        &morphs,
    );
    gpu::run(|pass| match full_detail {
        true => stage.record_full_detail(pass, &bound, case.count()),
        false => stage.record(pass, &bound, case.count()),
    });
    (gpu::read(&keys, case.instances.len()), gpu::read(&morphs, case.instances.len()))
}

/// The case with its budget filled, morphing or not.
fn filled(mut case: Case, morph: u32) -> (Case, Selected, FillState) {
    case.config.morph = morph;
    let mut selected = case.select();
    let lods = buckets().quantized_lods(data());
    let (choices, fill) =
        cpu::fill_budget(case.data, &lods, &case.instances, &selected.culled, &mut selected.sums, &case.config);
    selected.choices = choices;
    (case, selected, fill)
}

fn expected(case: &Case, selected: &Selected, fill: &FillState) -> (Vec<u32>, Vec<MorphRecord>) {
    cpu::key_instances(buckets(), &case.instances, &selected.culled, &selected.choices, fill, &case.config)
}

/// The first morph that is not within the bound.
fn morphs_differ(gpu: &[MorphRecord], cpu: &[MorphRecord]) -> Option<String> {
    let apart = |(a, b): (&MorphRecord, &MorphRecord)| {
        a.coarser_vertex_count != b.coarser_vertex_count || (a.fraction - b.fraction).abs() > cpu::FRACTION_BOUND
    };
    let i = gpu.iter().zip(cpu).position(apart)?;
    Some(format!("instance {i}: {:?} on the GPU, {:?} on the CPU", gpu[i], cpu[i]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn keys_and_morphs_agree_for_all_sizes() {
    for (number, case) in cases().chain(cases().map(dotted)).chain(cases().map(impostored)).enumerate() {
        let (case, selected, fill) = filled(case, number as u32 % 2);
        let (keys, morphs) = on_gpu(&case, &selected, fill, false);
        let expected = expected(&case, &selected, &fill);
        assert_eq!(first_difference(&keys, &expected.0), None, "{}", case.count());
        assert_eq!(morphs_differ(&morphs, &expected.1), None, "{}", case.count());
        let expected = cpu::key_full_detail(buckets(), &case.instances, &selected.culled);
        assert_eq!(first_difference(&on_gpu(&case, &selected, fill, true).0, &expected), None, "{}", case.count());
    }
}

/// Casters of shadows: nobody sees them, but they have levels.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn those_with_levels_whom_nobody_sees_have_keys() {
    let (case, mut selected, fill) = filled(dotted(case(1000, 7, Weight::Area)), 0);
    selected.culled.iter_mut().step_by(3).for_each(|cull| cull.visible = 0);
    let (keys, morphs) = on_gpu(&case, &selected, fill, false);
    let expected = expected(&case, &selected, &fill);
    let dots = keys.iter().step_by(3).filter(|key| (buckets().mesh_count..buckets().nobody()).contains(key)).count();
    assert!(dots > 20, "{dots} dots: the case is not worth running");
    assert_eq!(first_difference(&keys, &expected.0), None);
    assert_eq!(morphs_differ(&morphs, &expected.1), None);
}

#[test]
fn fractions_tell_where_between_two_levels_the_water_stands() {
    let (case, selected, fill) = filled(case(1000, 60, Weight::Area), 1);
    let (_, morphs) = expected(&case, &selected, &fill);
    let seen = || morphs.iter().filter(|m| m.coarser_vertex_count > 0);
    for tenth in 0..10 {
        let range = tenth as f32 * 0.1..(tenth + 1) as f32 * 0.1;
        assert!(seen().filter(|m| range.contains(&m.fraction)).count() > 5, "fractions from {range:?}");
    }
    let mut changed = morphs.clone();
    changed[seen().count() / 2].fraction += 0.01;
    assert!(morphs_differ(&changed, &morphs).is_some());

    // Ample budget: all at full detail and where they belong. Without morphing: all where they belong.
    for (each, morph) in [(1000, 1), (60, 0)] {
        let (case, selected, fill) = filled(crate::cases::case(1000, each, Weight::Area), morph);
        let (_, morphs) = expected(&case, &selected, &fill);
        let seen = morphs.iter().zip(&selected.choices).filter(|(_, choice)| choice.vertex_count > 0);
        assert!(seen.clone().count() > 100 && seen.clone().all(|(m, _)| m.fraction == 1.0));
    }
}

/// Who is small enough is an impostor, who is a little larger is both and has a share of the pixels by size, and nobody else is any.
#[test]
fn impostors_are_those_who_are_small_enough() {
    let (case, selected, fill) = filled(impostored(case(1000, 60, Weight::Area)), 1);
    let (keys, morphs) = expected(&case, &selected, &fill);
    let whole = case.config.impostor_area_px2;
    let (mut alone, mut fading) = (0, Vec::new());
    let all = case.instances.iter().zip(keys.iter().zip(&morphs)).zip(&selected.culled);
    for ((instance, (key, morph)), cull) in all.filter(|(_, cull)| cull.visible != 0) {
        let is_small = cull.area_px2 < whole;
        if *key >= buckets().first_fade {
            assert!(!is_small && cull.area_px2 < IMPOSTOR_FADE * whole && morph.fraction <= 1.0, "{cull:?}");
            fading.push((cull.area_px2, morph.fraction));
        } else if *key >= buckets().first_impostor {
            assert!(is_small && morph.fraction == 1.0, "{cull:?}");
            alone += 1;
        } else {
            let is_large = data().characters[instance.character as usize].min_vertex_count > 4;
            assert!(!is_small || !is_large || cull.area_px2 < case.config.dot_area_px2, "{cull:?}");
        }
    }
    fading.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(alone > 50 && fading.len() > 20, "{alone} alone, {} on the way", fading.len());
    assert!(fading.is_sorted_by(|a, b| a.1 >= b.1), "the larger, the less of the impostor: {fading:?}");
}

#[test]
fn keys_name_levels_of_the_own_character_that_are_no_larger_than_chosen() {
    let case = case(1000, 30, Weight::Area);
    let selected = case.select();
    let choices = &selected.choices;
    let (keys, _) = expected(&case, &selected, &FillState::default());
    for ((instance, choice), key) in case.instances.iter().zip(choices).zip(keys) {
        let of_its_own = |b: &Buckets| {
            let levels = 0..b.sets[instance.character as usize].level_count;
            levels.map(|l| b.at(instance.character, l)).any(|bucket| bucket == key)
        };
        if choice.vertex_count == 0 {
            assert_eq!(key, buckets().nobody());
        } else {
            assert!(of_its_own(buckets()) && buckets().records[key as usize].vertex_count <= choice.vertex_count);
        }
    }
}

/// The tables are worth comparing with: same triangles as the levels reformed, in another order, of both widths.
#[test]
fn tables_hold_the_reformed_triangles() {
    let b = buckets();
    assert!(b.count_16 > 0 && b.nobody() > b.count_16, "indices of both widths");
    let mut moved = 0;
    for (number, character) in data().characters.iter().enumerate() {
        for level in 0..b.sets[number].level_count {
            let bucket = b.at(number as u32, level);
            let record = b.records[bucket as usize];
            let choice =
                crowd_stages::LodChoice { vertex_count: record.vertex_count, triangle_count: record.triangle_count };
            let (mut table, mut reformed) = (b.triangles(bucket), cpu::reform_level(data(), character, choice));
            moved += usize::from(table != reformed);
            table.sort_unstable();
            reformed.sort_unstable();
            assert_eq!(table, reformed, "character {number}, level {level}");
        }
    }
    assert!(moved > 10, "the order is another");
}
