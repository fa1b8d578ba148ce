//! `find_leaders` on the GPU against its twin: equal.

use crate::cases::{buckets, cases, first_difference};
use crate::key_poses::{keyed, poses};
use crowd_stages::gpu::FindLeaders;
use crowd_stages::{LodChoice, PoseCounts, cpu};
use crowd_tests::gpu;

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn leaders_agree_for_all_sizes() {
    for case in cases() {
        let keyed = keyed(&case);
        let (sorted_pose_keys, by_pose) = cpu::sort_instances(&keyed.on_cpu().0);
        let count = by_pose.len();
        let stage = FindLeaders::new(&gpu::device().0);
        let (keys, values) = (gpu::output::<u32>(count), gpu::output::<u32>(count));
        let leads = gpu::output::<LodChoice>(count);
        let bound = stage.bind(
            &gpu::device().0,
            &gpu::uniform(&keyed.config),
            &gpu::uniform(&poses().0),
            &gpu::storage(&sorted_pose_keys),
            &gpu::storage(&by_pose),
            &keys,
            &values,
            &leads,
        );
        gpu::run(|pass| stage.record(pass, &bound, count as u32));
        let (expected_keys, expected_leads) = cpu::find_leaders(&poses().0, &sorted_pose_keys);
        assert_eq!(first_difference(&gpu::read::<u32>(&keys, count), &expected_keys), None);
        assert_eq!(first_difference(&gpu::read::<u32>(&values, count), &by_pose), None);
        assert_eq!(first_difference(&gpu::read::<LodChoice>(&leads, count), &expected_leads), None);
        // The buckets are as they would be without poses.
        assert_eq!(first_difference(&expected_keys, &cpu::sort_instances(&keyed.keys).0), None);
    }
}

#[test]
fn the_first_of_a_run_leads_and_whoever_shares_with_nobody() {
    let counts = PoseCounts { pose_bits: 4, own_pose: 15, bucket_count: 3, mesh_count: 3 };
    let key = |bucket: u32, pose: u32| bucket << 4 | pose;
    let sorted = [key(0, 2), key(0, 2), key(0, 15), key(0, 15), key(1, 2), key(1, 3), key(1, 3), key(3, 0), key(3, 0)];
    let (buckets, leads) = cpu::find_leaders(&counts, &sorted);
    assert_eq!(buckets, [0, 0, 0, 0, 1, 1, 1, 3, 3]);
    let leads: Vec<u32> = leads.iter().map(|lead| lead.vertex_count).collect();
    assert_eq!(leads, [1, 0, 1, 1, 1, 1, 0, 0, 0]);
}

#[test]
fn too_many_buckets_and_poses_are_refused() {
    let mut data = crowd_tests::synthetic::crowd();
    assert!(PoseCounts::of(&data, buckets()).is_some());
    data.clips[0].duration_s = 1e7;
    assert!(PoseCounts::of(&data, buckets()).is_none(), "five hundred million poses");
    data.clips[0].duration_s = f32::MAX;
    assert!(PoseCounts::of(&data, buckets()).is_none());
}
