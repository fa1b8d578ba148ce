//! A device whose shaders may bind little at a time: buffers are written in parts, or the rest is worked out in another way, and the picture is the same.

use crate::cases::{buckets, data};
use crate::whole_chain::{OPTIONS, close_up, one_clip_each};
use crowd_stages::gpu::{CrowdRenderer, RendererOptions, wanted_features, wanted_limits};
use crowd_stages::{DrawOptions, FrameConfig, FrameTotals, InstanceRecord, Skinning, Technique, Weight, overflow};
use crowd_tests::{gpu, synthetic};
use glam::Vec3;

const SIZE: (u32, u32) = (320, 180);
/// Bytes that a shader of the small device may bind.
const SMALL: u64 = 1 << 16;

fn small_device() -> (wgpu::Device, wgpu::Queue) {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = wgpu::Backends::PRIMARY.with_env();
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
        .expect("the other tests have one, too");
    let limits = wanted_limits(&adapter.limits());
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wanted_features() & adapter.features(),
        required_limits: wgpu::Limits { max_storage_buffer_binding_size: SMALL, ..limits },
        ..Default::default()
    }))
    .expect("less than there is");
    assert_eq!(device.limits().max_storage_buffer_binding_size, SMALL);
    (device, queue)
}

/// Who is drawn, and in how much room.
struct Scene {
    instances: Vec<InstanceRecord>,
    config: FrameConfig,
    options: RendererOptions,
}

/// A few people close up.
fn few() -> Scene {
    let (instances, config) = close_up();
    let config = FrameConfig { budget: 15_000, ..config };
    let options = RendererOptions { max_instances: 60, max_vertices: 16_000, max_triangles: 40_000, ..OPTIONS };
    Scene { instances, config, options }
}

/// As many as the small device has room for in its other lists.
fn many() -> Scene {
    let instances = synthetic::instances(data(), 800);
    let view = synthetic::view(Vec3::new(6.0, 14.0, 34.0), Vec3::new(0.0, 0.5, 0.0), 24_000, Weight::Area, SIZE.1);
    let options = RendererOptions { max_instances: 800, max_vertices: 60_000, max_triangles: 90_000, ..OPTIONS };
    Scene { instances, config: FrameConfig { hold_far_m: 10.0, ..FrameConfig::from_camera(&view) }, options }
}

/// The renderer, what each frame came to, and its pixels.
fn frames(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
    all: &[DrawOptions],
) -> (CrowdRenderer, Vec<(FrameTotals, Vec<u8>)>) {
    let Scene { instances, config, options } = scene;
    let mut renderer = CrowdRenderer::new(device, queue, data(), *options).expect("a small crowd");
    // What does not fit is worked out in another way, which would be seen of those who fade.
    renderer.set_instances(queue, &one_clip_each(instances)).expect("valid");
    let extent = wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: options.color_format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    let back = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE.0 * SIZE.1 * 4),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let draw = |renderer: &mut CrowdRenderer, draw: DrawOptions| {
        let mut encoder = device.create_command_encoder(&Default::default());
        renderer.encode(device, queue, &mut encoder, &view, SIZE, config, draw).expect("a small picture");
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE.0 * 4), rows_per_image: None };
        let into = wgpu::TexelCopyBufferInfo { buffer: &back, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), into, extent);
        queue.submit([encoder.finish()]);
        let totals = renderer.totals(device, true).expect("a frame was submitted");
        let (sender, mapped) = std::sync::mpsc::channel();
        back.map_async(wgpu::MapMode::Read, .., move |result| sender.send(result).expect("the receiver waits below"));
        device.poll(wgpu::PollType::wait_indefinitely()).expect("not lost");
        mapped.recv().expect("called once").expect("a buffer can be mapped");
        let pixels = back.get_mapped_range(..).expect("just mapped").to_vec();
        back.unmap();
        (totals, pixels)
    };
    let drawn = all.iter().map(|options| draw(&mut renderer, *options)).collect();
    (renderer, drawn)
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn pictures_of_a_device_that_binds_little_are_those_of_one_that_binds_all() {
    let bucketed = |skinning| DrawOptions { skinning, ..DrawOptions::from(Technique::Bucketed) };
    let all = [
        Technique::Reform.into(),
        Technique::Instanced.into(),
        Technique::Discrete.into(),
        bucketed(Skinning::Vertex),
        bucketed(Skinning::Palettes),
        bucketed(Skinning::Compute),
    ];
    let (device, queue) = small_device();
    let (small, small_frames) = frames(&device, &queue, &few(), &all);
    let (device, queue) = gpu::device();
    let (large, large_frames) = frames(device, queue, &few(), &all);
    for ((options, small), large) in all.iter().zip(&small_frames).zip(&large_frames) {
        assert_eq!(small.0, large.0, "{options:?}");
        assert!(small.1 == large.1, "{options:?}: the pictures differ");
        assert_eq!(small.0.overflow & !overflow::BUDGET, 0, "{options:?}");
    }
    let indices = 12 * u64::from(small_frames[0].0.triangle_count);
    assert!(indices > 3 * SMALL, "{indices} bytes of indices: the case is not worth running");
    assert!(small_frames[0].1 != small_frames[2].1, "and pictures can differ");
    // Vertices that have no place are worked out by the vertex shader.
    let room = |renderer: &CrowdRenderer| renderer.buffer(Technique::Bucketed, "skinned").map_or(0, wgpu::Buffer::size);
    assert_eq!((room(&small), room(&large)), (SMALL / 24 * 24, 16_000 * 24));
    assert!([&small, &large].into_iter().all(|renderer| renderer.skinning(Skinning::Compute).refused.is_none()));
}

