//! Instances that a simulator's own compute shader writes: drawn as if the CPU had set them.

use crate::cases::data;
use crate::whole_chain::{OPTIONS, close_up, compare, draw, renderer};
use crowd_stages::gpu::{CrowdRenderer, InstanceFeed};
use crowd_stages::{CrowdBounds, DrawOptions, FrameConfig, InstanceRecord, Skinning, Technique};
use crowd_tests::gpu::{self, Picture};

/// A simulator: rows of people, everyone turned a little more; every eleventh is of no character there is.
const SIMULATOR: &str = "
struct InstanceRecord {
    position: vec3f,
    yaw_rad: f32,
    scale: f32,
    character: u32,
    clip: u32,
    phase_s: f32,
    leaving_clip: u32,
    leaving_phase_s: f32,
    leaving_share: f32,
    reserved: u32,
}

@group(0) @binding(0) var<storage, read_write> instances: array<InstanceRecord>;
@group(0) @binding(1) var<storage, read_write> count: u32;

@compute @workgroup_size(64)
fn simulate(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i == 0u {
        count = 150u;
    }
    if i < arrayLength(&instances) {
        let place = vec3f(f32(i % 16u) - 8.0, 0.0, -f32(i / 16u));
        let character = select(i % 3u, 99u, i % 11u == 0u);
        instances[i] = InstanceRecord(place, f32(i) * 0.1, 0.8, character, (i % 3u) * 2u, f32(i) * 0.01,
            (i % 3u) * 2u + 1u, 0.3, select(0.0, 0.5, i % 4u == 0u), 0u);
    }
}
";

/// What a frame may ask for: everyone's room is more than the simulator fills.
const MOST: u32 = 200;

/// Two buffers that the simulator has written: people, and how many.
fn simulated() -> (wgpu::Buffer, wgpu::Buffer) {
    let (device, _) = gpu::device();
    let (instances, count) = (gpu::output::<InstanceRecord>(MOST as usize), gpu::output::<u32>(1));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SIMULATOR.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("simulate"),
        compilation_options: Default::default(),
        cache: None,
    });
    let bound = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: instances.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: count.as_entire_binding() },
        ],
    });
    gpu::run(|pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bound, &[]);
        pass.dispatch_workgroups(MOST.div_ceil(64), 1, 1);
    });
    (instances, count)
}

/// The same on the CPU, with nobody in place of those that cannot be drawn.
fn sound(instances: &wgpu::Buffer) -> Vec<InstanceRecord> {
    let all: Vec<InstanceRecord> = gpu::read(instances, 150);
    all.into_iter().map(|one| if one.character < 3 { one } else { InstanceRecord::default() }).collect()
}

