//! People who walk: what a feed says of each at a time, and how that becomes an instance with a clip.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::dice::{Dice, Purpose};
use crate::{Instance, Leaving};

/// Below this ground speed a walk or run clip is taken to stay in place: its own speed is not known.
pub const LEAST_CLIP_SPEED_M_S: f32 = 0.05;

/// How fast someone goes, in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Gait {
    /// Stands.
    #[default]
    Idle,
    /// Walks.
    Walk,
    /// Runs.
    Run,
}

impl Gait {
    /// Feeds change nobody's gait sooner than this after the last change, seconds: no third clip comes into a fade.
    pub const SHORTEST_S: f32 = 0.5;
    /// Standing begins below the first, metres a second, and ends at the second.
    pub const STANDS_BELOW_M_S: [f32; 2] = [0.15, 0.3];
    /// Running ends below the first, metres a second, and begins at the second; people change over at about 2.
    pub const RUNS_FROM_M_S: [f32; 2] = [1.9, 2.2];

    /// The gait at a speed, with hysteresis: `self` is kept until the speed is clearly another gait's.
    pub fn at_speed(self, speed_m_s: f32) -> Self {
        let stands_below = Self::STANDS_BELOW_M_S[usize::from(self == Self::Idle)];
        let runs_from = Self::RUNS_FROM_M_S[usize::from(self != Self::Run)];
        match speed_m_s {
            s if s < stands_below => Self::Idle,
            s if s < runs_from => Self::Walk,
            s if s >= runs_from => Self::Run,
            // Not a number: as before.
            _ => self,
        }
    }
}

/// One person of a feed at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walker {
    /// The same number for the same person at all times: character, scale and phase are a hash of it.
    pub id: u32,
    /// Feet, metres.
    pub position: Vec3,
    /// Facing: 0 looks along +Z, positive turns towards +X; within -pi to pi.
    pub yaw_rad: f32,
    /// Over the ground, smoothed.
    pub speed_m_s: f32,
    /// What the speed means, without flicker.
    pub gait: Gait,
    /// Metres walked since the person came.
    pub walked_m: f32,
    /// Part of them that were run.
    pub ran_m: f32,
    /// The gait before this one; means nothing while `changed_s` is infinite.
    pub gait_before: Gait,
    /// Seconds since the gait changed; infinite where it never did.
    pub changed_s: f32,
}

/// A clip as feeds use it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GaitClip {
    /// Index within the character.
    pub clip: u32,
    /// Seconds; 0 for a single pose.
    pub duration_s: f32,
    /// Speed over the ground at which the feet do not slide, at scale 1; 0 where it is not known.
    pub ground_speed_m_s: f32,
    /// What the clip itself moves the character by in one turn, metres at scale 1; zero for clips that stay in place.
    pub displacement_m: Vec3,
    /// Where the character has to be beside its even way for standing feet to stay.
    pub root_path: RootPath,
}

/// A closed way over the ground that a character takes beside its even one in a turn of a clip: a body that walks is faster and slower within a
/// step. Metres at scale 1; by default none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RootPath {
    /// x and z, evenly spread over the turn; the first comes again after the last.
    points: [[f32; 2]; 32],
}

impl RootPath {
    /// From points evenly spread over a turn, the last as the first; too few to be a way give none.
    pub fn of(points: &[[f32; 2]]) -> Self {
        let steps = points.len().saturating_sub(1);
        let mut path = Self::default();
        if steps < 2 {
            return path;
        }
        let count = path.points.len();
        for (i, point) in path.points.iter_mut().enumerate() {
            let at = i as f32 * steps as f32 / count as f32;
            let (first, share) = ((at as usize).min(steps - 1), at.fract());
            *point = [0, 1].map(|axis| points[first][axis] + (points[first + 1][axis] - points[first][axis]) * share);
        }
        path
    }

    /// Its points, evenly spread over a turn; the first comes again after the last.
    pub fn points(&self) -> &[[f32; 2]; 32] {
        &self.points
    }

    /// Where that is after so many turns, in the character's own space.
    pub fn at(&self, turns: f32) -> Vec3 {
        let count = self.points.len();
        let at = (turns - turns.floor()) * count as f32;
        let first = (at as usize).min(count - 1);
        let ([ax, az], [bx, bz]) = (self.points[first], self.points[(first + 1) % count]);
        let share = at - first as f32;
        Vec3::new(ax + (bx - ax) * share, 0.0, az + (bz - az) * share)
    }
}

