//! People who walk: what a feed says of each at a time, and how that becomes an instance with a clip.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::Instance;
use crate::dice::{Dice, Purpose};

/// Below this ground speed a walk or run clip is taken to stay in place: its own speed is not known.
const LEAST_CLIP_SPEED_M_S: f32 = 0.05;

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
    /// The gait at a speed, with hysteresis: `self` is kept until the speed is clearly another gait's.
    ///
    /// Standing ends at 0.3 m/s and begins below 0.15; running begins at 2.2 m/s (people change over at about 2) and ends
    /// below 1.9.
    pub fn at_speed(self, speed_m_s: f32) -> Self {
        let stands_below = if self == Self::Idle { 0.3 } else { 0.15 };
        let runs_from = if self == Self::Run { 1.9 } else { 2.2 };
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
}

/// What a feed needs to know of a character: its clips for standing, walking and running, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mover {
    /// By [`Gait`].
    pub clips: [GaitClip; 3],
    /// Factor between the character's own metres and those of the scene.
    pub scale: f32,
}

/// The characters among which walkers are dealt out.
#[derive(Debug, Clone, PartialEq)]
pub struct Cast {
    /// At least one.
    pub movers: Vec<Mover>,
    /// Another seed, another casting.
    pub seed: u32,
}

impl Cast {
    /// The character of a walker: an index into `movers`.
    pub fn character_of(&self, id: u32) -> u32 {
        Dice { seed: self.seed, index: id }.below(Purpose::Character, self.movers.len() as u32)
    }

    /// The walker as an instance at `time_s`; its clip plays at `time_s + phase_s`, as everyone's does.
    ///
    /// Where the clip's ground speed is known, the clip follows the metres walked, so that feet do not slide; otherwise it
    /// plays at its own rate. What the clip itself moves the character by is taken out again.
    pub fn instance(&self, walker: &Walker, time_s: f32) -> Instance {
        let dice = Dice { seed: self.seed, index: walker.id };
        let character = self.character_of(walker.id);
        let mover = &self.movers[character as usize];
        let clip = &mover.clips[walker.gait as usize];
        let scale = 1.0 + 0.06 * dice.around_zero(Purpose::Scale);
        let own_speed = clip.ground_speed_m_s * mover.scale * scale;
        let follows = walker.gait != Gait::Idle && own_speed >= LEAST_CLIP_SPEED_M_S && clip.duration_s > 0.0;
        let start = dice.unit(Purpose::Phase) * clip.duration_s;
        let clip_time = start + if follows { walker.walked_m / own_speed } else { time_s };
        let phase_s = if clip.duration_s > 0.0 { (clip_time - time_s).rem_euclid(clip.duration_s) } else { 0.0 };
        let moved = if clip.duration_s > 0.0 {
            let turns = clip_time / clip.duration_s;
            clip.displacement_m * ((turns - turns.floor()) * mover.scale * scale)
        } else {
            Vec3::ZERO
        };
        Instance {
            position: walker.position - turned(moved, walker.yaw_rad),
            yaw_rad: walker.yaw_rad,
            scale,
            character,
            clip: clip.clip,
            phase_s,
        }
    }
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
        let clip = |clip| GaitClip { clip, duration_s: 1.0, ground_speed_m_s, displacement_m };
        Cast { movers: vec![Mover { clips: [clip(0), clip(1), clip(2)], scale: 1.0 }; 3], seed: 1 }
    }

    fn walker(gait: Gait, walked_m: f32) -> Walker {
        Walker { id: 7, position: Vec3::new(walked_m, 0.0, 0.0), yaw_rad: 0.5, speed_m_s: 1.0, gait, walked_m }
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
