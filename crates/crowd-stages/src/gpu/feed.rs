//! Instances that a simulator writes on the GPU: borrowed, checked there, drawn; the CPU sees none of them.

use super::AdmitInstances;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::{CrowdBounds, Error, FeedConfig, FeedState, FrameConfig, FrameTotals, InstanceRecord, Result};
use std::mem::{offset_of, size_of};

/// Instances in a simulator's buffer, for [`super::CrowdRenderer::borrow_instances`].
///
/// The buffer holds [`InstanceRecord`]s as they lie, 48 bytes each, little-endian; in WGSL
///
/// ```wgsl
/// struct InstanceRecord {
///     position: vec3f, // feet, metres, Y up
///     yaw_rad: f32,    // 0 faces +Z, positive turns towards +X
///     scale: f32,      // 0: nobody, a place that is free
///     character: u32,  // index in CrowdData::characters
///     clip: u32,       // index in CrowdData::clips, one of the character's own
///     phase_s: f32,    // the clip plays at FrameConfig::time_s + phase_s
///     leaving_clip: u32,    // another of its clips that it fades out of,
///     leaving_phase_s: f32,
///     leaving_share: f32,   // and that one's share of the pose; 0: none
///     held_s: f32,     // seconds ago that its pose is of; 0, or what a stage that holds poses says
/// }
/// ```
///
/// A record with a number that is not finite, a character, clip or share that does not exist is nobody, and counted; a scale of 0 is nobody, too. Other
/// numbers are taken as they are: keep scales within 0.01 to 100, places within a thousand kilometres, times within some days.
///
/// The simulator may write it at any time before the frame's commands on the same queue.
#[derive(Debug, Clone)]
pub struct InstanceFeed<'a> {
    /// The records, with `STORAGE` usage.
    pub instances: &'a wgpu::Buffer,
    /// A number of 32 bits at the start of a buffer with `STORAGE` usage: how many of the records count. `None`: `most` do.
    pub count: Option<&'a wgpu::Buffer>,
    /// The most records there can be.
    pub most: u32,
    /// Where they can be, for shadows; nowhere (the default), no shadows.
    pub bounds: CrowdBounds,
    /// The character of each record, if that does not change: `most` of them, or none. Draw calls by the CPU, those of
    /// [`crate::Technique::PseudoInstancing`], need them.
    pub characters: &'a [u32],
}

/// A feed with its buffers bound.
pub(crate) struct BoundFeed {
    stage: AdmitInstances,
    bound: wgpu::BindGroup,
    state: wgpu::Buffer,
    pub(crate) most: u32,
    pub(crate) bytes: u64,
}

impl BoundFeed {
    /// Checks the buffers and binds them.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        feed: &InstanceFeed<'_>,
        crowd: &CrowdBuffers,
        frame: &FrameBuffers,
        character_count: u32,
    ) -> Result<Self> {
        let bytes = u64::from(feed.most.max(1)) * size_of::<InstanceRecord>() as u64;
        check(up.device, feed.instances, "bytes of the simulator's instances", bytes)?;
        feed.count.map_or(Ok(()), |count| check(up.device, count, "bytes of the simulator's count", 4))?;
        let (storage, fewer) = (wgpu::BufferUsages::STORAGE, "draw fewer instances");
        let before = up.bytes;
        let config = FeedConfig { most: feed.most, character_count, ..Default::default() };
        let config = up.filled("feed", &[config], wgpu::BufferUsages::UNIFORM, fewer)?;
        let all = up.filled("count of all", &[feed.most], storage, fewer)?;
        let block_refused =
            up.empty::<u32>("refused of blocks", AdmitInstances::block_words(feed.most), storage, fewer)?;
        let state = up.empty::<FeedState>("feed state", 1, storage | wgpu::BufferUsages::COPY_SRC, fewer)?;
        let stage = AdmitInstances::new(up.device);
        let (given, count) = (feed.instances, feed.count.unwrap_or(&all));
        let bound =
            stage.bind(up.device, &config, given, count, &crowd.characters, &frame.instances, &block_refused, &state);
        Ok(Self { stage, bound, state, most: feed.most, bytes: up.bytes - before })
    }

    /// Takes the simulator's records into the frame's, and their count into the frame's uniform.
    pub(crate) fn record(&self, recorder: &mut StageRecorder<'_>, frame: &FrameBuffers) {
        recorder.stage("admit_instances", |pass| self.stage.record(pass, &self.bound, self.most));
        self.record_count(recorder.encoder, &frame.config);
    }

    /// Their count alone, into a config of a frame whose instances have been taken.
    pub(crate) fn record_count(&self, encoder: &mut wgpu::CommandEncoder, config: &wgpu::Buffer) {
        let (from, to) = (offset_of!(FeedState, count) as u64, offset_of!(FrameConfig, instance_count) as u64);
        encoder.copy_buffer_to_buffer(&self.state, from, config, to, 4);
    }

    /// Adds who was refused to the frame's totals.
    pub(crate) fn record_totals(&self, encoder: &mut wgpu::CommandEncoder, frame: &FrameBuffers) {
        let (from, to) = (offset_of!(FeedState, refused_count) as u64, offset_of!(FrameTotals, refused_count) as u64);
        encoder.copy_buffer_to_buffer(&self.state, from, &frame.totals, to, 4);
    }
}

fn check(device: &wgpu::Device, buffer: &wgpu::Buffer, what: &'static str, needed: u64) -> Result<()> {
    if !buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
        return Err(Error::Feed { what, problem: "a buffer without STORAGE usage, allowed one with it" });
    }
    if buffer.size() < needed {
        return Err(Error::Limit {
            what,
            needed,
            allowed: buffer.size(),
            remedy: "hand over a larger buffer, or a smaller `most`",
        });
    }
    // Buffers are bound whole.
    let allowed = device.limits().max_storage_buffer_binding_size;
    if buffer.size() > allowed {
        let remedy = "hand over a smaller buffer, or ask the adapter for larger bindings";
        return Err(Error::Limit { what, needed: buffer.size(), allowed, remedy });
    }
    Ok(())
}
