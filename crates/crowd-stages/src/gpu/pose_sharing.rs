//! Instances in one pose share its palette and its vertices: sorted by bucket and pose, the first of each leads.

use super::bucket_draws::{BucketDraws, Lists};
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use super::{FindLeaders, KeyPoses, ScanCounts, SharePoses, SortInstances};
use crate::dispatch::BLOCK_SIZE;
use crate::{BucketRange, Error, InstanceBase, LodChoice, Result, SortPass};
use wgpu::BufferUsages as Usage;

/// Stages from the buckets' keys to those who lead, and what they write.
pub(crate) struct PoseSharing {
    pub(crate) leader_ranges: wgpu::Buffer,
    pub(crate) leaders: wgpu::Buffer,
    /// How many there are.
    pub(crate) leader_end: wgpu::Buffer,
    key_poses: (KeyPoses, wgpu::BindGroup),
    sort_instances: SortInstances,
    passes: Vec<(SortPass, wgpu::BindGroup)>,
    find_leaders: (FindLeaders, wgpu::BindGroup),
    scan_counts: (ScanCounts, wgpu::BindGroup),
    share_poses: (SharePoses, wgpu::BindGroup),
    bucket_count: u32,
}

impl PoseSharing {
    /// # Errors
    /// [`Error::Limit`] where a buffer is larger than the device can bind, or bucket and pose do not fit a key.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        max_instances: u32,
        draws: &BucketDraws,
    ) -> Result<Self> {
        let remedy = "draw without --share-poses";
        let (pose_counts, first_poses) = c.poses.as_ref().ok_or(Error::Limit {
            what: "bits of a bucket and a pose",
            needed: u64::from(u32::BITS) + 1,
            allowed: u32::BITS.into(),
            remedy,
        })?;
        let n = u64::from(max_instances);
        let written = Usage::STORAGE | Usage::COPY_SRC;
        let Lists { keys, morphs, sorted_keys, sorted, drawn, ranges, places } = draws.lists();
        let counts = up.filled("pose counts", &[*pose_counts], Usage::UNIFORM, remedy)?;
        let first_poses = up.filled("first poses", first_poses, Usage::STORAGE, remedy)?;
        let pose_keys = up.empty::<u32>("keys with poses", n, written, remedy)?;
        let pair = |up: &mut Uploader<'_>| -> Result<[wgpu::Buffer; 2]> {
            let keys = up.empty::<u32>("sorted keys with poses", n, written, remedy)?;
            Ok([keys, up.empty::<u32>("sorted by pose", n, written, remedy)?])
        };
        let pairs = [pair(up)?, pair(up)?];
        let digits = SortInstances::digit_count_words(max_instances);
        let digit_counts = up.empty::<u32>("counts of digits", digits, written, remedy)?;
        let leads = up.empty::<LodChoice>("leaders or not", n, written, remedy)?;
        let blocks = u64::from(max_instances.div_ceil(BLOCK_SIZE));
        let block_totals = up.empty::<InstanceBase>("leaders of blocks", blocks, written, remedy)?;
        let leaders_before = up.empty::<InstanceBase>("leaders before each", n, written, remedy)?;
        let leader_end = up.empty::<InstanceBase>("leaders in all", 1, written | Usage::UNIFORM, remedy)?;
        let bucket_count = pose_counts.bucket_count;
        let leader_ranges = up.empty::<BucketRange>("leaders of buckets", bucket_count.into(), written, remedy)?;
        let leaders = up.empty::<u32>("entries of leaders", n, written, remedy)?;

        let device = up.device;
        let key = KeyPoses::new(device);
        let (speeds, instances) = (&c.clip_speeds, &f.instances);
        let key_bound =
            key.bind(device, &f.config, &counts, instances, &c.clips, speeds, &first_poses, keys, morphs, &pose_keys);
        let sort = SortInstances::new(device);
        let mut passes = Vec::new();
        let largest = bucket_count << pose_counts.pose_bits | pose_counts.own_pose;
        for (number, pass) in SortInstances::passes(largest).into_iter().enumerate() {
            let uniform = up.filled("sort pass", &[pass], Usage::UNIFORM, remedy)?;
            let [into_keys, into] = &pairs[number % 2];
            let [from_keys, from] = &pairs[(number + 1) % 2];
            let from_keys = if number == 0 { &pose_keys } else { from_keys };
            let bound = sort.bind(device, &f.config, &uniform, from_keys, from, &digit_counts, into_keys, into);
            passes.push((pass, bound));
        }
        let [by_pose_keys, by_pose] = &pairs[(passes.len() + 1) % 2];
        let find = FindLeaders::new(device);
        let find_bound = find.bind(device, &f.config, &counts, by_pose_keys, by_pose, sorted_keys, sorted, &leads);
        let scan = ScanCounts::new(device);
        let scan_bound = scan.bind(device, &f.config, &leads, &block_totals, &leaders_before, &leader_end);
        let share = SharePoses::new(device);
        let buckets = &c.tables.bucket_counts;
        let share_bound = share.bind(
            device,
            &f.config,
            buckets,
            &leader_end,
            ranges,
            &leaders_before,
            sorted_keys,
            places,
            &leader_ranges,
            drawn,
            &leaders,
        );
        Ok(Self {
            leader_ranges,
            leaders,
            leader_end,
            key_poses: (key, key_bound),
            sort_instances: sort,
            passes,
            find_leaders: (find, find_bound),
            scan_counts: (scan, scan_bound),
            share_poses: (share, share_bound),
            bucket_count,
        })
    }

    /// After the buckets' keys: instances sorted by bucket and pose.
    pub(crate) fn record_sort(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (key, bound) = &self.key_poses;
        recorder.stage("key_poses", |pass| key.record(pass, bound, count));
        recorder.stage("sort_instances", |compute| {
            for (pass, bound) in &self.passes {
                self.sort_instances.record(compute, bound, pass, count);
            }
        });
        let (find, bound) = &self.find_leaders;
        recorder.stage("find_leaders", |pass| find.record(pass, bound, count));
    }

    /// After the buckets' ranges: how many lead in each.
    pub(crate) fn record_ranges(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (scan, bound) = &self.scan_counts;
        recorder.stage("scan_counts", |pass| scan.record(pass, bound, count));
        let (share, bound) = &self.share_poses;
        recorder.stage("share_poses", |pass| share.record_ranges(pass, bound, self.bucket_count));
    }

    /// After it is known what vertices need to know: who follows whom.
    pub(crate) fn record_followers(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        let (share, bound) = &self.share_poses;
        recorder.stage("share_poses", |pass| share.record(pass, bound, count));
    }
}
