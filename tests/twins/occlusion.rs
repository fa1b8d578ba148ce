//! Occlusion culling against an oracle: whoever owns a pixel of a picture without culling is drawn with it.

use crate::cases::buckets;
use crate::whole_chain::{OPTIONS, draw};
use crowd_pack::{ClipRecord, NONE, material_flags};
use crowd_raster::{Batch, Fill, Material, Target, View, Wrap};
use crowd_scene::{Kind, Layout, WalkableArea};
use crowd_stages::gpu::{CrowdRenderer, RendererOptions};
use crowd_stages::{
    CrowdData, DrawOptions, FrameConfig, InstanceRecord, LodChoice, PyramidConfig, SceneryVertex, Skinning, Technique,
    Weight, cpu, sight,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::{Mat4, Vec3};
use std::collections::BTreeSet;
use std::sync::OnceLock;

pub const WIDTH: u32 = 640;
pub const HEIGHT: u32 = 360;
const COUNT: u32 = 1200;
const WALL_M: f32 = 2.4;
/// Two streams, a wall between them, two walls across; y is -Z.
const AREA: &str = "POLYGON ((-9 -40, 9 -40, 9 40, -9 40, -9 -40), (-0.3 -20, -0.3 20, 0.3 20, 0.3 -20, -0.3 -20), \
                    (1 8, 1 8.3, 9 8.3, 9 8, 1 8), (-9 -8, -9 -7.7, -1 -7.7, -1 -8, -9 -8))";

/// A street with people and walls.
pub struct Street {
    pub data: CrowdData,
    pub instances: Vec<InstanceRecord>,
    pub walls: (Vec<SceneryVertex>, Vec<[u32; 3]>),
}

/// Who owns the pixels of a picture, and its depth.
pub struct Owners {
    pub numbers: BTreeSet<usize>,
    pub depth: Vec<f32>,
}

pub fn street() -> &'static Street {
    static STREET: OnceLock<Street> = OnceLock::new();
    STREET.get_or_init(|| {
        let data = tight(synthetic::crowd());
        let instances = people(&data, COUNT, 1);
        let area = WalkableArea::parse(AREA).expect("a polygon with three holes");
        let walls = area.walls(WALL_M);
        let corners = walls.positions.iter().zip(&walls.normals).map(|(position, normal)| SceneryVertex {
            position: position.to_array(),
            color: [150, 138, 120, 255],
            normal: normal.to_array(),
        });
        Street { data, instances, walls: (corners.collect(), walls.triangles) }
    })
}

/// The barrels with the boxes that their clips fill, and opaque.
fn tight(mut data: CrowdData) -> CrowdData {
    for number in 0..data.characters.len() {
        let character = data.characters[number];
        let choice = full_detail(&data, number as u32);
        let (mut low, mut high) = (Vec3::splat(f32::MAX), Vec3::splat(f32::MIN));
        for clip in character.clip_offset..character.clip_offset + character.clip_count {
            let ClipRecord { frame_count, duration_s, .. } = data.clips[clip as usize];
            for frame in 0..frame_count {
                let instance = InstanceRecord { scale: 1.0, character: number as u32, clip, ..Default::default() };
                let time_s = frame as f32 * duration_s / (frame_count - 1) as f32;
                for position in cpu::pose_instance(&data, &instance, choice, time_s).positions {
                    (low, high) = (low.min(position.into()), high.max(position.into()));
                }
            }
        }
        data.characters[number].box_min = (low - 1e-3).to_array();
        data.characters[number].box_max = (high + 1e-3).to_array();
    }
    for material in &mut data.materials {
        (material.image, material.alpha_cutoff, material.flags) = (NONE, 0.0, material_flags::DOUBLE_SIDED);
    }
    data
}

fn full_detail(data: &CrowdData, character: u32) -> LodChoice {
    let record = &data.characters[character as usize];
    LodChoice { vertex_count: record.vertex_count, triangle_count: record.triangle_count }
}

