//! `gather_drawn` on the GPU against its twin: integers equal, other numbers within a bound.

use crate::cases::{Case, buckets, case, cases, data, first_difference, impostored};
use crowd_stages::{BucketPlace, BucketRange, Buckets, DrawnInstance, MorphRecord, Weight, cpu, gpu::GatherDrawn};
use crowd_tests::gpu;
use std::collections::BTreeMap;

#[derive(Clone)]
pub struct Sorted {
    pub keys: Vec<u32>,
    pub values: Vec<u32>,
    pub morphs: Vec<MorphRecord>,
    pub ranges: Vec<BucketRange>,
    pub places: Vec<BucketPlace>,
}

/// Sorted by bucket, with morphs all over, and room for so many skinned vertices.
pub fn sorted(case: &Case, vertex_capacity: u32) -> Sorted {
    sorted_in(buckets(), case, vertex_capacity)
}

/// The same of a crowd of other data.
pub fn sorted_in(buckets: &Buckets, case: &Case, vertex_capacity: u32) -> Sorted {
    let selected = case.select();
    let fill = Default::default();
    let (keys, morphs) =
        cpu::key_instances(buckets, &case.instances, &selected.culled, &selected.choices, &fill, &case.config);
    let spread = |(i, m): (usize, MorphRecord)| MorphRecord { fraction: (i % 11) as f32 * 0.1, ..m };
    let (keys, values) = cpu::sort_instances(&keys);
    let (ranges, ..) = cpu::write_bucket_args(buckets, &keys, &selected.sums, &case.config);
    let (places, ..) = cpu::place_buckets(buckets, &ranges, vertex_capacity);
    Sorted { keys, values, morphs: morphs.into_iter().enumerate().map(spread).collect(), ranges, places }
}

fn on_gpu(case: &Case, sorted: &Sorted) -> Vec<DrawnInstance> {
    on_gpu_in(buckets(), case, sorted)
}

fn on_gpu_in(buckets: &Buckets, case: &Case, sorted: &Sorted) -> Vec<DrawnInstance> {
    run(buckets, case, sorted, |stage, pass, bound| stage.record(pass, bound, case.count()))
}

fn run(
    buckets: &Buckets,
    case: &Case,
    sorted: &Sorted,
    record: impl FnOnce(&GatherDrawn, &mut wgpu::ComputePass<'_>, &wgpu::BindGroup),
) -> Vec<DrawnInstance> {
    let stage = GatherDrawn::new(&gpu::device().0);
    let drawn = gpu::output::<DrawnInstance>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&buckets.counts()),
        &gpu::storage(&case.instances),
        &gpu::storage(&data().characters),
        &gpu::storage(&data().clips),
        &gpu::storage(&sorted.morphs),
        &gpu::storage(&sorted.keys),
        &gpu::storage(&sorted.values),
        &gpu::storage(&sorted.places),
        &drawn,
    );
    gpu::run(|pass| record(&stage, pass, &bound));
    gpu::read(&drawn, case.instances.len())
}

/// The same in the order of the instances.
fn scattered(case: &Case, sorted: &Sorted) -> Vec<DrawnInstance> {
    let places = || sorted.values.iter().zip(0..).zip(&sorted.keys);
    let (mut keys, mut entries) = (sorted.keys.clone(), sorted.values.clone());
    for ((i, place), key) in places() {
        (keys[*i as usize], entries[*i as usize]) = (*key, place);
    }
    let listed = Sorted { keys, values: entries, ..sorted.clone() };
    run(buckets(), case, &listed, |stage, pass, bound| stage.record_scattered(pass, bound, case.count()))
}

pub fn on_cpu(case: &Case, sorted: &Sorted) -> Vec<DrawnInstance> {
    on_cpu_in(buckets(), case, sorted)
}

/// The same of a crowd of other data.
pub fn on_cpu_in(buckets: &Buckets, case: &Case, sorted: &Sorted) -> Vec<DrawnInstance> {
    let Sorted { keys, values, morphs, places, .. } = sorted;
    cpu::gather_drawn(case.data, buckets, &case.instances, morphs, keys, values, places, case.config.time_s)
}

/// Whether the shares of frames and all else agree. At a frame's border the two may stand on either side of it.
fn agree(a: &DrawnInstance, b: &DrawnInstance) -> bool {
    let near = |a: f32, b: f32| (a - b).abs() <= cpu::DRAWN_BOUND;
    let pairs = |d: &DrawnInstance| {
        [(d.first_texel, d.second_texel, d.blend), (d.leaving_first_texel, d.leaving_second_texel, d.leaving_blend)]
    };
    let frames = pairs(a).into_iter().zip(pairs(b)).all(|(a, b)| {
        let is_at_border = near(a.2.max(b.2), 1.0) && near(a.2.min(b.2), 0.0);
        is_at_border || ((a.0, a.1) == (b.0, b.1) && near(a.2, b.2))
    });
    let integers = |d: &DrawnInstance| (d.coarser_vertex_count, d.material_offset, d.position.map(f32::to_bits));
    let bases = |d: &DrawnInstance| (d.vertex_base, d.palette_row, d.row_count);
    let rest = integers(a) == integers(b) && bases(a) == bases(b) && a.scale == b.scale && a.fraction == b.fraction;
    rest && frames && a.leaving_share == b.leaving_share && (0..2).all(|k| near(a.turn[k], b.turn[k]))
}

