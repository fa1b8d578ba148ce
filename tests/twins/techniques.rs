//! Techniques against each other: the same triangles must give the same picture.

use crate::cases::{buckets, case, data, first_difference};
use crate::whole_chain::{OPTIONS, close_up, compare, draw, renderer};
use crowd_stages::{DrawOptions, Fit, FrameConfig, Levels, LodChoice, Technique, Weight, cpu};
use crowd_tests::gpu::{self, Picture};

/// Reformation with levels snapped to those that have tables: the oracle.
const ORACLE: DrawOptions = DrawOptions { technique: Technique::Reform, levels: Levels::Quantized, fit: Fit::Fill };

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn bucketed_draws_what_reformation_of_the_same_levels_draws() {
    let (instances, config) = close_up();
    let mut renderer = renderer(OPTIONS, &instances);
    let picture = Picture::new((640, 360));
    for budget in [u32::MAX, 6000, 2500] {
        let config = FrameConfig { budget, ..config };
        let oracle_totals = draw(&mut renderer, &picture, &config, ORACLE);
        let oracle = picture.pixels();
        let totals = draw(&mut renderer, &picture, &config, Technique::Bucketed);
        let colors: std::collections::BTreeSet<[u8; 4]> = oracle.iter().copied().collect();
        assert!(colors.len() > 1000, "{} colours: this is not a picture", colors.len());
        assert_eq!(compare(&picture.pixels(), &oracle).max, 0, "budget {budget}: not one pixel differs");
        assert!(totals.draw_count >= 3);
        let of = |t: crowd_stages::FrameTotals| (t.visible_count, t.vertex_count, t.triangle_count, t.overflow);
        assert_eq!(of(totals), of(oracle_totals), "budget {budget}");

        // The comparison can fail: continuous levels are others.
        if budget == 6000 {
            draw(&mut renderer, &picture, &config, Technique::Reform);
            assert!(compare(&picture.pixels(), &oracle).max > 0);
        }
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_bucketed_chain_follows_from_its_levels_and_repeats_itself() {
    let case = case(5000, 30, Weight::Area);
    let picture = Picture::new((64, 36));
    let mut renderer = renderer(OPTIONS, &case.instances);
    let totals = draw(&mut renderer, &picture, &case.config, Technique::Bucketed);
    let n = case.instances.len();
    let read = |name| gpu::read::<u32>(renderer.buffer(Technique::Bucketed, name).expect("bucketing writes it"), n);
    let choices: Vec<LodChoice> =
        gpu::read(renderer.buffer(Technique::Bucketed, "choices").expect("the selection writes it"), n);
    let lods = buckets().quantized_lods(data());
    let frame = cpu::run_selection(data(), &lods, &case.instances, &case.config, Fit::Fill);
    let different = choices.iter().zip(&frame.choices).filter(|(gpu, cpu)| gpu != cpu).count();
    assert!(different * 50 < n, "{different} of {n} levels are others");
    let keys = cpu::key_instances(buckets(), &case.instances, &choices);
    let (sorted_keys, sorted) = cpu::sort_instances(&keys);
    assert_eq!(first_difference(&read("keys"), &keys), None);
    assert_eq!(first_difference(&read("sorted_keys"), &sorted_keys), None);
    assert_eq!(first_difference(&read("sorted_values"), &sorted), None);
    assert!(totals.vertex_count <= case.config.budget && totals.vertex_count > case.config.budget / 2);
    assert_eq!(draw(&mut renderer, &picture, &case.config, Technique::Bucketed), totals);
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn culling_and_instancing_change_nothing_on_the_picture() {
    let (instances, config) = close_up();
    let mut renderer = renderer(OPTIONS, &instances);
    let picture = Picture::new((640, 360));
    let all = draw(&mut renderer, &picture, &config, Technique::PseudoInstancing);
    let full = picture.pixels();
    let visible = draw(&mut renderer, &picture, &config, Technique::Instanced);
    assert_eq!(compare(&picture.pixels(), &full).max, 0, "not one pixel differs");
    assert!(visible.visible_count < all.visible_count && visible.draw_count == 3, "{visible:?}");

    // Three levels, all of them full detail.
    let far = FrameConfig { lod_depths_m: [f32::MAX; 2], ..config };
    let fine = draw(&mut renderer, &picture, &far, Technique::Discrete);
    assert_eq!(compare(&picture.pixels(), &full).max, 0, "not one pixel differs");
    let near = FrameConfig { lod_depths_m: [4.0, 8.0], ..config };
    let coarse = draw(&mut renderer, &picture, &near, Technique::Discrete);
    assert!(coarse.triangle_count < fine.triangle_count * 2 / 3 && coarse.draw_count > 3, "{coarse:?}");
    assert!(compare(&picture.pixels(), &full).share_over(8) > 0.01, "and this is another picture");
    let frame = cpu::select_discrete(data(), buckets(), &instances, &near);
    let of = |t: crowd_stages::FrameTotals| (t.visible_count, t.vertex_count, t.triangle_count);
    assert_eq!(of(coarse), of(frame.totals));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_static_floor_is_the_bucketed_picture_as_near_as_the_cpu_computes_it() {
    let (instances, config) = close_up();
    let config = FrameConfig { budget: 6000, ..config };
    let mut renderer = renderer(OPTIONS, &instances);
    let picture = Picture::new((640, 360));
    let totals = draw(&mut renderer, &picture, &config, Technique::Bucketed);
    let bucketed = picture.pixels();

    let (device, queue) = gpu::device();
    let mut encoder = device.create_command_encoder(&Default::default());
    let options = DrawOptions::from(Technique::StaticFloor);
    let unbaked = renderer.encode(device, queue, &mut encoder, &picture.view, picture.size, &config, options);
    assert!(unbaked.expect_err("nobody baked").to_string().contains("bake_floor"));
    renderer.bake_floor(device, queue, data(), &instances, &config, options).expect("it fits");
    let floor = draw(&mut renderer, &picture, &config, Technique::StaticFloor);
    let difference = compare(&picture.pixels(), &bucketed);
    assert!(difference.share_over(8) < 0.002, "{difference:?}");
    let of = |t: crowd_stages::FrameTotals| (t.visible_count, t.vertex_count, t.triangle_count);
    assert_eq!((of(floor), floor.draw_count), (of(totals), 1));
}
