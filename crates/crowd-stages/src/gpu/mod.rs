//! The dispatches, and a renderer that records them into an engine's command encoder.

use crate::{CrowdData, FrameConfig, FrameTotals, InstanceRecord, Result, Technique};

/// Picks an adapter and opens a device for headless work. `WGPU_BACKEND` overrides the backend.
///
/// Returns device, queue and the adapter's description.
pub fn open_device() -> Result<(wgpu::Device, wgpu::Queue, wgpu::AdapterInfo)> {
    unimplemented!("crowd-stages: being written")
}

/// Sizes and formats fixed for a renderer's life.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RendererOptions {
    /// Instances it can hold.
    pub max_instances: u32,
    /// Vertices a frame it can hold: the largest N.
    pub max_vertices: u32,
    /// Triangles a frame it can hold.
    pub max_triangles: u32,
    /// Colour target; sRGB formats are expected.
    pub color_format: wgpu::TextureFormat,
    /// 1 or 4 samples a pixel.
    pub sample_count: u32,
}

/// GPU buffers, textures and pipelines of one crowd.
pub struct CrowdRenderer {
    _private: (),
}

impl CrowdRenderer {
    /// Uploads the data and builds the pipelines.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, data: &CrowdData, options: RendererOptions) -> Result<Self> {
        let _ = (device, queue, data, options);
        unimplemented!("crowd-stages: being written")
    }

    /// Replaces the instances.
    pub fn set_instances(&mut self, queue: &wgpu::Queue, instances: &[InstanceRecord]) -> Result<()> {
        let _ = (queue, instances);
        unimplemented!("crowd-stages: being written")
    }

    /// Records one frame: stages, then sky, ground and the crowd into `color` (a view of `color_format`; resolved
    /// from the renderer's own multisampled texture when `sample_count` is 4). Depth is the renderer's own.
    pub fn encode(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        color: &wgpu::TextureView,
        size: (u32, u32),
        config: &FrameConfig,
        technique: Technique,
    ) {
        let _ = (device, queue, encoder, color, size, config, technique);
        unimplemented!("crowd-stages: being written")
    }

    /// Totals of the newest finished frame, without waiting (`wait`: until the last submitted one is done).
    pub fn totals(&mut self, device: &wgpu::Device, wait: bool) -> Option<FrameTotals> {
        let _ = (device, wait);
        unimplemented!("crowd-stages: being written")
    }

    /// GPU milliseconds per stage of the newest finished frame, where timestamps are offered. Measured from start to
    /// next start (end stamps of a pass come early on some drivers).
    pub fn timings_ms(&mut self) -> Vec<(&'static str, f32)> {
        unimplemented!("crowd-stages: being written")
    }

    /// Bytes of GPU memory this renderer asked for.
    pub fn gpu_bytes(&self) -> u64 {
        unimplemented!("crowd-stages: being written")
    }
}
