//! A stage's time stands under its own name: it grows with the stage's work, and with that of no other.

use crate::cases::case;
use crate::whole_chain::{OPTIONS, draw, renderer};
use crowd_stages::gpu::CrowdRenderer;
use crowd_stages::{FrameConfig, Technique, Weight};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::Vec3;
use std::collections::BTreeMap;

/// Each stage's middle time of nine frames, milliseconds: whoever else uses the machine makes some longer, and moves a stamp now and then.
fn median_ms(renderer: &mut CrowdRenderer, config: &FrameConfig) -> BTreeMap<&'static str, f32> {
    let picture = Picture::new((64, 36));
    let mut all: BTreeMap<&'static str, Vec<f32>> = BTreeMap::new();
    for _ in 0..9 {
        draw(renderer, &picture, config, Technique::Reform);
        renderer.timings_ms().into_iter().for_each(|(name, ms)| all.entry(name).or_default().push(ms));
    }
    let median = |mut times: Vec<f32>| {
        times.sort_by(f32::total_cmp);
        times[times.len() / 2]
    };
    all.into_iter().map(|(name, times)| (name, median(times))).collect()
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_stages_time_grows_with_its_own_work() {
    if !gpu::device().0.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        println!("not tested: this adapter has no time stamps");
        return;
    }
    let many = case(1000, 30, Weight::Area);
    let mut crowd = renderer(OPTIONS, &many.instances);
    let fine = FrameConfig { budget: u32::MAX, ..many.config };
    let up = synthetic::view(Vec3::new(0.0, 900.0, 0.0), Vec3::new(1.0, 2000.0, 0.0), u32::MAX, Weight::Area, 36);
    let nobody = FrameConfig { instance_count: fine.instance_count, ..FrameConfig::from_camera(&up) };
    let [fine, nobody] = [fine, nobody].map(|config| median_ms(&mut crowd, &config));
    println!("at full detail: {fine:?}; nobody seen: {nobody:?}");
    // Filling in triangles takes longer than what comes before and after it, and much less where there are none; under its neighbour's name it took a thirtieth of that one.
    let reform_ms = fine["reform_triangles"];
    assert!(reform_ms > 2.0 * nobody["reform_triangles"], "{fine:?} {nobody:?}");
    assert!(reform_ms > 3.0 * fine["write_draw_args"] && reform_ms > fine["place_vertices"], "{fine:?}");

    // The first stage has a time, too.
    let few = case(64, 30, Weight::Area);
    let mut handful = renderer(OPTIONS, &few.instances);
    let all = case(70_000, 1, Weight::Area);
    let mut masses = renderer(OPTIONS, &all.instances);
    let [few, all] = [median_ms(&mut handful, &few.config), median_ms(&mut masses, &all.config)];
    println!("more by count: {all:?} and {few:?}");
    assert!(all["cull_instances"] > 3.0 * few["cull_instances"], "{all:?} {few:?}");
}
