//! Peng 2011 Eq. 1 and Dong 2019 Eq. 1, computed by hand for three instances.

use crowd_pack::{CharacterRecord, ClipRecord, LodRecord};
use crowd_stages::{CrowdData, Fit, FrameConfig, InstanceRecord, Weight, cpu};

/// Characters of 5,000 and 40,000 vertices, a hundred at least; a level for every count, two triangles a vertex; a sphere of
/// radius 1 around the feet.
fn crowd() -> CrowdData {
    let mut data = CrowdData::default();
    for (number, vertex_count) in [5_000u32, 40_000].into_iter().enumerate() {
        data.characters.push(CharacterRecord {
            vertex_count,
            lod_offset: data.lods.len() as u32,
            min_vertex_count: 100,
            clip_offset: number as u32,
            clip_count: 1,
            ..Default::default()
        });
        data.clips.push(ClipRecord { frame_count: 1, sphere: [0.0, 0.0, 0.0, 1.0], ..Default::default() });
        data.lods
            .extend((0..=vertex_count).map(|k| LodRecord { vertex_count: k.max(100), triangle_count: k.max(100) * 2 }));
    }
    data
}

/// Three instances of the first character, 1, 8 and 27 metres away: with 1,000 pixels a radian the areas are
/// pi * 1000², pi * 125² and pi * 37.04² px².
fn instances() -> Vec<InstanceRecord> {
    let at = |z: f32| InstanceRecord { position: [0.0, 0.0, -z], scale: 1.0, ..Default::default() };
    vec![at(1.0), at(8.0), at(27.0)]
}

/// A frame without planes that cut, alpha 3.
fn frame(budget: u32, weight: Weight) -> FrameConfig {
    FrameConfig {
        planes: [[0.0, 0.0, 0.0, 1e9]; 6],
        focal_px: 1000.0,
        inverse_alpha: 1.0 / 3.0,
        budget,
        weight: weight as u32,
        ..Default::default()
    }
}

fn counts(data: &CrowdData, instances: &[InstanceRecord], config: &FrameConfig) -> Vec<u32> {
    cpu::run_selection(data, &data.lods, instances, config, Fit::Plain)
        .choices
        .iter()
        .map(|choice| choice.vertex_count)
        .collect()
}

/// A^(1/3) goes with distance^(-2/3): weights 1, 1/4 and 1/9, sum 49/36. With N = 4,900 the counts are 3,600, 900 and 400.
#[test]
fn three_instances_share_by_the_cube_root_of_their_area() {
    let counts = counts(&crowd(), &instances(), &frame(4_900, Weight::Area));
    for (found, by_hand) in counts.iter().zip([3_600u32, 900, 400]) {
        assert!(found.abs_diff(by_hand) <= 1, "{counts:?}: rounded down, and 1/3 is no float");
    }
    assert!(counts.iter().sum::<u32>() <= 4_900);
}

/// With alpha 1 the counts go with the area itself: 1, 1/64 and 1/729 of each other.
#[test]
fn with_alpha_one_the_shares_are_the_areas() {
    let config = FrameConfig { inverse_alpha: 1.0, ..frame(4_700, Weight::Area) };
    // Sum 1.016 997; 4,700 / that = 4,621.4; its 64th is 72, below the coarsest level of 100. The two clamped ones push the
    // sum to 4,821, so the near one gives up what is missing: 100 + 4,521 * (4,700 - 300) / (4,821 - 300) = 4,500, one less
    // since the share is rounded down to whole 2^-32.
    assert_eq!(counts(&crowd(), &instances(), &config), [4_499, 100, 100]);
}

/// Culled instances get nothing, and the others share all of N.
#[test]
fn an_instance_out_of_view_has_no_share() {
    let mut config = frame(4_500, Weight::Area);
    // Only what is nearer than 20 metres.
    config.planes[5] = [0.0, 0.0, 1.0, 20.0];
    let counts = counts(&crowd(), &instances(), &config);
    // 1 to 1/4: 3,600 and 900.
    assert!(counts[0].abs_diff(3_600) <= 1 && counts[1].abs_diff(900) <= 1 && counts[2] == 0, "{counts:?}");
}

/// Nobody has more than its mesh; what is left is not handed on (both papers have one pass).
#[test]
fn counts_end_at_full_detail() {
    let counts = counts(&crowd(), &instances(), &frame(49_000, Weight::Area));
    assert_eq!(counts[0], 5_000);
    assert!(counts[2].abs_diff(4_000) <= 1, "{counts:?}");
}

/// When the coarsest levels alone exceed N, everyone keeps them and the frame says so.
#[test]
fn a_budget_below_the_coarsest_levels_is_reported() {
    let data = crowd();
    let frame = cpu::run_selection(&data, &data.lods, &instances(), &frame(299, Weight::Area), Fit::Plain);
    assert!(frame.choices.iter().all(|choice| (choice.vertex_count, choice.triangle_count) == (100, 200)));
    assert_eq!((frame.totals.overflow, frame.totals.min_vertex_count), (crowd_stages::overflow::BUDGET, 300));
}

/// Dong 2019: ((A / D) * P^2)^(1/3). Distances 1, 8 and 27 give (A / D)^(1/3) = 1, 1/8 and 1/27 of each other; a character of
/// eight times the vertices weighs 8^(2/3) = 4 times as much.
#[test]
fn dong_weighs_by_area_over_distance_and_by_detail() {
    let mut instances = instances();
    let culled =
        |instances: &[InstanceRecord]| cpu::cull_instances(&crowd(), instances, &frame(1, Weight::AreaDistance));
    let same = culled(&instances);
    assert!((same[0].weight / same[1].weight - 8.0).abs() < 1e-4);
    assert!((same[0].weight / same[2].weight - 27.0).abs() < 1e-3);
    instances[1].character = 1;
    instances[1].clip = 1;
    let finer = culled(&instances);
    assert!((finer[1].weight / same[1].weight - 4.0).abs() < 1e-4);
}
