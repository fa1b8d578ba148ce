//! One for each pose.

use crate::{LodChoice, PoseCounts};

/// Buckets of the sorted entries again, and a vertex for each entry that leads: the first with its bucket and pose, or one whose pose
/// nobody shares. Nobody outside the buckets leads.
///
/// `sorted_pose_keys`: of `key_poses`, sorted by `sort_instances`. The vertices' prefix sums ([`super::scan_counts`]) number the leaders.
///
/// Paper: none. Twin: `shaders/stages/find_leaders.wgsl`. Equal.
pub fn find_leaders(pose_counts: &PoseCounts, sorted_pose_keys: &[u32]) -> (Vec<u32>, Vec<LodChoice>) {
    let of = |(entry, key): (usize, &u32)| {
        let bucket = key >> pose_counts.pose_bits;
        let is_own = key & pose_counts.own_pose == pose_counts.own_pose;
        let is_new = entry == 0 || sorted_pose_keys[entry - 1] != *key || is_own;
        let leads = is_new && bucket < pose_counts.bucket_count;
        (bucket, LodChoice { vertex_count: leads.into(), triangle_count: 0 })
    };
    sorted_pose_keys.iter().enumerate().map(of).unzip()
}
