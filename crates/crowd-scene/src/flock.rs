//! A flock of people on the ground: Reynolds' boids (1987; steering as in his "Steering Behaviors", 1999).
//!
//! Each person keeps apart from those near, turns the way the others go, stays with them, and turns back at the rim of a
//! round place. The step is fixed and everyone looks at the state before it, so the result is the same for any number of
//! threads and for any way in which a time is reached forwards.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::dice::{Dice, Purpose};
use crate::walker::{Gait, Walker, wrapped};

/// After this time a flock begins anew, seconds: whoever asks for a time waits for its steps.
pub const FLOCK_LOOP_S: f32 = 600.0;
/// Seconds of a flock's step.
pub const FLOCK_STEP_S: f32 = 1.0 / 30.0;
/// Square metres a person.
const ROOM_M2: f32 = 2.6;
/// Rounds in which those who are too wide for their first places part.
const PARTING_ROUNDS: u32 = 24;
/// They go at most this far in a round.
const MOST_PARTING_M: f32 = 0.3;
/// The grid ends this far outside the place; who is farther out counts as in the outermost cells.
const GRID_MARGIN_M: f32 = 6.0;
/// Far fewer cells than people need would be slow, far more would be large: both sides end here.
const MOST_CELLS: f32 = 4096.0;

/// Weights and measures of the flock's rules. Distances in metres, speeds in metres a second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlockRules {
    /// Keeps apart from those within `apart_m`.
    pub separation: f32,
    /// Takes on the neighbours' mean velocity.
    pub alignment: f32,
    /// Goes towards the neighbours' middle.
    pub cohesion: f32,
    /// Comfortable distance between two people; wider bodies have theirs besides ([`Boid::wider_m`]).
    pub apart_m: f32,
    /// Slowest and fastest; each person wants a pace between them.
    pub speed_m_s: [f32; 2],
    /// Who is nearer is a neighbour; also the side of a cell of the grid. A flock with wider bodies sees farther by what two of them are
    /// wider.
    pub sight_m: f32,
    /// Nobody follows more neighbours than this: the own cell's first, in order of number. Everyone keeps apart from all.
    pub most_followed: u32,
    /// Two people's bodies: who is nearer is pushed away; wider bodies have theirs besides.
    pub bodies_m: f32,
    /// By at most this in a step.
    pub most_push_m: f32,
    /// Acceleration at most, m/s²: people are no cars.
    pub most_m_s2: f32,
    /// Facing follows the velocity by this share a second.
    pub turn_hz: f32,
    /// People turn back from this share of the place's radius on.
    pub rim: f32,
}

impl Default for FlockRules {
    fn default() -> Self {
        Self {
            separation: 3.0,
            alignment: 0.9,
            cohesion: 0.2,
            apart_m: 1.1,
            speed_m_s: [0.5, 2.6],
            sight_m: 3.0,
            most_followed: 24,
            bodies_m: 0.55,
            most_push_m: 0.03,
            most_m_s2: 3.0,
            turn_hz: 5.0,
            rim: 0.92,
        }
    }
}

/// The flock at one time.
#[derive(Debug, Clone)]
pub struct Flock {
    rules: FlockRules,
    radius_m: f32,
    steps: u32,
    people: Vec<Boid>,
    /// Everyone at time 0.
    first: Vec<Boid>,
}

/// One of a flock at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boid {
    /// X and Z, metres.
    pub place: Vec2,
    /// The same a second.
    pub velocity: Vec2,
    /// Facing, radians: 0 looks along +Z.
    pub yaw_rad: f32,
    /// Metres walked since the start.
    pub walked_m: f32,
    /// The speed this person likes.
    pub pace_m_s: f32,
    /// What the speed means.
    pub gait: Gait,
    /// Metres run, part of those walked.
    pub ran_m: f32,
    /// The gait before this one; means nothing while `changed_s` is infinite.
    pub gait_before: Gait,
    /// Seconds since the gait changed; infinite where it never did.
    pub changed_s: f32,
    /// Metres that the body's radius is beyond a person's, half of [`FlockRules::bodies_m`].
    pub wider_m: f32,
}

/// Cells over a flock's place, squares of [`FlockRules::sight_m`]; the outermost ones reach to infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlockGrid {
    /// Least corner, metres.
    pub low: Vec2,
    /// Cells along X.
    pub columns: u32,
    /// Cells along Z.
    pub rows: u32,
}