fn people(data: &CrowdData, count: u32, seed: u32) -> Vec<InstanceRecord> {
    let durations = |c: usize| {
        let record = &data.characters[c];
        let clips = record.clip_offset..record.clip_offset + record.clip_count;
        clips.map(|clip| data.clips[clip as usize].duration_s).collect()
    };
    // Narrow, so that a street shuffles them as far as it ever does: in straight rows few would own a pixel.
    let kind = |c: usize| Kind { footprint_m: 0.15, clip_durations_s: durations(c), ..Default::default() };
    let kinds: Vec<Kind> = (0..data.characters.len()).map(kind).collect();
    let placed = crowd_scene::place(Layout::Street, count, 0.9, &kinds, &[], seed);
    let record = |one: &crowd_scene::Instance| InstanceRecord {
        position: one.position.to_array(),
        yaw_rad: one.yaw_rad,
        scale: one.scale,
        character: one.character,
        clip: data.characters[one.character as usize].clip_offset + one.clip,
        phase_s: one.phase_s,
        ..Default::default()
    };
    placed.iter().map(record).collect()
}

/// A camera that walks along the wall, jumps to its other side, above it, out of the street and back.
const EYES: [([f32; 3], [f32; 3]); 9] = [
    ([-4.0, 1.6, 26.0], [-3.5, 1.2, 0.0]),
    ([-4.0, 1.6, 25.5], [-3.5, 1.2, 0.0]),
    ([-3.6, 1.6, 25.0], [-3.0, 1.2, 0.0]),
    ([4.0, 1.6, 25.0], [3.0, 1.2, 0.0]),
    ([4.0, 1.6, 25.0], [3.0, 1.2, 0.0]),
    ([-8.0, 1.4, 0.0], [9.0, 1.0, 1.0]),
    ([0.0, 9.0, 30.0], [0.0, 0.0, 0.0]),
    ([60.0, 1.6, 0.0], [0.0, 1.0, 0.0]),
    ([-4.0, 1.6, 26.0], [-3.5, 1.2, 0.0]),
];

impl Street {
    /// The camera of a frame, with a budget for full detail.
    pub fn config(&self, frame: usize) -> FrameConfig {
        let (eye, target) = EYES[frame % EYES.len()];
        let view = synthetic::view(eye.into(), target.into(), u32::MAX, Weight::Area, HEIGHT);
        let time_s = 1.3 + frame as f32 / 30.0;
        FrameConfig { instance_count: self.instances.len() as u32, time_s, ..FrameConfig::from_camera(&view) }
    }

    /// Draws the walls and some of the people, each in a colour of their own.
    pub fn owners(&self, config: &FrameConfig, drawn: &[usize]) -> Owners {
        self.owners_of(&self.instances, config, drawn)
    }

    fn owners_of(&self, instances: &[InstanceRecord], config: &FrameConfig, drawn: &[usize]) -> Owners {
        let mut target = Target::new(WIDTH, HEIGHT, [0, 0, 0, 255]);
        let view = View {
            clip_from_world: Mat4::from_cols_array_2d(&config.clip_from_world),
            eye: Vec3::from_array(config.eye),
        };
        // The ground counts in the depth alone.
        crowd_raster::draw_ground(&mut target, &view);
        target.color.fill([0, 0, 0, 255]);
        let (corners, triangles) = &self.walls;
        let positions: Vec<[f32; 3]> = corners.iter().map(|corner| corner.position).collect();
        paint(&mut target, &view, &positions, triangles, &vec![[0, 0, 0, 255]; positions.len()], false);
        for &i in drawn {
            let choice = full_detail(&self.data, instances[i].character);
            let posed = cpu::pose_instance(&self.data, &instances[i], choice, config.time_s);
            let colors = vec![color_of(i); posed.positions.len()];
            paint(&mut target, &view, &posed.positions, &posed.triangles, &colors, true);
        }
        let decode = decoder();
        let numbers = target.color.iter().filter_map(|[r, g, b, _]| {
            let digits = [r, g, b].map(|value| decode[*value as usize]);
            (digits[0] * 256 + digits[1] * 16 + digits[2]).checked_sub(1)
        });
        Owners { numbers: numbers.collect(), depth: target.depth }
    }
}