/// The first ones have palettes and skinned vertices, the others are skinned in the vertex shader.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn more_people_than_there_are_palettes_look_as_if_all_had_one() {
    let ways = [Skinning::Vertex, Skinning::Palettes, Skinning::Compute];
    let all = ways.iter().flat_map(|skinning| {
        let own = DrawOptions { skinning: *skinning, ..DrawOptions::from(Technique::Bucketed) };
        [own, DrawOptions { no_morph: true, ..own }, DrawOptions { shadows: 2, ..own }]
    });
    let all: Vec<DrawOptions> = all.collect();
    let (device, queue) = small_device();
    let (small, small_frames) = frames(&device, &queue, &many(), &all);
    let (device, queue) = gpu::device();
    let (_, large_frames) = frames(device, queue, &many(), &all);
    for ((options, small), large) in all.iter().zip(&small_frames).zip(&large_frames) {
        assert_eq!(small.0, large.0, "{options:?}");
        assert!(small.1 == large.1, "{options:?}: the pictures differ");
        assert_eq!(small.0.overflow, 0, "{options:?}");
    }
    let palettes = small.buffer(Technique::Bucketed, "palettes").expect("drawn with them").size();
    let slots = palettes / (16 * u64::from(buckets().palette_rows));
    let seen = u64::from(small_frames[0].0.visible_count);
    assert!(slots > 100 && seen > slots + 50, "{slots} palettes for {seen} people: the case is not worth running");
    assert!(u64::from(small_frames[0].0.vertex_count) * 24 > 2 * SMALL);
    let choice = small.skinning(Skinning::Compute);
    assert!(choice.refused.is_none() && choice.way == Skinning::Compute, "{choice:?}");
}

/// Whose leader has no palette is drawn in their own pose, which is the same but for rounding.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn who_shares_a_pose_that_has_no_palette_looks_the_same() {
    let base = DrawOptions { holds_poses: true, share_poses: true, ..DrawOptions::from(Technique::Bucketed) };
    let all = [Skinning::Palettes, Skinning::Compute].map(|skinning| DrawOptions { skinning, ..base });
    let (small_device, small_queue) = small_device();
    let (device, queue) = gpu::device();
    let (mut small, small_frames) = frames(&small_device, &small_queue, &many(), &all);
    let (_, large_frames) = frames(device, queue, &many(), &all);
    for ((options, small), large) in all.iter().zip(&small_frames).zip(&large_frames) {
        assert_eq!(small.0, large.0, "{options:?}");
        let apart = small.1.iter().zip(&large.1).filter(|(a, b)| a.abs_diff(**b) > 8).count();
        println!("{options:?}: {apart} of {} numbers", small.1.len());
        assert!(apart * 5_000 <= small.1.len(), "{options:?}: {apart} of {} numbers differ", small.1.len());
    }
    let poses = small.shared_poses(&small_device, &small_queue).expect("can be read").expect("they were shared");
    let slots = SMALL / (16 * u64::from(buckets().palette_rows));
    assert!(u64::from(poses) > slots, "{poses} poses, {slots} palettes: the case is not worth running");
}
