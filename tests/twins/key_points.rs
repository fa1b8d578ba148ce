//! `key_points` on the GPU against its twin, and the picture of points against points put on pixels one by one.

use crate::cases::{Case, case, cases, data, first_difference};
use crate::whole_chain::{OPTIONS, compare, draw, renderer};
use crowd_raster::{Dab, Target, View, draw_dabs, draw_ground, draw_sky};
use crowd_stages::{
    BucketRecord, Buckets, CullRecord, FrameConfig, InstanceRecord, POINT_COUNTS, PointRecord, Technique, Weight, cpu,
    gpu::KeyPoints, surface_points,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::{Mat4, Vec3};
use std::sync::OnceLock;

fn points() -> &'static (Vec<Option<Vec<PointRecord>>>, Buckets) {
    static POINTS: OnceLock<(Vec<Option<Vec<PointRecord>>>, Buckets)> = OnceLock::new();
    POINTS.get_or_init(|| {
        let points = surface_points(data());
        let buckets = Buckets::with_points(data(), &points).expect("the barrels have index tables");
        (points, buckets)
    })
}

fn on_gpu(case: &Case, culled: &[CullRecord]) -> Vec<u32> {
    let stage = KeyPoints::new(&gpu::device().0);
    let (_, buckets) = points();
    let keys = gpu::output::<u32>(case.instances.len());
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&buckets.counts()),
        &gpu::storage(&case.instances),
        &gpu::storage(&buckets.sets),
        &gpu::storage(&buckets.records),
        &gpu::storage(culled),
        &keys,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    gpu::read(&keys, case.instances.len())
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn keys_are_equal_for_all_sizes() {
    for case in cases() {
        let culled = cpu::cull_instances(data(), &case.instances, &case.config);
        let expected = cpu::key_points(&points().1, &case.instances, &culled);
        assert_eq!(first_difference(&on_gpu(&case, &culled), &expected), None, "{} instances", case.count());
    }
}

#[test]
fn near_ones_keep_their_triangles_and_far_ones_become_fewer_points() {
    let (_, buckets) = points();
    let case = case(1000, 30, Weight::Area);
    let mut culled = cpu::cull_instances(data(), &case.instances, &case.config);
    let points_at = |culled: &mut [CullRecord], area_px2: f32| {
        culled.iter_mut().for_each(|cull| cull.area_px2 = area_px2);
        let key = |key: &u32| buckets.records.get(*key as usize).copied().unwrap_or_default();
        let drawn = cpu::key_points(buckets, &case.instances, culled).iter().map(key).collect::<Vec<_>>();
        drawn.into_iter().filter(|record| record.vertex_count > 0).collect::<Vec<_>>()
    };
    let visible = culled.iter().filter(|cull| cull.visible != 0).count();
    for (area_px2, count) in [(1.0, 64), (64.0, 64), (64.5, 256)] {
        let drawn = points_at(&mut culled, area_px2);
        assert_eq!(drawn.len(), visible);
        let has_points = |record: &&BucketRecord| record.triangle_count == 0;
        assert!(drawn.iter().filter(has_points).count() > visible / 4, "{area_px2}: {drawn:?}");
        assert!(drawn.iter().filter(has_points).all(|record| record.vertex_count == count), "{area_px2}: {drawn:?}");
    }
    for area_px2 in [4097.0, f32::INFINITY, f32::NAN] {
        assert!(points_at(&mut culled, area_px2).iter().all(|record| record.triangle_count > 0), "{area_px2}");
    }
}

/// A crowd far enough that everyone is points, but for those with fewer vertices than that.
fn far_away() -> (Vec<InstanceRecord>, FrameConfig) {
    let mut instances = synthetic::instances(data(), 200);
    instances.retain(|instance| data().characters[instance.character as usize].vertex_count > POINT_COUNTS[1]);
    let view = synthetic::view(Vec3::new(6.0, 20.0, 80.0), Vec3::new(0.0, 0.8, 0.0), u32::MAX, Weight::Area, 360);
    (instances, FrameConfig::from_camera(&view))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_picture_is_that_of_points_put_on_pixels() {
    let (instances, config) = far_away();
    let (all, buckets) = points();
    let picture = Picture::new((640, 360));
    let totals = draw(&mut renderer(OPTIONS, &instances), &picture, &config, Technique::Points);
    let config = FrameConfig { instance_count: instances.len() as u32, ..config };
    let frame = cpu::select_points(data(), buckets, &instances, &config);
    let of = |t: crowd_stages::FrameTotals| (t.visible_count, t.vertex_count, t.triangle_count);
    assert_eq!(of(totals), of(frame.totals));
    assert!(totals.triangle_count == 0 && instances.len() > 50, "{totals:?}");

    let view =
        View { clip_from_world: Mat4::from_cols_array_2d(&config.clip_from_world), eye: Vec3::from_array(config.eye) };
    let mut target = Target::new(640, 360, [0, 0, 0, 255]);
    draw_sky(&mut target, &view);
    draw_ground(&mut target, &view);
    let empty = target.color.clone();
    for (instance, choice) in instances.iter().zip(&frame.choices) {
        let points = all[instance.character as usize].as_ref().expect("barrels have a surface");
        let posed = cpu::pose_points(data(), &points[..choice.vertex_count as usize], instance, config.time_s);
        let dab = |point: cpu::PosedPoint| Dab {
            position: point.position,
            normal: point.normal,
            color: point.color,
            is_unlit: point.is_unlit,
            is_double_sided: point.is_double_sided,
        };
        draw_dabs(&mut target, &view, &posed.into_iter().map(dab).collect::<Vec<_>>(), 1);
    }
    // Points that fall on the edge between two pixels may fall to either side.
    let nobody = compare(&picture.pixels(), &empty).share_over(16);
    assert!(nobody > 0.005, "the comparison can fail: {nobody} of the picture is people");
    let difference = compare(&picture.pixels(), &target.color);
    assert!(difference.share_over(16) < 0.05 * nobody, "{difference:?}");
}