fn paint(
    target: &mut Target,
    view: &View,
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    colors: &[[u8; 4]],
    double_sided: bool,
) {
    let plain = Material {
        base_color: [1.0; 4],
        texture: None,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        alpha_cutoff: 0.0,
        double_sided,
        unlit: true,
        flat: false,
    };
    let batch = Batch {
        positions,
        normals: &[],
        uvs: &[],
        colors,
        vertex_materials: &vec![0; positions.len()],
        triangles,
        materials: &[plain],
        textures: &[],
        fill: Fill::VertexColor,
    };
    crowd_raster::draw(target, view, &batch);
}

/// Three digits to sixteen, far enough apart to survive the picture's encoding; number 0 is 1, since black is nobody.
fn color_of(i: usize) -> [u8; 4] {
    let digit = |place: usize| (((i + 1) >> place) % 16 * 17) as u8;
    [digit(8), digit(4), digit(0), 255]
}

/// The digit nearest to each encoded value.
fn decoder() -> Vec<usize> {
    let encoded = |digit: usize| {
        let linear = digit as f32 / 15.0;
        let value = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 };
        255.0 * value
    };
    let nearest = |value: usize| {
        let apart = |digit: &usize| (encoded(*digit) - value as f32).abs();
        (0..16).min_by(|a, b| apart(a).total_cmp(&apart(b))).expect("sixteen digits")
    };
    (0..256).map(nearest).collect()
}

/// Owners of pixels who were not drawn.
fn missing(owners: &BTreeSet<usize>, drawn: &BTreeSet<usize>) -> Vec<usize> {
    owners.difference(drawn).copied().collect()
}

fn everyone(instances: &[InstanceRecord]) -> Vec<usize> {
    (0..instances.len()).collect()
}

pub const ON: DrawOptions = DrawOptions {
    technique: Technique::Bucketed,
    levels: crowd_stages::Levels::Quantized,
    fit: crowd_stages::Fit::Fill,
    no_morph: true,
    no_impostors: false,
    occlusion: true,
    skinning: Skinning::Vertex,
    shadows: 0,
    holds_poses: false,
    share_poses: false,
    view: crowd_stages::View::Shaded,
    frozen: false,
};

pub fn renderer(sample_count: u32) -> CrowdRenderer {
    let (device, queue) = gpu::device();
    let street = street();
    let options = RendererOptions { sample_count, max_instances: 2 * COUNT, ..OPTIONS };
    let mut renderer = CrowdRenderer::new(device, queue, &street.data, options).expect("within default limits");
    renderer.set_scenery(device, queue, &street.walls.0, &street.walls.1).expect("a few walls");
    renderer
}

fn drawn_of(renderer: &CrowdRenderer, count: usize) -> BTreeSet<usize> {
    let words = gpu::read::<u32>(renderer.buffer(Technique::Bucketed, "seen").expect("set up"), count + 1);
    assert_eq!(words[0], count as u32);
    (0..count).filter(|i| words[1 + i] & sight::DRAWN != 0).collect()
}