fn first_apart(gpu: &[DrawnInstance], cpu: &[DrawnInstance]) -> Option<String> {
    let place = gpu.iter().zip(cpu).position(|(gpu, cpu)| !agree(gpu, cpu))?;
    Some(format!("at {place}: {:?} on the GPU, {:?} on the CPU", gpu[place], cpu[place]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn drawn_instances_agree_for_all_sizes() {
    for case in cases().chain(cases().map(impostored)) {
        let sorted = sorted(&case, case.count() * 20);
        let (gpu, cpu) = (on_gpu(&case, &sorted), on_cpu(&case, &sorted));
        assert_eq!(first_apart(&gpu, &cpu), None, "{} instances", case.count());
        let rest = gpu[cpu.len()..].iter().all(|drawn| *drawn == DrawnInstance::default());
        assert!(rest, "nobody is drawn after the last");
        assert_eq!(first_difference(&scattered(&case, &sorted), &gpu), None, "{} instances, scattered", case.count());
        // With palettes for fewer than are drawn.
        let meshes = sorted.keys.iter().filter(|key| **key < buckets().mesh_count).count();
        let few = Buckets { palette_slots: meshes as u32 / 3, ..buckets().clone() };
        let (gpu, of_few) = (on_gpu_in(&few, &case, &sorted), on_cpu_in(&few, &case, &sorted));
        assert_eq!(first_apart(&gpu, &of_few), None, "{} instances, few palettes", case.count());
        assert!(meshes < 3 || first_apart(&cpu, &of_few).is_some(), "a palette that is not there is seen");
    }
}

#[test]
fn everyone_in_a_bucket_is_drawn_once_and_one_that_differs_is_seen() {
    let case = case(1000, 30, Weight::Area);
    let drawn = on_cpu(&case, &sorted(&case, u32::MAX));
    let visible = case.select().sums.visible_count as usize;
    assert!(visible > 100 && drawn.len() == visible);
    let mut changed = drawn.clone();
    changed[visible / 2].turn[1] += 0.01;
    assert!(first_apart(&changed, &drawn).is_some());
    changed[visible / 2] = DrawnInstance { vertex_base: drawn[visible / 2].vertex_base + 1, ..drawn[visible / 2] };
    assert!(first_apart(&changed, &drawn).is_some());
    changed[visible / 2] = DrawnInstance { second_texel: 7, ..drawn[visible / 2] };
    assert!(first_apart(&changed, &drawn).is_some());
    changed[visible / 2] = DrawnInstance { leaving_first_texel: 7, ..drawn[visible / 2] };
    assert!(first_apart(&changed, &drawn).is_some());
    assert!(drawn.iter().filter(|one| one.leaving_share > 0.1).count() > visible / 4, "many fade");
}

/// Joints with their weights, in the order of the joints: their places differ.
fn influences(joints: [u32; 2], weights: [u32; 2]) -> BTreeMap<u32, u32> {
    let halves = |words: [u32; 2]| [words[0] & 0xffff, words[0] >> 16, words[1] & 0xffff, words[1] >> 16];
    let mut sums = BTreeMap::new();
    for (joint, weight) in halves(joints).into_iter().zip(halves(weights)).filter(|(_, weight)| *weight > 0) {
        *sums.entry(joint).or_default() += weight;
    }
    sums
}

/// What a morph needs is a property of the vertex: the one that its level's coarser neighbour has in its place.
#[test]
fn origins_are_where_the_coarser_level_has_them() {
    let origins = buckets().origins(data());
    let mut moved = 0;
    for (number, character) in data().characters.iter().enumerate() {
        let first = character.vertex_offset as usize;
        let level = |l: u32| buckets().records[buckets().at(number as u32, l) as usize];
        for l in 0..buckets().sets[number].level_count {
            let record = level(l);
            let coarser = if l == 0 { 0 } else { record.coarser_vertex_count };
            for v in coarser..record.vertex_count {
                let mut at = v;
                while l > 0 && at >= coarser {
                    at = data().collapse_map[first + at as usize];
                }
                let (origin, from) = (origins[first + v as usize], data().vertices[first + at as usize]);
                assert_eq!((origin.vertex, origin.position, origin.uv), (v, from.position, from.uv));
                assert_eq!(influences(origin.joints, origin.weights), influences(from.joints, from.weights));
                moved += usize::from(at != v);
            }
        }
    }
    assert!(moved > 100, "{moved} vertices come from somewhere else");
}
