//! `skin_vertices` on the GPU against its twin: within a bound; and pictures of all ways to skin, which are one.

use crate::cases::{Case, buckets, case, cases, first_difference};
use crate::gather_drawn::{Sorted, on_cpu_in, sorted_in};
use crate::whole_chain::{OPTIONS, apart, close_up, compare, draw, is_rounding, one_clip_each, renderer};
use crowd_stages::gpu::{CrowdRenderer, RendererOptions, SkinVertices};
use crowd_stages::{
    Buckets, CrowdData, DispatchArgs, DrawOptions, DrawnInstance, FrameConfig, InstanceRecord, LodChoice, OriginRecord,
    SkinnedVertex, Skinning, Technique, Weight, cpu, overflow,
};
use crowd_tests::gpu::{self, Picture};

/// What the stage is fed with.
pub struct Fed {
    data: &'static CrowdData,
    buckets: &'static Buckets,
    pub origins: Vec<OriginRecord>,
    pub sorted: Sorted,
    dispatch: DispatchArgs,
    pub drawn: Vec<DrawnInstance>,
    palettes: Vec<[f32; 4]>,
}

fn fed(case: &Case, vertex_capacity: u32) -> Fed {
    fed_in(buckets(), case, vertex_capacity)
}

/// Of a crowd of other data.
pub fn fed_in(buckets: &'static Buckets, case: &Case, vertex_capacity: u32) -> Fed {
    let sorted = sorted_in(buckets, case, vertex_capacity);
    let drawn = on_cpu_in(buckets, case, &sorted);
    let (_, dispatch, _) = cpu::place_buckets(buckets, &sorted.ranges, vertex_capacity);
    let palettes = cpu::blend_palettes(case.data, buckets, &drawn);
    let origins = buckets.origins(case.data);
    Fed { data: case.data, buckets, origins, sorted, dispatch, drawn, palettes }
}

impl Fed {
    fn count(&self) -> usize {
        self.sorted.places.last().map_or(0, |end| end.vertex_base as usize)
    }

    pub fn on_gpu(&self) -> Vec<SkinnedVertex> {
        let stage = SkinVertices::new(&gpu::device().0);
        let skinned = gpu::output::<SkinnedVertex>(self.count());
        let bound = stage.bind(
            &gpu::device().0,
            &gpu::uniform(&self.buckets.counts()),
            &gpu::storage(&self.sorted.places),
            &gpu::storage(&self.drawn),
            &gpu::storage(&self.data.vertices),
            &gpu::storage(&self.origins),
            &gpu::storage(&self.palettes),
            &skinned,
            None,
        );
        let dispatch = gpu::indirect(&self.dispatch);
        gpu::run(|pass| stage.record(pass, &bound, &dispatch));
        gpu::read(&skinned, self.count())
    }

    pub fn on_cpu(&self) -> Vec<SkinnedVertex> {
        let Self { data, buckets, origins, sorted, drawn, palettes, .. } = self;
        cpu::skin_vertices(data, buckets, origins, &sorted.ranges, &sorted.places, drawn, palettes)
    }
}

