//! The renderer: the shared selection, what the technique adds, then the draw, recorded into an engine's encoder.

mod borrow;
mod into;
mod memory;
mod options;
mod prepare;
mod readings;
mod reference;

use super::HoldPoses;
use super::draw_crowd::{DrawCrowd, Part};
use super::draw_marks::DrawMarks;
use super::draw_scenery::DrawScenery;
use super::feed::BoundFeed;
use super::kernel::is_software;
use super::memory_use::MemoryUse;
use super::occlusion::Occlusion;
use super::play_motion::{Motion, MotionPlan, check_motion};
use super::read_back::{self, Meters, ReadBack, RunCounter, StageClock};
use super::selection::Selection;
use super::shadows::{Light, STAMPS_A_CASCADE, Shadows};
use super::skinning_trial::SkinningTrial;
use super::stage_recorder::StageRecorder;
use super::targets::{Attachments, DepthWay, Targets, check_color_format};
use super::techniques::{self, Floor, FrameContext, Painter, Workshop};
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::data::check_instances;
use crate::dispatch::MAX_CASCADES;
use crate::{
    BudgetIn, CrowdBounds, CrowdData, DrawConfig, DrawOptions, Error, Fit, FrameConfig, FrameTotals, InstanceRecord,
    Result, SceneryVertex, Skinning, Technique, View, Weight, fit_cascades, shadow_side,
};
use crowd_pack::CharacterRecord;
use glam::Mat4;

pub use options::{RendererOptions, most_instances};

/// Names of all stages, as in [`CrowdRenderer::timings_ms`]: the shared ones in their order, then those of the techniques.
/// The draw is called `draw`.
pub const STAGES: [&str; 35] = [
    "admit_instances",
    "play_motion",
    "hold_poses",
    "cull_instances",
    "sum_weights",
    "fill_budget",
    "select_lod",
    "fit_budget",
    "scan_counts",
    "place_vertices",
    "reform_triangles",
    "write_draw_args",
    "key_instances",
    "key_poses",
    "sort_instances",
    "sort_at_once",
    "find_leaders",
    "write_bucket_args",
    "share_poses",
    "place_buckets",
    "gather_drawn",
    "blend_palettes",
    "skin_vertices",
    "cull_by_depth",
    "key_points",
    "recall_seen",
    "build_pyramid",
    "test_occlusion",
    "join_phases",
    "select_casters",
    "lend_vertices",
    "cell_boids",
    "fill_cells",
    "steer_boids",
    "place_boids",
];

/// Stages and draws of a frame, those that run twice counted twice.
const MOST_STAMPED: u32 = 2 * STAGES.len() as u32 + 2 + MAX_CASCADES * STAMPS_A_CASCADE;

/// Where a frame is drawn.
enum Onto<'a> {
    /// A colour view of that size, with the renderer's own depth.
    Own(&'a wgpu::TextureView, (u32, u32)),
    /// An engine's targets.
    Host(&'a Targets<'a>),
}

/// GPU buffers, textures and pipelines of one crowd; draws with any technique, each set up when it is first asked for.
pub struct CrowdRenderer {
    crowd: CrowdBuffers,
    frame: FrameBuffers,
    selection: Selection,
    scenery: Option<DrawScenery>,
    /// Set up when it is first asked for.
    occlusion: Option<Occlusion>,
    /// The same.
    shadows: Option<Shadows>,
    /// The same.
    marks: Option<DrawMarks>,
    /// Schedules of the instances, where they go by any.
    motion: Option<Motion>,
    /// Set up when poses are first held.
    hold: Option<(HoldPoses, wgpu::BindGroup)>,
    /// The instances may have poses that are held.
    holds: bool,
    /// Without shadows.
    unshaded: Light,
    bounds: CrowdBounds,
    draw: DrawCrowd,
    painters: [Option<Box<dyn Painter>>; Technique::ALL.len()],
    /// Whether a technique's buffers hold a whole frame of the present instances, to be drawn again frozen.
    holds_frame: [bool; Technique::ALL.len()],
    meters: Meters,
    read_back: ReadBack,
    trial: SkinningTrial,
    options: RendererOptions,
    characters: Vec<CharacterRecord>,
    /// Character of each instance; none where a simulator has them and does not say.
    instance_characters: Vec<u32>,
    /// Instances of a frame, of a simulator the most.
    instance_count: u32,
    /// A simulator's instances.
    feed: Option<BoundFeed>,
    /// What drawing all instances at full detail comes to.
    full_detail_totals: FrameTotals,
    layer_side: u32,
    /// What was asked for so far, but for what [`Self::memory`] adds.
    memory: MemoryUse,
    /// Bytes that the device binds at most.
    largest_binding: u64,
    is_software: bool,
}

