//! `key_instances` on the GPU against its twins: equal.

use crate::cases::{Case, Selected, buckets, case, cases, data, first_difference};
use crowd_stages::{Buckets, Weight, cpu, gpu::KeyInstances};
use crowd_tests::gpu;

fn on_gpu(case: &Case, selected: &Selected, full_detail: bool) -> Vec<u32> {
    let stage = KeyInstances::new(&gpu::device().0);
    let keys = gpu::output::<u32>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&buckets().counts()),
        &gpu::storage(&case.instances),
        &gpu::storage(&buckets().sets),
        &gpu::storage(&buckets().records),
        &gpu::storage(&selected.culled),
        &gpu::storage(&selected.choices),
        &keys,
    );
    gpu::run(|pass| match full_detail {
        true => stage.record_full_detail(pass, &bound, case.count()),
        false => stage.record(pass, &bound, case.count()),
    });
    gpu::read(&keys, case.instances.len())
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn keys_are_equal_for_all_sizes() {
    for case in cases() {
        let selected = case.select();
        let expected = cpu::key_instances(buckets(), &case.instances, &selected.choices);
        assert_eq!(first_difference(&on_gpu(&case, &selected, false), &expected), None, "{}", case.count());
        let expected = cpu::key_full_detail(buckets(), &case.instances, &selected.culled);
        assert_eq!(first_difference(&on_gpu(&case, &selected, true), &expected), None, "{}", case.count());
    }
}

#[test]
fn keys_name_levels_of_the_own_character_that_are_no_larger_than_chosen() {
    let case = case(1000, 30, Weight::Area);
    let choices = case.select().choices;
    let keys = cpu::key_instances(buckets(), &case.instances, &choices);
    for ((instance, choice), key) in case.instances.iter().zip(&choices).zip(keys) {
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
