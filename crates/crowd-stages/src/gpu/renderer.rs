//! The renderer: the stages in the paper's order, then the draw, recorded into an engine's encoder.

use super::draw_crowd::{DrawCrowd, Drawing};
use super::read_back::{ReadBack, StageClock};
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use super::{
    CullInstances, FitBudget, PlaceVertices, ReformTriangles, ScanCounts, SelectLod, SumWeights, WriteDrawArgs,
};
use crate::data::check_instances;
use crate::{
    Capacities, CrowdData, DrawConfig, Error, FrameConfig, FrameTotals, InstanceRecord, Result, Technique, overflow,
};
use crowd_pack::CharacterRecord;
use glam::Mat4;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Names of the stages in their order, as in [`CrowdRenderer::timings_ms`]; the draw follows as `draw`.
pub const STAGES: [&str; 8] = [
    "cull_instances",
    "sum_weights",
    "select_lod",
    "fit_budget",
    "scan_counts",
    "place_vertices",
    "reform_triangles",
    "write_draw_args",
];

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

impl RendererOptions {
    /// The same, with vertices and triangles lowered to what a device of these limits can bind: 33.5 million vertices and
    /// 11.1 million triangles where a binding may have 128 MiB.
    pub fn clamped_to(self, limits: &wgpu::Limits) -> Self {
        let words = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / 4;
        let words = u32::try_from(words).unwrap_or(u32::MAX);
        Self { max_vertices: self.max_vertices.min(words), max_triangles: self.max_triangles.min(words / 3), ..self }
    }
}

/// GPU buffers, textures and pipelines of one crowd.
pub struct CrowdRenderer {
    crowd: CrowdBuffers,
    frame: FrameBuffers,
    stages: Stages,
    draw: DrawCrowd,
    clock: Option<StageClock>,
    read_back: ReadBack,
    characters: Vec<CharacterRecord>,
    /// Of each instance's character at full detail, in the static index buffer.
    index_ranges: Vec<Range<u32>>,
    /// What drawing all instances at full detail comes to.
    full_detail_totals: FrameTotals,
    instance_count: u32,
    max_instances: u32,
    layer_side: u32,
    buffer_bytes: u64,
}

