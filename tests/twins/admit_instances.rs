//! `admit_instances` on the GPU against its twin: equal.

use crate::cases::{SIZES, data, first_difference};
use crowd_stages::gpu::AdmitInstances;
use crowd_stages::{FeedConfig, FeedState, InstanceRecord, cpu};
use crowd_tests::{gpu, synthetic};

fn on_gpu(given: &[InstanceRecord], given_count: u32, feed: &FeedConfig) -> (Vec<[u32; 12]>, FeedState) {
    let (device, _) = gpu::device();
    let stage = AdmitInstances::new(device);
    let instances = gpu::output::<InstanceRecord>(feed.most as usize);
    let block_refused = gpu::output::<u32>(AdmitInstances::block_words(feed.most) as usize);
    let state = gpu::output::<FeedState>(1);
    let (config, given) = (gpu::uniform(feed), gpu::storage(given));
    let (count, characters) = (gpu::storage(&[given_count]), gpu::storage(&data().characters));
    let bound = stage.bind(device, &config, &given, &count, &characters, &instances, &block_refused, &state);
    gpu::run(|pass| stage.record(pass, &bound, feed.most));
    (gpu::read(&instances, feed.most as usize), gpu::read::<FeedState>(&state, 1)[0])
}

/// Every ninth one is spoilt, each time in another way.
fn spoilt(count: u32) -> Vec<InstanceRecord> {
    let mut instances = synthetic::instances(data(), count);
    for (i, one) in instances.iter_mut().enumerate().step_by(9) {
        match i / 9 % 12 {
            0 => one.character = 3,
            1 => one.character = u32::MAX,
            2 => one.clip = u32::MAX,
            3 => one.clip = data().characters[(one.character as usize + 1) % 3].clip_offset,
            4 => one.position[1] = f32::NAN,
            5 => one.yaw_rad = f32::INFINITY,
            6 => one.scale = f32::NEG_INFINITY,
            7 => one.phase_s = f32::NAN,
            8 => one.leaving_phase_s = f32::INFINITY,
            9 => one.leaving_share = f32::NAN,
            10 => one.leaving_share = 1.5,
            _ => (one.leaving_share, one.leaving_clip) = (0.5, u32::MAX),
        }
    }
    instances
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn who_is_admitted_is_equal_whatever_is_given() {
    for most in SIZES {
        let given = spoilt(most);
        let feed = FeedConfig { most, character_count: 3, ..Default::default() };
        for count in [0, most / 2, most, most.saturating_add(7), u32::MAX] {
            let expected = cpu::admit_instances(&data().characters, &given, count, &feed);
            let (admitted, state) = on_gpu(&given, count, &feed);
            // By bits, so that a number that is not one would be seen.
            let bits: Vec<[u32; 12]> = bytemuck::cast_slice(&expected.0).to_vec();
            assert_eq!(first_difference(&admitted, &bits), None, "{count} of {most}");
            assert_eq!(state, expected.1, "{count} of {most}");
        }
    }
}

#[test]
fn who_cannot_be_drawn_is_nobody_and_counted() {
    let given = spoilt(90);
    let feed = FeedConfig { most: 90, character_count: 3, ..Default::default() };
    let (admitted, state) = cpu::admit_instances(&data().characters, &given, 100, &feed);
    assert_eq!(state, FeedState { count: 90, refused_count: 10 + 10 });
    assert_eq!(admitted.iter().filter(|one| one.scale == 0.0).count(), 10);
    assert!(data().check_instances(&admitted).is_ok());
    let config = synthetic::config(90, 10_000, crowd_stages::Weight::Area);
    let culled = cpu::cull_instances(data(), &admitted, &config);
    assert!(admitted.iter().zip(&culled).all(|(one, cull)| one.scale != 0.0 || cull.visible == 0), "nobody is seen");
}
