//! A step of a flock: Reynolds' three rules, the rim of the place, others' bodies.

use super::cell_boids::column_and_row;
use crate::{BoidRecord, FlockConfig, SortedBoid};
use glam::Vec2;
use std::f32::consts::TAU;

/// How far GPU and CPU may be apart after a step, metres and metres a second: roundings of sums over neighbours, and 2.5 ulp of
/// each quotient and square root.
pub const STEER_BOUND: f32 = 1e-4;

/// Cells around one's own, which comes first.
const CELLS: [(i32, i32); 9] = [(0, 0), (0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];

/// Everyone a step later. Each keeps apart from those within `apart_m`, takes on the mean velocity of those within `sight_m` and
/// goes towards their middle, turns back at the rim, and goes back to the pace it likes.
///
/// `starts` and `sorted_boids`: of [`super::fill_cells`].
///
/// Paper: Reynolds 1987, 1999 (Park & Han 2009 §4 use it). Departs: on the ground, among at most `most_followed` neighbours; bodies,
/// each of its own width, push each other apart. The rules are those of `Flock` in `crowd-scene`.
/// Twin: `shaders/stages/steer_boids.wgsl`. Within [`STEER_BOUND`] unless a distance lies on a rule's edge.
pub fn steer_boids(
    flock: &FlockConfig,
    boids: &[BoidRecord],
    starts: &[u32],
    sorted_numbers: &[u32],
    sorted_boids: &[SortedBoid],
) -> Vec<BoidRecord> {
    let grid = Grid { flock, starts, sorted_numbers, sorted_boids };
    boids.iter().zip(0..).map(|(boid, number)| moved(flock, boid, grid.steer(boid, number))).collect()
}

fn moved(flock: &FlockConfig, boid: &BoidRecord, (pull, push): (Vec2, Vec2)) -> BoidRecord {
    let velocity = Vec2::from(boid.velocity) + pull.clamp_length_max(flock.most_m_s2) * flock.step_s;
    let [slowest, fastest] = flock.speed_m_s;
    // Back to the pace this one likes.
    let speed = velocity.length();
    let speed = (speed + (boid.pace_m_s - speed) * 0.5 * flock.step_s).clamp(slowest, fastest);
    let velocity = velocity.normalize_or(Vec2::Y) * speed;
    let place = Vec2::from(boid.place) + (velocity * flock.step_s + push.clamp_length_max(flock.most_push_m));
    let goal = libm::atan2f(velocity.x, velocity.y);
    let turned = wrapped(goal - boid.yaw_rad) * (flock.turn_hz * flock.step_s).min(1.0);
    let gait = gait_at(flock, boid.gait, speed);
    let changed_s = boid.changed_s + flock.step_s;
    let changes = gait != boid.gait && changed_s >= flock.shortest_gait_s;
    BoidRecord {
        place: place.to_array(),
        velocity: velocity.to_array(),
        yaw_rad: wrapped(boid.yaw_rad + turned),
        walked_m: boid.walked_m + speed * flock.step_s,
        pace_m_s: boid.pace_m_s,
        gait: if changes { gait } else { boid.gait },
        gait_before: if changes { boid.gait } else { boid.gait_before },
        ran_m: boid.ran_m + if boid.gait == 2 { speed * flock.step_s } else { 0.0 },
        changed_s: if changes { 0.0 } else { changed_s },
        wider_m: boid.wider_m,
    }
}

/// Within -pi to pi.
fn wrapped(yaw_rad: f32) -> f32 {
    let turns = yaw_rad / TAU;
    (turns - (turns + 0.5).floor()) * TAU
}

fn gait_at(flock: &FlockConfig, before: u32, speed: f32) -> u32 {
    let stands_below = flock.stands_below_m_s[usize::from(before == 0)];
    let runs_from = flock.runs_from_m_s[usize::from(before != 2)];
    match speed {
        s if s < stands_below => 0,
        s if s < runs_from => 1,
        _ => 2,
    }
}

struct Grid<'a> {
    flock: &'a FlockConfig,
    starts: &'a [u32],
    sorted_numbers: &'a [u32],
    sorted_boids: &'a [SortedBoid],
}

impl Grid<'_> {
    /// An acceleration, and out of others' bodies, metres.
    fn steer(&self, me: &BoidRecord, number: u32) -> (Vec2, Vec2) {
        let flock = self.flock;
        let (place, velocity) = (Vec2::from(me.place), Vec2::from(me.velocity));
        let mut push = Vec2::ZERO;
        let (mut apart, mut velocities, mut places, mut count) = (Vec2::ZERO, Vec2::ZERO, Vec2::ZERO, 0);
        self.around(me.place, |other_number, other| {
            let away = place - Vec2::from(other.place);
            let distance = away.length();
            if other_number == number || distance > flock.sight_m {
                return;
            }
            if count < flock.most_followed {
                count += 1;
                velocities += Vec2::from(other.velocity);
                places += Vec2::from(other.place);
            }
            // As if both were as wide as a person.
            let near = distance - (me.wider_m + other.wider_m);
            if near < flock.apart_m {
                // Two in one spot part by their numbers.
                let sideways = if other_number < number { Vec2::X } else { Vec2::NEG_X };
                let away = away.normalize_or(sideways);
                apart += away * (flock.apart_m / near.max(0.05) - 1.0).min(8.0);
                push += away * (0.5 * (flock.bodies_m - near).max(0.0));
            }
        });
        let mut pull = flock.separation * apart;
        if count > 0 {
            let mean = 1.0 / count as f32;
            pull += flock.alignment * (velocities * mean - velocity);
            pull += flock.cohesion * (places * mean - place);
        }
        let beyond = place.length() - flock.radius_m * flock.rim;
        if beyond > 0.0 {
            // Inwards, and around rather than straight back.
            let inwards = (-place).normalize_or(Vec2::Y);
            let around = if inwards.perp_dot(velocity) < 0.0 { -inwards.perp() } else { inwards.perp() };
            pull += (inwards + 0.6 * around) * (1.0 + beyond);
        }
        (pull, push)
    }

    /// Calls `see` with everyone in the nine cells around a place.
    fn around(&self, place: [f32; 2], mut see: impl FnMut(u32, &SortedBoid)) {
        let (column, row) = column_and_row(self.flock, place);
        for (dx, dy) in CELLS {
            let (Some(x), Some(y)) = (column.checked_add_signed(dx), row.checked_add_signed(dy)) else { continue };
            if x >= self.flock.columns || y >= self.flock.rows {
                continue;
            }
            let cell = (y * self.flock.columns + x) as usize;
            let members = self.starts[cell] as usize..self.starts[cell + 1] as usize;
            for (number, boid) in self.sorted_numbers[members.clone()].iter().zip(&self.sorted_boids[members]) {
                see(*number, boid);
            }
        }
    }
}