pub fn first_apart(gpu: &[SkinnedVertex], cpu: &[SkinnedVertex]) -> Option<String> {
    let numbers = |s: &SkinnedVertex| [s.x, s.y, s.z, s.normal_x, s.normal_y, s.normal_z];
    let apart = |(a, b): (&SkinnedVertex, &SkinnedVertex)| {
        numbers(a).iter().zip(numbers(b)).any(|(a, b)| (a - b).abs() > cpu::SKIN_BOUND * b.abs().max(1.0))
    };
    let i = gpu.iter().zip(cpu).position(apart)?;
    Some(format!("vertex {i}: {:?} on the GPU, {:?} on the CPU", gpu[i], cpu[i]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn skinned_vertices_agree_for_all_sizes() {
    for case in cases().filter(|case| case.count() <= 1000) {
        for capacity in [u32::MAX, case.count() * 10] {
            let fed = fed(&case, capacity);
            let (gpu, cpu) = (fed.on_gpu(), fed.on_cpu());
            assert_eq!(gpu.len(), cpu.len());
            assert_eq!(first_apart(&gpu, &cpu), None, "{} instances, {capacity}", case.count());
        }
    }
}

/// Palettes mix a joint's matrices of two clips and then add up joints, the vertex shader adds up the joints of each clip and mixes the sums:
/// the same but for rounding. No number goes through more than 30 roundings on either way (four joints of two vertices of two clips, their
/// weights, shares and sums), each of 2^-24 of a row's product with a point: up to some six metres, 1.1e-5 m.
fn is_near(at: &SkinnedVertex, position: [f32; 3]) -> bool {
    [at.x, at.y, at.z].iter().zip(position).all(|(a, b)| (a - b).abs() <= cpu::SKIN_BOUND * b.abs().max(1.0))
}

#[test]
fn vertices_lie_where_the_whole_pose_has_them_and_one_that_moved_is_seen() {
    let case = case(200, 60, Weight::Area);
    let fed = fed(&case, u32::MAX);
    let skinned = fed.on_cpu();
    assert_eq!(skinned.len(), fed.count());
    let mut changed = skinned.clone();
    changed[skinned.len() / 2].z += 1e-3;
    assert!(first_apart(&changed, &skinned).is_some() && first_apart(&skinned, &skinned).is_none());

    let (compared, fading) = compared_with_whole_poses(&case, &fed, &skinned);
    assert!(fading > 100, "{fading} of those who fade");
    assert!(compared == skinned.len() && compared > 500, "{compared} vertices");
}

/// Compares all vertices with the oracle of the vertex shader, without turn and place, which knows nothing of origins' lists. How many, and of those how many fade.
pub fn compared_with_whole_poses(case: &Case, fed: &Fed, skinned: &[SkinnedVertex]) -> (usize, usize) {
    let sorted = &fed.sorted;
    let (mut compared, mut fading) = (0, 0);
    for (entry, (key, i)) in sorted.keys.iter().zip(&sorted.values).enumerate().take(fed.drawn.len()) {
        let record = fed.buckets.records[*key as usize];
        let choice = LodChoice { vertex_count: record.vertex_count, triangle_count: record.triangle_count };
        let instance = case.instances[*i as usize];
        let home = InstanceRecord { position: [0.0; 3], yaw_rad: 0.0, scale: 1.0, ..instance };
        let posed = cpu::pose_between(case.data, &home, choice, sorted.morphs[*i as usize], case.config.time_s);
        let first = fed.drawn[entry].vertex_base as usize;
        for (at, position) in skinned[first..].iter().zip(&posed.positions) {
            assert!(is_near(at, *position), "entry {entry}: {at:?}, posed {position:?}");
            assert!(!is_near(&SkinnedVertex { y: at.y + 1e-4, ..*at }, *position), "a tenth of a millimetre is seen");
            compared += 1;
            fading += usize::from(fed.drawn[entry].leaving_share > 0.1);
        }
    }
    (compared, fading)
}

pub fn way(skinning: Skinning, no_morph: bool) -> DrawOptions {
    DrawOptions { technique: Technique::Bucketed, no_morph, skinning, ..Default::default() }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn all_ways_to_skin_give_the_same_picture() {
    let (fading, config) = close_up();
    let config = FrameConfig { budget: 6000, ..config };
    let mut renderer = renderer(OPTIONS, &fading);
    let picture = Picture::new((640, 360));
    for (instances, fade) in [(one_clip_each(&fading), false), (fading.clone(), true)] {
        renderer.set_instances(&gpu::device().1, &instances).expect("they were good");
        let mut pictures = Vec::new();
        for no_morph in [false, true] {
            let totals = draw(&mut renderer, &picture, &config, way(Skinning::Vertex, no_morph));
            let of_vertex_shader = picture.pixels();
            assert_eq!(renderer.skinning(Skinning::Vertex).way, Skinning::Vertex);
            let mut beforehand = Vec::new();
            for skinning in [Skinning::Palettes, Skinning::Compute] {
                assert_eq!(draw(&mut renderer, &picture, &config, way(skinning, no_morph)), totals);
                assert_eq!(renderer.skinning(skinning).way, skinning);
                let difference = compare(&picture.pixels(), &of_vertex_shader);
                let what = format!("{skinning:?}, no_morph {no_morph}, fade {fade}: {}", apart(&difference));
                println!("{what}");
                // The same products and sums in the same order; of two clips in another one.
                assert!(if fade { is_rounding(&difference) } else { difference.max == 0 }, "{what}");
                beforehand.push(picture.pixels());
            }
            assert_eq!(compare(&beforehand[0], &beforehand[1]).max, 0, "both have palettes, no_morph {no_morph}");
            pictures.push(of_vertex_shader);
        }
        assert!(compare(&pictures[0], &pictures[1]).share_over(8) > 0.005, "morphs are seen");
        if fade {
            // A hundredth of a fade more is no rounding.
            let later = |one: &InstanceRecord| InstanceRecord { leaving_share: one.leaving_share * 0.99, ..*one };
            let later: Vec<InstanceRecord> = instances.iter().map(later).collect();
            renderer.set_instances(&gpu::device().1, &later).expect("they were good");
            draw(&mut renderer, &picture, &config, way(Skinning::Vertex, true));
            let difference = compare(&picture.pixels(), &pictures[1]);
            println!("a later fade: {}", apart(&difference));
            assert!(!is_rounding(&difference), "a later fade is seen");
        }
    }
    let bytes = renderer.buffer(Technique::Bucketed, "skinned").expect("skinned beforehand").size();
    assert_eq!(bytes, u64::from(OPTIONS.max_vertices) * 24);
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn auto_tries_all_ways_and_keeps_one_and_takes_palettes_where_somebody_may_fade() {
    let (instances, config) = close_up();
    let picture = Picture::new((640, 360));
    let tried = |renderer: &mut CrowdRenderer| {
        let mut seen = std::collections::BTreeSet::new();
        let mut first = None;
        for _ in 0..20 {
            draw(renderer, &picture, &config, Technique::Bucketed);
            seen.insert(renderer.skinning(Skinning::Auto).way.name());
            let pixels = picture.pixels();
            assert_eq!(first_difference(&pixels, first.get_or_insert(pixels.clone())), None);
        }
        seen
    };
    // Who fades would leave a trace: nothing is tried.
    let mut of_fading = renderer(OPTIONS, &instances);
    let seen = tried(&mut of_fading);
    assert!(seen.into_iter().eq(["palettes"]));
    let choice = of_fading.skinning(Skinning::Auto);
    assert!(choice.fades && choice.is_settled && choice.measured_ms.is_none(), "{choice:?}");

    let mut renderer = renderer(OPTIONS, &one_clip_each(&instances));
    let seen = tried(&mut renderer);
    let choice = renderer.skinning(Skinning::Auto);
    assert_eq!(seen.len(), 3, "{seen:?}");
    assert!(choice.is_settled && choice.refused.is_none() && !choice.fades, "{choice:?}");
    assert!(choice.measured_ms.is_some_and(|ms| ms.iter().all(|ms| *ms > 0.0)), "{choice:?}");
    // What is not used is given back.
    let has_room = renderer.buffer(Technique::Bucketed, "skinned").is_some();
    assert_eq!(has_room, choice.way != Skinning::Vertex);
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn beyond_a_binding_the_vertex_shader_skins_and_beyond_the_renderers_room_totals_say_so() {
    let (instances, config) = close_up();
    let picture = Picture::new((640, 360));
    // More than a binding holds: a test on a device that binds little has the pictures.
    let huge = RendererOptions { max_vertices: 8_000_000, ..OPTIONS };
    let mut first = renderer(huge, &instances);
    let totals = draw(&mut first, &picture, &config, way(Skinning::Compute, false));
    let choice = first.skinning(Skinning::Compute);
    assert_eq!((choice.way, totals.overflow, choice.refused), (Skinning::Compute, 0, None));
    // Fewer than are drawn.
    let mut second = renderer(RendererOptions { max_vertices: 2000, ..OPTIONS }, &instances);
    let totals = draw(&mut second, &picture, &config, way(Skinning::Compute, false));
    assert_eq!(totals.overflow & overflow::VERTICES, overflow::VERTICES, "{totals:?}");
    assert!(totals.needed_vertices > 2000);
    // Who asks for none by name is drawn whole: what leaves people out is not taken for the fastest way.
    let mut third = renderer(RendererOptions { max_vertices: 2000, ..OPTIONS }, &one_clip_each(&instances));
    for _ in 0..4 {
        let totals = draw(&mut third, &picture, &config, way(Skinning::Auto, false));
        let choice = third.skinning(Skinning::Auto);
        assert_eq!((choice.way, totals.overflow), (Skinning::Palettes, 0), "{totals:?}");
    }
    assert!(third.skinning(Skinning::Auto).measured_ms.is_none());
}
