//! Places a crowd: one function a layout, everything random from one integer hash.

use std::f32::consts::PI;

use glam::Vec3;

use crate::dice::{Dice, Purpose};
use crate::{Instance, Kind, Layout, Leaving, SeatStep};

/// Most shares of the spacing by which [`Layout::Grid`] moves a person from the exact spot, X and Z, each way.
const GRID_SHUFFLE: [f32; 2] = [0.16, 0.16];
/// The same of [`Layout::Street`].
const STREET_SHUFFLE: [f32; 2] = [0.12, 0.3];
/// Most share by which a person is larger or smaller than the character.
const SIZES: f32 = 0.06;
/// From one ring of seats to the next, in spacings.
const SEAT_DEPTH: f32 = 1.3;
/// How much higher the next ring is, in spacings.
const SEAT_RISE: f32 = 0.5;
/// Radius of the sunflower's first turn in spacings: chosen so that neighbours are at least one spacing apart.
const SUNFLOWER: f32 = 0.62;
/// 2 pi (2 - golden ratio): the angle between one seed of a sunflower and the next.
const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;

/// Places `count` instances around the origin. `clips[k]`: which clips of kind `k` may play (names resolved by the caller;
/// indices out of range are passed over); a missing or empty list means all.
/// Character, clip and phase come from a hash of the instance's number and `seed`: the same crowd every time.
///
/// `spacing_m`: from one person to the next, metres, see [`spacing_used`]. Nobody stands in another: whoever is moved from the exact
/// spot stays within their own square of that side, and is made larger only where that leaves the room. Empty when there are no kinds. A
/// kind without clips gets clip 0 at phase 0.
pub fn place(
    layout: Layout,
    count: u32,
    spacing_m: f32,
    kinds: &[Kind],
    clips: &[Vec<u32>],
    seed: u32,
) -> Vec<Instance> {
    if kinds.is_empty() {
        return Vec::new();
    }
    let allowed: Vec<Vec<u32>> = (0..kinds.len()).map(|k| clips_of(kinds, clips, k)).collect();
    let spacing = spacing_used(layout, spacing_m, kinds);
    // What everyone has to themselves around their spot.
    let own_m = 0.5 * spacing * closest_share(layout);
    let side = ceil_sqrt(count);
    let rings = if layout == Layout::Seats { rings_of(count, spacing) } else { Vec::new() };
    (0..count)
        .map(|index| {
            let dice = Dice { seed, index };
            let character = dice.below(Purpose::Character, kinds.len() as u32);
            let body_m = body_of(&kinds[character as usize]);
            let scale = match layout {
                Layout::Ranks => 1.0,
                _ => (1.0 + SIZES * dice.around_zero(Purpose::Scale)).min(own_m / body_m.max(1e-6)),
            };
            let free_m = (own_m - body_m * scale).max(0.0);
            let spot = match layout {
                Layout::Grid => grid_spot(index, count, side, spacing, &dice, free_m),
                Layout::Disc => disc_spot(index, spacing, &dice),
                Layout::Ranks => ranks_spot(index, count, side, spacing),
                Layout::Street => street_spot(index, count, side, spacing, &dice, free_m),
                Layout::Seats => seat_spot(index, &rings, spacing, &dice),
            };
            let choice = &allowed[character as usize];
            let clip = match choice.len() {
                0 => 0,
                n => choice[dice.below(Purpose::Clip, n as u32) as usize],
            };
            let duration = kinds[character as usize].clip_durations_s.get(clip as usize).copied().unwrap_or(0.0);
            let duration = if duration.is_finite() { duration.max(0.0) } else { 0.0 };
            Instance {
                position: spot.position,
                yaw_rad: spot.yaw_rad,
                scale,
                character,
                clip,
                phase_s: dice.unit(Purpose::Phase) * duration,
                leaving: Leaving::default(),
            }
        })
        .collect()
}

