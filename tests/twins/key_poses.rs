//! `key_poses` on the GPU against its twin; equal keys must mean equal poses.

use crate::cases::{Case, buckets, case, cases, data};
use crate::hold_poses::speeds;
use crowd_stages::gpu::KeyPoses;
use crowd_stages::{FrameConfig, InstanceRecord, MorphRecord, PoseCounts, Weight, cpu};
use crowd_tests::gpu;
use std::collections::BTreeMap;
use std::sync::OnceLock;

pub fn poses() -> &'static (PoseCounts, Vec<u32>) {
    static POSES: OnceLock<(PoseCounts, Vec<u32>)> = OnceLock::new();
    POSES.get_or_init(|| PoseCounts::of(data(), buckets()).expect("they fit 32 bits"))
}

/// A case whose poses are held, with its keys and with morphs all over.
pub struct Keyed {
    pub config: FrameConfig,
    pub instances: Vec<InstanceRecord>,
    pub keys: Vec<u32>,
    pub morphs: Vec<MorphRecord>,
}

pub fn keyed(case: &Case) -> Keyed {
    let config = FrameConfig { hold_far_m: 10.0, ..case.config };
    let mut instances = case.instances.clone();
    cpu::hold_poses(data(), speeds(), &config, &mut instances);
    let selected = case.select();
    let fill = Default::default();
    let (keys, morphs) = cpu::key_instances(buckets(), &instances, &selected.culled, &selected.choices, &fill, &config);
    let spread = |(i, m): (usize, MorphRecord)| MorphRecord { fraction: (i % 11) as f32 * 0.1, ..m };
    Keyed { config, instances, keys, morphs: morphs.into_iter().enumerate().map(spread).collect() }
}

impl Keyed {
    pub fn on_cpu(&self) -> (Vec<u32>, Vec<MorphRecord>) {
        let (counts, firsts) = poses();
        let Self { config, instances, keys, morphs } = self;
        cpu::key_poses(data(), speeds(), (counts, firsts), instances, keys, morphs, config)
    }

    fn on_gpu(&self) -> (Vec<u32>, Vec<MorphRecord>) {
        let stage = KeyPoses::new(&gpu::device().0);
        let count = self.instances.len();
        let (pose_keys, morphs) = (gpu::output::<u32>(count), gpu::storage(&self.morphs));
        let bound = stage.bind(
            &gpu::device().0,
            &gpu::uniform(&self.config),
            &gpu::uniform(&poses().0),
            &gpu::storage(&self.instances),
            &gpu::storage(&data().clips),
            &gpu::storage(speeds()),
            &gpu::storage(&poses().1),
            &gpu::storage(&self.keys),
            &morphs,
            &pose_keys,
        );
        gpu::run(|pass| stage.record(pass, &bound, count as u32));
        (gpu::read(&pose_keys, count), gpu::read(&morphs, count))
    }
}

/// Keys that differ; they may at the border of two poses or rates.
fn differing(a: &[u32], b: &[u32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn keys_agree_for_all_sizes() {
    let (mut apart, mut morphs_apart, mut all) = (0, 0, 0);
    for case in cases() {
        let keyed = keyed(&case);
        let ((gpu, gpu_morphs), (cpu, cpu_morphs)) = (keyed.on_gpu(), keyed.on_cpu());
        apart += differing(&gpu, &cpu);
        morphs_apart += gpu_morphs.iter().zip(&cpu_morphs).filter(|(a, b)| a != b).count();
        all += cpu.len();
        let bucket = |key: &u32| key >> poses().0.pose_bits;
        assert!(gpu.iter().map(bucket).eq(keyed.keys.iter().copied()), "buckets stay");
    }
    assert!(apart.max(morphs_apart) * 500 <= all, "{apart} keys and {morphs_apart} morphs of {all}");
}

#[test]
fn equal_keys_are_equal_poses_and_many_share_one() {
    let case = case(20_000, 30, Weight::Area);
    let keyed = keyed(&case);
    let (pose_keys, morphs) = keyed.on_cpu();
    assert_eq!(differing(&pose_keys, &keyed.keys), pose_keys.len(), "keys have grown by the poses");
    let own = poses().0.own_pose;
    let mut of_key: BTreeMap<u32, (f32, u32, u32)> = BTreeMap::new();
    let (mut shared, mut visible) = (0, 0);
    for (i, &key) in pose_keys.iter().enumerate() {
        if keyed.keys[i] == buckets().nobody() {
            continue;
        }
        visible += 1;
        let one = &keyed.instances[i];
        if key & own == own {
            let fades = one.leaving_share > 0.0;
            assert!(fades || keyed.keys[i] >= buckets().mesh_count, "everyone else is held: {one:?}");
            continue;
        }
        let duration_s = data().clips[one.clip as usize].duration_s;
        let turns = (keyed.config.time_s + one.phase_s - one.held_s) / duration_s;
        let seconds = (turns - turns.floor()) * duration_s;
        let quarters = (morphs[i].fraction * 4.0) as u32;
        assert_eq!(quarters as f32 * 0.25, morphs[i].fraction);
        let (other_s, other_clip, other_quarters) = *of_key.entry(key).or_insert((seconds, one.clip, quarters));
        let apart = (seconds - other_s).abs();
        assert!(apart.min(duration_s - apart) < 1e-3, "{seconds} s and {other_s} s have one key");
        assert_eq!((one.clip, quarters), (other_clip, other_quarters));
        shared += 1;
    }
    assert!(visible > 5000 && of_key.len() * 2 < shared, "{} poses for {shared} of {visible}", of_key.len());
}