impl Flock {
    /// `count` people around the origin at time 0, walking on.
    pub fn new(count: u32, seed: u32, rules: FlockRules) -> Self {
        Self::of_bodies(count, seed, rules, |_| 0.0)
    }

    /// The same of bodies of any size: `radius_m` says that of each by number, metres; who is narrower than a person has a person's room.
    pub fn of_bodies(count: u32, seed: u32, mut rules: FlockRules, radius_m: impl Fn(u32) -> f32) -> Self {
        let beyond = |number| (radius_m(number) - 0.5 * rules.bodies_m).max(0.0);
        let wider_m: Vec<f32> = (0..count).map(beyond).map(|m| if m.is_finite() { m } else { 0.0 }).collect();
        let widest_m = wider_m.iter().copied().fold(0.0, f32::max);
        // Whoever has to be kept apart from is a neighbour, and so stands in one of the nine cells around.
        rules.sight_m = rules.sight_m.max(rules.apart_m) + 2.0 * widest_m;
        let more = |wider_m: &f32| {
            let across_m = f64::from(ROOM_M2).sqrt() + 2.0 * f64::from(*wider_m);
            across_m * across_m - f64::from(ROOM_M2)
        };
        let room_m2 = count as f32 * ROOM_M2 + wider_m.iter().map(more).sum::<f64>() as f32;
        let radius_m = libm::sqrtf(room_m2 / PI).max(3.0);
        let people = start(seed, radius_m, &rules, &wider_m);
        let mut flock = Self { rules, radius_m, steps: 0, people: Vec::new(), first: people };
        for _ in 0..if widest_m > 0.0 { PARTING_ROUNDS } else { 0 } {
            if !flock.part() {
                break;
            }
        }
        flock.people.clone_from(&flock.first);
        flock
    }

    /// Everyone's first place a little out of others' bodies; false where nobody stood in any.
    fn part(&mut self) -> bool {
        let grid = Grid::new(&self.first, self.grid(), self.rules.sight_m);
        let out = |i: usize| {
            let (mut push, me) = (Vec2::ZERO, &self.first[i]);
            grid.around(me.place, |j| push += self.push(i, me, j as usize, &self.first[j as usize]));
            push.clamp_length_max(MOST_PARTING_M)
        };
        let pushes: Vec<Vec2> = (0..self.first.len()).into_par_iter().map(out).collect();
        self.first.iter_mut().zip(&pushes).for_each(|(boid, push)| boid.place += *push);
        pushes.iter().any(|push| *push != Vec2::ZERO)
    }

    /// Half of the way out of another's body.
    fn push(&self, i: usize, me: &Boid, j: usize, other: &Boid) -> Vec2 {
        let away = me.place - other.place;
        let near = away.length() - (me.wider_m + other.wider_m);
        if i == j || near >= self.rules.bodies_m {
            return Vec2::ZERO;
        }
        away.normalize_or(aside(i, j)) * (0.5 * (self.rules.bodies_m - near))
    }

    /// Radius of the place, metres; people turn back at its rim and go a few metres beyond at most.
    pub fn radius_m(&self) -> f32 {
        self.radius_m
    }

    /// Its rules.
    pub fn rules(&self) -> &FlockRules {
        &self.rules
    }

    /// Everyone, in order of their numbers.
    pub fn boids(&self) -> &[Boid] {
        &self.people
    }

    /// The cells by which neighbours are found.
    pub fn grid(&self) -> FlockGrid {
        let reach = self.radius_m + GRID_MARGIN_M;
        let side = (2.0 * reach / self.rules.sight_m).ceil().clamp(1.0, MOST_CELLS) as u32;
        FlockGrid { low: Vec2::splat(-reach), columns: side, rows: side }
    }

    /// Steps from the start to a time; after [`FLOCK_LOOP_S`] the flock begins anew.
    pub fn steps_at(time_s: f32) -> u32 {
        let time_s = if time_s > 0.0 { time_s % FLOCK_LOOP_S } else { 0.0 };
        (time_s / FLOCK_STEP_S) as u32
    }

    /// Goes on to `time_s`, step by step; to an earlier time from the start again. After [`FLOCK_LOOP_S`] the flock begins
    /// anew. A step of 10,000 people takes some milliseconds of one core.
    pub fn advance_to(&mut self, time_s: f32) {
        let wanted = Self::steps_at(time_s);
        if wanted < self.steps {
            self.people.clone_from(&self.first);
            self.steps = 0;
        }
        while self.steps < wanted {
            self.step();
        }
    }

