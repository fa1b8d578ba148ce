//! All stages through the renderer, as an engine runs them, and the picture that comes out.

use crate::cases::{SIZES, case, data, first_difference};
use crowd_raster::{ImageDifference, Target, compare_images};
use crowd_stages::gpu::{ANIMATION_HEIGHT, ANIMATION_WIDTH, CrowdRenderer, RendererOptions};
use crowd_stages::{
    Capacities, CrowdData, DrawArgs, DrawOptions, Fit, FrameConfig, FrameTotals, InstanceBase, InstanceRecord,
    LodChoice, Technique, Weight, cpu, overflow,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::Vec3;

pub const OPTIONS: RendererOptions = RendererOptions {
    max_instances: 70_000,
    max_vertices: 4_000_000,
    max_triangles: 8_000_000,
    color_format: Picture::FORMAT,
    sample_count: 1,
    depth_format: wgpu::TextureFormat::Depth32Float,
    reverse_z: false,
};

pub fn draw(
    renderer: &mut CrowdRenderer,
    picture: &Picture,
    config: &FrameConfig,
    technique: impl Into<DrawOptions>,
) -> FrameTotals {
    let (device, queue) = gpu::device();
    let mut encoder = device.create_command_encoder(&Default::default());
    renderer
        .encode(device, queue, &mut encoder, &picture.view, picture.size, config, technique)
        .expect("a small picture");
    queue.submit([encoder.finish()]);
    renderer.totals(device, true).expect("a frame was submitted and waited for")
}

pub fn renderer(options: RendererOptions, instances: &[InstanceRecord]) -> CrowdRenderer {
    renderer_of(data(), options, instances)
}

pub fn renderer_of(data: &CrowdData, options: RendererOptions, instances: &[InstanceRecord]) -> CrowdRenderer {
    let (device, queue) = gpu::device();
    let mut renderer = CrowdRenderer::new(device, queue, data, options).expect("within default limits");
    renderer.set_instances(queue, instances).expect("synthetic instances are valid");
    renderer
}

/// Colours of 640 x 360 pixels compared.
pub fn compare(a: &[[u8; 4]], b: &[[u8; 4]]) -> ImageDifference {
    let target = |color: &[[u8; 4]]| Target { width: 640, height: 360, color: color.to_vec(), depth: Vec::new() };
    compare_images(&target(a), &target(b)).expect("both have the same size")
}

/// A near view of a small crowd.
pub fn close_up() -> (Vec<InstanceRecord>, FrameConfig) {
    let instances = synthetic::instances(data(), 60);
    let view = synthetic::view(Vec3::new(2.0, 2.2, 8.0), Vec3::new(0.0, 0.8, 0.0), u32::MAX, Weight::Area, 360);
    (instances, FrameConfig::from_camera(&view))
}

/// The same people, none of whom fades.
pub fn one_clip_each(fading: &[InstanceRecord]) -> Vec<InstanceRecord> {
    fading.iter().map(|one| InstanceRecord { leaving_share: 0.0, ..*one }).collect()
}

/// Whether pictures of people who fade, skinned with palettes and without, differ by rounding alone: points lie some 1e-6 m apart, so that a channel
/// is rounded to its neighbour here and there (115 of 230,400 pixels are allowed, 50 were found), and a pixel's middle hardly ever changes sides
/// of an edge or of a shadow's (4 are allowed, 1 was found).
pub fn is_rounding(difference: &ImageDifference) -> bool {
    difference.share_over(0) <= 5e-4 && difference.share_over(2) <= 2e-5
}

/// What there is to say of it in a line.
pub fn apart(difference: &ImageDifference) -> String {
    let [any, seen] = [0, 2].map(|threshold| difference.share_over(threshold));
    format!("{any:.1e} of the pixels differ, {seen:.1e} by more than 2, at most by {}", difference.max)
}

/// How many vertices two chains may differ by in one instance: one from Eq. 1, one from the share, and a level's step.
const CHAIN_BOUND: u32 = 5;

/// Levels may differ by a little in a few instances, since weights do (`cpu::FLOAT_BOUND`).
fn choices_differ(gpu: &[LodChoice], cpu: &[LodChoice]) -> Option<String> {
    let apart = |i: &usize| gpu[*i].vertex_count.abs_diff(cpu[*i].vertex_count) > CHAIN_BOUND;
    if let Some(i) = (0..cpu.len()).find(apart) {
        return Some(format!("instance {i}: {:?} on the GPU, {:?} on the CPU", gpu[i], cpu[i]));
    }
    let different = gpu.iter().zip(cpu).filter(|(gpu, cpu)| gpu != cpu).count();
    (different * 50 > cpu.len()).then(|| format!("{different} of {} instances have other levels", cpu.len()))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_chain_agrees_and_its_buffers_follow_from_its_levels() {
    let mut renderer = renderer(OPTIONS, &[]);
    let picture = Picture::new((64, 36));
    let capacities =
        Capacities { vertex_count: OPTIONS.max_vertices, triangle_count: OPTIONS.max_triangles, ..Default::default() };
    for count in SIZES {
        let case = case(count, 30, Weight::Area);
        renderer.set_instances(&gpu::device().1, &case.instances).expect("valid");
        let totals = draw(&mut renderer, &picture, &case.config, Technique::Reform);
        let (frame, _) = cpu::run_frame(case.data, &case.instances, &case.config, &capacities, Fit::Fill);

        let buffer = |name| renderer.buffer(Technique::Reform, name).expect("reformation writes it");
        let [choices, bases, slots, indices, args] =
            ["choices", "bases", "slot_instances", "indices", "draw_args"].map(buffer);
        let n = case.instances.len();
        let choices: Vec<LodChoice> = gpu::read(choices, n);
        assert_eq!(choices_differ(&choices, &frame.choices), None, "{count} instances");
        assert!(totals.vertex_count <= case.config.budget.max(totals.min_vertex_count));
        assert_eq!(totals.overflow & !overflow::BUDGET, 0);

        let (expected_bases, end) = cpu::scan_counts(&choices);
        assert_eq!(first_difference(&gpu::read::<InstanceBase>(bases, n), &expected_bases), None, "{count} instances");
        let expected = cpu::place_vertices(&choices, &expected_bases, &capacities);
        assert_eq!(first_difference(&gpu::read(slots, expected.len()), &expected), None, "{count} instances");
        let expected = cpu::reform_triangles(case.data, &case.instances, &choices, &expected_bases, &capacities);
        assert_eq!(first_difference(&gpu::read(indices, expected.len()), &expected), None, "{count} instances");
        assert_eq!(gpu::read::<DrawArgs>(args, 1)[0].index_count, end.triangle_base * 3);
        assert_eq!((totals.vertex_count, totals.triangle_count), (end.vertex_base, end.triangle_base));
    }
}

#[test]
fn chains_that_differ_too_much_are_seen() {
    let case = case(1000, 30, Weight::Area);
    let choices = case.select().choices;
    assert_eq!(choices_differ(&choices, &choices), None);
    let mut one_far = choices.clone();
    one_far[3].vertex_count += CHAIN_BOUND + 1;
    assert!(choices_differ(&one_far, &choices).is_some());
    let many: Vec<LodChoice> = choices.iter().map(|c| LodChoice { vertex_count: c.vertex_count + 1, ..*c }).collect();
    assert!(choices_differ(&many, &choices).is_some());
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn at_full_detail_reformation_and_pseudo_instancing_draw_the_same_picture() {
    let (instances, config) = close_up();
    let mut renderer = renderer(OPTIONS, &instances);
    let picture = Picture::new((640, 360));
    let reformed_totals = draw(&mut renderer, &picture, &config, Technique::Reform);
    let reformed = picture.pixels();
    let full_totals = draw(&mut renderer, &picture, &config, Technique::PseudoInstancing);
    let full = picture.pixels();

    let colors: std::collections::BTreeSet<[u8; 4]> = reformed.iter().copied().collect();
    assert!(colors.len() > 1000, "{} colours: this is not a picture", colors.len());
    assert!(reformed_totals.visible_count > 40 && full_totals.visible_count == 60);
    assert_eq!(compare(&reformed, &full).max, 0, "not one pixel differs");

    // The comparison can fail: with few vertices the picture is another.
    let coarse = FrameConfig { budget: 2000, ..config };
    draw(&mut renderer, &picture, &coarse, Technique::Reform);
    assert!(compare(&picture.pixels(), &full).share_over(8) > 0.01);
}

/// Texels are addressed by one number over rows and layers of the animation texture.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn clips_far_down_the_animation_texture_draw_the_same_picture() {
    let (instances, config) = close_up();
    let picture = Picture::new((640, 360));
    draw(&mut renderer(OPTIONS, &instances), &picture, &config, Technique::Reform);
    let near = picture.pixels();

    let mut moved = data().clone();
    let before = ANIMATION_WIDTH * ANIMATION_HEIGHT * 2 - 100;
    moved.animation = vec![[9.0_f32.to_bits(); 4]; before as usize];
    moved.animation.extend_from_slice(&data().animation);
    for clip in &mut moved.clips {
        clip.texel_offset += before;
    }
    draw(&mut renderer_of(&moved, OPTIONS, &instances), &picture, &config, Technique::Reform);
    assert_eq!(compare(&picture.pixels(), &near).max, 0, "not one pixel differs");

    // One texel further, and the rows of the matrices are others.
    for clip in &mut moved.clips {
        clip.texel_offset -= 1;
    }
    draw(&mut renderer_of(&moved, OPTIONS, &instances), &picture, &config, Technique::Reform);
    assert!(compare(&picture.pixels(), &near).share_over(8) > 0.01);
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_same_frame_gives_the_same_bytes() {
    let case = case(1000, 30, Weight::Area);
    let picture = Picture::new((640, 360));
    let options = RendererOptions { sample_count: 4, ..OPTIONS };
    let mut first = renderer(options, &case.instances);
    let totals = draw(&mut first, &picture, &case.config, Technique::Reform);
    let pixels = picture.pixels();
    let mut second = renderer(options, &case.instances);
    assert_eq!(draw(&mut second, &picture, &case.config, Technique::Reform), totals);
    assert_eq!(first_difference(&picture.pixels(), &pixels), None);
    let later = FrameConfig { time_s: case.config.time_s + 0.3, ..case.config };
    draw(&mut second, &picture, &later, Technique::Reform);
    assert!(first_difference(&picture.pixels(), &pixels).is_some(), "people move");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn small_buffers_are_reported_and_the_rest_is_drawn() {
    let (instances, config) = close_up();
    let options = RendererOptions { max_vertices: 3000, max_triangles: 100_000, ..OPTIONS };
    let mut renderer = renderer(options, &instances);
    let totals = draw(&mut renderer, &Picture::new((64, 36)), &config, Technique::Reform);
    assert_eq!(totals.overflow, overflow::VERTICES);
    assert!(totals.needed_vertices > 3000 && (2000..=3000).contains(&totals.vertex_count), "{totals:?}");
}

/// Four samples of the largest picture come to eight gigabytes: more than most devices have, and never a panic.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_picture_without_room_is_an_error_and_the_next_one_is_drawn() {
    let (device, queue) = gpu::device();
    let (instances, config) = close_up();
    let mut renderer = renderer(RendererOptions { sample_count: 4, ..OPTIONS }, &instances);
    let small = Picture::new((64, 36));
    let side = device.limits().max_texture_dimension_2d;
    let mut dropped = device.create_command_encoder(&Default::default());
    match renderer.encode(device, queue, &mut dropped, &small.view, (side, side), &config, Technique::Reform) {
        Err(error) => assert!(error.to_string().contains("no memory for"), "{error}"),
        // That much memory there is, on some devices.
        Ok(()) => return,
    }
    drop(dropped);
    assert!(draw(&mut renderer, &small, &config, Technique::Reform).triangle_count > 0);
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_does_not_fit_is_refused_with_numbers() {
    let (device, queue) = gpu::device();
    let enormous = RendererOptions { max_triangles: u32::MAX, ..OPTIONS };
    let mut without_reform =
        CrowdRenderer::new(device, queue, data(), enormous).expect("nothing asks for triangles yet");
    let error = without_reform.prepare(device, queue, Technique::Reform).expect_err("48 GiB of indices").to_string();
    assert!(without_reform.prepare(device, queue, Technique::Bucketed).is_ok(), "it writes no indices");
    assert!(error.contains("index buffer") && error.contains("lower the vertex budget"), "{error}");
    let clamped = enormous.clamped_to(&device.limits());
    assert!(clamped.max_triangles < u32::MAX && clamped.max_vertices == OPTIONS.max_vertices);

    let mut renderer = renderer(RendererOptions { max_instances: 2, ..OPTIONS }, &[]);
    let one = synthetic::instances(data(), 1)[0];
    assert!(renderer.set_instances(queue, &[one; 3]).is_err());
    let error = renderer.set_instances(queue, &[InstanceRecord { character: 9, ..one }]).expect_err("three characters");
    assert_eq!(error.to_string(), "instance 0: character 9, the pack has 3");
    let stranger = InstanceRecord { clip: data().characters[2].clip_offset, character: 0, ..one };
    assert!(renderer.set_instances(queue, &[stranger]).is_err(), "a clip of another character");
}