impl CrowdRenderer {
    /// Uploads the data and builds the pipelines.
    ///
    /// # Errors
    /// [`Error::Limit`] when a buffer or texture is larger than the device allows; nothing is clamped silently, see
    /// [`RendererOptions::clamped_to`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, data: &CrowdData, options: RendererOptions) -> Result<Self> {
        if !matches!(options.sample_count, 1 | 4) {
            return Err(Error::Limit {
                what: "samples a pixel",
                needed: options.sample_count.into(),
                allowed: 4,
                remedy: "use 1 or 4",
            });
        }
        let mut up = Uploader { device, queue, bytes: 0 };
        let crowd = CrowdBuffers::new(&mut up, data)?;
        let capacities = Capacities {
            vertex_count: options.max_vertices,
            triangle_count: options.max_triangles,
            ..Default::default()
        };
        let frame = FrameBuffers::new(&mut up, options.max_instances, capacities)?;
        Ok(Self {
            stages: Stages::new(device, &crowd, &frame),
            draw: DrawCrowd::new(device, &crowd, &frame, options.color_format, options.sample_count),
            clock: StageClock::new(device, queue, STAGES.len() as u32 + 1),
            read_back: ReadBack::default(),
            characters: data.characters.clone(),
            index_ranges: Vec::new(),
            full_detail_totals: FrameTotals::default(),
            instance_count: 0,
            max_instances: options.max_instances,
            layer_side: data.layer_side.max(1),
            buffer_bytes: up.bytes,
            crowd,
            frame,
        })
    }

    /// Replaces the instances.
    ///
    /// # Errors
    /// [`Error::Limit`] when there are more than `max_instances`, [`Error::Instance`] when one names a character or clip
    /// that is not there, [`Error::NotFinite`] when one has a number that is not finite. The instances stay as they were.
    pub fn set_instances(&mut self, queue: &wgpu::Queue, instances: &[InstanceRecord]) -> Result<()> {
        if instances.len() as u64 > u64::from(self.max_instances) {
            return Err(Error::Limit {
                what: "instances",
                needed: instances.len() as u64,
                allowed: self.max_instances.into(),
                remedy: "make the renderer with a larger max_instances",
            });
        }
        check_instances(&self.characters, instances)?;
        queue.write_buffer(&self.frame.instances, 0, bytemuck::cast_slice(instances));
        self.instance_count = instances.len() as u32;
        let characters = || instances.iter().map(|instance| &self.characters[instance.character as usize]);
        self.index_ranges =
            characters().map(|c| c.triangle_offset * 3..(c.triangle_offset + c.triangle_count) * 3).collect();
        let sum = |count: fn(&CharacterRecord) -> u32| characters().fold(0u32, |sum, c| sum.saturating_add(count(c)));
        self.full_detail_totals = FrameTotals {
            visible_count: self.instance_count,
            vertex_count: sum(|c| c.vertex_count),
            triangle_count: sum(|c| c.triangle_count),
            min_vertex_count: sum(|c| c.min_vertex_count),
            needed_vertices: sum(|c| c.vertex_count),
            needed_triangles: sum(|c| c.triangle_count),
            ..Default::default()
        };
        Ok(())
    }

    /// Records one frame: stages, then sky, ground and the crowd into `color` (a view of `color_format`; resolved
    /// from the renderer's own multisampled texture when `sample_count` is 4). Depth is the renderer's own.
    ///
    /// `config.instance_count` is ignored. Uniforms are written through the queue, so submit each frame before recording
    /// the next.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] when the depth and multisampled textures of a new `size` do not fit; drop the encoder then.
    pub fn encode(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        color: &wgpu::TextureView,
        size: (u32, u32),
        config: &FrameConfig,
        technique: Technique,
    ) -> Result<()> {
        self.draw.fit_targets(device, size)?;
        let config = FrameConfig { instance_count: self.instance_count, ..*config };
        let clip_from_world = Mat4::from_cols_array_2d(&config.clip_from_world);
        let draw_config = DrawConfig::new(&clip_from_world, size.0, size.1, self.layer_side);
        queue.write_buffer(&self.frame.config, 0, bytemuck::bytes_of(&config));
        queue.write_buffer(&self.frame.draw_config, 0, bytemuck::bytes_of(&draw_config));

        let mut names: Vec<&'static str> = Vec::new();
        let clock = self.clock.as_ref().map(|clock| &clock.queries);
        let (drawing, known_totals) = match technique {
            Technique::Reform => {
                self.stages.record(encoder, self.instance_count, clock);
                names.extend(STAGES);
                (Drawing::Reformed, None)
            }
            Technique::PseudoInstancing => (Drawing::FullDetail(&self.index_ranges), Some(self.known_totals(&config))),
        };
        let first = names.len() as u32;
        names.push("draw");
        let stamps = clock.map(|queries| (queries, first, first + 1));
        self.draw.record(encoder, color, &self.crowd, &self.frame, drawing, stamps);
        self.read_back.record(device, encoder, &self.frame.totals, known_totals, self.clock.as_ref(), names);
        Ok(())
    }

    fn known_totals(&self, config: &FrameConfig) -> FrameTotals {
        let totals = self.full_detail_totals;
        let exceeds = totals.min_vertex_count > config.budget;
        FrameTotals { overflow: if exceeds { overflow::BUDGET } else { 0 }, ..totals }
    }

    /// Totals of the newest finished frame, without waiting (`wait`: until the last submitted one is done).
    ///
    /// A frame that was recorded but never submitted is waited for a second, no longer.
    pub fn totals(&mut self, device: &wgpu::Device, wait: bool) -> Option<FrameTotals> {
        let poll = || if wait { wgpu::PollType::wait_indefinitely() } else { wgpu::PollType::Poll };
        // An error means a lost device: nothing new will arrive, and the engine hears of it in its own calls.
        let mut is_alive = device.poll(poll()).is_ok();
        // The work is done, but where another thread polls the same device, it may still be about to tell us.
        let patience = Instant::now() + Duration::from_secs(1);
        while wait && is_alive && self.read_back.is_under_way() && Instant::now() < patience {
            std::thread::sleep(Duration::from_micros(50));
            is_alive = device.poll(poll()).is_ok();
        }
        self.read_back.collect(self.clock.as_ref()).totals
    }

    /// GPU milliseconds per stage of the newest finished frame, where timestamps are offered. Measured from start to
    /// next start (end stamps of a pass come early on some drivers).
    pub fn timings_ms(&mut self) -> Vec<(&'static str, f32)> {
        self.read_back.collect(self.clock.as_ref()).timings_ms.clone()
    }

    /// Bytes of GPU memory this renderer asked for.
    pub fn gpu_bytes(&self) -> u64 {
        self.buffer_bytes + self.draw.target_bytes()
    }

    /// The buffers the stages wrote, for tests: choices, bases, vertex list, indices, draw arguments. All can be copied from.
    pub fn frame_buffers(&self) -> [&wgpu::Buffer; 5] {
        let frame = &self.frame;
        [&frame.choices, &frame.bases, &frame.slot_instances, &frame.indices, &frame.draw_args]
    }
}