    /// Fills `walkers` with everyone, in order of their numbers.
    pub fn people(&self, walkers: &mut Vec<Walker>) {
        walkers.clear();
        walkers.extend(self.people.iter().zip(0..).map(|(boid, id)| Walker {
            id,
            position: Vec3::new(boid.place.x, 0.0, boid.place.y),
            yaw_rad: boid.yaw_rad,
            speed_m_s: boid.velocity.length(),
            gait: boid.gait,
            walked_m: boid.walked_m,
            ran_m: boid.ran_m,
            gait_before: boid.gait_before,
            changed_s: boid.changed_s,
        }));
    }

    fn step(&mut self) {
        let grid = Grid::new(&self.people, self.grid(), self.rules.sight_m);
        let next = |i: usize| self.moved(i, &grid);
        let people: Vec<Boid> = (0..self.people.len()).into_par_iter().map(next).collect();
        self.people = people;
        self.steps += 1;
    }

    fn moved(&self, i: usize, grid: &Grid) -> Boid {
        let mut boid = self.people[i];
        let (pull, push) = self.steer(i, grid);
        let [slowest, fastest] = self.rules.speed_m_s;
        let velocity = boid.velocity + pull.clamp_length_max(self.rules.most_m_s2) * FLOCK_STEP_S;
        // Back to the pace this person likes.
        let speed = velocity.length();
        let speed = (speed + (boid.pace_m_s - speed) * 0.5 * FLOCK_STEP_S).clamp(slowest, fastest);
        boid.velocity = velocity.normalize_or(Vec2::Y) * speed;
        boid.place += boid.velocity * FLOCK_STEP_S + push.clamp_length_max(self.rules.most_push_m);
        boid.walked_m += speed * FLOCK_STEP_S;
        boid.ran_m += if boid.gait == Gait::Run { speed * FLOCK_STEP_S } else { 0.0 };
        let goal = libm::atan2f(boid.velocity.x, boid.velocity.y);
        boid.yaw_rad =
            wrapped(boid.yaw_rad + wrapped(goal - boid.yaw_rad) * (self.rules.turn_hz * FLOCK_STEP_S).min(1.0));
        boid.changed_s += FLOCK_STEP_S;
        let gait = boid.gait.at_speed(speed);
        if gait != boid.gait && boid.changed_s >= Gait::SHORTEST_S {
            (boid.gait, boid.gait_before, boid.changed_s) = (gait, boid.gait, 0.0);
        }
        boid
    }

    /// Reynolds' three rules and the rim, as an acceleration; and out of others' bodies, metres.
    fn steer(&self, i: usize, grid: &Grid) -> (Vec2, Vec2) {
        let me = &self.people[i];
        let mut push = Vec2::ZERO;
        let (mut apart, mut velocities, mut places, mut count) = (Vec2::ZERO, Vec2::ZERO, Vec2::ZERO, 0);
        grid.around(me.place, |j| {
            let other = &self.people[j as usize];
            let away = me.place - other.place;
            let distance = away.length();
            if j as usize == i || distance > self.rules.sight_m {
                return;
            }
            if count < self.rules.most_followed {
                count += 1;
                velocities += other.velocity;
                places += other.place;
            }
            // As if both were as wide as a person.
            let near = distance - (me.wider_m + other.wider_m);
            if near < self.rules.apart_m {
                let away = away.normalize_or(aside(i, j as usize));
                apart += away * (self.rules.apart_m / near.max(0.05) - 1.0).min(8.0);
                push += away * (0.5 * (self.rules.bodies_m - near).max(0.0));
            }
        });
        let mut pull = self.rules.separation * apart;
        if count > 0 {
            let mean = 1.0 / count as f32;
            pull += self.rules.alignment * (velocities * mean - me.velocity);
            pull += self.rules.cohesion * (places * mean - me.place);
        }
        let beyond = me.place.length() - self.radius_m * self.rules.rim;
        if beyond > 0.0 {
            // Inwards, and around rather than straight back.
            let inwards = -me.place.normalize_or(Vec2::Y);
            let around = if inwards.perp_dot(me.velocity) < 0.0 { -inwards.perp() } else { inwards.perp() };
            pull += (inwards + 0.6 * around) * (1.0 + beyond);
        }
        (pull, push)
    }
}

