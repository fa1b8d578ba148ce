//! A motion graph gone through once: what somebody plays from second to second, until it begins anew.
//!
//! Any time can be asked for, in any order, by whoever has the schedule: nobody is simulated. A crowd shares some schedules; each of
//! its people goes through one from a time of their own.

use std::collections::VecDeque;

use crate::dice::{Dice, Purpose};
use crate::motion_graph::{MotionGraph, MotionWay, Stay};

/// A schedule ends with the first return to its beginning after this time, seconds.
const LEAST_LOOP_S: f32 = 90.0;
/// Or after so many stays.
const MOST_STAYS: usize = 64;

/// What a character has for a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateClip {
    /// Number of the clip.
    pub clip: u32,
    /// Seconds of a turn; 0 for a single pose.
    pub duration_s: f32,
}

/// Somebody plays a clip, and at first fades out of the one before. Turns count from the clips' beginnings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionStretch {
    /// From the schedule's beginning, seconds.
    pub start_s: f32,
    /// Seconds of the fade at its beginning, before which the next stretch does not begin.
    pub fade_s: f32,
    /// Number of the clip.
    pub clip: u32,
    /// Turns at the beginning.
    pub turns: f32,
    /// Turns a second at the beginning, from which they go evenly to `rate_hz` at the fade's end.
    pub first_rate_hz: f32,
    /// Turns a second after the fade.
    pub rate_hz: f32,
    /// Number of the clip that is left.
    pub left_clip: u32,
    /// Its turns at the beginning.
    pub left_turns: f32,
    /// Its turns a second at the beginning.
    pub left_rate_hz: f32,
    /// Its turns a second at the fade's end.
    pub left_last_rate_hz: f32,
}

impl MotionStretch {
    /// Turns of the clip `since_s` seconds after the beginning.
    pub fn turns_at(&self, since_s: f32) -> f32 {
        let fading_s = since_s.min(self.fade_s);
        self.turns
            + turned(fading_s, self.first_rate_hz, self.rate_hz, self.fade_s)
            + (since_s - fading_s) * self.rate_hz
    }
}

/// Turns after `since_s` of a fade in which the rate goes evenly from one to the other.
fn turned(since_s: f32, first_hz: f32, last_hz: f32, fade_s: f32) -> f32 {
    if fade_s <= 0.0 { 0.0 } else { since_s * (first_hz + (last_hz - first_hz) * (0.5 * since_s / fade_s)) }
}

/// Stretches that go round.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// By their start, the first at 0.
    pub stretches: Vec<MotionStretch>,
    /// Seconds until it begins anew.
    pub loop_s: f32,
}

/// The schedule of one of a crowd and the seconds by which they are ahead in it: an index below `count`, and 0 to below 1 of its loop.
pub fn deal_schedule(index: u32, seed: u32, count: u32) -> (u32, f32) {
    let dice = Dice { seed, index };
    (dice.below(Purpose::Schedule, count.max(1)), dice.unit(Purpose::Start))
}

/// A stay in a state, before turns are counted.
struct Visit {
    state: usize,
    stay_s: f32,
    /// By which it was entered.
    way: Option<MotionWay>,
}

impl MotionGraph {
    /// Goes through the graph at random until it comes back to its beginning after 90 seconds or 64 stays. `clips`: what a character has
    /// for each state; it goes only where it has a clip and from where it can come back. `ahead`: turns that its second clip is ahead of
    /// the first where their feet are alike. `seed`, `number`: another number, another way. `None` where there is no clip for any state.
    ///
    /// Fades do not overlap: a stay is at least as long as the fade into it. In step, the clip that is left and the one that begins have
    /// the same number of turns a second at every moment of the fade, from the one's own to the other's.
    pub fn schedule(
        &self,
        clips: &[Option<StateClip>],
        ahead: &dyn Fn(u32, u32) -> f32,
        seed: u32,
        number: u32,
    ) -> Option<Schedule> {
        let is_there: Vec<bool> = (0..self.states.len()).map(|s| clips.get(s).is_some_and(Option::is_some)).collect();
        let first = is_there.iter().position(|&is_there| is_there)?;
        let together = self.together_with(first, &is_there);
        let ways: Vec<MotionWay> =
            self.ways.iter().copied().filter(|way| together[way.from] && together[way.to]).collect();
        let clip_of = |state: usize| clips[state].expect("only states with clips are gone through");
        if ways.is_empty() {
            return Some(single(clip_of(first)));
        }
        let visits = self.go_round(first, &ways, clips, seed, number);
        Some(count_turns(&visits, clip_of, ahead))
    }

