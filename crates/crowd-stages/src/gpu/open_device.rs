//! A device for headless work.

use crate::{Error, Result};

/// Picks an adapter and opens a device for headless work. `WGPU_BACKEND` overrides the backend.
///
/// Returns device, queue and the adapter's description. Asks for wgpu's default limits, with the sizes of buffers and textures
/// raised to what the adapter has, and for timestamps where they are offered.
///
/// # Errors
/// [`Error::NoAdapter`] when there is no Vulkan, Metal or DirectX 12 adapter (OpenGL only on request through `WGPU_BACKEND`).
pub fn open_device() -> Result<(wgpu::Device, wgpu::Queue, wgpu::AdapterInfo)> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = wgpu::Backends::PRIMARY.with_env();
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        force_fallback_adapter: false,
        compatible_surface: None,
        apply_limit_buckets: false,
    }))
    .map_err(|error| Error::NoAdapter(error.to_string()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("crowd"),
        required_features: wanted_features() & adapter.features(),
        required_limits: wanted_limits(&adapter.limits()),
        experimental_features: wgpu::ExperimentalFeatures::disabled(),
        memory_hints: wgpu::MemoryHints::Performance,
        trace: wgpu::Trace::Off,
    }))
    .map_err(|error| Error::NoAdapter(error.to_string()))?;
    Ok((device, queue, adapter.get_info()))
}

/// What the renderer uses where it is there. The bucketed technique needs `INDIRECT_FIRST_INSTANCE`, nothing needs the others.
pub fn wanted_features() -> wgpu::Features {
    wgpu::Features::TIMESTAMP_QUERY
        | wgpu::Features::PIPELINE_STATISTICS_QUERY
        | wgpu::Features::INDIRECT_FIRST_INSTANCE
        | wgpu::Features::MULTI_DRAW_INDIRECT_COUNT
}

/// wgpu's default limits with the adapter's sizes: eight storage buffers a stage are enough, 128 MiB a buffer may not be.
///
/// Their storage textures a stage are used on software Vulkan, where frames of clips are fetched faster that way; a device of an engine's own that allows
/// none fetches them as cards do.
pub fn wanted_limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        max_buffer_size: adapter.max_buffer_size,
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_texture_array_layers: adapter.max_texture_array_layers,
        ..wgpu::Limits::default()
    }
}
