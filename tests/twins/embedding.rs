//! The crowd in an engine's own targets: what the engine has drawn hides it and is hidden by it.

use crate::cases::data;
use crate::whole_chain::{OPTIONS, compare, draw, one_clip_each, renderer};
use crowd_stages::gpu::{CrowdRenderer, RendererOptions, Targets};
use crowd_stages::{
    DrawOptions, FrameConfig, FrameTotals, FrameView, InstanceRecord, Skinning, Technique, View, Weight,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::{Mat4, Vec3};
use wgpu::util::DeviceExt;

const SIZE: (u32, u32) = (640, 360);
const PIXELS: usize = (SIZE.0 * SIZE.1) as usize;
/// What the engine clears its colour to; a byte's middle each, so that rounding cannot change it.
const BACKGROUND: [u8; 4] = [255, 0, 255, 255];
const AT_ONCE: DrawOptions = DrawOptions {
    technique: Technique::Bucketed,
    levels: crowd_stages::Levels::Quantized,
    fit: crowd_stages::Fit::Fill,
    no_morph: true,
    no_impostors: false,
    occlusion: false,
    skinning: Skinning::Vertex,
    shadows: 0,
    holds_poses: false,
    share_poses: false,
    view: View::Shaded,
    frozen: false,
};

const WALL: &str = "
struct Wall { rect: vec4f, color: vec4f, depth: vec4f }
@group(0) @binding(0) var<uniform> wall: Wall;
@vertex fn place(@builtin(vertex_index) v: u32) -> @builtin(position) vec4f {
    let corner = array(vec2f(0.0, 0.0), vec2f(1.0, 0.0), vec2f(0.0, 1.0), vec2f(0.0, 1.0), vec2f(1.0, 0.0), vec2f(1.0, 1.0))[v];
    return vec4f(mix(wall.rect.xy, wall.rect.zw, corner), wall.depth.x, 1.0);
}
@fragment fn paint() -> @location(0) vec4f { return wall.color; }";

/// A wall across the view from one x to another, as far away as its depth says.
#[derive(Clone, Copy)]
struct Wall {
    x: [f32; 2],
    depth: f32,
    color: [u8; 4],
}

impl Wall {
    fn covers(&self, pixel: usize) -> bool {
        let x = ((pixel % SIZE.0 as usize) as f32 + 0.5) / SIZE.0 as f32 * 2.0 - 1.0;
        x > self.x[0] && x < self.x[1]
    }
}

/// An engine's targets and what it draws walls with.
struct Host {
    options: RendererOptions,
    picture: Picture,
    /// Where there are several samples.
    samples: Option<wgpu::TextureView>,
    depth: wgpu::Texture,
    walls: wgpu::RenderPipeline,
}

fn texture(format: wgpu::TextureFormat, sample_count: u32, usage: wgpu::TextureUsages) -> wgpu::Texture {
    gpu::device().0.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

impl Host {
    fn new(options: RendererOptions) -> Self {
        let RendererOptions { color_format, sample_count, depth_format, reverse_z, .. } = options;
        let device = &gpu::device().0;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(WALL.into()),
        });
        let nearer = if reverse_z { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Less };
        let walls = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: depth_format,
                depth_write_enabled: Some(true),
                depth_compare: Some(nearer),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: wgpu::MultisampleState { count: sample_count, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(color_format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let read = match depth_format {
            wgpu::TextureFormat::Depth32Float if sample_count == 1 => wgpu::TextureUsages::COPY_SRC,
            _ => wgpu::TextureUsages::empty(),
        };
        let none = wgpu::TextureUsages::empty();
        let samples =
            (sample_count > 1).then(|| texture(color_format, sample_count, none).create_view(&Default::default()));
        let depth = texture(depth_format, sample_count, read | wgpu::TextureUsages::TEXTURE_BINDING);
        Self { options, picture: Picture::new(SIZE), samples, depth, walls }
    }

    fn color(&self) -> &wgpu::TextureView {
        self.samples.as_ref().unwrap_or(&self.picture.view)
    }

    /// A pass of the engine's own; the first clears, the last resolves.
    fn pass(&self, encoder: &mut wgpu::CommandEncoder, walls: &[Wall], is_first: bool) {
        let device = &gpu::device().0;
        let nothing = if self.options.reverse_z { 0.0 } else { 1.0 };
        let (color, depth) = match is_first {
            true => {
                let [r, g, b, a] = BACKGROUND.map(|channel| f64::from(channel) / 255.0);
                (wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }), wgpu::LoadOp::Clear(nothing))
            }
            false => (wgpu::LoadOp::Load, wgpu::LoadOp::Load),
        };
        let view = self.depth.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: self.color(),
                depth_slice: None,
                resolve_target: (self.samples.is_some() && !is_first).then_some(&self.picture.view),
                ops: wgpu::Operations { load: color, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations { load: depth, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.walls);
        for wall in walls {
            let color = wall.color.map(|channel| f32::from(channel) / 255.0);
            let words = [[wall.x[0], -1.0, wall.x[1], 1.0], color, [wall.depth; 4]];
            let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: bytemuck::cast_slice(&words),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let bound = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &self.walls.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
            });
            pass.set_bind_group(0, &bound, &[]);
            pass.draw(0..6, 0..1);
        }
    }

    /// Walls, the crowd, more walls.
    fn frame(
        &self,
        crowd: &mut CrowdRenderer,
        config: &FrameConfig,
        options: DrawOptions,
        [before, after]: [&[Wall]; 2],
    ) -> FrameTotals {
        let (device, queue) = gpu::device();
        let mut encoder = device.create_command_encoder(&Default::default());
        self.pass(&mut encoder, before, true);
        // A view of its own each frame, as engines may make it.
        let depth = self.depth.create_view(&Default::default());
        let targets = Targets { color: self.color(), resolve: None, depth: &depth, size: SIZE };
        crowd.encode_into(device, queue, &mut encoder, &targets, config, options).expect("the targets fit");
        self.pass(&mut encoder, after, false);
        queue.submit([encoder.finish()]);
        crowd.totals(device, true).expect("a frame was submitted and waited for")
    }

    /// Of one sample a pixel in 32 bits.
    fn depths(&self) -> Vec<f32> {
        let (device, queue) = gpu::device();
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * PIXELS as u64,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE.0), rows_per_image: None };
        let into = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(self.depth.as_image_copy(), into, self.depth.size());
        queue.submit([encoder.finish()]);
        gpu::read(&buffer, PIXELS)
    }
}