    /// From `first` and back to it; the way of the first visit is the one that comes back.
    fn go_round(
        &self,
        first: usize,
        ways: &[MotionWay],
        clips: &[Option<StateClip>],
        seed: u32,
        number: u32,
    ) -> Vec<Visit> {
        let home = hops_to(first, ways, self.states.len());
        let (mut visits, mut time_s) = (Vec::new(), 0.0);
        let (mut state, mut way) = (first, None);
        loop {
            let dice = Dice { seed, index: number.wrapping_mul(4096).wrapping_add(visits.len() as u32) };
            let goes_home = time_s >= LEAST_LOOP_S || visits.len() >= MOST_STAYS;
            let next = choose(ways, state, goes_home.then_some(&home[..]), &dice);
            let stay_s = self.stay_s(state, clips[state].map_or(0.0, |clip| clip.duration_s), next.fade_s, &dice);
            visits.push(Visit { state, stay_s, way });
            time_s += stay_s;
            (state, way) = (next.to, Some(next));
            if goes_home && next.to == first {
                visits[0].way = way;
                return visits;
            }
        }
    }

    /// Seconds of a stay that the fade into it fits in.
    fn stay_s(&self, state: usize, duration_s: f32, next_fade_s: f32, dice: &Dice) -> f32 {
        let least_s = self.longest_fade_into(state).max(0.1);
        match self.states[state].stay {
            Stay::Seconds(least, most) => (least + (most - least) * dice.unit(Purpose::Stay)).max(least_s),
            Stay::Turns(least, most) => {
                let turns = least + dice.below(Purpose::Stay, most - least + 1);
                let turn_s = if plays(duration_s) { duration_s } else { 1.0 };
                let needed = libm::ceilf((least_s + next_fade_s) / turn_s);
                (turns as f32).max(needed) * turn_s - next_fade_s
            }
        }
    }
}

/// One clip for ever.
fn single(clip: StateClip) -> Schedule {
    let rate_hz = rate_hz(clip);
    let stretch = MotionStretch { clip: clip.clip, left_clip: clip.clip, rate_hz, ..Default::default() };
    Schedule { stretches: vec![stretch], loop_s: if rate_hz > 0.0 { clip.duration_s } else { 1.0 } }
}

fn rate_hz(clip: StateClip) -> f32 {
    if plays(clip.duration_s) { 1.0 / clip.duration_s } else { 0.0 }
}

/// Whether a clip of that duration is played; others are stills, so that all times of a schedule stay numbers.
fn plays(duration_s: f32) -> bool {
    (1e-3..=1e5).contains(&duration_s)
}

/// Ways from each state to `goal`, the fewest.
fn hops_to(goal: usize, ways: &[MotionWay], state_count: usize) -> Vec<u32> {
    let mut hops = vec![u32::MAX; state_count];
    hops[goal] = 0;
    let mut open = VecDeque::from([goal]);
    while let Some(at) = open.pop_front() {
        for way in ways.iter().filter(|way| way.to == at) {
            if hops[way.from] == u32::MAX {
                hops[way.from] = hops[at] + 1;
                open.push_back(way.from);
            }
        }
    }
    hops
}

/// One of a state's ways by weight; homewards one that comes nearer.
fn choose(ways: &[MotionWay], state: usize, home: Option<&[u32]>, dice: &Dice) -> MotionWay {
    let leads =
        |way: &&MotionWay| way.from == state && home.is_none_or(|hops| hops[way.to] == nearer(hops, way.from, ways));
    let total: f32 = ways.iter().filter(leads).map(|way| way.weight).sum();
    let mut rest = dice.unit(Purpose::Way) * total;
    let mut chosen = None;
    for way in ways.iter().filter(leads) {
        chosen = Some(*way);
        rest -= way.weight;
        if rest < 0.0 {
            break;
        }
    }
    chosen.expect("every state that is gone through leads on")
}

/// The fewest hops from any state that one way leads to.
fn nearer(hops: &[u32], state: usize, ways: &[MotionWay]) -> u32 {
    ways.iter().filter(|way| way.from == state).map(|way| hops[way.to]).min().unwrap_or(u32::MAX)
}

