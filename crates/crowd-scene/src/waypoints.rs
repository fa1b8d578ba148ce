//! A walk along waypoints, for when no simulator is at hand: everyone goes round a closed way at a pace of their own.
//!
//! ```text
//! # crowd waypoints v1
//! route 4                    # a closed way, people up to 2 m to each side
//! -20 12                     # x z, metres
//!  20 12
//!  20 -12   3                # and waits 3 s here
//! route 1
//! 0 0
//! 0 30
//! ```
//!
//! Where someone is follows from the time alone: any time can be asked for, in any order, and nobody is simulated.

use glam::{Vec2, Vec3};

use crate::dice::{Dice, Purpose};
use crate::text::{FARTHEST_M, lines_after, wrong_in_words};
use crate::walker::{Gait, Walker, between_yaws};
use crate::{Error, Result};

const HEADING: &str = "# crowd waypoints v1";
const MOST_POINTS: usize = 100_000;
/// Around a corner people turn within this much of their way, each side.
const TURN_M: f32 = 0.6;
/// How fast people walk, metres a second, and how much faster or slower the fastest and the slowest do.
const MEAN_PACE_M_S: f32 = 1.3;
const PACE_SPREAD_M_S: f32 = 0.3;
/// The fastest walk this far in the time that a gait lasts at least.
const SHORTEST_LEG_M: f32 = (MEAN_PACE_M_S + PACE_SPREAD_M_S) * Gait::SHORTEST_S;

/// Closed ways, at least one, each of at least two different points.
#[derive(Debug, Clone, PartialEq)]
pub struct Waypoints {
    routes: Vec<Route>,
}

#[derive(Debug, Clone, PartialEq)]
struct Route {
    half_width_m: f32,
    points: Vec<Point>,
    /// Metres before each point, and all around.
    metres: Vec<f32>,
    /// Seconds waited on all points.
    wait_s: f32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    at: Vec2,
    wait_s: f32,
    /// To the right of the way, so long that the borders stay parallel around the corner.
    aside: Vec2,
}

impl Waypoints {
    /// Reads the text file described above.
    ///
    /// # Errors
    /// [`Error::Format`] with the line: another heading, a wrong number of words, a number out of range, a point before the
    /// first route, a route of fewer than two different points, no route at all. [`Error::Limit`] past 100,000 points.
    pub fn parse(text: &str) -> Result<Self> {
        // Half the width, the line it stands in, and the points with their waits.
        let mut raw: Vec<(f32, usize, Vec<(Vec2, f32)>)> = Vec::new();
        let mut count = 0;
        for line in lines_after(text, HEADING)? {
            if line.is_word(0, "route") {
                line.must_have(2, "route and its width")?;
                raw.push((0.5 * line.number_in(1, "width", 0.0, 1000.0)?, line.number, Vec::new()));
                continue;
            }
            line.must_have_between(2, 3, "x z, and perhaps seconds to wait")?;
            let Some((_, _, points)) = raw.last_mut() else {
                return Err(wrong_in_words(line.number, "a point", "`route` and its width before the first point"));
            };
            count += 1;
            if count > MOST_POINTS {
                return Err(Error::Limit { line: line.number, allowed: MOST_POINTS });
            }
            let at = Vec2::new(
                line.number_in(0, "x", -FARTHEST_M, FARTHEST_M)?,
                line.number_in(1, "z", -FARTHEST_M, FARTHEST_M)?,
            );
            let wait_s = if line.word_count() == 3 { line.number_in(2, "seconds to wait", 0.0, 3600.0)? } else { 0.0 };
            points.push((at, wait_s));
        }
        if raw.is_empty() {
            return Err(wrong_in_words(text.lines().count().max(1), "no route", "at least one `route` and its width"));
        }
        let routes = raw.into_iter().map(|(half_width_m, line, points)| {
            Route::new(half_width_m, &points)
                .ok_or_else(|| wrong_in_words(line, "a route of fewer than two different points", "at least two"))
        });
        Ok(Self { routes: routes.collect::<Result<_>>()? })
    }

