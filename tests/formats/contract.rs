//! `fixtures/packs/v3`, `v4` and `v5` load and mean what they meant, for our reader and for one that knows only `docs/FORMAT.md`; `packs/v1` and
//! `packs/v2` are refused by their versions.

use crate::independent_reader::{Reader, Track, crc32};
use crate::tiny_pack;
use crowd_pack::{AnimationLayout, Error, JointStorage, Pack};
use std::path::{Path, PathBuf};

const FILES: [(&str, AnimationLayout, JointStorage); 4] = [
    ("fixtures/packs/v3/tiny.crowdpack", AnimationLayout::Premultiplied3x4, JointStorage::F32),
    ("fixtures/packs/v3/tiny_f16.crowdpack", AnimationLayout::Premultiplied3x4, JointStorage::F16),
    ("fixtures/packs/v3/tiny_quantized.crowdpack", AnimationLayout::Premultiplied3x4, JointStorage::Quantized),
    ("fixtures/packs/v3/tiny_split_layout.crowdpack", AnimationLayout::Split4x4, JointStorage::F32),
];

const IMPOSTORS: &str = "fixtures/packs/v4/tiny_impostors.crowdpack";
const FINISHES: &str = "fixtures/packs/v5/tiny_finishes.crowdpack";

fn fixture(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// `REWRITE_PACKS_V3=1` writes the files anew. It has its own name, so that renewing goldens does not touch the contract.
#[test]
fn the_builder_still_gives_the_committed_bytes() {
    for (path, layout, storage) in FILES {
        let bytes = tiny_pack::stored(layout, storage).to_bytes().unwrap();
        let path = fixture(path);
        if std::env::var_os("REWRITE_PACKS_V3").is_some() {
            std::fs::write(&path, &bytes).unwrap();
        }
        let committed = std::fs::read(&path).unwrap();
        assert!(committed == bytes, "{}: other bytes; did the format change without its version?", path.display());
        assert!(bytes.len() < 20_000);
    }
}

/// `REWRITE_PACKS_V4=1` writes the file anew.
#[test]
fn a_pack_with_impostors_has_the_committed_bytes_of_version_4() {
    let contents = tiny_pack::with_impostors();
    let bytes = contents.to_bytes().unwrap();
    if std::env::var_os("REWRITE_PACKS_V4").is_some() {
        std::fs::write(fixture(IMPOSTORS), &bytes).unwrap();
    }
    assert!(std::fs::read(fixture(IMPOSTORS)).unwrap() == bytes, "did the format change without its version?");
    assert_eq!(*Pack::open(&fixture(IMPOSTORS)).unwrap().contents(), contents);
    let pack = Reader::new(&bytes);
    assert_eq!(pack.version, 4);
    check_manifest(&pack);
    assert_eq!([pack.impostor_size(0), pack.impostor_size(1)], [(16, 8), (16, 16)]);
    assert_eq!(
        [pack.impostor_picture(0, false), pack.impostor_picture(1, true)],
        [&tiny_pack::PNG[..], &tiny_pack::PNG[..70]]
    );
}

/// `REWRITE_PACKS_V5=1` writes the file anew.
#[test]
fn a_pack_with_finishes_has_the_committed_bytes_of_version_5() {
    let contents = tiny_pack::with_finishes();
    let bytes = contents.to_bytes().unwrap();
    if std::env::var_os("REWRITE_PACKS_V5").is_some() {
        std::fs::write(fixture(FINISHES), &bytes).unwrap();
    }
    assert!(std::fs::read(fixture(FINISHES)).unwrap() == bytes, "did the format change without its version?");
    assert_eq!(*Pack::open(&fixture(FINISHES)).unwrap().contents(), contents);
    let pack = Reader::new(&bytes);
    assert_eq!(pack.version, 5);
    check_manifest(&pack);
    let finishes = pack.finishes();
    assert_eq!(finishes.materials.len(), 3);
    let full = &finishes.materials[0];
    assert_eq!(full.numbers, [0.75, 0.5, 1.0, 0.5, 0.0, 10.0]);
    assert_eq!(full.optional_numbers, [vec![1.5], vec![0.5, 1.0, 2.0, 3.0], vec![0.5, 0.25, 1.0, 0.75]]);
    let texture = |image, sampler, weight| Some((image, sampler, weight));
    let wanted = [
        texture(0, 0, 1.0),
        texture(1, 0b0110, -2.0),
        texture(0, 0b1001, 0.25),
        texture(1, 0b0101, 1.0),
        texture(0, 0, 1.0),
        None,
        texture(0, 0, 1.0),
    ];
    assert_eq!((full.textures, full.blend), (wanted, true));
    let plain = &finishes.materials[2];
    assert_eq!((plain.numbers, plain.textures, plain.blend), ([0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [None; 7], false));
    assert_eq!(finishes.names, [vec!["coat"], vec!["bumps", ""], vec!["", "rig"]]);
    assert_eq!(finishes.credits, [["CC-BY 4.0 Ada", r#"{"title":"flag"}"#], ["", ""]]);
    assert_eq!(pack.finish_image(1), &tiny_pack::PNG[..70]);
    let [(no_joints, no_places, no_tracks), (joints, places, tracks)] = &finishes.rigs[..] else { panic!("two rigs") };
    assert!(no_joints.is_empty() && no_places.is_empty() && no_tracks.is_empty());
    assert_eq!(joints[0], (1, vec![0.5; 16]));
    assert_eq!((joints.len(), places[0]), (places.len() + 1, 1));
    let nodes = |tracks: &[Track]| tracks.iter().map(|track| track.node).collect::<Vec<_>>();
    for (spare, (_, own)) in tracks.iter().zip(&pack.characters[1].clips) {
        assert_eq!(nodes(spare), nodes(own));
    }
}

#[test]
fn committed_files_load() {
    for (path, layout, storage) in FILES {
        let pack = Pack::open(&fixture(path)).unwrap();
        assert_eq!(*pack.contents(), tiny_pack::stored(layout, storage));
        assert_eq!((pack.find("flag"), pack.find("tetrahedron"), pack.find("hat")), (Some(0), Some(1), None));
    }
}

#[test]
fn packs_of_older_versions_are_refused_by_number() {
    for version in [1, 2] {
        for name in ["tiny.crowdpack", "tiny_split_layout.crowdpack"] {
            let error = Pack::open(&fixture(&format!("fixtures/packs/v{version}/{name}"))).unwrap_err();
            assert!(matches!(error, Error::Version { found, supported: 5 } if found == version), "{error}");
            assert!(error.to_string().ends_with("bake the pack again"), "{error}");
        }
    }
}

#[test]
fn the_crc_of_the_page_is_this_one() {
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
}

#[test]
fn the_page_is_enough_to_read_a_pack() {
    for (path, layout, _) in FILES {
        let file = std::fs::read(fixture(path)).unwrap();
        let pack = Reader::new(&file);
        check_manifest(&pack);
        check_meshes(&pack);
        check_levels(&pack);
        check_animation(&pack);
        assert_eq!(pack.image(0), tiny_pack::PNG);
        assert_eq!(pack.count("inverse_binds") > 0, layout == AnimationLayout::Split4x4);
    }
}

fn check_manifest(pack: &Reader<'_>) {
    let page = include_str!("../../docs/FORMAT.md");
    let listed: Vec<&str> =
        pack.section_names().into_iter().filter(|name| page.contains(&format!("| `{name}` |"))).collect();
    assert_eq!(listed, pack.section_names(), "every section stands in the page's table");
    assert_eq!(pack.generator, "by hand");
    let [flag, tetrahedron] = &pack.characters[..] else { panic!("two characters") };
    assert_eq!((flag.name.as_str(), tetrahedron.name.as_str()), ("flag", "tetrahedron"));
    assert_eq!(tetrahedron.nodes, [("root".to_owned(), None), ("tip".to_owned(), Some(0))]);
    assert_eq!(tetrahedron.materials, ["side", "tip"]);
    // 70,000 takes a varint of five bytes.
    assert_eq!(tetrahedron.parts, [("body".to_owned(), 0, 70_000, false)]);
    assert_eq!(flag.parts, [("cloth".to_owned(), 0, 2, true)]);
    let wanted = [("lod1".to_owned(), 0, vec![0.75], true), ("lod2".to_owned(), 3, vec![1.0, 120.0], false)];
    assert_eq!(tetrahedron.discrete, wanted);
    assert_eq!((flag.measured.len(), tetrahedron.measured.len()), (2, 2));
    // rms, max, bound, texels, degrees, pixels, share
    assert_eq!(tetrahedron.measured[0], [0.015_625, 0.062_5, 0.093_75, 2.5, 12.0, 67.5, 0.25]);
    assert_eq!(tetrahedron.frames, [vec![0, 1, 4], vec![2]]);
    assert_eq!((flag.obstacles.len(), tetrahedron.obstacles.as_slice()), (0, [1, 1, 2, 5].as_slice()));
    assert_eq!(flag.levels, [(3, 1, 0.5), (4, 2, 0.0)]);
    assert_eq!(flag.warnings, ["the corner \u{fb02}aps"]);
    let names: Vec<&str> = tetrahedron.clips.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["sway", "hop"]);
    assert_eq!(tetrahedron.contacts, [(1, 0.25, 0.75)]);
    let path = vec![vec![0.0, 0.5], vec![0.0, -0.5], vec![0.0, 0.5]];
    assert_eq!(tetrahedron.feet, [(0.0, Vec::new(), 0.0), (0.125, path, 0.062_5)]);
    let [sway, hop] = [&tetrahedron.clips[0].1[0], &tetrahedron.clips[1].1[0]];
    assert_eq!((sway.node, sway.property, sway.interpolation), (1, 0, 1));
    assert_eq!((hop.node, hop.property, hop.interpolation), (0, 0, 2));
    assert_eq!((sway.times.as_slice(), hop.times.as_slice()), ([0.0, 0.25, 0.5].as_slice(), [0.0, 1.0].as_slice()));
    assert_eq!(sway.values, [0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(hop.values.len(), 18);
}

fn check_meshes(pack: &Reader<'_>) {
    for k in [0, 1, 3] {
        assert_eq!(pack.reform(0, k), [[0, 1, 2]]);
    }
    assert_eq!(pack.reform(0, 4), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(pack.reform(1, 4), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    assert_eq!(pack.reform(1, 99).len(), 6);
    assert_eq!(pack.normal(0, 0), [0.0, 0.0, 1.0]);
    assert_eq!(pack.normal(1, 3), [0.0, 1.0, 0.0]);
    let tilted = pack.normal(1, 4);
    let wanted = [2.0, 1.0, -1.0].map(|c: f32| c / 6.0_f32.sqrt());
    assert!((0..3).all(|i| (tilted[i] - wanted[i]).abs() < 1e-4), "{tilted:?}");
}

fn check_levels(pack: &Reader<'_>) {
    // Quantised levels, coarsest first, then the discrete ones.
    let flag = pack.level_tables(0);
    assert_eq!(flag[0].triangles, [[0, 1, 2]]);
    assert_eq!(flag[1].triangles, [[2, 1, 3], [0, 1, 2]]);
    let [coarse, full, again, refitted] = &pack.level_tables(1)[..] else { panic!("four levels") };
    for (level, k) in [(coarse, 4), (full, 5)] {
        assert_eq!(sorted(&level.triangles), sorted(&pack.reform(1, k)));
        assert_eq!(level.own_vertices, None);
    }
    assert_eq!(again.triangles[0], [1, 0, 2], "the tables need not agree in anything but what the page says");
    assert_eq!((coarse.bound_m, refitted.bound_m), (0.093_75, 0.5));
    assert_eq!(refitted.own_vertices, Some(0));
    assert_eq!(pack.refit_position(3), [0.0, 0.75, 0.0]);
}

/// Triangles as a set: each from its least corner on, the list in order.
fn sorted(triangles: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let turn = |t: &[usize; 3]| {
        let least = (0..3).min_by_key(|&i| t[i]).expect("three corners");
        [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
    };
    let mut turned: Vec<_> = triangles.iter().map(turn).collect();
    turned.sort_unstable();
    turned
}

fn check_animation(pack: &Reader<'_>) {
    assert_eq!(f32::from_bits(pack.character(1, 100) as u32), 0.001_953_125);
    assert_eq!(pack.matrix(1, 0, 1, 1)[0], [1.0, 0.0, 0.0, 0.25]);
    assert_eq!(pack.matrix(1, 1, 1, 0)[2], [0.0, 0.0, 1.0, 2.0]);
    // The apex follows the tip alone, the middle of the edge both joints by halves, the foot the root alone.
    assert_eq!(pack.skin(1, 3, 0, 1), [0.25, 1.0, 0.0]);
    let middle = pack.skin(1, 4, 0, 1);
    assert!((middle[0] - 0.375).abs() < 1e-5 && (middle[1] - 0.5).abs() < 1e-5, "{middle:?}");
    assert_eq!(pack.skin(1, 0, 0, 1), [0.0, 0.0, 0.5]);
}