/// Two in one spot part by their numbers.
fn aside(i: usize, j: usize) -> Vec2 {
    if j < i { Vec2::X } else { Vec2::NEG_X }
}

/// A sunflower as in the layout, everyone with a direction and a pace of their own.
fn start(seed: u32, radius_m: f32, rules: &FlockRules, wider_m: &[f32]) -> Vec<Boid> {
    const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;
    let [slowest, fastest] = rules.speed_m_s;
    let count = wider_m.len() as u32;
    let boid = |(index, &wider_m): (u32, &f32)| {
        let dice = Dice { seed, index };
        let angle = f64::from(index) * GOLDEN_ANGLE_RAD;
        let out = radius_m * 0.95 * libm::sqrtf((index as f32 + 0.5) / count.max(1) as f32);
        let (sin, cos) = libm::sincos(angle);
        let yaw_rad = PI * dice.around_zero(Purpose::Yaw);
        let pace_m_s = (1.3 + 0.35 * dice.around_zero(Purpose::Pace)).clamp(slowest, fastest);
        let (sin_yaw, cos_yaw) = libm::sincosf(yaw_rad);
        Boid {
            place: Vec2::new(sin as f32, cos as f32) * out,
            velocity: Vec2::new(sin_yaw, cos_yaw) * pace_m_s,
            yaw_rad,
            walked_m: 0.0,
            pace_m_s,
            gait: Gait::Walk,
            ran_m: 0.0,
            gait_before: Gait::Walk,
            changed_s: f32::INFINITY,
            wider_m,
        }
    };
    (0..count).zip(wider_m).map(boid).collect()
}

