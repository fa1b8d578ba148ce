//! `build_pyramid` on the GPU against its twin: equal.

use crate::cases::first_difference;
use crowd_stages::{PyramidConfig, cpu, gpu::BuildPyramid};
use crowd_tests::{gpu, synthetic::hash};

/// Odd, even, long, a power of two, one pixel, one whose second level is large.
const SIZES: [(u32, u32); 8] = [(1, 1), (2, 1), (64, 64), (63, 65), (641, 17), (1, 300), (320, 181), (700, 401)];

/// A depth of a picture that a formula draws: the vertex shader covers it, the fragment shader has the depth.
const PAINT: &str = "
@vertex fn cover(@builtin(vertex_index) v: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((v << 1u) & 2u), f32(v & 2u)) * 2.0 - 1.0, 0.5, 1.0);
}
fn hash(x: u32) -> u32 {
    var h = (x ^ (x >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return h ^ (h >> 16u);
}
@fragment fn one(@builtin(position) at: vec4f) -> @builtin(frag_depth) f32 {
    return f32(hash(u32(at.y) * 4096u + u32(at.x)) >> 8u) / 16777216.0;
}
@fragment fn several(@builtin(position) at: vec4f, @builtin(sample_index) s: u32) -> @builtin(frag_depth) f32 {
    return f32(hash((s << 24u) + u32(at.y) * 4096u + u32(at.x)) >> 8u) / 16777216.0;
}";

fn painted(width: u32, height: u32, samples: u32) -> Vec<f32> {
    let at = |x: u32, y: u32, s: u32| (hash((s << 24) + y * 4096 + x) >> 8) as f32 / 16_777_216.0;
    (0..width * height).flat_map(|i| (0..samples).map(move |s| at(i % width, i / width, s))).collect()
}

fn paint(width: u32, height: u32, samples: u32) -> wgpu::TextureView {
    let (device, queue) = gpu::device();
    let format = wgpu::TextureFormat::Depth32Float;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(PAINT.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cover"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(if samples > 1 { "several" } else { "one" }),
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    });
    let view = texture.create_view(&Default::default());
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..1);
    }
    queue.submit([encoder.finish()]);
    view
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn pyramids_agree_for_odd_sizes_and_several_samples() {
    let stage = BuildPyramid::new(&gpu::device().0);
    for (samples, reversed) in [(1, 0), (4, 0), (1, 1), (4, 1)] {
        for (width, height) in SIZES {
            let config = PyramidConfig { reversed, ..PyramidConfig::new(width, height, samples) };
            let farthest = gpu::output::<f32>(config.number_count() as usize);
            let depth = paint(width, height, samples);
            let bound = stage.bind(&gpu::device().0, config, &gpu::uniform(&config), &farthest, &depth);
            gpu::run(|pass| stage.record(pass, &bound));
            let expected = cpu::build_pyramid(&config, &painted(width, height, samples));
            let found = gpu::read(&farthest, config.number_count() as usize);
            assert_eq!(first_difference(&found, &expected), None, "{width} x {height}, {samples} samples");
        }
    }
}

#[test]
fn every_pixel_is_in_the_block_that_its_shifted_coordinates_name() {
    for (width, height) in SIZES {
        let config = PyramidConfig::new(width, height, 2);
        let last = config.levels[config.level_count as usize - 1];
        assert_eq!((last.width, last.height), (1, 1));
        let depth = painted(width, height, 2);
        let farthest = cpu::build_pyramid(&config, &depth);
        for (k, level) in config.levels[..config.level_count as usize].iter().enumerate() {
            let mut most = vec![0.0f32; (level.width * level.height) as usize];
            for (i, sample) in depth.iter().enumerate() {
                let (x, y) = (i as u32 / 2 % width, i as u32 / 2 / width);
                let block = ((y >> (k + 1)) * level.width + (x >> (k + 1))) as usize;
                most[block] = most[block].max(*sample);
            }
            let found = &farthest[level.offset as usize..][..most.len()];
            assert_eq!(first_difference(found, &most), None, "{width} x {height}, level {k}");
        }
        let mut changed = farthest.clone();
        *changed.last_mut().expect("at least one number") *= 0.5;
        assert!(first_difference(&changed, &farthest).is_some());
    }
}
