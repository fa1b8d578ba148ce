//! `select_casters` on the GPU against its twin: equal, but for spheres that touch an edge.

use crate::cases::{Case, buckets, case, cases};
use crowd_stages::{
    CascadeStep, CrowdBounds, CrowdData, DrawConfig, LodChoice, ShadowConfig, Weight, cpu, fit_cascades,
    gpu::SelectCasters,
};
use crowd_tests::gpu;
use glam::{Mat4, Vec3};

struct Casting {
    case: Case,
    shadow: ShadowConfig,
    choices: Vec<LodChoice>,
}

fn casting(case: Case) -> Casting {
    let clip_from_world = Mat4::from_cols_array_2d(&case.config.clip_from_world);
    let draw = DrawConfig::new(&clip_from_world, 640, 360, 64);
    let mut bounds = CrowdBounds::default();
    for instance in &case.instances {
        let (center, radius) = cpu::world_sphere(case.data, instance);
        bounds.add(center, radius);
    }
    let shadow = fit_cascades(&case.config, &draw, &bounds, 4);
    let choices = case.select().choices;
    Casting { case, shadow, choices }
}

fn step(cascade: u32, has_choices: u32) -> CascadeStep {
    CascadeStep { cascade, has_choices, ..Default::default() }
}

fn on_gpu(casting: &Casting, step: &CascadeStep) -> Vec<LodChoice> {
    let Casting { case, shadow, choices } = casting;
    let stage = SelectCasters::new(&gpu::device().0);
    let casters = gpu::output::<LodChoice>(choices.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(shadow),
        &gpu::uniform(step),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.clips),
        &gpu::storage(&buckets().error_lods()),
        &gpu::storage(choices),
        &casters,
        &gpu::storage(&buckets().sets),
        &gpu::storage(&buckets().records),
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&casters, choices.len())
}

fn on_cpu(casting: &Casting, data: &CrowdData, step: &CascadeStep) -> Vec<LodChoice> {
    let Casting { case, shadow, choices } = casting;
    let lods = buckets().error_lods();
    cpu::select_casters(data, buckets(), &lods, &case.instances, choices, shadow, step, &case.config)
}

/// The data with spheres a little larger or smaller.
fn resized(data: &CrowdData, factor: f32) -> CrowdData {
    let mut data = data.clone();
    data.clips.iter_mut().for_each(|clip| clip.sphere[3] *= factor);
    data
}

