//! Polling a device that may be lost: an error, where wgpu panics.

use crate::{Error, Result};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// How wgpu's own panic begins where polling fails.
const POLL_PANIC: &str = "Error in Device::poll";

/// Polls the device, or waits for it. wgpu panics where it finds the device lost, and has no call that returns an error instead: that panic
/// ends here (the process's panic hook has heard of it); panics of callbacks go on.
///
/// # Errors
/// [`Error::DeviceLost`] when nothing more will come from this device.
pub fn poll_device(device: &wgpu::Device, poll_type: wgpu::PollType) -> Result<wgpu::PollStatus> {
    match catch_unwind(AssertUnwindSafe(|| device.poll(poll_type))) {
        Ok(Ok(status)) => Ok(status),
        Ok(Err(error)) => Err(Error::DeviceLost(error.to_string())),
        Err(payload) => match payload.downcast_ref::<String>() {
            Some(words) if words.starts_with(POLL_PANIC) => {
                let cause = words.lines().map(str::trim).rfind(|line| !line.is_empty());
                Err(Error::DeviceLost(cause.unwrap_or(words).to_owned()))
            }
            _ => resume_unwind(payload),
        },
    }
}
