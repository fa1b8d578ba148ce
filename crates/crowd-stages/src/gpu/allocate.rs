//! Buffers and textures that may be larger than the device's memory: an error, where wgpu alone would panic.

use crate::{Error, Result};

/// Makes a buffer. `what` and `remedy` go into the error.
///
/// # Errors
/// [`Error::OutOfMemory`] when the device has no memory for it.
pub fn buffer_or_error(
    device: &wgpu::Device,
    what: &'static str,
    remedy: &'static str,
    descriptor: &wgpu::BufferDescriptor<'_>,
) -> Result<wgpu::Buffer> {
    within_memory(device, what, descriptor.size, remedy, || device.create_buffer(descriptor))
}

/// Makes a texture of `bytes`. `what`, `bytes` and `remedy` go into the error.
///
/// # Errors
/// [`Error::OutOfMemory`] when the device has no memory for it.
pub fn texture_or_error(
    device: &wgpu::Device,
    what: &'static str,
    bytes: u64,
    remedy: &'static str,
    descriptor: &wgpu::TextureDescriptor<'_>,
) -> Result<wgpu::Texture> {
    within_memory(device, what, bytes, remedy, || device.create_texture(descriptor))
}

fn within_memory<T>(
    device: &wgpu::Device,
    what: &'static str,
    bytes: u64,
    remedy: &'static str,
    make: impl FnOnce() -> T,
) -> Result<T> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let made = make();
    match pollster::block_on(scope.pop()) {
        None => Ok(made),
        Some(_) => Err(Error::OutOfMemory { what, bytes, remedy }),
    }
}