fn difference(casting: &Casting, step: &CascadeStep, gpu: &[LodChoice], cpu: &[LodChoice]) -> Option<String> {
    let [larger, smaller] = [1.0005, 0.9995].map(|factor| on_cpu(casting, &resized(casting.case.data, factor), step));
    let i = (0..cpu.len()).find(|&i| gpu[i] != cpu[i] && larger[i] == smaller[i])?;
    Some(format!("instance {i}: {:?} on the GPU, {:?} on the CPU", gpu[i], cpu[i]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn casters_agree_for_all_sizes_and_cascades() {
    for case in cases().filter(|case| case.count() > 0) {
        let mut casting = casting(case);
        for (cascade, has_dots) in (0..4).flat_map(|cascade| [(cascade, false), (cascade, true)]) {
            casting.case.config.dot_area_px2 = if has_dots { 200.0 } else { 0.0 };
            casting.case.config.morph = u32::from(cascade > 1);
            let step = step(cascade, cascade % 2);
            let expected = on_cpu(&casting, casting.case.data, &step);
            let found = on_gpu(&casting, &step);
            assert_eq!(difference(&casting, &step, &found, &expected), None, "cascade {cascade}, dots: {has_dots}");
        }
    }
}

#[test]
fn who_is_a_few_texels_high_casts_as_dots_that_have_fewer_vertices_than_the_coarsest_mesh() {
    let mut casting = casting(case(1000, 30, Weight::Area));
    let [meshes, dots] = [0.0, 200.0].map(|area| {
        casting.case.config.dot_area_px2 = area;
        (0..4).map(|cascade| on_cpu(&casting, casting.case.data, &step(cascade, 0))).collect::<Vec<_>>()
    });
    let coarsest =
        |i: usize| casting.case.data.characters[casting.case.instances[i].character as usize].min_vertex_count;
    let mut counts = [0; 4];
    for (cascade, (meshes, dots)) in meshes.iter().zip(&dots).enumerate() {
        for (i, (mesh, caster)) in meshes.iter().zip(dots).enumerate() {
            assert_eq!(mesh.vertex_count > 0, caster.vertex_count > 0, "somebody comes or goes");
            let is_dots = caster.vertex_count > 0 && caster.vertex_count < coarsest(i);
            assert!(is_dots || caster == mesh);
            counts[cascade] += u32::from(is_dots);
        }
    }
    assert!(counts[0] == 0 && counts[3] > 20, "{counts:?}");
}

#[test]
fn a_changed_level_is_seen() {
    let casting = casting(case(1000, 30, Weight::Area));
    let step = step(1, 1);
    let expected = on_cpu(&casting, casting.case.data, &step);
    let some = expected.iter().position(|choice| choice.vertex_count > 0).expect("somebody casts a shadow");
    let mut changed = expected.clone();
    changed[some].vertex_count += 1;
    assert!(difference(&casting, &step, &changed, &expected).is_some());
}

#[test]
fn casters_are_at_most_as_fine_as_what_the_camera_sees() {
    let casting = casting(case(1000, 30, Weight::Area));
    for cascade in 0..4 {
        for (caster, seen) in on_cpu(&casting, casting.case.data, &step(cascade, 1)).iter().zip(&casting.choices) {
            assert!(seen.vertex_count == 0 || caster.vertex_count <= seen.vertex_count);
        }
    }
}

#[test]
fn where_levels_morph_casters_are_coarser_than_what_the_camera_sees() {
    let mut casting = casting(case(1000, 30, Weight::Area));
    casting.case.config.morph = 1;
    // As for one who allows no error.
    casting.shadow.cascades.iter_mut().for_each(|cascade| cascade.details_per_m = f32::MAX);
    let coarsest =
        |i: usize| casting.case.data.characters[casting.case.instances[i].character as usize].min_vertex_count;
    let mut coarser = 0;
    for cascade in 0..4 {
        let casters = on_cpu(&casting, casting.case.data, &step(cascade, 1));
        for (i, (caster, seen)) in casters.iter().zip(&casting.choices).enumerate() {
            let both = caster.vertex_count > 0 && seen.vertex_count > 0;
            assert!(!both || caster.vertex_count < seen.vertex_count || caster.vertex_count == coarsest(i));
            coarser += u32::from(both && caster.vertex_count < seen.vertex_count);
        }
    }
    assert!(coarser > 100, "{coarser}");
}

/// Where a point in the view looks for its shadow, as `shaders/shared/shadow.wgsl` does.
fn cascade_of(shadow: &ShadowConfig, p: Vec3) -> Option<u32> {
    let edge = 1.0 - 3.0 / shadow.side as f32;
    (0..shadow.cascade_count).find(|c| {
        let at = Mat4::from_cols_array_2d(&shadow.cascades[*c as usize].clip_from_world).transform_point3(p);
        at.truncate().abs().max_element() < edge && at.z < 1.0
    })
}

#[test]
fn whoever_stands_between_a_point_in_view_and_the_sun_is_in_the_map_that_the_point_reads() {
    let casting = casting(case(1000, 30, Weight::Area));
    let Casting { case, shadow, .. } = &casting;
    let casters: Vec<Vec<LodChoice>> = (0..4).map(|c| on_cpu(&casting, case.data, &step(c, 0))).collect();
    let sun = Vec3::from(crowd_stages::SUN_DIRECTION);
    let (mut shaded, mut read) = (0, [0; 4]);
    for i in 0..4000 {
        let at = |step: u32| crowd_tests::synthetic::hash(i * 2 + step) as f32 / u32::MAX as f32 - 0.5;
        let p = Vec3::new(70.0 * at(0), 0.0, 70.0 * at(1));
        let in_view = case.config.planes.iter().all(|n| Vec3::new(n[0], n[1], n[2]).dot(p) + n[3] >= 0.0);
        let Some(cascade) = cascade_of(shadow, p).filter(|_| in_view) else { continue };
        read[cascade as usize] += 1;
        for (number, instance) in case.instances.iter().enumerate() {
            let (center, radius) = cpu::world_sphere(case.data, instance);
            let aside = (center - p).reject_from(sun).length();
            if aside <= radius && (center - p).dot(sun) > 0.0 {
                shaded += 1;
                assert!(casters[cascade as usize][number].vertex_count > 0, "{number} over {p} in {cascade}");
            }
        }
    }
    assert!(shaded > 200 && read.iter().filter(|points| **points > 20).count() >= 2, "{shaded} shaded, {read:?}");
}
