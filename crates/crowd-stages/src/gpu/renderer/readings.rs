//! What a renderer knows of frames that are done: totals, times, buffers for tests.

use super::super::poll_device::poll_device;
use super::super::read_back;
use super::super::skinning_trial::SkinningChoice;
use super::CrowdRenderer;
use crate::{FillState, FrameTotals, InstanceBase, Result, Skinning, Technique};
use std::time::{Duration, Instant};

impl CrowdRenderer {
    /// How many palettes the newest frame of [`Technique::Bucketed`] had to blend, and instances' vertices to skin, where poses are shared:
    /// one for each pose that somebody is in. Waits. `None` where they never were.
    pub fn shared_poses(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Option<u32>> {
        let Some(end) = self.buffer(Technique::Bucketed, "leader_end") else { return Ok(None) };
        let encoder = device.create_command_encoder(&Default::default());
        let read: Vec<InstanceBase> = read_back::read_now(device, queue, encoder, end, 1)?;
        Ok(read.first().map(|end| end.vertex_base))
    }

    /// How high the water was in the newest frame that filled a budget, whatever its technique: bits of a float for the
    /// [`crate::FrameConfig::water_before_bits`] of the frame after it. A renderer remembers that by itself; who draws frames of several crowds or techniques in
    /// turn has to. Waits.
    pub fn water_bits(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<u32> {
        let encoder = device.create_command_encoder(&Default::default());
        let read: Vec<FillState> = read_back::read_now(device, queue, encoder, &self.frame.fill, 1)?;
        Ok(read.first().map_or(0, |fill| fill.smooth_bits))
    }

    /// Where the vertices of [`Technique::Bucketed`] are worked out, when `asked` is asked for, and why there.
    pub fn skinning(&self, asked: Skinning) -> SkinningChoice {
        self.trial.choice(asked)
    }

    /// Totals of the newest finished frame, without waiting (`wait`: until the last submitted one is done).
    ///
    /// A frame that was recorded but never submitted is waited for a second, no longer.
    pub fn totals(&mut self, device: &wgpu::Device, wait: bool) -> Option<FrameTotals> {
        let poll_type = || if wait { wgpu::PollType::wait_indefinitely() } else { wgpu::PollType::Poll };
        // An error means a lost device: nothing new will arrive, and the engine hears of it by its `set_device_lost_callback`.
        let poll = || poll_device(device, poll_type()).is_ok();
        let mut is_alive = poll();
        // The work is done, but where another thread polls the same device, it may still be about to tell us.
        let patience = Instant::now() + Duration::from_secs(1);
        while wait && is_alive && self.read_back.is_under_way() && Instant::now() < patience {
            std::thread::sleep(Duration::from_micros(50));
            is_alive = poll();
        }
        self.read_back.collect(&self.meters).totals
    }

    /// GPU milliseconds per stage of the newest finished frame, where timestamps are offered. Measured from start to next start, on software Vulkan
    /// from end to end; so the waiting between two passes counts, too.
    pub fn timings_ms(&mut self) -> Vec<(&'static str, f32)> {
        self.read_back.collect(&self.meters).timings_ms.clone()
    }

    /// How often the newest finished frame ran the vertex shader for the crowd, as the adapter counts; `None` where it does not.
    pub fn vertex_runs(&mut self) -> Option<u64> {
        self.read_back.collect(&self.meters).vertex_runs
    }

    /// A buffer that the stages wrote, for tests, by its name in the shaders; `None` where a technique has none of that
    /// name or is not set up. All can be copied from.
    pub fn buffer(&self, technique: Technique, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "choices" => Some(&self.frame.choices),
            "culled" => Some(&self.frame.culled),
            "sums" => Some(&self.frame.sums),
            "seen" | "tally" | "farthest" => self.occlusion.as_ref()?.buffer(name),
            "casters" => self.shadows.as_ref()?.buffer("sorted_keys"),
            "drawn_casters" => self.shadows.as_ref()?.buffer("drawn"),
            _ => self.painters[technique.number()].as_ref()?.buffer(name),
        }
    }
}