    /// A rectangle around the origin that has room for `count` people with `spacing_m` between neighbours.
    pub fn around(count: u32, spacing_m: f32) -> Self {
        let spacing = if spacing_m.is_finite() && spacing_m > 0.0 { spacing_m } else { 1.0 };
        // Eight abreast at most, twice as long as it is wide.
        let lanes = (count as f32 / 12.0).clamp(1.0, 8.0);
        let length = (count as f32 / lanes * 1.6 * spacing).max(16.0);
        let (half_x, half_z) = (length / 6.0, length / 12.0);
        let corner = |x: f32, z: f32| (Vec2::new(x * half_x, z * half_z), 0.0);
        let points = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
        let route = Route::new(0.5 * lanes * spacing, &points).expect("four different corners");
        Self { routes: vec![route] }
    }

    /// Corners of the ground people walk on, metres.
    pub fn extent(&self) -> (Vec3, Vec3) {
        let corners = self.routes.iter().flat_map(|route| {
            let margin = Vec2::splat(route.half_width_m);
            route.points.iter().flat_map(move |point| [point.at - margin, point.at + margin])
        });
        let (low, high) =
            corners.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        (Vec3::new(low.x, 0.0, low.y), Vec3::new(high.x, 0.0, high.y))
    }

    /// Fills `walkers` with `count` people at `time_s`, dealt out among the routes by their length.
    pub fn people_at(&self, count: u32, seed: u32, time_s: f32, walkers: &mut Vec<Walker>) {
        walkers.clear();
        let total: f32 = self.routes.iter().map(Route::length_m).sum();
        walkers.extend((0..count).map(|id| {
            let dice = Dice { seed, index: id };
            // A share of all metres picks the route and the start on it.
            let mut start = dice.unit(Purpose::Start) * total;
            let mut chosen = &self.routes[0];
            for route in &self.routes {
                chosen = route;
                if start < route.length_m() {
                    break;
                }
                start -= route.length_m();
            }
            let pace_m_s = MEAN_PACE_M_S + PACE_SPREAD_M_S * dice.around_zero(Purpose::Pace);
            chosen.walker(id, start.clamp(0.0, chosen.length_m()), pace_m_s, dice.around_zero(Purpose::X), time_s)
        }));
    }
}

impl Route {
    /// `None` where fewer than two different points are left.
    fn new(half_width_m: f32, points: &[(Vec2, f32)]) -> Option<Self> {
        let mut kept: Vec<(Vec2, f32)> = Vec::with_capacity(points.len());
        for &(at, wait_s) in points {
            match kept.last_mut() {
                Some(last) if last.0.distance(at) < 0.01 => last.1 += wait_s,
                _ => kept.push((at, wait_s)),
            }
        }
        while kept.len() > 1 && kept[0].0.distance(kept[kept.len() - 1].0) < 0.01 {
            let last = kept.pop().expect("more than one");
            kept[0].1 += last.1;
        }
        if kept.len() < 2 {
            return None;
        }
        join_waits(&mut kept);
        let count = kept.len();
        let direction = |i: usize| (kept[(i + 1) % count].0 - kept[i].0).normalize_or(Vec2::X);
        let right = |d: Vec2| Vec2::new(-d.y, d.x);
        let corner = |i: usize| {
            let (before, after) = (right(direction((i + count - 1) % count)), right(direction(i)));
            let middle = (before + after).normalize_or(after);
            // At hairpins the corner is cut off at twice the width.
            middle / middle.dot(after).max(0.5)
        };
        let points: Vec<Point> =
            (0..count).map(|i| Point { at: kept[i].0, wait_s: kept[i].1, aside: corner(i) }).collect();
        let mut metres = vec![0.0];
        for i in 0..count {
            metres.push(metres[i] + kept[i].0.distance(kept[(i + 1) % count].0));
        }
        Some(Self { half_width_m, wait_s: kept.iter().map(|point| point.1).sum(), points, metres })
    }

