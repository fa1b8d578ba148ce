//! Finding an adapter and opening a device.

use crate::cli::BackendWord;
use crate::loss::Loss;
use crate::plan::MachinePlan;
use crate::stats::Adapter;
use crate::{Error, Result};
use crowd_stages::gpu::poll_device;
use std::time::{Duration, Instant};

/// An open device.
#[derive(Debug, Clone)]
pub struct Gpu {
    /// Where it came from; a window asks it for surface formats.
    pub adapter: wgpu::Adapter,
    /// Device.
    pub device: wgpu::Device,
    /// Queue.
    pub queue: wgpu::Queue,
    /// The adapter, described.
    pub info: wgpu::AdapterInfo,
    /// Whether the device is lost.
    pub loss: Loss,
}

/// What is left of a lost device is not put away: drivers and wgpu expect it to be idle then, and panic.
impl Drop for Gpu {
    fn drop(&mut self) {
        if self.loss.is_lost() {
            self.let_finish();
            std::mem::forget((self.device.clone(), self.queue.clone()));
        }
    }
}

impl Gpu {
    /// Whether a processor plays the GPU's part (lavapipe, WARP).
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Waits for what a lost device still works on: drivers in software have threads for that, and a process that ends under them crashes. Where the
    /// driver does not know, nothing is waited for.
    pub fn let_finish(&self) {
        let since = Instant::now();
        while since.elapsed() < Duration::from_secs(10)
            && poll_device(&self.device, wgpu::PollType::Poll).is_ok_and(|status| !status.is_queue_empty())
        {
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// What draws, in a line.
    pub fn line(&self) -> String {
        let software = if self.is_software() { ", software" } else { "" };
        format!("adapter: {} ({:?}{software})", self.info.name, self.info.backend)
    }

    /// For the report.
    pub fn describe(&self) -> Adapter {
        describe(&self.info)
    }
}

/// Backends in the order in which they are tried: OpenGL only where there is nothing else.
pub const BACKENDS: [wgpu::Backends; 2] = [wgpu::Backends::PRIMARY, wgpu::Backends::GL];

/// An instance for pictures without a window. `WGPU_BACKEND` overrides the backends.
pub fn headless_instance(backends: wgpu::Backends) -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends.with_env();
    wgpu::Instance::new(descriptor)
}

/// Adapters in the order in which they are preferred: graphics cards first, processors last.
pub fn list_adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| preference(&adapter.get_info()));
    adapters
}

/// Opens a device for pictures without a window. OpenGL in software is passed over unless a GPU is asked for: our own
/// rasteriser is many times faster (0.03 s against 14 s for the first picture of fifty people on two cores). The error then says what
/// would take it.
///
/// # Errors
/// As [`open`].
pub fn open_headless(plan: &MachinePlan) -> Result<Gpu> {
    let [first, last] = BACKENDS.map(|backends| move || open(&headless_instance(backends), plan, None));
    let asked_for = plan.backend == BackendWord::Gpu || plan.adapter.is_some();
    first().or_else(|error| match last() {
        Ok(gpu) if asked_for || !gpu.is_software() => Ok(gpu),
        Ok(gpu) => Err(passed_over(&gpu.info.name)),
        Err(_) => Err(error),
    })
}

/// There is OpenGL in software, and nobody asked for it.
fn passed_over(name: &str) -> Error {
    Error::Machine {
        what: format!(
            "no GPU but OpenGL in software ({name}), which is passed over as slower than the CPU's own rasteriser"
        ),
        remedy: "install a Vulkan driver (on Debian: mesa-vulkan-drivers), or take OpenGL with --backend gpu",
    }
}

fn preference(info: &wgpu::AdapterInfo) -> (u32, bool, String) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (kind, info.backend == wgpu::Backend::Gl, info.name.clone())
}

/// For the report.
pub fn describe(info: &wgpu::AdapterInfo) -> Adapter {
    Adapter {
        name: info.name.clone(),
        backend: format!("{:?}", info.backend),
        driver: info.driver.clone(),
        driver_version: info.driver_info.clone(),
        device_type: format!("{:?}", info.device_type),
    }
}

/// Opens the adapter whose name contains the plan's, or the best one that can draw to `surface`.
///
/// # Errors
/// [`Error::Machine`] when there is none, or it gives no device.
pub fn open(instance: &wgpu::Instance, plan: &MachinePlan, surface: Option<&wgpu::Surface<'_>>) -> Result<Gpu> {
    const REMEDY: &str = "install a Vulkan driver (on Debian: mesa-vulkan-drivers) or use --headless --backend cpu";
    let all = list_adapters(instance);
    let names: Vec<String> = all.iter().map(|a| a.get_info().name).collect();
    let fits = |adapter: &wgpu::Adapter| {
        let name_fits = plan
            .adapter
            .as_deref()
            .is_none_or(|part| adapter.get_info().name.to_lowercase().contains(&part.to_lowercase()));
        name_fits && surface.is_none_or(|surface| adapter.is_surface_supported(surface))
    };
    let adapter = all.into_iter().find(fits).ok_or_else(|| Error::Machine {
        what: match &plan.adapter {
            Some(part) => format!("--adapter: found none with {part:?} in its name among [{}]", names.join(", ")),
            None if names.is_empty() => "no GPU: no adapter was found".to_owned(),
            None => format!("no GPU that can draw to this window among [{}]", names.join(", ")),
        },
        remedy: REMEDY,
    })?;
    let info = adapter.get_info();
    let request = adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("crowdplay"),
        required_features: crowd_stages::gpu::wanted_features() & adapter.features(),
        required_limits: adapter.limits(),
        experimental_features: wgpu::ExperimentalFeatures::disabled(),
        memory_hints: wgpu::MemoryHints::Performance,
        trace: wgpu::Trace::Off,
    });
    let (device, queue) = pollster::block_on(request)
        .map_err(|e| Error::Machine { what: format!("{}: no device: {e}", info.name), remedy: REMEDY })?;
    let loss = Loss::watch(&device, format!("{} ({:?})", info.name, info.backend));
    Ok(Gpu { adapter, device, queue, info, loss })
}
