//! Which clips people play by now.

use crate::{InstanceRecord, MotionRecord, MotionSchedule, MotionStretch};
use crowd_pack::{ClipRecord, NONE};

/// Sets the clip, the clip that is left, and where both are, of every instance that goes by a schedule; the others stay as they are.
///
/// `motions`: one an instance. Looked up by time, so any time may follow any other, and nothing is kept from frame to frame.
///
/// Paper: none; ERATO §2.2 notes when an animation ends. Twin: `shaders/stages/play_motion.wgsl`. Clips equal but at the border of two
/// stretches; turns within [`TURNS_BOUND`], shares within [`SHARE_BOUND`].
pub fn play_motion(
    clips: &[ClipRecord],
    stretches: &[MotionStretch],
    schedules: &[MotionSchedule],
    motions: &[MotionRecord],
    time_s: f32,
    instances: &mut [InstanceRecord],
) {
    for (instance, motion) in instances.iter_mut().zip(motions).filter(|(_, motion)| motion.schedule != NONE) {
        let MotionSchedule { first, count, loop_s, .. } = schedules[motion.schedule as usize];
        let of_schedule = &stretches[first as usize..(first + count) as usize];
        let now_s = time_s + motion.ahead_s;
        let within_s = now_s - (now_s / loop_s).floor() * loop_s;
        let one = &of_schedule[of_schedule.partition_point(|one| one.start_s <= within_s).max(1) - 1];
        let since_s = within_s - one.start_s;
        let fading_s = since_s.min(one.fade_s);
        let turned = |first_hz: f32, last_hz: f32| {
            fading_s * (first_hz + (last_hz - first_hz) * (0.5 * fading_s / one.fade_s.max(1e-6)))
        };
        let turns = one.turns + turned(one.first_rate_hz, one.rate_hz) + (since_s - fading_s) * one.rate_hz;
        let left_turns = one.left_turns + turned(one.left_rate_hz, one.left_last_rate_hz);
        let phase = |clip: u32, turns: f32| (turns - turns.floor()) * clips[clip as usize].duration_s - time_s;
        // Neither end of a fade jumps in speed.
        let done = if since_s < one.fade_s { fading_s / one.fade_s.max(1e-6) } else { 1.0 };
        instance.clip = one.clip;
        instance.phase_s = phase(one.clip, turns);
        instance.leaving_clip = one.left_clip;
        instance.leaving_phase_s = phase(one.left_clip, left_turns);
        instance.leaving_share = 1.0 - done * done * (3.0 - 2.0 * done);
    }
}

/// How far GPU and CPU may differ in turns: times of some hundred seconds keep 3e-5 s, and a turn takes a tenth of one at least.
pub const TURNS_BOUND: f32 = 1e-3;

/// How far GPU and CPU may differ in the share that is left: the same of a fade, whose shares go half as fast again in its middle.
pub const SHARE_BOUND: f32 = 1e-3;
