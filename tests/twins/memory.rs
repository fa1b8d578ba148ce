//! Memory that a renderer foretells against what it asks for, and that against what the device has given.

use crate::cases::data;
use crate::whole_chain::{OPTIONS, close_up, draw, renderer};
use crowd_stages::gpu::{CrowdRenderer, MemoryUse, RendererOptions, open_device};
use crowd_stages::{DrawOptions, FrameConfig, Skinning, Technique, View};
use crowd_tests::gpu::{self, Picture};

/// Frames of which each asks for other things.
fn asking() -> Vec<Vec<DrawOptions>> {
    let vertex = |technique| DrawOptions { skinning: Skinning::Vertex, ..DrawOptions::from(technique) };
    let bucketed = vertex(Technique::Bucketed);
    let compute = DrawOptions { skinning: Skinning::Compute, ..bucketed };
    let shared = DrawOptions { holds_poses: true, share_poses: true, ..compute };
    let occluded = DrawOptions { occlusion: true, ..bucketed };
    let shaded = DrawOptions { shadows: 2, ..bucketed };
    let viewed = DrawOptions { view: View::Levels, ..bucketed };
    let mut all: Vec<Vec<DrawOptions>> =
        Technique::ALL.into_iter().filter(|t| *t != Technique::StaticFloor).map(|t| vec![vertex(t)]).collect();
    all.extend([vec![compute], vec![shared], vec![occluded], vec![shaded], vec![viewed]]);
    all.push(vec![DrawOptions { shadows: 2, ..compute }]);
    all.push(vec![vertex(Technique::Reform), compute, occluded, shaded]);
    all
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_frames_will_ask_for_is_what_they_ask_for() {
    let (instances, config) = close_up();
    let config = FrameConfig { hold_px: 1.0, budget: 6000, ..config };
    let options = RendererOptions { max_instances: 1000, max_vertices: 70_000, max_triangles: 90_000, ..OPTIONS };
    let picture = Picture::new((192, 108));
    for draws in asking() {
        let mut renderer = renderer(options, &instances);
        let foretold = renderer.memory_of(options, &draws, picture.size);
        for options in &draws {
            draw(&mut renderer, &picture, &config, *options);
        }
        assert_eq!(renderer.memory(), foretold, "{draws:?}");
        assert_eq!(renderer.gpu_bytes(), foretold.total());
        // The comparison can fail: room for one vertex more, where vertices have room of their own.
        let more = RendererOptions { max_vertices: options.max_vertices + 1, ..options };
        let has_room = draws.iter().any(|d| d.technique == Technique::Reform || d.skinning == Skinning::Compute);
        assert_eq!(renderer.memory_of(more, &draws, picture.size) != foretold, has_room, "{draws:?}");
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_floor_is_foretold_as_the_most_it_can_be_and_room_can_be_made_anew() {
    let (instances, config) = close_up();
    let (device, queue) = gpu::device();
    let options = RendererOptions { max_vertices: 6000, max_triangles: 12_000, ..OPTIONS };
    let config = FrameConfig { budget: 6000, ..config };
    let floor = DrawOptions { skinning: Skinning::Vertex, ..DrawOptions::from(Technique::StaticFloor) };
    let picture = Picture::new((64, 36));
    let mut renderer = renderer(OPTIONS, &instances);
    draw(&mut renderer, &picture, &config, Technique::Reform);
    let large = renderer.gpu_bytes();
    renderer.make_room(options.max_vertices, options.max_triangles);
    assert!(renderer.gpu_bytes() + 4 * 4_000_000 < large, "the lists are gone");
    let foretold = renderer.memory_of(options, &[floor], picture.size);
    renderer.bake_floor(device, queue, data(), &instances, &config, floor).expect("a small mesh");
    draw(&mut renderer, &picture, &config, floor);
    let MemoryUse { floor, .. } = renderer.memory();
    assert!(floor > 0 && floor <= foretold.floor, "{floor} of {}", foretold.floor);
    assert_eq!(MemoryUse { floor, ..foretold }, renderer.memory());
    let totals = draw(&mut renderer, &picture, &config, Technique::Reform);
    assert!(totals.vertex_count > 0 && totals.overflow == 0, "{totals:?}");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_is_asked_for_is_what_the_device_has_given() {
    // A device of its own: nobody else's buffers are in its report.
    let (device, queue, _) = open_device().expect("the other tests have one, too");
    let given = || -> Option<u64> {
        let report = device.generate_allocator_report()?;
        // wgpu's own, of data on its way.
        let own = |name: &str| name.contains("wgpu internal");
        Some(report.allocations.iter().filter(|one| !own(&one.name)).map(|one| one.size).sum())
    };
    let Some(before) = given() else {
        println!("this backend does not say what it has allocated");
        return;
    };
    let (instances, config) = close_up();
    let config = FrameConfig { budget: 6000, ..config };
    let mut renderer = CrowdRenderer::new(&device, &queue, data(), OPTIONS).expect("within default limits");
    renderer.set_instances(&queue, &instances).expect("valid");
    let size = wgpu::Extent3d { width: 640, height: 360, depth_or_array_layers: 1 };
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: OPTIONS.color_format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = target.create_view(&Default::default());
    for draws in asking() {
        for options in draws.into_iter().filter(|options| !options.share_poses) {
            let mut encoder = device.create_command_encoder(&Default::default());
            renderer.encode(&device, &queue, &mut encoder, &view, (640, 360), &config, options).expect("small");
            queue.submit([encoder.finish()]);
            device.poll(wgpu::PollType::wait_indefinitely()).expect("not lost");
        }
    }
    let target_bytes = 640 * 360 * 4;
    let given = (given().expect("it said before") - before) as f64;
    let asked = (renderer.gpu_bytes() + target_bytes) as f64;
    println!("{given} bytes given, {asked} asked for");
    assert!((0.99..1.02).contains(&(given / asked)), "{given} bytes given, {asked} asked for");
}