    fn length_m(&self) -> f32 {
        self.metres[self.points.len()]
    }

    /// Someone who was `start_m` along the way at time 0. `aside`: -1 to 1 across the width.
    fn walker(&self, id: u32, start_m: f32, pace_m_s: f32, aside: f32, time_s: f32) -> Walker {
        let round_s = f64::from(self.length_m() / pace_m_s + self.wait_s);
        // In f64: after a day the place still moves smoothly.
        let since = f64::from(time_s) + f64::from(start_m / pace_m_s);
        let rounds = (since / round_s).floor();
        let (along_m, waits, changed_s) = self.along((since - rounds * round_s) as f32, pace_m_s);
        let side = aside * self.half_width_m;
        let place = self.place(along_m, side);
        let walked_m = (rounds * f64::from(self.length_m())) as f32 + along_m;
        let speed_m_s = if waits { 0.0 } else { pace_m_s };
        Walker {
            id,
            position: Vec3::new(place.x, 0.0, place.y),
            yaw_rad: self.heading(along_m),
            speed_m_s,
            gait: if waits { Gait::Idle } else { Gait::Walk },
            walked_m,
            ran_m: 0.0,
            gait_before: if waits { Gait::Walk } else { Gait::Idle },
            changed_s,
        }
    }

    /// Metres along the way after `seconds` of a round that begins with the wait at the first point, whether people stand there,
    /// and the seconds since that changed. Nobody stands for a wait too short for a gait.
    fn along(&self, mut seconds: f32, pace_m_s: f32) -> (f32, bool, f32) {
        let stands = |point: &Point| point.wait_s >= Gait::SHORTEST_S;
        let last_leg_s = self.points.iter().rposition(stands).map(|last| {
            let waits: f32 = self.points[last + 1..].iter().map(|point| point.wait_s).sum();
            (self.length_m() - self.metres[last]) / pace_m_s + waits
        });
        // Since the last wait of the round before.
        let mut walked_s = last_leg_s.unwrap_or(f32::INFINITY);
        for (i, point) in self.points.iter().enumerate() {
            if seconds < point.wait_s {
                let stands = stands(point);
                return (self.metres[i], stands, if stands { seconds } else { walked_s + seconds });
            }
            seconds -= point.wait_s;
            walked_s = if stands(point) { 0.0 } else { walked_s + point.wait_s };
            let leg_s = (self.metres[i + 1] - self.metres[i]) / pace_m_s;
            if seconds < leg_s {
                return (self.metres[i] + seconds * pace_m_s, false, walked_s + seconds);
            }
            seconds -= leg_s;
            walked_s += leg_s;
        }
        (self.length_m(), false, walked_s)
    }

    fn leg(&self, along_m: f32) -> usize {
        (self.metres.partition_point(|&m| m <= along_m).max(1) - 1).min(self.points.len() - 1)
    }

    fn place(&self, along_m: f32, side_m: f32) -> Vec2 {
        let leg = self.leg(along_m);
        let (a, b) = (&self.points[leg], &self.points[(leg + 1) % self.points.len()]);
        let t = ((along_m - self.metres[leg]) / (self.metres[leg + 1] - self.metres[leg])).clamp(0.0, 1.0);
        (a.at + a.aside * side_m).lerp(b.at + b.aside * side_m, t)
    }

    fn heading(&self, along_m: f32) -> f32 {
        let count = self.points.len();
        let leg = self.leg(along_m);
        let yaw = |leg: usize| {
            let d = self.points[(leg + 1) % count].at - self.points[leg % count].at;
            libm::atan2f(d.x, d.y)
        };
        let (before_m, after_m) = (along_m - self.metres[leg], self.metres[leg + 1] - along_m);
        // Half of the turn on each side of the corner.
        if before_m < TURN_M.min(0.5 * (before_m + after_m)) {
            between_yaws(yaw(leg + count - 1), yaw(leg), 0.5 + 0.5 * before_m / TURN_M)
        } else if after_m < TURN_M {
            between_yaws(yaw(leg), yaw(leg + 1), 0.5 - 0.5 * after_m / TURN_M)
        } else {
            yaw(leg)
        }
    }
}