/// The spacing that [`place`] takes when asked for `spacing_m`: 1 where that is not a positive number, and raised so that two of the
/// widest kind stand side by side.
pub fn spacing_used(layout: Layout, spacing_m: f32, kinds: &[Kind]) -> f32 {
    let wanted = if spacing_m.is_finite() && spacing_m > 0.0 { spacing_m } else { 1.0 };
    let widest = kinds.iter().map(body_of).fold(0.0, f32::max);
    wanted.max(2.0 * widest / closest_share(layout))
}

/// How near to each other the nearest two spots of a layout may be, in spacings.
fn closest_share(layout: Layout) -> f32 {
    match layout {
        Layout::Grid | Layout::Ranks | Layout::Street => 1.0,
        Layout::Disc => 0.95,
        // A chord is a little shorter than its arc.
        Layout::Seats => 0.99,
    }
}

/// Radius of a kind's body on the ground, metres.
fn body_of(kind: &Kind) -> f32 {
    if kind.footprint_m.is_finite() { kind.footprint_m.max(0.0) } else { 0.0 }
}

/// How far somebody is moved from the exact spot: at most these shares of the spacing, and no farther than is free.
fn shuffled(dice: &Dice, spacing: f32, shares: [f32; 2], free_m: f32) -> Vec3 {
    let [x, z] = shares.map(|share| (share * spacing).min(free_m));
    Vec3::new(x * dice.around_zero(Purpose::X), 0.0, z * dice.around_zero(Purpose::Z))
}

/// Where and how one person stands.
struct Spot {
    position: Vec3,
    yaw_rad: f32,
}

/// Rows from the front (+Z) to the back, each centred; the last may be short.
fn row_and_column(index: u32, count: u32, columns: u32, spacing: f32) -> Vec3 {
    let (row, column) = (index / columns, index % columns);
    let rows = count.div_ceil(columns);
    let in_row = if row + 1 == rows { count - row * columns } else { columns };
    let x = (column as f32 - (in_row - 1) as f32 * 0.5) * spacing;
    let z = ((rows - 1) as f32 * 0.5 - row as f32) * spacing;
    Vec3::new(x, 0.0, z)
}

fn grid_spot(index: u32, count: u32, side: u32, spacing: f32, dice: &Dice, free_m: f32) -> Spot {
    Spot {
        position: row_and_column(index, count, side, spacing) + shuffled(dice, spacing, GRID_SHUFFLE, free_m),
        yaw_rad: dice.around_zero(Purpose::Yaw) * 0.6,
    }
}

fn ranks_spot(index: u32, count: u32, side: u32, spacing: f32) -> Spot {
    Spot { position: row_and_column(index, count, side, spacing), yaw_rad: 0.0 }
}

fn disc_spot(index: u32, spacing: f32, dice: &Dice) -> Spot {
    let radius = f64::from(spacing * SUNFLOWER) * (f64::from(index) + 0.5).sqrt();
    let angle = f64::from(index) * GOLDEN_ANGLE_RAD;
    let position = Vec3::new((radius * libm::sin(angle)) as f32, 0.0, (radius * libm::cos(angle)) as f32);
    Spot { position, yaw_rad: dice.around_zero(Purpose::Yaw) * 0.9 }
}

/// Even numbers walk along +Z on the right of the street's middle (-X), odd ones towards them on the other side.
fn street_spot(index: u32, count: u32, side: u32, spacing: f32, dice: &Dice, free_m: f32) -> Spot {
    let lanes = side.div_ceil(5).max(1);
    let towards = index.is_multiple_of(2);
    let place = index / 2;
    let rows = count.div_ceil(2).div_ceil(lanes);
    let (row, lane) = (place / lanes, place % lanes);
    let shuffle = shuffled(dice, spacing, STREET_SHUFFLE, free_m);
    let x = (lane as f32 + 1.0) * spacing + shuffle.x;
    let z = ((rows - 1) as f32 * 0.5 - row as f32) * spacing + shuffle.z;
    let sway = dice.around_zero(Purpose::Yaw) * 0.08;
    Spot { position: Vec3::new(if towards { -x } else { x }, 0.0, z), yaw_rad: if towards { sway } else { PI + sway } }
}

