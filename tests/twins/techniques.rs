//! Techniques against each other: the same triangles must give the same picture.

use crate::cases::{buckets, case, data, first_difference};
use crate::whole_chain::{OPTIONS, close_up, compare, draw, one_clip_each, renderer};
use crowd_stages::{
    CullRecord, DrawOptions, FillState, Fit, FrameConfig, InstanceRecord, Levels, LodChoice, MorphRecord, Skinning,
    Technique, View, Weight, cpu,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::Vec3;

/// Reformation with levels snapped to those that have tables: the oracle.
const ORACLE: DrawOptions = DrawOptions {
    technique: Technique::Reform,
    levels: Levels::Quantized,
    fit: Fit::Fill,
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
/// Levels that change at once, as those of the oracle.
const AT_ONCE: DrawOptions = DrawOptions { technique: Technique::Bucketed, ..ORACLE };

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn bucketed_draws_what_reformation_of_the_same_levels_draws() {
    let (fading, config) = close_up();
    // On their way between two clips barrels fold through themselves; where triangles meet in depth the one drawn first wins.
    for (instances, allowed_share) in [(one_clip_each(&fading), 0.0), (fading, 1e-4)] {
        let mut renderer = renderer(OPTIONS, &instances);
        let picture = Picture::new((640, 360));
        for budget in [u32::MAX, 6000, 2500] {
            let config = FrameConfig { budget, ..config };
            let oracle_totals = draw(&mut renderer, &picture, &config, ORACLE);
            let oracle = picture.pixels();
            let totals = draw(&mut renderer, &picture, &config, AT_ONCE);
            let colors: std::collections::BTreeSet<[u8; 4]> = oracle.iter().copied().collect();
            assert!(colors.len() > 1000, "{} colours: this is not a picture", colors.len());
            let share = compare(&picture.pixels(), &oracle).share_over(0);
            assert!(share <= allowed_share, "budget {budget}: {share} of the pixels differ");
            assert!(totals.draw_count >= 3);
            let of = |t: crowd_stages::FrameTotals| (t.visible_count, t.vertex_count, t.triangle_count, t.overflow);
            assert_eq!(of(totals), of(oracle_totals), "budget {budget}");

            // The comparison can fail: continuous levels are others.
            if budget == 6000 {
                draw(&mut renderer, &picture, &config, Technique::Reform);
                assert!(compare(&picture.pixels(), &oracle).share_over(0) > 1e-3);
            }
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
    let culled: Vec<CullRecord> =
        gpu::read(renderer.buffer(Technique::Bucketed, "culled").expect("the selection writes it"), n);
    let (keys, _) =
        cpu::key_instances(buckets(), &case.instances, &culled, &choices, &FillState::default(), &case.config);
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
    let moving = picture.pixels();
    let difference = compare(&moving, &bucketed);
    assert!(difference.share_over(8) < 0.002, "{difference:?}");

    // That holds for vertices on their way between levels, too, and they are not where they are without.
    let at_once = DrawOptions { technique: Technique::StaticFloor, ..ORACLE };
    renderer.bake_floor(device, queue, data(), &instances, &config, at_once).expect("it fits");
    draw(&mut renderer, &picture, &config, at_once);
    let still = picture.pixels();
    draw(&mut renderer, &picture, &config, AT_ONCE);
    assert!(compare(&still, &picture.pixels()).share_over(8) < 0.002);
    assert!(compare(&still, &moving).share_over(8) > 0.005, "{:?}", compare(&still, &moving));
    let of = |t: crowd_stages::FrameTotals| (t.visible_count, t.vertex_count, t.triangle_count);
    assert_eq!((of(floor), floor.draw_count), (of(totals), 1));
}

/// Where every vertex of full detail is drawn: its own place, or that of the vertex it has collapsed into.
fn places(instances: &[InstanceRecord], frame: &cpu::CpuFrame) -> Vec<Vec3> {
    let mut places = Vec::new();
    for (i, instance) in instances.iter().enumerate().filter(|(i, _)| frame.choices[*i].vertex_count > 0) {
        let choice = frame.choices[i];
        let at_once = MorphRecord { coarser_vertex_count: choice.vertex_count, fraction: 1.0 };
        let morph = frame.morphs.get(i).copied().unwrap_or(at_once);
        let posed = cpu::pose_between(data(), instance, choice, morph, 0.4);
        let character = &data().characters[instance.character as usize];
        let map = &data().collapse_map[character.vertex_offset as usize..][..character.vertex_count as usize];
        for v in 0..character.vertex_count {
            let mut at = v;
            while at >= choice.vertex_count {
                at = map[at as usize];
            }
            places.push(Vec3::from_array(posed.positions[at as usize]));
        }
    }
    places
}

/// The same moment with a budget that grows by a quarter per cent at a time: what moves is the levels alone. (Of pictures, sums of
/// differences say nothing: edges cross as many pixels in many small steps as in a large one.)
#[test]
fn vertices_move_a_quarter_as_far_in_one_step_as_without_morphs() {
    let (instances, config) = close_up();
    let lods = buckets().quantized_lods(data());
    let farthest = |frame_at: &dyn Fn(&FrameConfig) -> cpu::CpuFrame| {
        let budgets = (0..40).map(|step| (5000.0 * (1.0 + 0.0025 * step as f32)) as u32);
        let mut all = budgets.map(|budget| places(&instances, &frame_at(&FrameConfig { budget, ..config })));
        let mut before = all.next().expect("forty budgets");
        let mut farthest = 0.0f32;
        for after in all {
            let distances = before.iter().zip(&after).map(|(a, b)| a.distance(*b));
            farthest = distances.fold(farthest, f32::max);
            before = after;
        }
        farthest
    };
    let jumping = farthest(&|config| cpu::run_selection(data(), &lods, &instances, config, Fit::Fill));
    let moving = farthest(&|config| cpu::run_morphing_selection(data(), buckets(), &lods, &instances, config));
    println!("farthest in one step: {moving} m with morphs, {jumping} m without");
    assert!(moving > 0.0 && moving < 0.25 * jumping, "{moving} m with morphs, {jumping} m without");
}

#[test]
fn at_the_beginning_of_its_way_a_level_is_the_coarser_one() {
    let instance = synthetic::instances(data(), 1)[0];
    let character = instance.character;
    let levels = buckets().sets[character as usize].level_count;
    let choice = |level: u32| {
        let record = buckets().records[buckets().at(character, level) as usize];
        LodChoice { vertex_count: record.vertex_count, triangle_count: record.triangle_count }
    };
    let (fine, coarse) = (choice(levels - 1), choice(levels - 2));
    let morph = |fraction| MorphRecord { coarser_vertex_count: coarse.vertex_count, fraction };
    let of = |choice, morph| cpu::pose_between(data(), &instance, choice, morph, 0.4);
    let (start, end) = (of(fine, morph(0.0)), of(fine, morph(1.0)));
    let below = cpu::pose_instance(data(), &instance, coarse, 0.4);
    // Triangles that the coarser level lacks have no extent; the others are where it has them.
    let corners = |posed: &cpu::PosedInstance| {
        let place = |t: &[u32; 3]| t.map(|v| posed.positions[v as usize].map(f32::to_bits));
        let real = posed.triangles.iter().map(place).filter(|[a, b, c]| a != b && b != c && c != a);
        real.collect::<std::collections::BTreeSet<_>>().len()
    };
    assert_eq!(start.triangles.len(), fine.triangle_count as usize);
    assert_eq!(corners(&start), corners(&below));
    assert_eq!(end.positions, cpu::pose_instance(data(), &instance, fine, 0.4).positions);
}

/// Everyone is far away: a budget that the coarsest meshes exceed is met by dots, and the picture is much like theirs.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn far_away_dots_look_much_like_what_they_stand_for() {
    let instances = synthetic::instances(data(), 600);
    let view = synthetic::view(Vec3::new(0.0, 30.0, 110.0), Vec3::ZERO, 5_400, Weight::Area, 360);
    let config = FrameConfig::from_camera(&view);
    let mut renderer = renderer(OPTIONS, &instances);
    let picture = Picture::new((640, 360));
    draw(&mut renderer, &picture, &config, Technique::PseudoInstancing);
    let full = picture.pixels();
    let least = draw(&mut renderer, &picture, &FrameConfig { budget: 0, ..config }, Technique::Bucketed);
    let meshes = compare(&picture.pixels(), &full);
    let may_be_dots = FrameConfig { dot_area_px2: crowd_stages::dot_area_px2(12.0), ..config };
    let totals = draw(&mut renderer, &picture, &may_be_dots, Technique::Bucketed);
    let dots = compare(&picture.pixels(), &full);
    println!("RMS: {} of dots, {} of meshes", dots.rms, meshes.rms);
    assert!(least.overflow != 0 && least.vertex_count > 5_400, "without dots it does not hold: {least:?}");
    assert!(totals.overflow == 0 && totals.vertex_count <= 5_400 && totals.visible_count == 600, "{totals:?}");
    assert!(dots.rms < 1.25 * meshes.rms, "{} of dots, {} of meshes", dots.rms, meshes.rms);
    // Without them the picture is farther from full detail, so the comparison tells.
    renderer.set_instances(&gpu::device().1, &[]).expect("nobody fits");
    draw(&mut renderer, &picture, &config, Technique::Bucketed);
    let nobody = compare(&picture.pixels(), &full).rms;
    assert!(nobody > 1.5 * dots.rms, "{nobody} of nobody, {} of dots", dots.rms);
}

/// Levels stay those of the frame before while the camera goes on, and are chosen anew where there is none.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_frozen_frame_has_the_levels_of_the_one_before_and_its_own_camera() {
    let (instances, near) = close_up();
    let near = FrameConfig { budget: 6000, ..near };
    let far = synthetic::view(Vec3::new(9.0, 7.2, 25.0), Vec3::new(0.0, 0.8, 0.0), 6000, Weight::Area, 360);
    let far = FrameConfig::from_camera(&far);
    let mut renderer = renderer(OPTIONS, &instances);
    let picture = Picture::new((640, 360));
    for technique in [Technique::Discrete, Technique::Reform, Technique::Bucketed] {
        let thawed = DrawOptions { skinning: Skinning::Vertex, ..technique.into() };
        let frozen = DrawOptions { frozen: true, ..thawed };
        draw(&mut renderer, &picture, &near, thawed);
        let of_near = picture.pixels();
        draw(&mut renderer, &picture, &far, frozen);
        let (of_far_frozen, totals) = (picture.pixels(), draw(&mut renderer, &picture, &near, frozen));
        assert_eq!(compare(&picture.pixels(), &of_near).max, 0, "{technique}: back at its camera nothing has changed");
        assert!(totals.vertex_count > 0);
        draw(&mut renderer, &picture, &far, thawed);
        let own = picture.pixels();
        assert!(compare(&of_far_frozen, &own).max > 0, "{technique}: other levels are another picture");
        assert!(compare(&of_far_frozen, &own).rms < compare(&of_near, &own).rms, "{technique}: of this camera");
        // Of other instances nothing is held.
        renderer.set_instances(&gpu::device().1, &instances[..30]).expect("they fit");
        draw(&mut renderer, &picture, &near, frozen);
        let first_frozen = picture.pixels();
        draw(&mut renderer, &picture, &near, thawed);
        assert_eq!(compare(&picture.pixels(), &first_frozen).max, 0, "{technique}: a first frame is like any other");
        renderer.set_instances(&gpu::device().1, &instances).expect("they fit");
    }
}
