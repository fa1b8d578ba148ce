//! What the stages get of a pack: the fixtures of the format, in both layouts of the animation and all storages of joints.

use crowd_pack::{NONE, Pack};
use crowd_stages::{CrowdData, InstanceRecord, LodChoice, cpu};
use std::path::Path;

fn open(name: &str) -> Pack {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/packs/v3");
    Pack::open(&folder.join(name)).expect("a pack of the contract")
}

/// Positions of every character at full detail in its first clip, at a time between two frames.
fn poses(data: &CrowdData) -> Vec<[f32; 3]> {
    let pose = |(number, character): (usize, &crowd_pack::CharacterRecord)| {
        let instance = InstanceRecord {
            scale: 1.0,
            character: number as u32,
            clip: character.clip_offset,
            phase_s: 0.1,
            ..Default::default()
        };
        let (vertex_count, triangle_count) = (character.vertex_count, character.triangle_count);
        cpu::pose_instance(data, &instance, LodChoice { vertex_count, triangle_count }, 0.3).positions
    };
    data.characters.iter().enumerate().flat_map(pose).collect()
}

#[test]
fn a_pack_is_unpacked_with_layers_of_one_size() {
    let pack = open("tiny.crowdpack");
    let contents = pack.contents();
    let data = CrowdData::from_pack(&pack, 8).expect("its images decode");
    assert_eq!((data.vertices.len(), data.lods.len()), (contents.vertices.len(), contents.lods.len()));
    assert_eq!(data.layers.len(), contents.images.len());
    assert!(data.layer_side.is_power_of_two() && data.layer_side <= 8);
    for layer in &data.layers {
        let texel_counts: Vec<usize> = layer.mips.iter().map(Vec::len).collect();
        let expected: Vec<usize> = (0..=data.layer_side.ilog2()).rev().map(|level| 1 << (2 * level)).collect();
        assert_eq!(texel_counts, expected);
    }
    assert!(data.materials.iter().all(|m| m.image == NONE || (m.image as usize) < data.layers.len()));
    let first = InstanceRecord { clip: data.characters[0].clip_offset, ..Default::default() };
    assert!(data.check_instances(&[first]).is_ok());
    let stranger = InstanceRecord { clip: data.clips.len() as u32, ..first };
    assert!(data.check_instances(&[first, stranger]).is_err());
}

#[test]
fn layouts_and_storages_of_the_animation_give_the_same_poses() {
    let poses = |name| poses(&CrowdData::from_pack(&open(name), 64).expect("its images decode"));
    let whole = poses("tiny.crowdpack");
    for other in ["tiny_split_layout.crowdpack", "tiny_f16.crowdpack", "tiny_quantized.crowdpack"] {
        let others = poses(other);
        assert!(!whole.is_empty() && whole.len() == others.len());
        for (a, b) in whole.iter().zip(&others) {
            let apart = (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f32::max);
            assert!(apart < 1e-5, "{other}: {a:?} and {b:?}");
        }
    }
}
