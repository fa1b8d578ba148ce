//! Which of the two draws: a GPU where there is one, else the software rasteriser, said aloud.

use crate::cli::BackendWord;
use crate::cpu_backend::CpuBackend;
use crate::crowd::Crowd;
use crate::gpu_backend::GpuBackend;
use crate::gpu_device::{self, Gpu};
use crate::memory::Parts;
use crate::picture::Picture;
use crate::plan::{DetailPlan, GPU_BUDGET, LARGEST_USUAL_BUDGET, MachinePlan, SOFTWARE_BUDGET, Simulator};
use crate::stats::Adapter;
use crate::{Error, Result, Talk};
use crowd_stages::dispatch::DOT_VERTICES;
use crowd_stages::gpu::SkinningChoice;
use crowd_stages::{BudgetIn, DrawOptions, FrameConfig, FrameTotals, Technique, Weight};
use std::time::Instant;

/// What draws the frames of a headless run.
pub enum Backend {
    /// A GPU, or software that plays one.
    Gpu(Box<GpuBackend>),
    /// The software rasteriser.
    Cpu(Box<CpuBackend>),
}

/// Opens a GPU if the plan wants one and there is one. `None`: draw on the CPU.
///
/// # Errors
/// [`crate::Error::Machine`] when `--backend gpu` or `--adapter` asks for a GPU and there is none.
pub fn find_gpu(plan: &MachinePlan, talk: &mut Talk<'_>) -> Result<Option<Gpu>> {
    if plan.backend == BackendWord::Cpu {
        return Ok(None);
    }
    match gpu_device::open_headless(plan) {
        Ok(gpu) => {
            talk.say(&gpu.line());
            Ok(Some(gpu))
        }
        Err(error) if plan.backend == BackendWord::Auto && plan.adapter.is_none() => {
            talk.say(&format!("{error}"));
            talk.say("drawing on the CPU instead (as with --backend cpu)");
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// The budget when the user gave none: the coarsest levels of the whole crowd, which are drawn whatever the budget, and
/// as much more as the machine draws swiftly; with nothing to spare the near ones would be as coarse as the far ones. Where far
/// ones may be dots, one dot each and as much more again.
pub fn usual_budget(gpu: Option<&Gpu>, crowd: &Crowd, detail: &DetailPlan) -> u32 {
    let swift = if gpu.is_some_and(|gpu| !gpu.is_software()) { GPU_BUDGET } else { SOFTWARE_BUDGET };
    let least = u32::try_from(crowd.summary.vertices_least).unwrap_or(u32::MAX);
    let has_dots = gpu.is_some() && detail.dots_px > 0.0 && detail.draw.has_dots() && detail.weight != Weight::Error;
    let dotted = crowd.summary.instances.saturating_mul(DOT_VERTICES).saturating_add(swift);
    let least = if has_dots { least.min(dotted) } else { least };
    let vertices = least.saturating_add(swift).min(least.max(LARGEST_USUAL_BUDGET));
    if detail.budget_in == BudgetIn::Vertices {
        return vertices;
    }
    // As many triangles as so many vertices of full detail have.
    let share = crowd.summary.triangles_full as f64 / crowd.summary.vertices_full.max(1) as f64;
    (f64::from(vertices) * share) as u32
}

/// The largest budget that makes sense: everyone at full detail, within what a frame's buffers hold.
pub fn largest_budget(crowd: &Crowd, budget_in: BudgetIn) -> u32 {
    let full = match budget_in {
        BudgetIn::Vertices => crowd.summary.vertices_full,
        BudgetIn::Triangles => crowd.summary.triangles_full,
    };
    u32::try_from(full).unwrap_or(u32::MAX).min(LARGEST_USUAL_BUDGET)
}

/// The plan's level of detail; reformation instead of the usual technique where the adapter cannot do that.
pub fn settle_technique(detail: &DetailPlan, gpu: Option<&Gpu>, talk: &mut Talk<'_>) -> DetailPlan {
    let mut settled = *detail;
    let technique = detail.draw.technique;
    let lacks = gpu.is_some_and(|gpu| !crowd_stages::gpu::supports(&gpu.device, technique));
    if lacks && !detail.technique_is_given {
        settled.draw.technique = Technique::Reform;
        talk.say(&format!("this adapter cannot draw {technique}; drawing {} instead", Technique::Reform));
    }
    settled
}

impl Backend {
    /// Sets up drawing.
    pub fn new(gpu: Option<Gpu>, crowd: &Crowd, size: [u32; 2], samples: u32, budget: (u32, BudgetIn)) -> Result<Self> {
        Ok(match gpu {
            Some(gpu) => Self::Gpu(Box::new(GpuBackend::new(gpu, crowd, size, samples, budget)?)),
            None if crowd.simulator == Simulator::Gpu => {
                return Err(Error::Machine {
                    what: "--simulate gpu needs a GPU, and there is none".to_owned(),
                    remedy: "use --simulate auto",
                });
            }
            None => Self::Cpu(Box::new(CpuBackend::new(crowd, size, samples)?)),
        })
    }

    /// Shows the crowd at a time; milliseconds that simulating and sending it took, where it moves.
    pub fn show_time(&mut self, crowd: &mut Crowd, time_s: f32) -> Result<Option<f32>> {
        let start = Instant::now();
        let moves = crowd.moving.is_some();
        match self {
            Self::Gpu(gpu) => gpu.show_time(crowd, time_s)?,
            Self::Cpu(_) => {
                crowd.advance(time_s);
            }
        }
        Ok(moves.then(|| start.elapsed().as_secs_f32() * 1e3))
    }

    /// Who simulates the crowd's flock, `gpu` or `cpu`; `None` where it is none.
    pub fn simulator(&self, crowd: &Crowd) -> Option<&'static str> {
        crowd.moving.as_ref()?.flock()?;
        match self {
            Self::Gpu(gpu) if gpu.simulates() => Some("gpu"),
            _ => Some("cpu"),
        }
    }

    /// Whether it takes what people play from the CPU's instances, not from the GPU's.
    pub fn poses_on_cpu(&self, options: DrawOptions) -> bool {
        matches!(self, Self::Cpu(_)) || options.technique == Technique::StaticFloor
    }

    /// What has to be done before a frame and is no part of its time.
    pub fn bake(&mut self, crowd: &Crowd, config: &FrameConfig, options: DrawOptions) -> Result<()> {
        match self {
            Self::Gpu(gpu) => gpu.bake(crowd, config, options),
            Self::Cpu(_) => Ok(()),
        }
    }

    /// Draws a frame and waits for it. `watch`: see [`CpuBackend::draw`].
    pub fn draw(
        &mut self,
        crowd: &Crowd,
        config: &FrameConfig,
        options: DrawOptions,
        watch: &mut dyn FnMut(f64),
    ) -> Result<FrameTotals> {
        match self {
            Self::Gpu(gpu) => gpu.draw(config, options),
            Self::Cpu(cpu) => Ok(cpu.draw(crowd, config, options, watch)),
        }
    }

    /// The newest frame's pixels.
    pub fn picture(&self) -> Result<Picture> {
        match self {
            Self::Gpu(gpu) => gpu.picture(),
            Self::Cpu(cpu) => Ok(cpu.picture()),
        }
    }

    /// What another camera sees of the newest frame, see [`GpuBackend::reference_picture`]; `None` on the CPU.
    pub fn reference_picture(&mut self, configs: [&FrameConfig; 2], options: DrawOptions) -> Result<Option<Picture>> {
        match self {
            Self::Gpu(gpu) => gpu.reference_picture(configs, options).map(Some),
            Self::Cpu(_) => Ok(None),
        }
    }

    /// Milliseconds by stage of the newest frame, where offered.
    pub fn timings_ms(&mut self) -> Vec<(&'static str, f32)> {
        match self {
            Self::Gpu(gpu) => gpu.timings_ms(),
            Self::Cpu(cpu) => cpu.timings_ms(),
        }
    }

    /// Where a GPU works out vertices, and why there; `None` on the CPU and for techniques that have one way.
    pub fn skinning(&self, options: DrawOptions) -> Option<SkinningChoice> {
        match self {
            Self::Gpu(gpu) if options.technique == Technique::Bucketed => Some(gpu.skinning(options)),
            _ => None,
        }
    }

    /// Bytes of GPU memory by what they are for; none without a GPU.
    pub fn memory(&self) -> Parts {
        match self {
            Self::Gpu(gpu) => gpu.memory(),
            Self::Cpu(_) => Parts::new(),
        }
    }

    /// Makes room for as much as fits, see [`GpuBackend::fit_memory`]: that budget; `None` on the CPU, which takes none.
    pub fn fit_memory(
        &mut self,
        crowd: &Crowd,
        detail: &DetailPlan,
        limit_bytes: u64,
        has_reference: bool,
        budget: Option<u32>,
    ) -> Result<Option<u32>> {
        let draws = (vec![detail.draw], has_reference);
        match self {
            Self::Gpu(gpu) => gpu.fit_memory(crowd, detail, limit_bytes, draws, budget).map(Some),
            Self::Cpu(_) => Ok(None),
        }
    }

    /// See [`GpuBackend::room_remark`].
    pub fn room_remark(&self) -> Option<&str> {
        match self {
            Self::Gpu(gpu) => gpu.room_remark(),
            Self::Cpu(_) => None,
        }
    }

    /// `gpu` or `cpu`, as in the report.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Gpu(_) => "gpu",
            Self::Cpu(_) => "cpu",
        }
    }

    /// What draws, for the report.
    pub fn describe(&self) -> Adapter {
        match self {
            Self::Gpu(gpu) => gpu.gpu().describe(),
            Self::Cpu(_) => cpu_adapter(),
        }
    }
}

/// The software rasteriser, for the report.
pub fn cpu_adapter() -> Adapter {
    Adapter {
        name: "crowd-raster".to_owned(),
        backend: "cpu".to_owned(),
        driver: "crowd-raster".to_owned(),
        driver_version: env!("CARGO_PKG_VERSION").to_owned(),
        device_type: "Cpu".to_owned(),
    }
}