/// What a feed needs to know of a character: its clips for standing, walking and running, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mover {
    /// By [`Gait`].
    pub clips: [GaitClip; 3],
    /// Factor between the character's own metres and those of the scene.
    pub scale: f32,
    /// Turns that the run clip is ahead of the walk clip where its feet are where the walk's are.
    pub run_ahead_turns: f32,
}

/// What stays the same of a walker at all times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WalkerTraits {
    /// Index of the mover: the character.
    pub mover: u32,
    /// Size, around 1.
    pub scale: f32,
    /// Where in its clips it begins, 0 to below 1.
    pub start: f32,
}

/// The characters among which walkers are dealt out.
#[derive(Debug, Clone, PartialEq)]
pub struct Cast {
    /// At least one.
    pub movers: Vec<Mover>,
    /// Another seed, another casting.
    pub seed: u32,
    /// Seconds over which someone fades from one gait into the next; 0: at once. At most [`Gait::SHORTEST_S`].
    pub fade_s: f32,
}

impl Cast {
    /// The character of a walker: an index into `movers`.
    pub fn character_of(&self, id: u32) -> u32 {
        Dice { seed: self.seed, index: id }.below(Purpose::Character, self.movers.len() as u32)
    }

    /// What stays the same of a walker.
    pub fn traits_of(&self, id: u32) -> WalkerTraits {
        let dice = Dice { seed: self.seed, index: id };
        WalkerTraits {
            mover: self.character_of(id),
            scale: 1.0 + 0.06 * dice.around_zero(Purpose::Scale),
            start: dice.unit(Purpose::Phase),
        }
    }

    /// The walker as an instance at `time_s`; its clip plays at `time_s + phase_s`, as everyone's does.
    ///
    /// Where the clips' ground speeds are known, they follow the metres walked, so that feet do not slide; otherwise they play at
    /// their own rates. Walking and running then go by one count of steps, so that at a change both clips have the same foot on
    /// the ground. For `fade_s` after a change the gait before shares in the pose. What clips themselves move the character by is
    /// taken out again, and they go along their clips' root paths, so that feet stay where they are planted.
    pub fn instance(&self, walker: &Walker, time_s: f32) -> Instance {
        let WalkerTraits { mover: character, scale, start } = self.traits_of(walker.id);
        let mover = &self.movers[character as usize];
        let size = mover.scale * scale;
        let of = |gait: Gait| {
            let clip = &mover.clips[gait as usize];
            let turns = start + mover.turns(gait, walker, size, time_s);
            let phase_s = if clip.duration_s > 0.0 {
                (turns * clip.duration_s - time_s).rem_euclid(clip.duration_s)
            } else {
                0.0
            };
            let moved = clip.displacement_m * (turns - turns.floor()) - clip.root_path.at(turns);
            (clip, phase_s, moved * size)
        };
        let (clip, phase_s, mut moved) = of(walker.gait);
        let mut leaving = Leaving::default();
        let before = walker.gait_before;
        let is_other = mover.clips[before as usize].clip != clip.clip;
        if is_other && walker.changed_s < self.fade_s {
            let (left, left_phase_s, left_moved) = of(before);
            leaving =
                Leaving { clip: left.clip, phase_s: left_phase_s, share: left_share(walker.changed_s / self.fade_s) };
            moved += (left_moved - moved) * leaving.share;
        }
        Instance {
            position: walker.position - turned(moved, walker.yaw_rad),
            yaw_rad: walker.yaw_rad,
            scale,
            character,
            clip: clip.clip,
            phase_s,
            leaving,
        }
    }
}

impl Mover {
    /// Turns of a gait's clip by now. `size`: of the instance over the clips' own metres.
    fn turns(&self, gait: Gait, walker: &Walker, size: f32, time_s: f32) -> f32 {
        let stride = |gait: Gait| {
            let clip = &self.clips[gait as usize];
            let own_speed = clip.ground_speed_m_s * size;
            (own_speed >= LEAST_CLIP_SPEED_M_S && clip.duration_s > 0.0).then_some(own_speed * clip.duration_s)
        };
        let by_time = |clip: &GaitClip| if clip.duration_s > 0.0 { time_s / clip.duration_s } else { 0.0 };
        let ahead = if gait == Gait::Run { self.run_ahead_turns } else { 0.0 };
        match (gait, stride(Gait::Walk), stride(Gait::Run)) {
            (Gait::Walk | Gait::Run, Some(walk_m), Some(run_m)) => {
                (walker.walked_m - walker.ran_m) / walk_m + walker.ran_m / run_m + ahead
            }
            (Gait::Walk, Some(stride_m), None) | (Gait::Run, None, Some(stride_m)) => walker.walked_m / stride_m,
            _ => by_time(&self.clips[gait as usize]),
        }
    }
}

