//! Dispatch of what instances play: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::{Error, MotionRecord, MotionSchedule, MotionStretch, Result};
use crowd_pack::{CharacterRecord, NONE};
use std::collections::BTreeSet;
use wgpu::BufferUsages as Usage;

/// Shader: `shaders/stages/play_motion.wgsl`. Twin: [`crate::cpu::play_motion`].
pub struct PlayMotion {
    kernel: Kernel,
}

impl PlayMotion {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/play_motion.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "play_motion", Self::source(), &["play_motion"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        motions: &wgpu::Buffer,
        schedules: &wgpu::Buffer,
        stretches: &wgpu::Buffer,
        clips: &wgpu::Buffer,
        instances: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, motions, schedules, stretches, clips, instances])
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}

/// Schedules of a crowd, and the stage that looks them up.
pub(crate) struct Motion {
    stage: PlayMotion,
    bound: wgpu::BindGroup,
    pub(crate) bytes: u64,
}

impl Motion {
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        max_instances: u32,
        plan: MotionPlan<'_>,
    ) -> Result<Self> {
        let fewer = "draw fewer instances";
        let mut motions = plan.motions.to_vec();
        motions.resize(max_instances as usize, MotionRecord { schedule: NONE, ahead_s: 0.0 });
        let motions = up.filled("bytes of motions", &motions, Usage::STORAGE, fewer)?;
        let schedules = up.filled("bytes of schedules", plan.schedules, Usage::STORAGE, fewer)?;
        let stretches = up.filled("bytes of stretches", plan.stretches, Usage::STORAGE, fewer)?;
        let stage = PlayMotion::new(up.device);
        let bound = stage.bind(up.device, &f.config, &motions, &schedules, &stretches, &c.clips, &f.instances);
        Ok(Self { stage, bound, bytes: up.bytes })
    }

    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass<'_>, instance_count: u32) {
        self.stage.record(pass, &self.bound, instance_count);
    }
}

/// What a crowd plays from second to second: see [`super::CrowdRenderer::set_motion`].
#[derive(Debug, Clone, Copy)]
pub struct MotionPlan<'a> {
    /// Of all schedules.
    pub stretches: &'a [MotionStretch],
    /// Of all instances.
    pub schedules: &'a [MotionSchedule],
    /// One an instance, in their order.
    pub motions: &'a [MotionRecord],
}

/// Refuses what the stage could not follow. `of_instances`: the character of each instance.
pub(crate) fn check_motion(plan: &MotionPlan<'_>, characters: &[CharacterRecord], of_instances: &[u32]) -> Result<()> {
    let refused = |what, index, found: String, allowed| Err(Error::Motion { what, index, found, allowed });
    for (index, motion) in plan.motions.iter().enumerate().filter(|(_, motion)| motion.schedule != NONE) {
        if motion.schedule as usize >= plan.schedules.len() {
            return refused("motion", index, format!("schedule {}", motion.schedule), "a schedule that is there");
        }
        if !motion.ahead_s.is_finite() {
            return refused("motion", index, format!("{} s ahead", motion.ahead_s), "a finite number");
        }
    }
    for (index, schedule) in plan.schedules.iter().enumerate() {
        let end = u64::from(schedule.first) + u64::from(schedule.count);
        if schedule.count == 0 || end > plan.stretches.len() as u64 {
            return refused("schedule", index, format!("stretches up to {end}"), "at least one, and all of them there");
        }
        let starts = || plan.stretches[schedule.first as usize..end as usize].iter().map(|one| one.start_s);
        let goes_round = schedule.loop_s.is_finite() && schedule.loop_s > 0.0;
        if !goes_round || !starts().is_sorted() || starts().next() != Some(0.0) {
            return refused(
                "schedule",
                index,
                format!("a loop of {} s", schedule.loop_s),
                "rising starts from 0 in a loop that ends",
            );
        }
    }
    for (index, one) in plan.stretches.iter().enumerate() {
        let numbers = [one.start_s, one.turns, one.first_rate_hz, one.rate_hz, one.left_turns, one.left_rate_hz];
        let are_finite = numbers.iter().chain([&one.left_last_rate_hz]).all(|number| number.is_finite());
        if !are_finite || !(0.0..=f32::MAX).contains(&one.fade_s) {
            return refused("stretch", index, format!("{one:?}"), "finite numbers, and no fade below 0");
        }
    }
    // Many go by one schedule: each is looked at once for each character.
    let goes = |(motion, character): (&MotionRecord, &u32)| (motion.schedule, *character);
    let pairs: BTreeSet<(u32, u32)> = plan.motions.iter().zip(of_instances).map(goes).collect();
    for (schedule, character) in pairs.into_iter().filter(|(schedule, _)| *schedule != NONE) {
        let MotionSchedule { first, count, .. } = plan.schedules[schedule as usize];
        let character = &characters[character as usize];
        let own = character.clip_offset..character.clip_offset + character.clip_count;
        for index in first..first + count {
            let one = &plan.stretches[index as usize];
            if let Some(clip) = [one.clip, one.left_clip].into_iter().find(|clip| !own.contains(clip)) {
                return refused("stretch", index as usize, format!("clip {clip}"), "a clip of who goes by it");
            }
        }
    }
    Ok(())
}
