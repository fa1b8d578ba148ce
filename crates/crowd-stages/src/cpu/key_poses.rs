//! Who is in which pose.

use super::{held_tick, hold_ticks};
use crate::{Buckets, CrowdData, FrameConfig, InstanceRecord, MorphRecord, PoseCounts};

/// Keys of the instances with the pose behind the bucket: equal ones look the same. And their morphs, in quarters where poses are
/// shared.
///
/// A pose is one that is held ([`super::hold_poses`]), of a clip and at a tick, or the only one of a clip, and a quarter of the way between two
/// levels. Who is not held, or fades, or is dots, gets the bucket's [`PoseCounts::own_pose`], which nobody shares.
///
/// `keys`, `morphs`: of `key_instances`; `pose_counts`, `first_poses`: of [`PoseCounts::of`]; `clip_speeds`: of [`super::clip_speeds`].
///
/// Paper: ERATO §4 keeps a character's own vertices from update to update; Lister et al. 2010 share them. Twin:
/// `shaders/stages/key_poses.wgsl`. Equal but at the border of two poses or rates.
pub fn key_poses(
    data: &CrowdData,
    clip_speeds: &[f32],
    (pose_counts, first_poses): (&PoseCounts, &[u32]),
    instances: &[InstanceRecord],
    keys: &[u32],
    morphs: &[MorphRecord],
    config: &FrameConfig,
) -> (Vec<u32>, Vec<MorphRecord>) {
    let of = |i: usize| {
        let (instance, mut morph) = (&instances[i], morphs[i]);
        let clip = &data.clips[instance.clip as usize];
        let ticks = hold_ticks(data, clip_speeds[instance.clip as usize], config, instance);
        let is_still = instance.leaving_share == 0.0 && (clip.duration_s <= 0.0 || clip.frame_count < 2);
        let mut pose = pose_counts.own_pose;
        if keys[i] < pose_counts.mesh_count && (ticks > 0 || is_still) {
            let tick = if is_still { 0 } else { held_tick(clip, instance, config, ticks).min(clip_ticks(clip) - 1) };
            let quarters = (morph.fraction * 4.0 + 0.5) as u32;
            morph.fraction = quarters as f32 * 0.25;
            pose = (first_poses[instance.clip as usize] + tick) * 5 + quarters.min(4);
        }
        (keys[i] << pose_counts.pose_bits | pose, morph)
    };
    (0..instances.len()).map(of).unzip()
}

/// Poses of a clip that may be held: its ticks, at least one.
fn clip_ticks(clip: &crowd_pack::ClipRecord) -> u32 {
    if clip.duration_s > 0.0 && clip.frame_count > 1 {
        ((clip.duration_s / super::HOLD_TICK_S) as u32).saturating_add(1)
    } else {
        1
    }
}

impl PoseCounts {
    /// Numbers of poses for a crowd: how many bits a pose takes, and the first pose of each clip among those of its character. `None`
    /// where bucket and pose do not fit a key of 32 bits.
    pub fn of(data: &CrowdData, buckets: &Buckets) -> Option<(Self, Vec<u32>)> {
        let mut first_poses = vec![0; data.clips.len()];
        let mut most = 0u64;
        for character in &data.characters {
            let clips = character.clip_offset as usize..(character.clip_offset + character.clip_count) as usize;
            let mut next = 0u64;
            for (first, clip) in first_poses[clips.clone()].iter_mut().zip(&data.clips[clips]) {
                *first = u32::try_from(next).ok()?;
                next += u64::from(clip_ticks(clip));
            }
            most = most.max(next * 5);
        }
        // One more for those who share theirs with nobody.
        let pose_bits = u64::BITS - most.leading_zeros();
        let bucket_bits = u32::BITS - buckets.nobody().leading_zeros();
        if pose_bits + bucket_bits > u32::BITS || pose_bits >= u32::BITS {
            return None;
        }
        let own_pose = (1 << pose_bits) - 1;
        let (bucket_count, mesh_count) = (buckets.nobody(), buckets.mesh_count);
        Some((Self { pose_bits, own_pose, bucket_count, mesh_count }, first_poses))
    }
}