/// People by cells, in order of their numbers within a cell.
struct Grid {
    low: Vec2,
    side_m: f32,
    columns: usize,
    rows: usize,
    /// First entry of each cell in `members`, and the end.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Grid {
    fn new(people: &[Boid], cells: FlockGrid, side_m: f32) -> Self {
        let (columns, rows) = (cells.columns as usize, cells.rows as usize);
        let (starts, members) = (vec![0; columns * rows + 1], vec![0; people.len()]);
        let mut grid = Self { low: cells.low, side_m, columns, rows, starts, members };
        for boid in people {
            let cell = grid.cell(boid.place);
            grid.starts[cell + 1] += 1;
        }
        for cell in 0..columns * rows {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        let mut next = grid.starts.clone();
        for (boid, number) in people.iter().zip(0..) {
            let cell = grid.cell(boid.place);
            grid.members[next[cell] as usize] = number;
            next[cell] += 1;
        }
        grid
    }

    fn column_and_row(&self, place: Vec2) -> (usize, usize) {
        let at = (place - self.low) / self.side_m;
        ((at.x.max(0.0) as usize).min(self.columns - 1), (at.y.max(0.0) as usize).min(self.rows - 1))
    }

    fn cell(&self, place: Vec2) -> usize {
        let (column, row) = self.column_and_row(place);
        row * self.columns + column
    }

    /// Calls `see` with everyone in the nine cells around a place, the own cell first.
    fn around(&self, place: Vec2, mut see: impl FnMut(u32)) {
        const CELLS: [(isize, isize); 9] =
            [(0, 0), (0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
        let (column, row) = self.column_and_row(place);
        for (dx, dy) in CELLS {
            let (x, y) = (column.wrapping_add_signed(dx), row.wrapping_add_signed(dy));
            if x >= self.columns || y >= self.rows {
                continue;
            }
            let cell = y * self.columns + x;
            self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize]
                .iter()
                .for_each(|&member| see(member));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn after(count: u32, seed: u32, time_s: f32) -> Vec<Walker> {
        let mut flock = Flock::new(count, seed, FlockRules::default());
        flock.advance_to(time_s);
        let mut walkers = Vec::new();
        flock.people(&mut walkers);
        walkers
    }

    #[test]
    fn a_flock_is_the_same_for_any_number_of_threads() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| after(700, 3, 2.0))
        };
        assert_eq!(on(1), on(4));
        assert_ne!(on(1), after(700, 4, 2.0));
    }

    #[test]
    fn a_time_is_the_same_however_it_is_reached() {
        let mut flock = Flock::new(200, 1, FlockRules::default());
        for time_s in [0.5, 1.7, 3.0, 1.0] {
            flock.advance_to(time_s);
        }
        let mut walkers = Vec::new();
        flock.people(&mut walkers);
        assert_eq!(walkers, after(200, 1, 1.0));
    }

    #[test]
    fn people_keep_apart_stay_in_their_place_and_walk() {
        let walkers = after(600, 2, 30.0);
        let radius = Flock::new(600, 2, FlockRules::default()).radius_m();
        let mut crowded = 0;
        for (i, a) in walkers.iter().enumerate() {
            assert!(a.position.length() < radius + 4.0, "{} of {radius}", a.position.length());
            assert!((0.49..=2.61).contains(&a.speed_m_s) && a.walked_m > 10.0);
            let nearest =
                walkers.iter().enumerate().filter(|&(j, _)| j != i).map(|(_, b)| a.position.distance(b.position));
            crowded += usize::from(nearest.fold(f32::INFINITY, f32::min) < 0.45);
        }
        assert!(crowded < 12, "{crowded} of 600 touch someone");
    }

    #[test]
    fn wide_bodies_keep_as_far_apart_as_they_are_wide() {
        // Two of seven are animals of two metres, as in the shipped cast.
        let radius_m = |number: u32| if number % 7 < 2 { 1.0 } else { 0.3 };
        let deepest = |boids: &[Boid]| {
            let nearest = |(i, a): (usize, &Boid)| {
                let bodies = |(j, b): (usize, &Boid)| {
                    a.place.distance(b.place)
                        - radius_m(i as u32)
                        - if i == j { f32::NEG_INFINITY } else { radius_m(j as u32) }
                };
                boids.iter().enumerate().map(bodies).fold(f32::INFINITY, f32::min)
            };
            let mut gaps: Vec<f32> = boids.iter().enumerate().map(nearest).collect();
            gaps.sort_by(f32::total_cmp);
            gaps
        };
        let mut flock = Flock::of_bodies(500, 2, FlockRules::default(), radius_m);
        assert!(flock.rules().sight_m >= 3.0 + 2.0 * (1.0 - 0.276));
        let gaps = deepest(flock.boids());
        assert!(gaps[0] > -0.1, "at the start somebody is {} m in another", -gaps[0]);
        for time_s in [10.0, 40.0] {
            flock.advance_to(time_s);
            let gaps = deepest(flock.boids());
            let touching = gaps.iter().filter(|gap| **gap < -0.1).count();
            assert!(touching < 15 && gaps[0] > -0.5, "{touching} of 500 touch, {} m at most", -gaps[0]);
        }
        // As if all were people they would.
        let mut people = Flock::new(500, 2, FlockRules::default());
        people.advance_to(10.0);
        assert!(deepest(people.boids()).iter().filter(|gap| **gap < -0.1).count() > 100);
    }

    #[test]
    fn neighbours_come_to_go_the_same_way() {
        // Of pairs of neighbours, the mean cosine between their directions.
        let agreement = |walkers: &[Walker]| {
            let (mut sum, mut count) = (0.0, 0);
            for a in walkers {
                for b in walkers.iter().filter(|b| b.id != a.id && b.position.distance(a.position) < 2.0) {
                    sum += libm::cosf(a.yaw_rad - b.yaw_rad);
                    count += 1;
                }
            }
            sum / count.max(1) as f32
        };
        let mut rules = FlockRules { alignment: 0.0, cohesion: 0.0, ..FlockRules::default() };
        let run = |rules: FlockRules| {
            let mut flock = Flock::new(300, 5, rules);
            flock.advance_to(20.0);
            let mut walkers = Vec::new();
            flock.people(&mut walkers);
            walkers
        };
        let without = agreement(&run(rules));
        rules = FlockRules::default();
        let with = agreement(&run(rules));
        assert!(with > 0.8 && with > without + 0.2, "{with} against {without}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn any_flock_is_finite(count in 0_u32..80, seed: u32, apart in 0.1_f32..3.0, weight in 0.0_f32..50.0) {
            let rules = FlockRules { separation: weight, cohesion: weight, apart_m: apart, ..FlockRules::default() };
            let mut flock = Flock::new(count, seed, rules);
            flock.advance_to(2.0);
            let mut walkers = Vec::new();
            flock.people(&mut walkers);
            prop_assert_eq!(walkers.len(), count as usize);
            prop_assert!(walkers.iter().all(|w| w.position.is_finite() && w.yaw_rad.is_finite()));
        }
    }
}