/// The stages with their buffers bound.
struct Stages {
    cull_instances: (CullInstances, wgpu::BindGroup),
    sum_weights: (SumWeights, wgpu::BindGroup),
    select_lod: (SelectLod, wgpu::BindGroup),
    fit_budget: (FitBudget, wgpu::BindGroup),
    scan_counts: (ScanCounts, wgpu::BindGroup),
    place_vertices: (PlaceVertices, wgpu::BindGroup),
    reform_triangles: (ReformTriangles, wgpu::BindGroup),
    write_draw_args: (WriteDrawArgs, wgpu::BindGroup),
}

impl Stages {
    fn new(device: &wgpu::Device, c: &CrowdBuffers, f: &FrameBuffers) -> Self {
        let cull = CullInstances::new(device);
        let sum = SumWeights::new(device);
        let select = SelectLod::new(device);
        let fit = FitBudget::new(device);
        let scan = ScanCounts::new(device);
        let place = PlaceVertices::new(device);
        let reform = ReformTriangles::new(device);
        let write = WriteDrawArgs::new(device);
        let (config, capacities) = (&f.config, &f.capacities);

        let cull_bound = cull.bind(device, config, &f.instances, &c.characters, &c.clips, &f.culled);
        let sum_bound = sum.bind(device, config, &f.instances, &c.characters, &f.culled, &f.block_sums, &f.sums);
        let select_bound = select.bind(device, config, &f.instances, &c.characters, &f.culled, &f.sums, &f.wanted);
        let fit_bound = fit.bind(
            device,
            config,
            &f.instances,
            &c.characters,
            &c.lods,
            &f.wanted,
            &f.block_wanted,
            &f.sums,
            &f.choices,
        );
        let scan_bound = scan.bind(device, config, &f.choices, &f.block_totals, &f.bases, &f.counts);
        let place_bound = place.bind(device, config, capacities, &f.choices, &f.bases, &f.slot_instances);
        let reform_bound = reform.bind(
            device,
            config,
            capacities,
            &f.instances,
            &c.characters,
            &c.triangles,
            &c.collapse_map,
            &f.choices,
            &f.bases,
            &f.indices,
        );
        let write_bound =
            write.bind(device, config, capacities, &f.sums, &f.choices, &f.bases, &f.counts, &f.draw_args, &f.totals);
        Self {
            cull_instances: (cull, cull_bound),
            sum_weights: (sum, sum_bound),
            select_lod: (select, select_bound),
            fit_budget: (fit, fit_bound),
            scan_counts: (scan, scan_bound),
            place_vertices: (place, place_bound),
            reform_triangles: (reform, reform_bound),
            write_draw_args: (write, write_bound),
        }
    }

    /// One pass a stage, each with a time stamp at its start.
    fn record(&self, encoder: &mut wgpu::CommandEncoder, count: u32, clock: Option<&wgpu::QuerySet>) {
        let mut stage = |number: usize, dispatch: &dyn Fn(&mut wgpu::ComputePass<'_>)| {
            let timestamp_writes = clock.map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(number as u32),
                end_of_pass_write_index: None,
            });
            let label = Some(STAGES[number]);
            dispatch(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes }));
        };
        stage(0, &|pass| self.cull_instances.0.record(pass, &self.cull_instances.1, count));
        stage(1, &|pass| self.sum_weights.0.record(pass, &self.sum_weights.1, count));
        stage(2, &|pass| self.select_lod.0.record(pass, &self.select_lod.1, count));
        stage(3, &|pass| self.fit_budget.0.record(pass, &self.fit_budget.1, count));
        stage(4, &|pass| self.scan_counts.0.record(pass, &self.scan_counts.1, count));
        stage(5, &|pass| self.place_vertices.0.record(pass, &self.place_vertices.1, count));
        stage(6, &|pass| self.reform_triangles.0.record(pass, &self.reform_triangles.1, count));
        stage(7, &|pass| self.write_draw_args.0.record(pass, &self.write_draw_args.1));
    }
}