/// Share of what is left after `done` of a fade, 1 to 0, with no jump in speed at either end.
fn left_share(done: f32) -> f32 {
    let done = done.clamp(0.0, 1.0);
    1.0 - done * done * (3.0 - 2.0 * done)
}

/// A vector of a character, seen from the world.
fn turned(v: Vec3, yaw_rad: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(yaw_rad);
    Vec3::new(v.x * cos + v.z * sin, v.y, v.z * cos - v.x * sin)
}

/// The same direction within -pi to pi.
pub(crate) fn wrapped(yaw_rad: f32) -> f32 {
    let turns = yaw_rad / TAU;
    (turns - (turns + 0.5).floor()) * TAU
}

/// From `a` to `b` by the shorter way, `t` from 0 to 1.
pub(crate) fn between_yaws(a: f32, b: f32, t: f32) -> f32 {
    wrapped(a + wrapped(b - a) * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn walk(ground_speed_m_s: f32, displacement_m: Vec3) -> Cast {
        let clip = |clip| GaitClip { clip, duration_s: 1.0, ground_speed_m_s, displacement_m, ..Default::default() };
        Cast {
            movers: vec![Mover { clips: [clip(0), clip(1), clip(2)], scale: 1.0, run_ahead_turns: 0.0 }; 3],
            seed: 1,
            fade_s: 0.3,
        }
    }

    fn walker(gait: Gait, walked_m: f32) -> Walker {
        Walker {
            id: 7,
            position: Vec3::new(walked_m, 0.0, 0.0),
            yaw_rad: 0.5,
            speed_m_s: 1.0,
            gait,
            walked_m,
            ran_m: 0.0,
            gait_before: Gait::Idle,
            changed_s: f32::INFINITY,
        }
    }

    #[test]
    fn walking_and_running_count_the_same_steps_and_fade() {
        let mut cast = walk(1.0, Vec3::ZERO);
        for mover in &mut cast.movers {
            mover.clips[2] = GaitClip { clip: 2, duration_s: 0.6, ground_speed_m_s: 3.0, ..Default::default() };
            mover.run_ahead_turns = 0.25;
        }
        let turns =
            |clip_phase_s: f32, duration_s: f32, time_s: f32| ((time_s + clip_phase_s) / duration_s).rem_euclid(1.0);
        let mut shares = Vec::new();
        for i in 0..8 {
            let changed_s = i as f32 * 0.05;
            let ran_m = 3.0 * changed_s;
            let now = 5.0 + changed_s;
            let runs = Walker { ran_m, gait_before: Gait::Walk, changed_s, ..walker(Gait::Run, 2.0 + ran_m) };
            let one = cast.instance(&runs, now);
            let steps = turns(one.phase_s, 0.6, now) - 0.25;
            if one.leaving.share > 0.0 {
                let left = turns(one.leaving.phase_s, 1.0, now);
                assert!(wrapped((steps - left) * TAU).abs() < 1e-3, "{steps} and {left} turns");
                assert_eq!((one.clip, one.leaving.clip), (2, 1));
            }
            shares.push(one.leaving.share);
        }
        assert!(shares[0] == 1.0 && shares.is_sorted_by(|a, b| a >= b) && shares[6] == 0.0, "{shares:?}");
        // Where walking stops and running starts nothing jumps.
        let (stops, starts) =
            (walker(Gait::Walk, 2.0), Walker { changed_s: 0.0, gait_before: Gait::Walk, ..walker(Gait::Run, 2.0) });
        let (a, b) = (cast.instance(&stops, 5.0), cast.instance(&starts, 5.0));
        assert_eq!((a.clip, a.phase_s), (b.leaving.clip, b.leaving.phase_s));
        assert_eq!(b.leaving.share, 1.0);
        cast.fade_s = 0.0;
        assert_eq!(cast.instance(&starts, 5.0).leaving, Leaving::default(), "switched off");
    }

    #[test]
    fn gaits_do_not_flicker_at_their_borders() {
        assert_eq!(Gait::Idle.at_speed(0.2), Gait::Idle);
        assert_eq!(Gait::Walk.at_speed(0.2), Gait::Walk);
        assert_eq!(Gait::Walk.at_speed(0.1), Gait::Idle);
        assert_eq!(Gait::Walk.at_speed(2.0), Gait::Walk);
        assert_eq!(Gait::Run.at_speed(2.0), Gait::Run);
        assert_eq!(Gait::Idle.at_speed(3.0), Gait::Run);
        assert_eq!(Gait::Run.at_speed(f32::NAN), Gait::Run);
    }

    #[test]
    fn a_person_keeps_character_and_scale() {
        let cast = walk(1.0, Vec3::ZERO);
        let (a, b) = (cast.instance(&walker(Gait::Walk, 1.0), 0.0), cast.instance(&walker(Gait::Idle, 9.0), 5.0));
        assert_eq!((a.character, a.scale), (b.character, b.scale));
        let characters: std::collections::BTreeSet<u32> = (0..50).map(|id| cast.character_of(id)).collect();
        assert_eq!(characters.len(), 3);
    }

    #[test]
    fn the_clip_follows_the_ground_where_its_speed_is_known() {
        let clip_time = |cast: &Cast, walked: f32, time: f32| {
            let one = cast.instance(&walker(Gait::Walk, walked), time);
            (time + one.phase_s).rem_euclid(1.0)
        };
        let close = |a: f32, b: f32| wrapped((a - b) * TAU).abs() < 1e-3;
        let known = walk(1.0, Vec3::ZERO);
        assert!(close(clip_time(&known, 2.0, 3.0), clip_time(&known, 2.0, 3.4)), "who does not move, does not step");
        let step = 0.25 / known.instance(&walker(Gait::Walk, 0.0), 0.0).scale;
        assert!(close(clip_time(&known, 2.25, 3.0), clip_time(&known, 2.0, 3.0) + step));
        let unknown = walk(0.0, Vec3::ZERO);
        assert!(close(clip_time(&unknown, 2.0, 3.25), clip_time(&unknown, 2.0, 3.0) + 0.25));
    }

    #[test]
    fn what_the_clip_moves_is_taken_out() {
        let cast = walk(1.5, Vec3::new(0.0, 0.0, 1.5));
        for (walked, time) in [(0.0, 0.0), (0.7, 0.3), (3.3, 9.1)] {
            let person = walker(Gait::Walk, walked);
            let one = cast.instance(&person, time);
            let shown_turns = (time + one.phase_s).rem_euclid(1.0);
            let shown = one.position + turned(Vec3::new(0.0, 0.0, 1.5) * shown_turns * one.scale, one.yaw_rad);
            assert!(shown.distance(person.position) < 1e-3, "{shown} is not {}", person.position);
        }
    }

    #[test]
    fn a_root_path_is_gone_along_and_closes() {
        let path = RootPath::of(&[[0.0, 0.0], [0.0, 0.1], [0.0, 0.0], [0.0, -0.1], [0.0, 0.0]]);
        for (turns, z) in [(0.0, 0.0), (0.125, 0.05), (0.25, 0.1), (1.25, 0.1), (-0.25, -0.1), (7.75, -0.1)] {
            assert!((path.at(turns) - Vec3::new(0.0, 0.0, z)).length() < 1e-6, "{turns}: {}", path.at(turns));
        }
        assert_eq!(RootPath::of(&[[1.0, 1.0], [1.0, 1.0]]), RootPath::default());
        let mut cast = walk(1.0, Vec3::ZERO);
        let person = walker(Gait::Walk, 0.25);
        let even = cast.instance(&person, 2.0);
        cast.movers.iter_mut().for_each(|mover| mover.clips[1].root_path = path);
        let one = cast.instance(&person, 2.0);
        let turns = (2.0 + one.phase_s).rem_euclid(1.0);
        let beside = turned(path.at(turns) * one.scale, one.yaw_rad);
        assert!((one.position - even.position - beside).length() < 1e-5 && beside.length() > 1e-3);
    }

    proptest! {
        #[test]
        fn directions_are_wrapped(yaw in -100.0_f32..100.0, other in -100.0_f32..100.0, t in 0.0_f32..=1.0) {
            let same = wrapped(yaw);
            prop_assert!(same.abs() < 0.5001 * TAU);
            prop_assert!((libm::sinf(same) - libm::sinf(yaw)).abs() < 1e-4);
            prop_assert!(wrapped(between_yaws(yaw, other, t) - yaw).abs() <= wrapped(other - yaw).abs() + 1e-3);
        }
    }
}