/// The view of `close_up`.
fn view() -> FrameView {
    synthetic::view(Vec3::new(2.0, 2.2, 8.0), Vec3::new(0.0, 0.8, 0.0), u32::MAX, Weight::Area, SIZE.1)
}

fn camera(reversed: bool) -> FrameConfig {
    let view = view();
    let looks = glam::camera::rh::view::look_at_mat4(view.eye, Vec3::new(0.0, 0.8, 0.0), Vec3::Y);
    let reverse = glam::camera::rh::proj::directx::perspective_infinite_reverse(
        view.fov_y_rad,
        SIZE.0 as f32 / SIZE.1 as f32,
        0.1,
    );
    let clip_from_world = if reversed { reverse * looks } else { view.clip_from_world };
    FrameConfig::from_camera(&FrameView { clip_from_world, ..view })
}

fn people() -> Vec<InstanceRecord> {
    one_clip_each(&synthetic::instances(data(), 60))
}

/// The depth of what is so far ahead of the camera.
fn depth_at(config: &FrameConfig, metres: f32) -> f32 {
    let clip_from_world = Mat4::from_cols_array_2d(&config.clip_from_world);
    let eye = Vec3::from(config.eye);
    let ahead = (Vec3::new(0.0, 0.8, 0.0) - eye).normalize();
    clip_from_world.project_point3(eye + ahead * metres).z
}

