//! `blend_palettes` on the GPU against its twin, fed with what the GPU gathered: within rounding.

use crate::cases::{buckets, case, data};
use crate::whole_chain::{OPTIONS, draw, renderer};
use crowd_stages::{DrawOptions, DrawnInstance, FrameConfig, Skinning, Technique, Weight, cpu};
use crowd_tests::gpu::{self, Picture};

/// A share of a matrix entry of a few metres.
const BOUND: f32 = 1e-6;

fn first_apart(gpu: &[[f32; 4]], cpu: &[[f32; 4]]) -> Option<String> {
    let apart = |(a, b): (&[f32; 4], &[f32; 4])| {
        a.iter().zip(b).any(|(a, b)| (a - b).abs() > BOUND * a.abs().max(b.abs()).max(1.0))
    };
    let row = gpu.iter().zip(cpu).position(apart)?;
    Some(format!("row {row}: {:?} on the GPU, {:?} on the CPU", gpu[row], cpu[row]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn palettes_agree_for_everyone_drawn() {
    let case = case(5000, 30, Weight::Area);
    let picture = Picture::new((64, 36));
    let mut renderer = renderer(OPTIONS, &case.instances);
    let options = DrawOptions { skinning: Skinning::Palettes, ..DrawOptions::from(Technique::Bucketed) };
    let visible = draw(&mut renderer, &picture, &case.config, options).visible_count as usize;
    let buffer = |name| renderer.buffer(Technique::Bucketed, name).expect("bucketing writes it");
    let drawn: Vec<DrawnInstance> = gpu::read(buffer("drawn"), visible);
    let expected = cpu::blend_palettes(data(), buckets(), &drawn);
    let palettes: Vec<[f32; 4]> = gpu::read(buffer("palettes"), expected.len());
    assert!(visible > 500 && drawn.iter().any(|one| one.blend > 0.3 && one.blend < 0.7));
    assert_eq!(first_apart(&palettes, &expected), None);

    // The comparison can fail: these are not the nearest frames' matrices, as the papers have them.
    let nearest: Vec<DrawnInstance> = drawn.iter().map(|one| DrawnInstance { blend: 0.0, ..*one }).collect();
    assert!(first_apart(&palettes, &cpu::blend_palettes(data(), buckets(), &nearest)).is_some());
    // Nor those of one clip alone.
    let alone: Vec<DrawnInstance> = drawn.iter().map(|one| DrawnInstance { leaving_share: 0.0, ..*one }).collect();
    assert!(first_apart(&palettes, &cpu::blend_palettes(data(), buckets(), &alone)).is_some());
}

/// Where poses are shared the leaders have the palettes, in their order.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn palettes_of_leaders_agree() {
    let case = case(5000, 30, Weight::Area);
    let picture = Picture::new((64, 36));
    let mut renderer = renderer(OPTIONS, &case.instances);
    let options = DrawOptions { skinning: Skinning::Palettes, ..DrawOptions::from(Technique::Bucketed) };
    let options = DrawOptions { holds_poses: true, share_poses: true, ..options };
    let config = FrameConfig { hold_far_m: 10.0, ..case.config };
    let visible = draw(&mut renderer, &picture, &config, options).visible_count as usize;
    let (device, queue) = gpu::device();
    let count = renderer.shared_poses(device, queue).expect("can be read").expect("they were shared") as usize;
    let buffer = |name| renderer.buffer(Technique::Bucketed, name).expect("bucketing writes it");
    let drawn: Vec<DrawnInstance> = gpu::read(buffer("drawn"), visible);
    let entries: Vec<u32> = gpu::read(buffer("leaders"), count);
    let leaders: Vec<DrawnInstance> = entries.iter().map(|entry| drawn[*entry as usize]).collect();
    assert!(count > 500 && count < visible && leaders.iter().all(|one| one.row_count > 0));
    let expected = cpu::blend_palettes(data(), buckets(), &leaders);
    let palettes: Vec<[f32; 4]> = gpu::read(buffer("palettes"), expected.len());
    assert_eq!(first_apart(&palettes, &expected), None);
    // The comparison can fail: the first entries are not the leaders.
    assert!(first_apart(&palettes, &cpu::blend_palettes(data(), buckets(), &drawn[..count])).is_some());
}
