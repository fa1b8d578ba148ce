//! Real files, damaged: the reader answers. A panic fails the test by itself.

use std::time::{Duration, Instant};

use crowd_source::{Limits, read_character};

use crate::assets::folder;

fn answers(name: &str, damage: impl Fn(&mut Vec<u8>, usize), steps: usize) {
    let path = folder().join(name);
    let whole = std::fs::read(&path).expect("readable");
    for step in 0..steps {
        let mut bytes = whole.clone();
        damage(&mut bytes, step);
        let start = Instant::now();
        let _ = read_character(&path, &bytes, &Limits::default());
        assert!(start.elapsed() < Duration::from_secs(20), "{name}, step {step}: {:?}", start.elapsed());
    }
}

/// A small generator of numbers that look random, the same everywhere.
fn scatter(seed: usize) -> usize {
    let mut x = seed as u64 ^ 0x9e37_79b9_7f4a_7c15;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ (x >> 31)) as usize
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn every_shorter_glb_is_refused() {
    let path = folder().join("khronos-rigged/RiggedSimple.glb");
    let whole = std::fs::read(&path).expect("readable");
    for length in 0..whole.len() {
        let loaded = read_character(&path, &whole[..length], &Limits::default());
        assert!(loaded.is_err(), "{length} of {} bytes were accepted", whole.len());
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn shorter_big_files_are_answered() {
    for name in [
        "khronos-fox/Fox.glb",
        "nasty/valid/cesium_man_meshopt.glb",
        "quaternius-ultimate-characters/Knight_Male.gltf",
        "obj-spot/cow.obj",
    ] {
        answers(name, |bytes, step| bytes.truncate(bytes.len() * step / 40), 40);
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn files_with_flipped_bytes_are_answered() {
    for (name, steps) in [
        ("khronos-rigged/RiggedSimple.glb", 2000),
        ("nasty/valid/cesium_man_meshopt.glb", 150),
        ("nasty/valid/RiggedSimple_embedded.gltf", 1000),
        ("nasty/valid/SimpleSparseAccessor.gltf", 1000),
        ("nasty/valid/obj/concave_polygon.obj", 1000),
    ] {
        let flip = |bytes: &mut Vec<u8>, step: usize| {
            for n in 0..1 + step % 4 {
                let at = scatter(step * 8 + n) % bytes.len();
                bytes[at] ^= 1 << (scatter(step * 8 + n + 1) % 8);
            }
        };
        answers(name, flip, steps);
    }
}