/// One ring of seats.
struct Ring {
    /// Number of its first seat.
    first: u32,
    seats: u32,
    radius_m: f32,
}

/// Rings for `count` seats: twelve times as many seats in a ring as there are rings, so that larger crowds sit both
/// farther out and higher up. The last ring's people spread over all of it.
fn rings_of(count: u32, spacing: f32) -> Vec<Ring> {
    let ring_count = ((f64::from(count) / 12.0).sqrt().ceil() as u32).max(1);
    let depth = spacing * SEAT_DEPTH;
    // The mean ring has its share of the seats.
    let mean_radius = count as f32 / ring_count as f32 * spacing / std::f32::consts::TAU;
    let inner = (mean_radius - 0.5 * depth * (ring_count - 1) as f32).max(3.0 * spacing);
    let (mut rings, mut first) = (Vec::new(), 0);
    while first < count {
        let radius_m = inner + depth * rings.len() as f32;
        let room = (std::f32::consts::TAU * radius_m / spacing) as u32;
        let seats = room.clamp(1, count - first);
        rings.push(Ring { first, seats, radius_m });
        first += seats;
    }
    rings
}

/// The steps that the rings of [`Layout::Seats`] stand on, from the inside out: each ends where the next begins; the ring on the ground has none.
/// The same arguments as for [`place`]; nobody, or a single ring on the ground, needs none.
pub fn seat_steps(count: u32, spacing_m: f32, kinds: &[Kind]) -> Vec<SeatStep> {
    let spacing = spacing_used(Layout::Seats, spacing_m, kinds);
    let rings = if count == 0 || kinds.is_empty() { Vec::new() } else { rings_of(count, spacing) };
    let half = 0.5 * SEAT_DEPTH * spacing;
    let step = |(ring, number): (&Ring, u16)| SeatStep {
        inner_m: ring.radius_m - half,
        outer_m: ring.radius_m + half,
        height_m: f32::from(number) * spacing * SEAT_RISE,
    };
    rings.iter().zip(0..).map(step).skip(1).collect()
}

fn seat_spot(index: u32, rings: &[Ring], spacing: f32, dice: &Dice) -> Spot {
    let ring = rings.partition_point(|ring| ring.first <= index).max(1) - 1;
    let Ring { first, seats, radius_m } = rings[ring];
    // Every other ring half a seat further: one looks between two heads.
    let seat = (index - first) as f32 + if ring % 2 == 1 { 0.5 } else { 0.0 };
    let angle = seat / seats as f32 * std::f32::consts::TAU;
    let (sin, cos) = libm::sincosf(angle);
    let up = ring as f32 * spacing * SEAT_RISE;
    Spot {
        position: Vec3::new(sin * radius_m, up, cos * radius_m),
        yaw_rad: libm::atan2f(-sin, -cos) + 0.12 * dice.around_zero(Purpose::Yaw),
    }
}

/// Clips kind `k` may play: those asked for that exist, else all it has.
fn clips_of(kinds: &[Kind], clips: &[Vec<u32>], k: usize) -> Vec<u32> {
    let existing = kinds[k].clip_durations_s.len() as u32;
    let asked: Vec<u32> =
        clips.get(k).map(|list| list.iter().copied().filter(|&c| c < existing).collect()).unwrap_or_default();
    if asked.is_empty() { (0..existing).collect() } else { asked }
}