/// Draws a frame with and without; how many were occluded.
fn check(renderer: &mut CrowdRenderer, instances: &[InstanceRecord], config: &FrameConfig, what: &str) -> u32 {
    let picture = Picture::new((WIDTH, HEIGHT));
    let off = draw(renderer, &picture, config, DrawOptions { occlusion: false, ..ON });
    let without = picture.pixels();
    let on = draw(renderer, &picture, config, ON);
    let with = picture.pixels();
    let different = with.iter().zip(&without).filter(|(a, b)| a != b).count();
    assert_eq!(different, 0, "{what}: pixels differ");
    assert_eq!(on.visible_count + on.occluded_count, off.visible_count, "{what}");
    assert_eq!((on.overflow, off.occluded_count, on.outside_count), (0, 0, off.outside_count), "{what}");
    let drawn = drawn_of(renderer, instances.len());
    assert_eq!(drawn.len() as u32, on.visible_count, "{what}");
    let owners = street().owners_of(instances, config, &everyone(instances)).numbers;
    assert_eq!(missing(&owners, &drawn), [0usize; 0], "{what}: {} own pixels", owners.len());
    println!("{what}: {} in the frustum, {} drawn, {} own pixels", off.visible_count, drawn.len(), owners.len());
    on.occluded_count
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn nobody_who_owns_a_pixel_is_missing_while_the_camera_walks_and_jumps() {
    let street = street();
    for samples in [1, 4] {
        let mut renderer = renderer(samples);
        renderer.set_instances(&gpu::device().1, &street.instances).expect("valid");
        let mut occluded = Vec::new();
        for frame in 0..EYES.len() {
            occluded.push(check(&mut renderer, &street.instances, &street.config(frame), &format!("frame {frame}")));
        }
        // The first frame draws everyone; along the wall most are hidden.
        assert_eq!(occluded[0], 0);
        let in_frustum = cpu::cull_instances(&street.data, &street.instances, &street.config(2));
        let in_frustum = in_frustum.iter().filter(|cull| cull.visible != 0).count() as u32;
        assert!(occluded[2] * 2 > in_frustum, "{} of {in_frustum}", occluded[2]);
    }
}

/// Both phases skin what they draw, one after the other into the same buffers.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn skinned_beforehand_both_phases_draw_the_same_picture() {
    let street = street();
    let mut renderer = renderer(1);
    renderer.set_instances(&gpu::device().1, &street.instances).expect("valid");
    let picture = Picture::new((WIDTH, HEIGHT));
    let mut occluded = 0;
    for (frame, skinning) in (0..EYES.len()).zip([Skinning::Compute, Skinning::Palettes].into_iter().cycle()) {
        let config = street.config(frame);
        draw(&mut renderer, &picture, &config, DrawOptions { occlusion: false, ..ON });
        let without = picture.pixels();
        for _ in 0..2 {
            occluded += draw(&mut renderer, &picture, &config, DrawOptions { skinning, ..ON }).occluded_count;
            assert!(picture.pixels() == without, "frame {frame}, {}", skinning.name());
        }
    }
    assert!(occluded > 0, "somebody is hidden");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn nobody_is_missing_when_the_people_move_or_are_others() {
    let street = street();
    let mut renderer = renderer(1);
    let mut moved = street.instances.clone();
    for (i, one) in moved.iter_mut().enumerate() {
        // Everyone changes sides.
        one.position[0] = -one.position[0];
        one.position[2] += if i % 3 == 0 { 3.0 } else { -2.0 };
    }
    let fewer = people(&street.data, COUNT / 2, 5);
    let more = people(&street.data, 2 * COUNT, 6);
    for (what, instances) in [
        ("first", &street.instances),
        ("again", &street.instances),
        ("moved", &moved),
        ("fewer", &fewer),
        ("more", &more),
    ] {
        renderer.set_instances(&gpu::device().1, instances).expect("valid");
        check(&mut renderer, instances, &street.config(1), what);
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_budget_holds_and_hidden_people_take_next_to_nothing_from_it() {
    let street = street();
    let mut renderer = renderer(1);
    renderer.set_instances(&gpu::device().1, &street.instances).expect("valid");
    let picture = Picture::new((WIDTH, HEIGHT));
    let budget = 40_000;
    // What is kept for newcomers and what may be left so that levels keep still come out of one hundredth.
    for slack in [0, budget / 1000 * 9] {
        let mut last = Default::default();
        for frame in [0, 0, 1, 1, 2, 2] {
            let config = FrameConfig { budget, slack, ..street.config(frame) };
            last = draw(&mut renderer, &picture, &config, ON);
            assert!(last.vertex_count <= budget && last.overflow == 0, "frame {frame}: {last:?}");
        }
        assert!(last.vertex_count >= budget - budget / 100, "slack {slack}: {last:?}");
        assert!(last.occluded_count > last.visible_count, "{last:?}");
    }
}

/// The twins on a first phase of every other one, with depth from the rasteriser.
fn wrongly_culled(frame: usize, build: impl Fn(&PyramidConfig, &[f32]) -> Vec<f32>) -> usize {
    let street = street();
    let config = street.config(frame);
    let mut culled = cpu::cull_instances(&street.data, &street.instances, &config);
    let mut seen = vec![street.instances.len() as u32];
    seen.extend((0..culled.len()).map(|i| if i % 2 == 0 { sight::SEEN } else { sight::HIDDEN }));
    cpu::recall_seen(&street.data, &street.instances, &seen, &mut culled, &config);
    let first: Vec<usize> = (0..culled.len()).filter(|i| culled[*i].visible != 0).collect();
    let pyramid = PyramidConfig::new(WIDTH, HEIGHT, 1);
    let farthest = build(&pyramid, &street.owners(&config, &first).depth);
    cpu::test_occlusion(&street.data, &street.instances, &pyramid, &farthest, &mut culled, &mut seen, &config);
    let drawn = (0..culled.len()).filter(|i| seen[1 + i] & sight::DRAWN != 0).collect();
    let owners = street.owners(&config, &everyone(&street.instances)).numbers;
    assert!(owners.len() > 30, "frame {frame}: {} own pixels", owners.len());
    missing(&owners, &drawn).len()
}

#[test]
fn the_twins_miss_nobody() {
    for frame in [0, 3, 5, 6] {
        assert_eq!(wrongly_culled(frame, cpu::build_pyramid), 0, "frame {frame}");
    }
}

/// Frames in which somebody is missed.
fn frames_with_somebody_missed(build: impl Fn(usize, &PyramidConfig, &[f32]) -> Vec<f32>) -> usize {
    let missed = |frame: &usize| wrongly_culled(*frame, |config, depth| build(*frame, config, depth)) > 0;
    (0..EYES.len()).filter(missed).count()
}

#[test]
fn a_pyramid_of_nearest_depths_misses_somebody() {
    // As with `min` in place of `max`, for boxes that are in one block: each number is the nearest depth around it.
    let nearest = |_, config: &PyramidConfig, depth: &[f32]| {
        let turned: Vec<f32> = depth.iter().map(|depth| 1.0 - depth).collect();
        let nearest: Vec<f32> = cpu::build_pyramid(config, &turned).into_iter().map(|number| 1.0 - number).collect();
        let levels = &config.levels[..config.level_count as usize];
        let coarser = |k: usize, x: u32, y: u32| {
            let at = (k + 3).min(levels.len() - 1);
            let (x, y) = (x >> (at - k), y >> (at - k));
            nearest[(levels[at].offset + y * levels[at].width + x) as usize]
        };
        let of_level = |(k, level): (usize, &crowd_stages::PyramidLevel)| -> Vec<f32> {
            (0..level.width * level.height).map(|i| coarser(k, i % level.width, i / level.width)).collect()
        };
        levels.iter().enumerate().flat_map(of_level).collect()
    };
    assert!(frames_with_somebody_missed(nearest) > 0);
}

#[test]
fn a_pyramid_of_another_camera_misses_somebody() {
    let street = street();
    let other = |frame: usize, config: &PyramidConfig, _: &[f32]| {
        let depth = street.owners(&street.config(frame + 3), &everyone(&street.instances)).depth;
        cpu::build_pyramid(config, &depth)
    };
    assert!(frames_with_somebody_missed(other) > 0);
}

#[test]
fn the_oracle_knows_everyone_by_colour() {
    let decode = decoder();
    for i in [0, 14, 15, 255, 1000, 4094] {
        let [r, g, b, _] = color_of(i).map(|value| (value / 17) as usize);
        assert_eq!(r * 256 + g * 16 + b, i + 1);
    }
    assert_eq!((decode[0], decode[255]), (0, 15));
    assert_eq!(missing(&BTreeSet::from([1, 2]), &BTreeSet::from([2])), [1]);
    assert!(buckets().records.len() > 3);
}
