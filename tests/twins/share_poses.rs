//! `share_poses` on the GPU against its twins: equal; and pictures of shared poses, which are those of held ones.

use crate::cases::{Case, buckets, case, cases, data, first_difference};
use crate::hold_poses::speeds;
use crate::key_poses::{keyed, poses};
use crate::whole_chain::{OPTIONS, compare, draw};
use crowd_stages::gpu::{CrowdRenderer, RendererOptions, SharePoses};
use crowd_stages::{
    BucketRange, Buckets, DrawOptions, DrawnInstance, FrameConfig, InstanceBase, Skinning, Technique, Weight, cpu,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn followers_agree_for_all_sizes() {
    for case in cases() {
        // Palettes for all, or for a third.
        for palette_slots in [buckets().palette_slots, case.count() / 3] {
            followers_agree(&case, &Buckets { palette_slots, ..buckets().clone() });
        }
    }
}

fn followers_agree(case: &Case, buckets: &Buckets) {
    let keyed = keyed(case);
    let (pose_keys, morphs) = keyed.on_cpu();
    let (sorted_pose_keys, by_pose) = cpu::sort_instances(&pose_keys);
    let (keys, leads) = cpu::find_leaders(&poses().0, &sorted_pose_keys);
    let (before, end) = cpu::scan_counts(&leads);
    let (ranges, ..) = cpu::write_bucket_args(buckets, &keys, &case.select().sums, &keyed.config);
    let leader_ranges = cpu::range_leaders(&ranges, &before, end);
    let (places, ..) = cpu::place_buckets(buckets, &leader_ranges, case.count() * 20);
    let time_s = keyed.config.time_s;
    let gathered = cpu::gather_drawn(data(), buckets, &keyed.instances, &morphs, &keys, &by_pose, &places, time_s);
    let mut drawn = gathered.clone();
    let leaders = cpu::follow_leaders(buckets, &keys, &before, end, &places, &mut drawn);
    assert_eq!(leaders.len() as u32, end.vertex_base);

    let stage = SharePoses::new(&gpu::device().0);
    let ranges_out = gpu::output::<BucketRange>(ranges.len());
    let leaders_out = gpu::output::<u32>(leaders.len());
    let mut padded = gathered;
    padded.resize(case.instances.len(), DrawnInstance::default());
    let drawn_out = gpu::storage(&padded);
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&keyed.config),
        &gpu::uniform(&buckets.counts()),
        &gpu::uniform(&end),
        &gpu::storage(&ranges),
        &gpu::storage::<InstanceBase>(&before),
        &gpu::storage(&keys),
        &gpu::storage(&places),
        &ranges_out,
        &drawn_out,
        &leaders_out,
    );
    gpu::run(|pass| stage.record_ranges(pass, &bound, ranges.len() as u32));
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    let read: Vec<BucketRange> = gpu::read(&ranges_out, ranges.len());
    assert_eq!(first_difference(&read, &leader_ranges), None, "{} instances", case.count());
    assert_eq!(first_difference(&gpu::read::<u32>(&leaders_out, leaders.len()), &leaders), None);
    assert_eq!(first_difference(&gpu::read::<DrawnInstance>(&drawn_out, drawn.len()), &drawn), None);
    if case.count() >= 1000 {
        let followers = drawn.iter().filter(|one| one.row_count == 0).count();
        assert!(followers > 20, "{followers} of {} follow", drawn.len());
    }
}

/// What is shared is what everyone has on their own: the picture is that of held poses, and fewer are worked out than are seen.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn shared_poses_are_drawn_as_held_ones_are() {
    let case = case(3000, 60, Weight::Area);
    let mut with_speeds = synthetic::crowd();
    with_speeds.clip_speeds = speeds().to_vec();
    let (device, queue) = gpu::device();
    let options = RendererOptions { max_instances: 3000, max_vertices: 400_000, ..OPTIONS };
    let mut renderer = CrowdRenderer::new(device, queue, &with_speeds, options).expect("it fits");
    let alone: Vec<_> =
        case.instances.iter().map(|one| crowd_stages::InstanceRecord { leaving_share: 0.0, ..*one }).collect();
    renderer.set_instances(queue, &alone).expect("good ones");
    let picture = Picture::new((640, 360));
    let config = FrameConfig { hold_far_m: 20.0, ..case.config };
    let base = DrawOptions { holds_poses: true, ..DrawOptions::from(Technique::Bucketed) };
    for no_morph in [true, false] {
        for skinning in [Skinning::Palettes, Skinning::Compute] {
            let own = DrawOptions { skinning, no_morph, ..base };
            let totals = draw(&mut renderer, &picture, &config, own);
            let expected = picture.pixels();
            let shared = DrawOptions { share_poses: true, ..own };
            assert!(shared.shares_poses());
            assert_eq!(draw(&mut renderer, &picture, &config, shared), totals);
            assert_eq!(renderer.skinning(skinning).way, skinning);
            let apart = compare(&picture.pixels(), &expected).share_over(8);
            // Quarters of morphs move vertices by a little.
            let allowed = if no_morph { 2e-3 } else { 0.03 };
            assert!(apart <= allowed, "{skinning:?}, no_morph {no_morph}: {apart} of the pixels");
            let poses = renderer.shared_poses(device, queue).expect("it can be read").expect("they were shared");
            let seen = totals.visible_count;
            assert!(poses > 0 && poses < seen * 9 / 10, "{poses} poses for {seen}");
            // Switched off, nothing is left of it.
            draw(&mut renderer, &picture, &config, own);
            assert_eq!(compare(&picture.pixels(), &expected).max, 0);
        }
    }
    let way = |skinning| DrawOptions { skinning, share_poses: true, ..base };
    assert!(!way(Skinning::Vertex).shares_poses() && !way(Skinning::Auto).shares_poses());
    let frozen = DrawOptions { frozen: true, ..way(Skinning::Compute) };
    assert!(!frozen.shares_poses(), "a frozen list is of other poses");
}