/// Smallest whole number whose square holds `count`, at least 1.
fn ceil_sqrt(count: u32) -> u32 {
    let mut side = f64::from(count).sqrt() as u64;
    while side * side < u64::from(count) {
        side += 1;
    }
    (side as u32).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LAYOUTS: [Layout; 5] = [Layout::Grid, Layout::Disc, Layout::Ranks, Layout::Street, Layout::Seats];

    fn kinds() -> Vec<Kind> {
        vec![
            Kind { footprint_m: 0.3, clip_durations_s: vec![1.0, 2.0, 0.5], ..Kind::default() },
            Kind { footprint_m: 0.4, clip_durations_s: vec![4.0], ..Kind::default() },
            Kind { footprint_m: 0.2, ..Kind::default() },
        ]
    }

    /// Smallest distance between two people.
    fn closest(crowd: &[Instance]) -> f32 {
        let mut closest = f32::INFINITY;
        for (i, a) in crowd.iter().enumerate() {
            for b in &crowd[i + 1..] {
                closest = closest.min(a.position.distance(b.position));
            }
        }
        closest
    }

    /// How far two bodies are in each other at most.
    fn deepest(crowd: &[Instance], kinds: &[Kind]) -> f32 {
        let body = |one: &Instance| kinds[one.character as usize].footprint_m * one.scale;
        let mut deepest = f32::NEG_INFINITY;
        for (i, a) in crowd.iter().enumerate() {
            for b in &crowd[i + 1..] {
                let apart = Vec3::new(a.position.x - b.position.x, 0.0, a.position.z - b.position.z).length();
                deepest = deepest.max(body(a) + body(b) - apart);
            }
        }
        deepest
    }

    #[test]
    fn bodies_in_each_other_are_seen() {
        let kinds = [Kind { footprint_m: 0.5, ..Kind::default() }];
        let mut crowd = place(Layout::Ranks, 9, 1.0, &kinds, &[], 0);
        assert!(deepest(&crowd, &kinds) < 1e-3);
        crowd[4].position.x += 0.2;
        assert!(deepest(&crowd, &kinds) > 0.1);
    }

    proptest! {
        #[test]
        fn any_crowd_is_whole_repeatable_and_in_range(
            which in 0_usize..5, count in 0_u32..400, spacing in 0.2_f32..5.0, seed: u32,
            asked in proptest::collection::vec(proptest::collection::vec(0_u32..6, 0..3), 0..4),
        ) {
            let kinds = kinds();
            let crowd = place(LAYOUTS[which], count, spacing, &kinds, &asked, seed);
            prop_assert_eq!(crowd.len(), count as usize);
            prop_assert_eq!(&crowd, &place(LAYOUTS[which], count, spacing, &kinds, &asked, seed));
            for person in &crowd {
                let kind = &kinds[person.character as usize];
                prop_assert!(person.position.is_finite() && (person.position.y == 0.0 || which == 4) && person.scale > 0.5);
                match kind.clip_durations_s.get(person.clip as usize) {
                    Some(&duration) => prop_assert!((0.0..duration).contains(&person.phase_s)),
                    None => prop_assert!(person.clip == 0 && person.phase_s == 0.0),
                }
                let asked: Vec<u32> = asked.get(person.character as usize).into_iter().flatten().copied()
                    .filter(|&c| (c as usize) < kind.clip_durations_s.len()).collect();
                prop_assert!(asked.is_empty() || asked.contains(&person.clip));
            }
        }

        #[test]
        fn people_keep_their_distance(which in 0_usize..5, count in 2_u32..300, spacing in 0.9_f32..3.0, seed: u32) {
            let least = [1.0 - 2.0 * GRID_SHUFFLE[0], 0.95, 0.999, 0.39, 0.99][which] * spacing;
            let crowd = place(LAYOUTS[which], count, spacing, &kinds(), &[], seed);
            prop_assert!(closest(&crowd) >= least, "{} < {least}", closest(&crowd));
        }

        #[test]
        fn nobody_stands_in_another(
            which in 0_usize..5, count in 2_u32..300, spacing in 0.05_f32..4.0, seed: u32,
            bodies in proptest::collection::vec(0.05_f32..1.5, 1..5),
        ) {
            let kinds: Vec<Kind> = bodies.iter().map(|&footprint_m| Kind { footprint_m, ..Kind::default() }).collect();
            let crowd = place(LAYOUTS[which], count, spacing, &kinds, &[], seed);
            prop_assert!(deepest(&crowd, &kinds) < 1e-3, "{} m into each other", deepest(&crowd, &kinds));
        }

        #[test]
        fn seats_stand_on_their_steps(count in 1_u32..600, spacing in 0.2_f32..3.0) {
            let steps = seat_steps(count, spacing, &kinds());
            for person in place(Layout::Seats, count, spacing, &kinds(), &[], 1) {
                let out = libm::hypotf(person.position.x, person.position.z);
                let step = steps.iter().find(|step| (step.inner_m..step.outer_m).contains(&out));
                prop_assert_eq!(step.map_or(0.0, |step| step.height_m), person.position.y);
            }
            for pair in steps.windows(2) {
                prop_assert!((pair[0].outer_m - pair[1].inner_m).abs() < 1e-3 && pair[0].height_m < pair[1].height_m);
            }
        }

        #[test]
        fn a_crowd_stands_around_the_origin(which in 0_usize..5, count in 1_u32..2000) {
            let crowd = place(LAYOUTS[which], count, 1.0, &kinds(), &[], 5);
            let middle = crowd.iter().map(|p| p.position).sum::<Vec3>() / count as f32;
            let across = Vec3::new(middle.x, 0.0, middle.z).length();
            prop_assert!(across < 3.0, "{middle}");
        }
    }

    #[test]
    fn ranks_are_straight_and_look_ahead() {
        let crowd = place(Layout::Ranks, 9, 2.0, &kinds(), &[], 1);
        let expected = [[-2.0, 2.0], [0.0, 2.0], [2.0, 2.0], [-2.0, 0.0]];
        for (person, [x, z]) in crowd.iter().zip(expected) {
            assert_eq!(person.position, Vec3::new(x, 0.0, z));
            assert_eq!((person.yaw_rad, person.scale), (0.0, 1.0));
        }
    }

    #[test]
    fn seats_face_the_stage_and_rise() {
        let crowd = place(Layout::Seats, 500, 1.0, &kinds(), &[], 3);
        for person in &crowd {
            let ahead = Vec3::new(libm::sinf(person.yaw_rad), 0.0, libm::cosf(person.yaw_rad));
            let to_stage = -Vec3::new(person.position.x, 0.0, person.position.z).normalize();
            assert!(ahead.dot(to_stage) > 0.98);
        }
        let radius = |p: &Instance| libm::sqrtf(p.position.x * p.position.x + p.position.z * p.position.z);
        let (first, last) = (&crowd[0], &crowd[499]);
        assert!(radius(last) > radius(first) + 2.0 && last.position.y > first.position.y + 0.9);
        assert!(radius(first) >= 3.0, "the stage is free");
    }

    #[test]
    fn a_street_has_two_opposing_streams() {
        let crowd = place(Layout::Street, 1000, 1.0, &kinds(), &[], 3);
        let ahead = crowd.iter().filter(|p| p.yaw_rad.abs() < 0.1).count();
        let back = crowd.iter().filter(|p| (p.yaw_rad - PI).abs() < 0.1).count();
        assert_eq!((ahead, back), (500, 500));
        assert!(crowd.iter().all(|p| (p.position.x < 0.0) == (p.yaw_rad < 1.0)));
    }

    #[test]
    fn a_large_footprint_widens_the_spacing() {
        let giant = [Kind { footprint_m: 3.0, clip_durations_s: vec![1.0], ..Kind::default() }];
        assert!(closest(&place(Layout::Ranks, 16, 1.0, &giant, &[], 0)) >= 6.0);
    }

    #[test]
    fn another_seed_is_another_crowd_and_all_characters_come() {
        let kinds = kinds();
        let crowd = place(Layout::Grid, 3000, 1.0, &kinds, &[], 1);
        assert_ne!(crowd, place(Layout::Grid, 3000, 1.0, &kinds, &[], 2));
        for k in 0..3 {
            let share = crowd.iter().filter(|p| p.character == k).count();
            assert!((850..1150).contains(&share), "{share}");
        }
    }

    #[test]
    fn no_kinds_and_no_spacing_are_answered_without_panic() {
        assert!(place(Layout::Grid, 10, 1.0, &[], &[], 0).is_empty());
        let crowd = place(Layout::Disc, 10, f32::NAN, &kinds(), &[], 0);
        assert!(crowd.iter().all(|p| p.position.is_finite()));
    }
}