/// Turns from stay to stay, and round again.
fn count_turns(visits: &[Visit], clip_of: impl Fn(usize) -> StateClip, ahead: &dyn Fn(u32, u32) -> f32) -> Schedule {
    let mut stretches: Vec<MotionStretch> = Vec::with_capacity(visits.len());
    let mut start_s = 0.0;
    let way_of = |i: usize| visits[i].way.expect("every visit was come to, the first from the last");
    for (i, visit) in visits.iter().enumerate() {
        let (before, clip, way) = (&visits[(i + visits.len() - 1) % visits.len()], clip_of(visit.state), way_of(i));
        let left = clip_of(before.state);
        let mut stretch = MotionStretch {
            start_s,
            fade_s: way.fade_s,
            clip: clip.clip,
            turns: 0.0,
            first_rate_hz: if way.is_in_step { rate_hz(left) } else { rate_hz(clip) },
            rate_hz: rate_hz(clip),
            left_clip: left.clip,
            left_turns: 0.0,
            left_rate_hz: rate_hz(left),
            left_last_rate_hz: if way.is_in_step { rate_hz(clip) } else { rate_hz(left) },
        };
        if let Some(last) = stretches.last() {
            stretch.left_turns = last.turns_at(before.stay_s).rem_euclid(1.0);
            if way.is_in_step {
                stretch.turns = (stretch.left_turns + ahead(left.clip, clip.clip)).rem_euclid(1.0);
            }
        }
        stretches.push(stretch);
        start_s += visit.stay_s;
    }
    let last_stay_s = visits[visits.len() - 1].stay_s;
    let last = stretches[stretches.len() - 1];
    let mut left_turns = last.turns_at(last_stay_s).rem_euclid(1.0);
    let mut loop_s = start_s;
    if way_of(0).is_in_step && last.rate_hz > 0.0 {
        // The last stay is as much longer as its steps need to meet those of the beginning.
        let missing = (-left_turns - ahead(last.clip, stretches[0].clip)).rem_euclid(1.0);
        loop_s += missing / last.rate_hz;
        left_turns = (left_turns + missing).rem_euclid(1.0);
    }
    stretches[0].left_turns = left_turns;
    Schedule { stretches, loop_s }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GRAPH: &str = "# crowd motion graph v1
state stands idle seconds 1 4
state strolls walk seconds 2 5
state hurries run seconds 1 3
state waves wave turns 1 2
way stands strolls 0.4
way strolls stands 0.4 weight 2
way strolls hurries 0.3 in-step
way hurries strolls 0.3 in-step
way stands waves 0.5
way waves stands 0.5
";

    fn clips() -> Vec<Option<StateClip>> {
        [2.0, 1.0, 0.6, 0.8].iter().zip(0..).map(|(&duration_s, clip)| Some(StateClip { clip, duration_s })).collect()
    }

    fn ahead(from: u32, to: u32) -> f32 {
        match (from, to) {
            (1, 2) => 0.2,
            (2, 1) => 0.8,
            _ => 0.0,
        }
    }

    /// Difference of two turns, the shorter way round.
    fn apart(a: f32, b: f32) -> f32 {
        let d = (a - b).rem_euclid(1.0);
        d.min(1.0 - d)
    }

    /// Clip and turns at a time, and the same of the clip that is left.
    fn at(schedule: &Schedule, time_s: f32) -> (u32, f32, Option<(u32, f32)>) {
        let time_s = time_s.rem_euclid(schedule.loop_s);
        let number = schedule.stretches.partition_point(|one| one.start_s <= time_s) - 1;
        let one = &schedule.stretches[number];
        let since_s = time_s - one.start_s;
        let left = one.left_turns + turned(since_s, one.left_rate_hz, one.left_last_rate_hz, one.fade_s);
        (one.clip, one.turns_at(since_s), (since_s < one.fade_s).then_some((one.left_clip, left)))
    }

    #[test]
    fn schedules_go_round_without_a_jump_and_in_step() {
        let graph = MotionGraph::parse(GRAPH).unwrap();
        for number in 0..20 {
            let schedule = graph.schedule(&clips(), &ahead, 5, number).unwrap();
            assert!(schedule.loop_s >= LEAST_LOOP_S && schedule.stretches[0].start_s == 0.0);
            let ends = schedule.stretches.iter().skip(1).map(|one| one.start_s).chain([schedule.loop_s]);
            for (one, end_s) in schedule.stretches.iter().zip(ends) {
                assert!(one.fade_s <= end_s - one.start_s + 1e-3, "fades do not overlap");
                assert!(graph.ways().iter().any(|way| (way.from as u32, way.to as u32) == (one.left_clip, one.clip)));
                // What plays at the end of a stretch is what the next one leaves, where it was.
                let (clip, turns, _) = at(&schedule, end_s - 1e-3);
                let (next, next_turns, left) = at(&schedule, end_s + 1e-3);
                let (left_clip, left_turns) = left.expect("it begins with a fade");
                assert!(left_clip == clip && apart(left_turns, turns) < 0.01, "{number}: {turns}, then {left_turns}");
                if next + left_clip == 3 && next.max(left_clip) == 2 {
                    assert!(apart(next_turns, left_turns + ahead(left_clip, next)) < 1e-3, "steps meet");
                }
            }
        }
    }

    #[test]
    fn a_clip_counted_in_turns_ends_where_it_began() {
        let graph = MotionGraph::parse(GRAPH).unwrap();
        let mut waved = 0;
        for number in 0..20 {
            let schedule = graph.schedule(&clips(), &ahead, 5, number).unwrap();
            for pair in schedule.stretches.windows(2).filter(|pair| pair[0].clip == 3) {
                let end_s = pair[1].start_s + pair[1].fade_s;
                assert!(apart(pair[0].turns_at(end_s - pair[0].start_s), 0.0) < 1e-3);
                waved += 1;
            }
        }
        assert!(waved > 20);
    }

    #[test]
    fn a_character_without_some_clips_does_the_rest() {
        let graph = MotionGraph::parse(GRAPH).unwrap();
        let mut some = clips();
        some[1] = None;
        let schedule = graph.schedule(&some, &ahead, 1, 0).unwrap();
        let seen: std::collections::BTreeSet<u32> = schedule.stretches.iter().map(|one| one.clip).collect();
        assert_eq!(Vec::from_iter(seen), [0, 3], "no way to running but through walking");
        let one = graph.schedule(&[None, None, clips()[2], None], &ahead, 1, 0).unwrap();
        assert_eq!((one.stretches.len(), one.stretches[0].clip, one.loop_s), (1, 2, 0.6));
        assert_eq!(graph.schedule(&[None; 4], &ahead, 1, 0), None);
    }

    #[test]
    fn people_are_spread_over_schedules_and_times() {
        let (mut of, mut times) = ([0; 8], [0; 8]);
        for index in 0..4000 {
            let (number, share) = deal_schedule(index, 3, 8);
            of[number as usize] += 1;
            times[(share * 8.0) as usize] += 1;
        }
        assert!(of.into_iter().chain(times).all(|count: i32| (400..600).contains(&count)), "{of:?} {times:?}");
    }

    /// Also what a pack may say and nobody plays.
    fn durations() -> impl Strategy<Value = f32> {
        prop_oneof![4 => 0.0_f32..30.0, 1 => proptest::sample::select(vec![0.0, 1e-40, 1e-10, 1e30, f32::MAX])]
    }

    proptest! {
        #[test]
        fn any_durations_give_finite_schedules(
            durations in proptest::collection::vec(proptest::option::of(durations()), 4), seed: u32, number in 0_u32..64,
        ) {
            let graph = MotionGraph::parse(GRAPH).unwrap();
            let clips: Vec<Option<StateClip>> = durations.iter().zip(0..)
                .map(|(duration, clip)| duration.map(|duration_s| StateClip { clip, duration_s })).collect();
            let schedule = graph.schedule(&clips, &ahead, seed, number);
            prop_assert_eq!(schedule.is_some(), clips.iter().any(Option::is_some));
            if let Some(schedule) = schedule {
                prop_assert!(schedule.loop_s.is_finite() && schedule.loop_s > 0.0 && schedule.stretches.len() <= 2 * MOST_STAYS);
                prop_assert!(schedule.stretches.is_sorted_by(|a, b| a.start_s < b.start_s));
                prop_assert!(schedule.stretches.iter().all(|one| one.turns.is_finite() && one.left_turns.is_finite()));
            }
        }
    }
}