/// Where two waits lie so near to each other that nobody gets into their stride between them, all the waiting is done at the first.
fn join_waits(points: &mut [(Vec2, f32)]) {
    let count = points.len();
    let long = |points: &[(Vec2, f32)], i: usize| points[i].1 >= Gait::SHORTEST_S;
    let Some(first) = (0..count).find(|&i| long(points, i)) else { return };
    let (mut waits_at, mut since_m) = (first, 0.0);
    for step in 1..count {
        let (before, i) = ((first + step - 1) % count, (first + step) % count);
        since_m += points[before].0.distance(points[i].0);
        if !long(points, i) {
            continue;
        }
        if since_m < SHORTEST_LEG_M {
            points[waits_at].1 += std::mem::take(&mut points[i].1);
        } else {
            (waits_at, since_m) = (i, 0.0);
        }
    }
    // Around the end of the way to where it began.
    let rest_m: f32 = since_m + points[(first + count - 1) % count].0.distance(points[first].0);
    if rest_m < SHORTEST_LEG_M {
        let wait_s = std::mem::take(&mut points[first].1);
        // Where that is the only one, the way is too short for anyone to stop on.
        points[waits_at].1 += if waits_at == first { 0.0 } else { wait_s };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOOD: &str = "# crowd waypoints v1\nroute 2 # round\n-20 12\n20 12\n20 -12 3\nroute 0\n0 0\n0 30\n";

    fn at(ways: &Waypoints, count: u32, time_s: f32) -> Vec<Walker> {
        let mut walkers = Vec::new();
        ways.people_at(count, 1, time_s, &mut walkers);
        walkers
    }

    #[test]
    fn people_go_on_smoothly_and_stay_on_their_way() {
        let ways = Waypoints::parse(GOOD).expect("good");
        let (low, high) = ways.extent();
        let mut stood = 0;
        for step in 0..600 {
            let time_s = step as f32 * 0.5;
            let (now, soon) = (at(&ways, 60, time_s), at(&ways, 60, time_s + 0.1));
            for (a, b) in now.iter().zip(&soon) {
                assert!(a.position.distance(b.position) < 0.1 * 1.7 * 2.5, "{} to {}", a.position, b.position);
                assert!(a.position.cmpge(low - 2.0).all() && a.position.cmple(high + 2.0).all(), "{}", a.position);
                assert!(b.walked_m >= a.walked_m - 1e-2);
                stood += usize::from(a.gait == Gait::Idle);
            }
        }
        assert!(stood > 100, "people wait");
    }

    #[test]
    fn nobody_walks_for_less_than_a_gait_lasts_between_two_waits() {
        let heading = "# crowd waypoints v1\nroute 0\n";
        // Waits 0.5 m apart, along the way and around its end.
        for (route, rounds_wait_s) in [("0 0 2\n0.5 0 3\n9 0\n9 9 1\n", 6.0), ("0 0 2\n9 0\n9 9 1\n0 0.5 3\n", 6.0)] {
            let ways = Waypoints::parse(&format!("{heading}{route}")).expect("good");
            assert_eq!(ways.routes[0].wait_s, rounds_wait_s, "nobody waits longer or shorter");
            for id in 0..8 {
                let gaits: Vec<Gait> = (0..8000).map(|step| at(&ways, 8, step as f32 * 0.01)[id].gait).collect();
                let lasts: Vec<usize> = gaits.chunk_by(|a, b| a == b).map(<[Gait]>::len).collect();
                assert!(lasts.len() > 4, "they stand and walk");
                assert!(lasts[1..lasts.len() - 1].iter().all(|&steps| steps >= 49), "{lasts:?}");
            }
        }
        let tiny = Waypoints::parse(&format!("{heading}0 0 2\n0.2 0\n")).expect("good");
        assert!(at(&tiny, 1, 7.0)[0].gait == Gait::Walk, "too short to stop on");
    }

    /// The gait and since when, seen by looking often, are what walkers say; nobody stands for a wait that is too short for it.
    #[test]
    fn people_know_since_when_they_stand_or_walk() {
        let text = "# crowd waypoints v1\nroute 0\n0 0 2\n6 0 0.3\n6 9 1\n0 9\n";
        let ways = Waypoints::parse(text).expect("good");
        let one = |step: u32| at(&ways, 1, step as f32 * 0.01)[0];
        let (mut since, mut changes) = (None, 0);
        for step in 1..6000 {
            let (before, now) = (one(step - 1), one(step));
            assert_ne!(now.gait, now.gait_before);
            if before.gait != now.gait {
                (since, changes) = (Some(step), changes + 1);
                assert_eq!(now.gait_before, before.gait);
            }
            if let Some(since) = since {
                let seen_s = (step - since) as f32 * 0.01;
                assert!((now.changed_s - seen_s).abs() < 0.012, "{} s, seen {seen_s} s ago", now.changed_s);
            }
        }
        // 30 m and 3.3 s a round, in which two of the three waits are stood.
        assert!((7..=14).contains(&changes), "{changes}");
        let never = Waypoints::parse("# crowd waypoints v1\nroute 0\n0 0 0.3\n6 0\n6 9\n").expect("good");
        assert!(at(&never, 9, 50.0).iter().all(|w| w.gait == Gait::Walk && w.changed_s == f32::INFINITY));
    }

    #[test]
    fn people_look_where_they_go() {
        let ways = Waypoints::around(50, 1.0);
        let (mut agree, mut count) = (0, 0);
        for (a, b) in at(&ways, 50, 7.0).iter().zip(&at(&ways, 50, 7.05)) {
            let d = b.position - a.position;
            agree += usize::from(libm::cosf(libm::atan2f(d.x, d.z) - a.yaw_rad) > 0.7);
            count += 1;
        }
        assert!(agree * 10 >= count * 9, "{agree} of {count}");
    }

    #[test]
    fn the_fixture_is_read() {
        let ways = Waypoints::parse(include_str!("../../../fixtures/scenes/waypoints.txt")).expect("a fixture");
        let (low, high) = ways.extent();
        assert_eq!((low, high), (Vec3::new(-13.5, 0.0, -9.5), Vec3::new(13.5, 0.0, 9.5)));
    }

    #[test]
    fn refusals_name_the_line_and_what_was_found() {
        for (text, expected) in [
            ("", "line 1: found nothing, expected `# crowd waypoints v1`"),
            ("# crowd waypoints v1\n", "found no route"),
            ("# crowd waypoints v1\n0 0\n", "line 2: found a point, expected `route`"),
            ("# crowd waypoints v1\nroute x\n", "line 2: found `x`, expected width"),
            ("# crowd waypoints v1\nroute 1\n0 NaN\n", "line 3: found `NaN`, expected z"),
            ("# crowd waypoints v1\nroute 1\n0 0\n0 0\n", "line 2: found a route of fewer than two different points"),
            ("# crowd waypoints v1\nroute 1\n0 0 0 0\n", "line 3: found 4 words, expected 2 to 3"),
        ] {
            let message = Waypoints::parse(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*", words in "(route [0-9.]{1,4}\n|[0-9. -]{0,12}\n){0,9}", time_s in 0.0_f32..1e6) {
            let _ = Waypoints::parse(&text);
            if let Ok(ways) = Waypoints::parse(&format!("{HEADING}\n{words}")) {
                prop_assert!(at(&ways, 20, time_s).iter().all(|w| w.position.is_finite() && w.yaw_rad.is_finite()));
            }
        }
    }
}
