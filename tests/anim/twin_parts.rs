//! Both eyes of a real character or none, through its levels.

use crowd_tests::folders::assets;
use crowdbake::bake::bake_character;
use crowdbake::plan::PlanEntry;
use crowdbake::unpack::Unpacked;
use std::collections::{BTreeMap, BTreeSet};

/// Where the middles of eyes lie, the left one's: the Barbarian's own, and those of the bear that it wears. Metres at rest.
const EYES: [[f32; 3]; 2] = [[0.171, 1.781, 0.599], [0.313, 1.928, 0.455]];
/// How far from there.
const NEAR_M: f32 = 0.02;

/// A place, by its bits.
type Place = [u32; 3];

/// The part of each place: what hangs together by place, named by one of its places.
fn parts_of(triangles: &[[Place; 3]]) -> BTreeMap<Place, Place> {
    let mut above: BTreeMap<Place, Place> = triangles.as_flattened().iter().map(|&place| (place, place)).collect();
    fn root(above: &BTreeMap<Place, Place>, mut place: Place) -> Place {
        while above[&place] != place {
            place = above[&place];
        }
        place
    }
    for triangle in triangles {
        let roots = triangle.map(|place| root(&above, place));
        let first = *roots.iter().min().expect("three");
        above.extend(roots.map(|other| (other, first)));
    }
    above.keys().map(|&place| (place, root(&above, place))).collect()
}

/// The places of the part whose middle is there.
fn part_at(parts: &BTreeMap<Place, Place>, at: [f32; 3]) -> BTreeSet<Place> {
    let mut places: BTreeMap<Place, BTreeSet<Place>> = BTreeMap::new();
    for (&place, &part) in parts {
        places.entry(part).or_default().insert(place);
    }
    let is_there = |places: &BTreeSet<Place>| {
        let sum = places.iter().fold(glam::Vec3::ZERO, |sum, place| sum + glam::Vec3::from(place.map(f32::from_bits)));
        (sum / places.len() as f32).distance(at.into()) < NEAR_M
    };
    let mut there = places.into_values().filter(is_there);
    let found = there.next().unwrap_or_else(|| panic!("a part at {at:?}"));
    assert!(there.next().is_none(), "one part at {at:?}");
    found
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn the_barbarian_has_both_eyes_or_none_from_30_to_2_percent() {
    let path = assets().join("kaykit-adventurers/Barbarian.glb");
    let baked = bake_character(&PlanEntry::of_file(&path), false, &|_, _| {}).unwrap();
    let contents = crowdbake::assemble::assemble(&[baked], Default::default()).unwrap();
    let character = Unpacked::new(&contents, 0);
    // Adding 0 makes one of both zeros.
    let place = |v: u32| character.positions[v as usize].map(|c| (c + 0.0).to_bits());
    let places = |triangles: &[[u32; 3]]| -> Vec<[Place; 3]> { triangles.iter().map(|t| t.map(place)).collect() };
    let parts = parts_of(&places(character.triangles));
    let eyes = EYES.map(|[x, y, z]| [part_at(&parts, [x, y, z]), part_at(&parts, [-x, y, z])]);
    let mut seen = [[0, 0]; 2];
    for percent in (2..=30).rev() {
        let (level, reached) = character.level_of_ratio(f64::from(percent) / 100.0);
        assert!(reached, "{percent} %");
        let triangles = places(&character.level_triangles(level));
        for (pair, seen) in eyes.iter().zip(&mut seen) {
            let count = |eye: &BTreeSet<Place>| triangles.iter().filter(|t| t.iter().all(|p| eye.contains(p))).count();
            let counts = [count(&pair[0]), count(&pair[1])];
            // One triangle alone shows nothing.
            let shown = counts.map(|count| count > 1);
            assert_eq!(shown[0], shown[1], "{percent} %: {counts:?} triangles");
            seen[usize::from(shown[0])] += 1;
        }
    }
    // It is asked where they are there and where they are not.
    assert!(seen.iter().all(|pair| pair.iter().all(|&levels| levels > 0)), "{seen:?}");
}