impl CrowdRenderer {
    /// Uploads the data and compiles the shared stages.
    ///
    /// # Errors
    /// [`Error::Limit`] when a buffer or texture is larger than the device allows; nothing is clamped silently.
    /// [`Error::Target`] for a depth format that is none, of 16 bits, or that the device lacks. [`Error::Tables`] when a character has
    /// no levels with index tables.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, data: &CrowdData, options: RendererOptions) -> Result<Self> {
        if !matches!(options.sample_count, 1 | 4) {
            return Err(Error::Limit {
                what: "samples a pixel",
                needed: options.sample_count.into(),
                allowed: 4,
                remedy: "use 1 or 4",
            });
        }
        check_color_format(options.color_format, device)?;
        DepthWay::of(&options).check(device)?;
        let mut up = Uploader { device, queue, bytes: 0 };
        let crowd = CrowdBuffers::new(&mut up, data)?;
        let character_bytes = up.bytes - crowd.animation_bytes - crowd.layer_bytes - crowd.impostor_bytes;
        let mut memory = MemoryUse {
            characters: character_bytes,
            animation: crowd.animation_bytes,
            images: crowd.layer_bytes,
            impostors: crowd.impostor_bytes,
            ..MemoryUse::default()
        };
        let before = up.bytes;
        let frame = FrameBuffers::new(&mut up, options.max_instances)?;
        memory.instances = up.bytes - before;
        let draw = DrawCrowd::new(device, &frame, crowd.joint_storages, &options);
        Ok(Self {
            selection: Selection::new(device, &crowd, &frame),
            unshaded: Light::new(device, draw.light_layout(), 1, 1)?,
            shadows: None,
            marks: None,
            motion: None,
            hold: None,
            holds: false,
            bounds: CrowdBounds::default(),
            draw,
            scenery: None,
            occlusion: None,
            painters: Default::default(),
            holds_frame: Default::default(),
            meters: Meters { clock: StageClock::new(device, queue, MOST_STAMPED), runs: RunCounter::new(device) },
            read_back: ReadBack::default(),
            trial: SkinningTrial::default(),
            options,
            characters: data.characters.clone(),
            instance_characters: Vec::new(),
            instance_count: 0,
            feed: None,
            full_detail_totals: FrameTotals::default(),
            layer_side: data.layer_side.max(1),
            memory,
            largest_binding: device.limits().max_storage_buffer_binding_size,
            is_software: is_software(device),
            crowd,
            frame,
        })
    }

    /// Sets a technique up, unless it is: its buffers and stages. [`Self::encode`] does so itself; beforehand it shows
    /// early what does not fit. What draws is compiled by the first frame without shadows and by the first with them.
    ///
    /// # Errors
    /// [`Error::Limit`] when one of its buffers is larger than the device allows (see [`RendererOptions::clamped_to`]),
    /// [`Error::Feature`] when the device lacks what it needs.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, technique: Technique) -> Result<()> {
        if self.painters[technique.number()].is_some() {
            return Ok(());
        }
        let mut up = Uploader { device, queue, bytes: 0 };
        let Self { crowd, frame, draw, options, .. } = &*self;
        let painter = techniques::set_up(technique, Workshop { up: &mut up, crowd, frame, draw, options })?;
        self.painters[technique.number()] = Some(painter);
        self.memory.techniques += up.bytes;
        Ok(())
    }

    /// Sets what stands still around the crowd: triangles of one colour a corner, lit like the crowd, counterclockwise seen
    /// from the side that is drawn. Replaces what was there; no triangles, no scenery.
    ///
    /// # Errors
    /// [`Error::Instance`] for a triangle whose corner is not there, [`Error::Limit`] or [`Error::OutOfMemory`] where it does
    /// not fit the device.
    pub fn set_scenery(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        vertices: &[SceneryVertex],
        triangles: &[[u32; 3]],
    ) -> Result<()> {
        self.scenery = None;
        self.memory.scenery = 0;
        if triangles.is_empty() {
            return Ok(());
        }
        let mut up = Uploader { device, queue, bytes: 0 };
        let (config, light) = (&self.frame.config, self.draw.light_layout());
        let scenery = DrawScenery::new(&mut up, config, vertices, triangles, &self.options, light)?;
        self.scenery = Some(scenery);
        self.memory.scenery = up.bytes;
        Ok(())
    }

    /// Replaces the instances.
    ///
    /// # Errors
    /// [`Error::Limit`] when there are more than `max_instances`, [`Error::Instance`] when one names a character or clip
    /// that is not there, [`Error::NotFinite`] when one has a number that is not finite. The instances stay as they were.
    pub fn set_instances(&mut self, queue: &wgpu::Queue, instances: &[InstanceRecord]) -> Result<()> {
        if instances.len() as u64 > u64::from(self.options.max_instances) {
            return Err(Error::Limit {
                what: "instances",
                needed: instances.len() as u64,
                allowed: self.options.max_instances.into(),
                remedy: "make the renderer with a larger max_instances",
            });
        }
        check_instances(&self.characters, instances)?;
        queue.write_buffer(&self.frame.instances, 0, bytemuck::cast_slice(instances));
        self.bounds = CrowdBounds::default();
        self.trial.note_fades(instances.iter().any(|instance| instance.leaving_share > 0.0));
        for instance in instances {
            let [x, y, z, radius] = self.characters[instance.character as usize].sphere;
            let reach = (glam::Vec3::new(x, y, z).length() + radius) * instance.scale.abs();
            self.bounds.add(instance.position.into(), reach);
        }
        self.return_instances(queue);
        self.note_instances(instances.len() as u32, instances.iter().map(|instance| instance.character).collect());
        Ok(())
    }

    /// Takes note of who the instances are.
    fn note_instances(&mut self, count: u32, characters: Vec<u32>) {
        if count != self.instance_count || characters != self.instance_characters {
            self.holds_frame = Default::default();
            // Its clips were those of others.
            self.end_motion();
        }
        (self.instance_count, self.instance_characters) = (count, characters);
        let sum = |count: fn(&CharacterRecord) -> u32| {
            let all = self.instance_characters.iter().map(|character| &self.characters[*character as usize]);
            all.fold(0u32, |sum, c| sum.saturating_add(count(c)))
        };
        self.full_detail_totals = FrameTotals {
            visible_count: count,
            vertex_count: sum(|c| c.vertex_count),
            triangle_count: sum(|c| c.triangle_count),
            min_vertex_count: sum(|c| c.min_vertex_count),
            needed_vertices: sum(|c| c.vertex_count),
            needed_triangles: sum(|c| c.triangle_count),
            draw_count: count,
            ..Default::default()
        };
    }

    /// Lets the present instances go by schedules: from now on the stage `play_motion` writes, at the time of each frame, which clip
    /// they play, which they leave and where they are in both. `None`: they stay at what their records say by then; set those anew.
    /// It ends where others take their place: another number of them, other characters, a simulator's.
    ///
    /// # Errors
    /// [`Error::Limit`] for more motions than instances or where they do not fit the device; [`Error::Motion`] for a schedule or
    /// a stretch that is not there, a clip that its character does not have, a number that is not finite, a loop or a stretch out of
    /// order.
    pub fn set_motion(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Option<MotionPlan<'_>>,
    ) -> Result<()> {
        let Some(plan) = plan else {
            self.end_motion();
            return Ok(());
        };
        let (needed, allowed) = (plan.motions.len() as u64, self.instance_characters.len() as u64);
        if needed > allowed {
            return Err(Error::Limit { what: "motions", needed, allowed, remedy: "set the instances first" });
        }
        check_motion(&plan, &self.characters, &self.instance_characters)?;
        self.end_motion();
        let mut up = Uploader { device, queue, bytes: 0 };
        let motion = Motion::new(&mut up, &self.crowd, &self.frame, self.options.max_instances, plan)?;
        self.memory.motion = motion.bytes;
        self.trial.note_fades(plan.stretches.iter().any(|stretch| stretch.fade_s > 0.0));
        self.motion = Some(motion);
        Ok(())
    }

    /// Instances stay at what their records say.
    fn end_motion(&mut self) {
        (self.motion, self.memory.motion) = (None, 0);
    }

    /// Bakes the frame that [`Technique::StaticFloor`] will draw: selects levels on the GPU as [`Technique::Bucketed`] does,
    /// waits for them, places everyone on the CPU and uploads the mesh. Takes long; it is no part of the technique's time.
    ///
    /// `data` and `instances`: those that the renderer has.
    ///
    /// # Errors
    /// Those of [`Self::prepare`]; [`Error::Limit`] when the mesh is larger than the device allows.
    pub fn bake_floor(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        data: &CrowdData,
        instances: &[InstanceRecord],
        config: &FrameConfig,
        options: impl Into<DrawOptions>,
    ) -> Result<()> {
        let options = DrawOptions { technique: Technique::StaticFloor, ..options.into() };
        self.prepare(device, queue, options.technique)?;
        let config = self.complete(config, &options);
        queue.write_buffer(&self.frame.config, 0, bytemuck::bytes_of(&config));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("bake floor") });
        let mut recorder = StageRecorder::new(&mut encoder, None);
        if let Some(feed) = &self.feed {
            feed.record(&mut recorder, &self.frame);
        }
        if let Some(motion) = &self.motion {
            recorder.stage("play_motion", |pass| motion.record(pass, config.instance_count));
        }
        self.frame.recall_water(recorder.encoder, &config);
        self.selection.record(&mut recorder, &config, &options);
        let choices = read_back::read_now(device, queue, encoder, &self.frame.choices, instances.len())?;
        let encoder = device.create_command_encoder(&Default::default());
        let culled = read_back::read_now(device, queue, encoder, &self.frame.culled, instances.len())?;
        let encoder = device.create_command_encoder(&Default::default());
        let fill = read_back::read_now(device, queue, encoder, &self.frame.fill, 1)?;
        let mut up = Uploader { device, queue, bytes: 0 };
        let floor = Floor::bake(&mut up, data, instances, &culled, &choices, &fill[0], &config)?;
        let painter = self.painters[options.technique.number()].as_mut().expect("prepared above");
        painter.lay_floor(floor);
        self.memory.floor = up.bytes;
        Ok(())
    }

    /// Records one frame: stages, then sky, ground and the crowd into `color` (a view of `color_format`; resolved
    /// from the renderer's own multisampled texture when `sample_count` is 4). Depth is the renderer's own; [`Self::encode_into`] draws the
    /// crowd alone into an engine's colour and depth.
    ///
    /// `options`: a [`Technique`], or [`DrawOptions`] with its switches. `config.instance_count` is ignored. Uniforms are
    /// written through the queue, so submit each frame before recording the next: two recorded before one submission, a split screen's, would
    /// both show the second camera. The same holds for [`Self::encode_into`] and [`Self::set_instances`].
    ///
    /// # Errors
    /// Those of [`Self::prepare`]; [`Error::Feed`] for [`Technique::PseudoInstancing`] of a simulator's instances whose characters
    /// nobody named; [`Error::OutOfMemory`] when the depth and multisampled textures of a new `size` do not
    /// fit; [`Error::Target`] when `color` is of another format or size, [`Error::DepthRange`] when the camera's depth goes the
    /// other way than [`RendererOptions::reverse_z`] says. Drop the encoder then.
    pub fn encode(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        color: &wgpu::TextureView,
        size: (u32, u32),
        config: &FrameConfig,
        options: impl Into<DrawOptions>,
    ) -> Result<()> {
        self.encode_onto(device, queue, encoder, Onto::Own(color, size), config, options.into())
    }

    fn encode_onto(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        onto: Onto<'_>,
        config: &FrameConfig,
        mut options: DrawOptions,
    ) -> Result<()> {
        if options.technique == Technique::PseudoInstancing
            && self.instance_characters.len() < self.instance_count as usize
        {
            let problem = "none, allowed one each: pseudo-instancing draws by the CPU's calls";
            return Err(Error::Feed { what: "characters of instances", problem });
        }
        self.prepare(device, queue, options.technique)?;
        let skinning = self.prepare_skinning(device, queue, config, &options);
        options.share_poses &= skinning == Skinning::Vertex || self.prepare_sharing(device, queue, &options);
        let (size, host_depth) = match onto {
            Onto::Own(color, size) => {
                self.draw.fit_targets(device, size, options.occludes())?;
                self.check_own(color, size, config)?;
                (size, None)
            }
            Onto::Host(targets) => (targets.size, Some(targets.depth)),
        };
        if options.occludes() {
            self.fit_occlusion(device, queue, host_depth, size)?;
        }
        if options.shadows > 0 {
            self.fit_shadows(device, queue, shadow_side(size.1))?;
            self.fit_lending(device, &options, skinning);
        }
        if options.holds_poses {
            self.prepare_holding(device);
        }
        let view = options.shown_view();
        if view != View::Shaded {
            self.prepare_marks(device, queue)?;
        }
        let (config, draw_config) = self.write_uniforms(queue, size, config, &options);
        let painter = self.painters[options.technique.number()].as_ref().expect("prepared above");
        if !painter.is_ready() {
            return Err(Error::NoFloor);
        }
        let context = FrameContext {
            crowd: &self.crowd,
            selection: &self.selection,
            occlusion: self.occlusion.as_ref().filter(|_| options.occludes()),
            config: &config,
            options,
            skinning,
            characters: &self.instance_characters,
            full_detail_totals: &self.full_detail_totals,
        };
        let Meters { clock, runs } = &self.meters;
        let mut recorder = StageRecorder::new(encoder, clock.as_ref().map(|clock| clock.stamps.clone()));
        if let Some(feed) = &self.feed {
            feed.record(&mut recorder, &self.frame);
        }
        self.frame.recall_water(recorder.encoder, &config);
        if let Some(motion) = &self.motion {
            recorder.stage("play_motion", |pass| motion.record(pass, config.instance_count));
        }
        // Once more after they were held last: then nobody is held any more.
        if let Some((stage, bound)) = self.hold.as_ref().filter(|_| options.holds_poses || self.holds) {
            recorder.stage("hold_poses", |pass| stage.record(pass, bound, config.instance_count));
            self.holds = options.holds_poses;
        }
        let holds_frame = &mut self.holds_frame[options.technique.number()];
        if options.frozen && *holds_frame {
            painter.record_frozen(&mut recorder, &context);
        } else {
            painter.record_stages(&mut recorder, &context);
            // With occlusion culling the second phase overwrites the first.
            *holds_frame = !options.occludes();
        }
        let shadows = self.shadows.as_ref().filter(|_| options.shadows > 0);
        if let Some(shadows) = shadows {
            let shadow = fit_cascades(&config, &draw_config, &self.bounds, options.shadows);
            let has_choices = matches!(options.technique, Technique::Reform | Technique::Bucketed);
            let (crowd, scenery) = (&self.crowd, self.scenery.as_ref());
            let feed = self.feed.as_ref();
            shadows.record(device, queue, &mut recorder, crowd, scenery, feed, &config, &shadow, has_choices);
        }
        let light = shadows.map_or(&self.unshaded, |shadows| &shadows.light).bound();
        let into = match onto {
            Onto::Own(color, _) => self.draw.own_attachments(color),
            Onto::Host(&Targets { color, resolve, depth, .. }) => {
                Attachments { color, resolve, depth, are_hosts: true }
            }
        };
        let parts: &[Part] = if context.occlusion.is_some() { &[Part::First, Part::Last] } else { &[Part::Only] };
        for (number, &part) in parts.iter().enumerate() {
            if let Some(occlusion) = context.occlusion.filter(|_| part == Part::Last) {
                occlusion.record_second(&mut recorder, &config, painter.can_be_gated(&context));
                painter.record_again(&mut recorder, &context);
                occlusion.record_join(&mut recorder);
            }
            let stamps = recorder.draw_stamps("draw", part != Part::First);
            let mut pass = self.draw.begin(recorder.encoder, &into, stamps, part, light, shadows.is_some());
            if let Some(scenery) = self.scenery.as_ref().filter(|_| part != Part::Last) {
                scenery.draw(&mut pass, shadows.is_some());
            }
            if let Some(runs) = runs {
                pass.begin_pipeline_statistics_query(&runs.queries, number as u32);
            }
            painter.draw(&mut pass, &context);
            if runs.is_some() {
                pass.end_pipeline_statistics_query();
            }
            if let Some(marks) = self.marks.as_ref().filter(|_| view != View::Shaded && part != Part::First) {
                let sight =
                    context.occlusion.and_then(|occlusion| occlusion.buffer("seen")).unwrap_or(&self.frame.choices);
                marks.write(queue, &config, &self.bounds, view, options.technique != Technique::Instanced);
                let bound = marks.bind(device, &self.crowd, &self.frame, sight);
                marks.draw_tags(&mut pass, &bound, config.instance_count);
            }
        }
        let names = recorder.into_names();
        let known_totals = painter.known_totals(&context);
        if let Some(feed) = &self.feed {
            feed.record_totals(encoder, &self.frame);
        }
        let draws = parts.len() as u32;
        self.read_back.record(device, encoder, &self.frame.totals, known_totals, &self.meters, names, draws);
        if options.technique == Technique::Bucketed {
            let number = self.read_back.last_frame();
            self.trial.drawn(number, options.skinning, skinning, self.meters.clock.is_some());
        }
        Ok(())
    }

    /// Writes what the shaders know of a frame.
    fn write_uniforms(
        &self,
        queue: &wgpu::Queue,
        size: (u32, u32),
        config: &FrameConfig,
        options: &DrawOptions,
    ) -> (FrameConfig, DrawConfig) {
        let config = self.complete(config, options);
        let clip_from_world = Mat4::from_cols_array_2d(&config.clip_from_world);
        let draw_config = DrawConfig::new(&clip_from_world, size.0, size.1, self.layer_side);
        queue.write_buffer(&self.frame.config, 0, bytemuck::bytes_of(&config));
        queue.write_buffer(&self.frame.draw_config, 0, bytemuck::bytes_of(&draw_config));
        (config, draw_config)
    }

    fn complete(&self, config: &FrameConfig, options: &DrawOptions) -> FrameConfig {
        let instance_count = self.instance_count;
        // Levels by error have no water between them to morph by.
        let morphs = options.morphs() && config.weight != Weight::Error as u32;
        let has_dots = options.has_dots() && config.weight != Weight::Error as u32;
        let dot_area_px2 = if has_dots { config.dot_area_px2 } else { 0.0 };
        let has_impostors = has_dots && self.crowd.impostors.is_some() && !options.no_impostors;
        let impostor_area_px2 = if has_impostors { config.impostor_area_px2 } else { 0.0 };
        let [hold_far_m, hold_px] = if options.holds_poses { [config.hold_far_m, config.hold_px] } else { [0.0; 2] };
        // Eq. 1 as printed knows vertices alone.
        let fills = options.fit == Fit::Fill || config.weight == Weight::Error as u32;
        let budget_in = if fills { config.budget_in } else { BudgetIn::Vertices as u32 };
        let complete =
            FrameConfig { instance_count, morph: morphs.into(), dot_area_px2, hold_far_m, hold_px, ..*config };
        FrameConfig { budget_in, impostor_area_px2, ..complete }
    }
}