fn lend(renderer: &mut CrowdRenderer, instances: &wgpu::Buffer, count: Option<&wgpu::Buffer>, characters: &[u32]) {
    let (device, queue) = gpu::device();
    let mut bounds = CrowdBounds::default();
    bounds.add(glam::Vec3::ZERO, 20.0);
    let feed = InstanceFeed { instances, count, most: MOST, bounds, characters };
    renderer.borrow_instances(device, queue, &feed).expect("it fits");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_a_simulator_writes_is_drawn_as_if_the_cpu_had_set_it() {
    let (_, config) = close_up();
    let config = FrameConfig { budget: 12_000, dot_area_px2: 300.0, ..config };
    let (written, count) = simulated();
    let people = sound(&written);
    assert_eq!(people.iter().filter(|one| one.scale == 0.0).count(), 14);
    let mut by_cpu = renderer(OPTIONS, &people);
    let mut by_gpu = renderer(OPTIONS, &[]);
    lend(&mut by_gpu, &written, Some(&count), &[]);
    let picture = Picture::new((640, 360));
    let compute = DrawOptions { skinning: Skinning::Compute, ..Technique::Bucketed.into() };
    let occlusion = DrawOptions { occlusion: true, ..Technique::Bucketed.into() };
    let shadows = DrawOptions { shadows: 2, ..Technique::Bucketed.into() };
    let all: [DrawOptions; 7] = [
        Technique::Bucketed.into(),
        compute,
        occlusion,
        shadows,
        Technique::Reform.into(),
        Technique::Instanced.into(),
        Technique::Discrete.into(),
    ];
    for options in all {
        let expected_totals = draw(&mut by_cpu, &picture, &config, options);
        let expected = picture.pixels();
        let totals = draw(&mut by_gpu, &picture, &config, options);
        let difference = compare(&picture.pixels(), &expected);
        // The same box of the crowd is not known, so the maps of the sun lie elsewhere.
        let allowed = if options.shadows > 0 { 0.05 } else { 0.0 };
        assert!(difference.share_over(0) <= allowed, "{options:?}: {}", difference.share_over(0));
        assert_eq!((totals.refused_count, expected_totals.refused_count), (14, 0));
        assert_eq!(totals.visible_count, expected_totals.visible_count, "{options:?}");
        assert_eq!(totals.vertex_count, expected_totals.vertex_count, "{options:?}");
        assert_eq!(totals.outside_count, expected_totals.outside_count, "{options:?}");
    }
    // Without the count, all that there is room for; and back to the CPU's.
    lend(&mut by_gpu, &written, None, &[]);
    let more = draw(&mut by_gpu, &picture, &config, Technique::Instanced);
    assert_eq!(more.visible_count + more.outside_count, MOST);
    by_gpu.set_instances(&gpu::device().1, &people).expect("they are sound");
    let again = draw(&mut by_gpu, &picture, &config, Technique::Bucketed);
    assert_eq!(again, draw(&mut by_cpu, &picture, &config, Technique::Bucketed));
}

/// Casters of a frame with more people stay in the buffers; they may not push those who are left out of the lists.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn who_is_left_when_a_simulators_people_go_throws_the_same_shadow() {
    let (device, queue) = gpu::device();
    let (_, config) = close_up();
    let config = FrameConfig { budget: 12_000, ..config };
    let (written, _) = simulated();
    let count = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 4,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let picture = Picture::new((640, 360));
    let of = |renderer: &mut CrowdRenderer, people: u32, skinning, shadows| {
        queue.write_buffer(&count, 0, bytemuck::bytes_of(&people));
        let options = DrawOptions { skinning, shadows, ..Technique::Bucketed.into() };
        let totals = draw(renderer, &picture, &config, options);
        assert_eq!(totals.visible_count + totals.outside_count, people);
        picture.pixels()
    };
    let [mut fresh, mut used] = [(), ()].map(|()| renderer(OPTIONS, &[]));
    lend(&mut fresh, &written, Some(&count), &[]);
    lend(&mut used, &written, Some(&count), &[]);
    // One map, for what stays is of the last map drawn, and in outer ones there are few.
    for skinning in [Skinning::Compute, Skinning::Vertex] {
        let [expected, plain] = [1, 0].map(|shadows| of(&mut fresh, 40, skinning, shadows));
        assert!(compare(&expected, &plain).share_over(0) > 0.01, "shadows are seen");
        of(&mut used, 150, skinning, 1);
        let left = of(&mut used, 40, skinning, 1);
        let different = compare(&left, &expected).share_over(0);
        assert_eq!(different, 0.0, "{}", skinning.name());
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_draw_for_each_instance_needs_their_characters() {
    let (device, queue) = gpu::device();
    let (_, config) = close_up();
    let (written, count) = simulated();
    let mut renderer = renderer(OPTIONS, &[]);
    lend(&mut renderer, &written, Some(&count), &[]);
    let picture = Picture::new((64, 64));
    let mut encoder = device.create_command_encoder(&Default::default());
    let refused =
        renderer.encode(device, queue, &mut encoder, &picture.view, picture.size, &config, Technique::PseudoInstancing);
    assert!(refused.expect_err("nobody said who they are").to_string().contains("characters"));
    let characters: Vec<u32> = (0..MOST).map(|i| i % 3).collect();
    lend(&mut renderer, &written, Some(&count), &characters);
    let totals = draw(&mut renderer, &picture, &config, Technique::PseudoInstancing);
    assert_eq!((totals.draw_count, totals.refused_count), (MOST, 14));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn buffers_that_do_not_fit_are_refused() {
    let (device, queue) = gpu::device();
    let mut renderer = renderer(OPTIONS, &[]);
    let (small, none) = (gpu::output::<InstanceRecord>(10), gpu::uniform(&[0_u32; 4096]));
    let big = gpu::output::<InstanceRecord>(OPTIONS.max_instances as usize + 1);
    let mut refused = |instances: &wgpu::Buffer, most: u32, characters: &[u32]| {
        let feed = InstanceFeed { instances, count: None, most, bounds: CrowdBounds::default(), characters };
        renderer.borrow_instances(device, queue, &feed).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let limits = device.limits();
    let huge = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("more than a binding holds"),
        size: limits.max_storage_buffer_binding_size + 48,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    assert!(limits.max_buffer_size > limits.max_storage_buffer_binding_size, "else there is no such buffer");
    assert!(refused(&huge, 1, &[]).contains("larger bindings"));
    assert!(refused(&none, 0, &[]).contains("STORAGE"));
    assert!(refused(&small, 11, &[]).contains("needs 528"));
    assert!(refused(&none, 10, &[]).contains("STORAGE"));
    assert!(refused(&big, OPTIONS.max_instances + 1, &[]).contains("max_instances"));
    assert!(refused(&small, 2, &[0]).contains("another number"));
    assert!(refused(&small, 2, &[0, 3]).contains("instance 1: character 3"));
    assert_eq!(refused(&small, 2, &[0, 2]), "");
    assert!(data().characters.len() == 3);
}