/// The left half nearer, the right half farther.
fn walls(config: &FrameConfig) -> [Wall; 2] {
    [
        Wall { x: [-1.0, 0.0], depth: depth_at(config, 6.5), color: [0, 255, 0, 255] },
        Wall { x: [0.0, 1.0], depth: depth_at(config, 8.0), color: [0, 0, 255, 255] },
    ]
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn walls_hide_people_and_people_hide_walls_whichever_way_depth_goes() {
    let mut pictures = Vec::new();
    for reverse_z in [false, true] {
        let options = RendererOptions { reverse_z, ..OPTIONS };
        let config = camera(reverse_z);
        let host = Host::new(options);
        let mut crowd = renderer(options, &people());
        let nearer = |a: f32, b: f32| if reverse_z { a > b } else { a < b };
        let nothing = if reverse_z { 0.0 } else { 1.0 };

        // Alone: the engine's background stays, and people look as in the renderer's own picture.
        host.frame(&mut crowd, &config, AT_ONCE, [&[], &[]]);
        let (alone, depths) = (host.picture.pixels(), host.depths());
        let own = Picture::new(SIZE);
        draw(&mut crowd, &own, &config, AT_ONCE);
        let own = own.pixels();
        let shown: Vec<usize> = (0..PIXELS).filter(|p| depths[*p] != nothing).collect();
        let same = shown.iter().filter(|p| alone[**p] == own[**p]).count();
        assert!(shown.len() > 10_000 && same * 100 > 98 * shown.len(), "{same} of {}", shown.len());
        let stays =
            (0..PIXELS).filter(|p| depths[*p] == nothing).all(|p| alone[p] == BACKGROUND && own[p] != BACKGROUND);
        assert!(stays, "the background is the engine's");

        // One wall before the crowd is drawn, the other after.
        let [left, right] = walls(&config);
        host.frame(&mut crowd, &config, AT_ONCE, [&[left], &[right]]);
        let (found, found_depths) = (host.picture.pixels(), host.depths());
        let (mut hidden, mut before, mut behind) = (0, 0, 0);
        for p in 0..PIXELS {
            let (mut color, mut depth) = (BACKGROUND, nothing);
            if left.covers(p) {
                (color, depth) = (left.color, left.depth);
                let is_person = depths[p] != nothing;
                hidden += usize::from(is_person && !nearer(depths[p], depth));
                before += usize::from(is_person && nearer(depths[p], depth));
            }
            if nearer(depths[p], depth) {
                (color, depth) = (alone[p], depths[p]);
            }
            if right.covers(p) {
                behind += usize::from(!nearer(right.depth, depth));
                if nearer(right.depth, depth) {
                    (color, depth) = (right.color, right.depth);
                }
            }
            assert_eq!((found[p], found_depths[p]), (color, depth), "pixel {p}, reversed: {reverse_z}");
        }
        println!("reversed {reverse_z}: {hidden} hidden, {before} before the left wall, {behind} before the right one");
        assert!(hidden > 1000 && before > 1000 && behind > 1000);
        pictures.push(found);
    }
    let difference = compare(&pictures[0], &pictures[1]);
    assert!(difference.share_over(8) < 0.002, "{difference:?}");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn several_samples_and_a_stencil_show_the_same() {
    let config = camera(false);
    let [left, right] = walls(&config);
    let plain = Host::new(OPTIONS);
    plain.frame(&mut renderer(OPTIONS, &people()), &config, AT_ONCE, [&[left], &[right]]);
    let expected = plain.picture.pixels();
    let depth_format = wgpu::TextureFormat::Depth24PlusStencil8;
    let options = RendererOptions { sample_count: 4, depth_format, ..OPTIONS };
    let host = Host::new(options);
    let mut crowd = renderer(options, &people());
    for occlusion in [false, true, true] {
        host.frame(&mut crowd, &config, DrawOptions { occlusion, ..AT_ONCE }, [&[left], &[right]]);
        let found = host.picture.pixels();
        // Where everything around is alike, all samples are.
        let around = |p: usize| {
            let width = SIZE.0 as usize;
            (0..9).map(move |k| (p + k % 3 + k / 3 * width).wrapping_sub(1 + width)).filter(|q| *q < PIXELS)
        };
        let is_plain = |p: usize| around(p).all(|q| expected[q] == expected[p]);
        let plain: Vec<usize> = (0..PIXELS).filter(|p| is_plain(*p)).collect();
        let other = plain.iter().filter(|p| found[**p] != expected[**p]).count();
        assert!(plain.len() > PIXELS / 3 && other * 500 < plain.len(), "{other} of {}", plain.len());
        let difference = compare(&found, &expected);
        assert!(difference.share_over(48) < 0.06, "{difference:?}");
    }

    // Resolved by the renderer.
    let depth = host.depth.create_view(&Default::default());
    let targets = Targets { color: host.color(), resolve: Some(&host.picture.view), depth: &depth, size: SIZE };
    let (device, queue) = gpu::device();
    let mut encoder = device.create_command_encoder(&Default::default());
    host.pass(&mut encoder, &[left], true);
    crowd.encode_into(device, queue, &mut encoder, &targets, &config, AT_ONCE).expect("the targets fit");
    queue.submit([encoder.finish()]);
    let resolved = host.picture.pixels();
    assert!((0..PIXELS).filter(|p| left.covers(*p)).any(|p| resolved[p] == left.color));
    assert!((0..PIXELS).filter(|p| right.covers(*p)).all(|p| resolved[p] != right.color));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn occlusion_culling_leaves_out_whom_the_engines_walls_hide() {
    let culling = DrawOptions { occlusion: true, ..AT_ONCE };
    for reverse_z in [false, true] {
        let options = RendererOptions { reverse_z, ..OPTIONS };
        let config = camera(reverse_z);
        let host = Host::new(options);
        let mut crowd = renderer(options, &people());
        let [left, right] = walls(&config);
        host.frame(&mut crowd, &config, AT_ONCE, [&[left], &[right]]);
        let expected = host.picture.pixels();
        let mut occluded = 0;
        for _ in 0..3 {
            occluded = host.frame(&mut crowd, &config, culling, [&[left], &[right]]).occluded_count;
            assert!(host.picture.pixels() == expected, "nobody who can be seen is missing, reversed: {reverse_z}");
        }
        assert!(occluded > 3, "{occluded} behind the left wall, reversed: {reverse_z}");

        // Before everyone: next to all are left out.
        let whole = Wall { x: [-1.0, 1.0], depth: depth_at(&config, 0.5), ..left };
        for _ in 0..2 {
            host.frame(&mut crowd, &config, culling, [&[whole], &[]]);
        }
        let totals = host.frame(&mut crowd, &config, culling, [&[whole], &[]]);
        // One stands so near that their box reaches behind the eye.
        assert!(totals.visible_count <= 1 && totals.occluded_count > 50, "{totals:?}");
        // Tags of those left out show through it.
        let beside_wall = || host.picture.pixels().iter().filter(|pixel| **pixel != whole.color).count();
        let untagged = beside_wall();
        host.frame(&mut crowd, &config, DrawOptions { view: View::Occlusion, ..culling }, [&[whole], &[]]);
        assert!(beside_wall() > untagged + 200, "{} of {untagged}, reversed: {reverse_z}", beside_wall());
        // Gone again: everyone is back at once.
        host.frame(&mut crowd, &config, culling, [&[left], &[right]]);
        assert!(host.picture.pixels() == expected, "reversed: {reverse_z}");
    }
}

/// Pipelines of all that is drawn are made for the targets' formats: validation would say so.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn everything_can_be_drawn_into_a_reversed_stencil_of_several_samples() {
    let depth_format = wgpu::TextureFormat::Depth24PlusStencil8;
    let options = RendererOptions { sample_count: 4, depth_format, reverse_z: true, ..OPTIONS };
    let (device, queue) = gpu::device();
    let config = FrameConfig { dot_area_px2: 1e6, ..camera(true) };
    let host = Host::new(options);
    let mut crowd = renderer(options, &people());
    let ground = [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, -9.0]];
    let vertices =
        ground.map(|position| crowd_stages::SceneryVertex { position, color: [255; 4], normal: [0.0, 1.0, 0.0] });
    crowd.set_scenery(device, queue, &vertices, &[[0, 1, 2]]).expect("a triangle");
    // Its colour is the ground's wherever nobody stands: what only the crowd has is told by an empty crowd's picture.
    let mut nobody = renderer(options, &[]);
    nobody.set_scenery(device, queue, &vertices, &[[0, 1, 2]]).expect("a triangle");
    host.frame(&mut nobody, &config, AT_ONCE, [&[], &[]]);
    let empty = host.picture.pixels();
    for technique in Technique::ALL.into_iter().filter(|technique| *technique != Technique::StaticFloor) {
        let draw_options = DrawOptions { technique, shadows: 2, view: View::Levels, ..AT_ONCE };
        let totals = host.frame(&mut crowd, &config, draw_options, [&[], &[]]);
        assert!(totals.visible_count > 20, "{technique}: {totals:?}");
        let people = host.picture.pixels().iter().zip(&empty).filter(|(pixel, ground)| pixel != ground).count();
        assert!(people > 5000, "{technique}: {people} pixels");
        draw(&mut crowd, &Picture::new(SIZE), &config, draw_options);
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn targets_and_cameras_of_another_kind_are_refused_by_name() {
    use wgpu::TextureFormat::{Depth24Plus, Depth32Float, Rgba8Unorm, Rgba8UnormSrgb, Rgba16Float};
    let (device, queue) = gpu::device();
    let mut crowd = renderer(OPTIONS, &people());
    let none = wgpu::TextureUsages::empty();
    let readable = wgpu::TextureUsages::TEXTURE_BINDING;
    let make = |format, samples, usage| texture(format, samples, usage).create_view(&Default::default());
    let color = make(Rgba8UnormSrgb, 1, none);
    let depth = make(Depth32Float, 1, readable);
    let mut said = |color: &wgpu::TextureView, resolve, depth: &wgpu::TextureView, size, reversed: bool, occlusion| {
        let targets = Targets { color, resolve, depth, size };
        let mut encoder = device.create_command_encoder(&Default::default());
        let options = DrawOptions { occlusion, ..AT_ONCE };
        let result = crowd.encode_into(device, queue, &mut encoder, &targets, &camera(reversed), options);
        result.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(said(&color, None, &depth, SIZE, false, true), "");
    // A view may be sRGB where its texture is not.
    let plain = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[Rgba8UnormSrgb],
    });
    let srgb = plain.create_view(&wgpu::TextureViewDescriptor { format: Some(Rgba8UnormSrgb), ..Default::default() });
    assert_eq!(said(&srgb, None, &depth, SIZE, false, false), "");
    let other = [
        (
            said(&make(Rgba16Float, 1, none), None, &depth, SIZE, false, false),
            "colour target: found Rgba16Float, allowed Rgba8UnormSrgb",
        ),
        (
            said(&make(Rgba8Unorm, 4, none), None, &depth, SIZE, false, false),
            "colour target: found 4 samples a pixel, allowed 1",
        ),
        (
            said(&color, None, &make(Depth24Plus, 1, readable), SIZE, false, false),
            "depth target: found Depth24Plus, allowed Depth32Float",
        ),
        (
            said(&color, None, &make(Depth32Float, 4, readable), SIZE, false, false),
            "depth target: found 4 samples a pixel, allowed 1",
        ),
        (said(&color, None, &make(Depth32Float, 1, none), SIZE, false, true), "depth target: found usages"),
        (said(&color, Some(&color), &depth, SIZE, false, false), "resolve target: found one beside"),
        (
            said(&color, None, &depth, (320, 180), false, false),
            "colour target: found 640 x 360 pixels, allowed 320 x 180",
        ),
        (
            said(&color, None, &depth, SIZE, true, false),
            "clip_from_world: found depth 1 near and 0 far, allowed 0 near and 1 far",
        ),
    ];
    for (words, expected) in other {
        assert!(words.starts_with(expected), "{words}");
    }

    // The renderer's own pictures as well, and a renderer of another kind.
    let picture = Picture::new((64, 36));
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut own = |view: &wgpu::TextureView, size, reversed| {
        let result = crowd.encode(device, queue, &mut encoder, view, size, &camera(reversed), Technique::Reform);
        result.expect_err("refused").to_string()
    };
    assert!(own(&make(Rgba16Float, 1, none), SIZE, false).starts_with("colour target: found Rgba16Float"));
    assert!(own(&picture.view, SIZE, false).starts_with("colour target: found 64 x 36 pixels, allowed 640 x 360"));
    assert!(own(&color, SIZE, true).starts_with("clip_from_world: found depth 1 near"));
    for depth_format in [Rgba8Unorm, wgpu::TextureFormat::Depth16Unorm, wgpu::TextureFormat::Stencil8] {
        let wrong = RendererOptions { depth_format, ..OPTIONS };
        let refused = CrowdRenderer::new(device, queue, data(), wrong).err().expect("no depth of 24 bits").to_string();
        assert!(refused.starts_with(&format!("RendererOptions::depth_format: found {depth_format:?}")), "{refused}");
    }
    for color_format in
        [wgpu::TextureFormat::R32Uint, wgpu::TextureFormat::Depth32Float, wgpu::TextureFormat::Bc1RgbaUnorm]
    {
        let wrong = RendererOptions { color_format, ..OPTIONS };
        let refused = CrowdRenderer::new(device, queue, data(), wrong).err().expect("no colours").to_string();
        assert!(refused.starts_with(&format!("RendererOptions::color_format: found {color_format:?}")), "{refused}");
    }
    let mut reversed = renderer(RendererOptions { reverse_z: true, ..OPTIONS }, &people());
    let result = reversed.encode(device, queue, &mut encoder, &color, SIZE, &camera(false), Technique::Reform);
    assert!(
        result.expect_err("refused").to_string().contains("found depth 0 near and 1 far, allowed 1 near and 0 far")
    );
}
