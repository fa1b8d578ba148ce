//! A flock that never leaves the GPU: cells, sort, steering, instances. The CPU's work does not grow with the flock.

use super::stage_recorder::StageRecorder;
use super::upload::Uploader;
use super::{CellBoids, FillCells, PlaceBoids, SortInstances, SteerBoids};
use crate::{
    BoidRecord, BoidTraits, Error, FlockConfig, FrameConfig, InstanceRecord, MoverRecord, Result, SortPass, SortedBoid,
};
use std::mem::size_of;
use wgpu::BufferUsages as Usage;

/// Steps in one submission.
const STEPS_A_SUBMISSION: u32 = 32;

/// A flock on the GPU; [`Self::instances`] is what [`super::InstanceFeed`] borrows.
///
/// Paper: Park & Han 2009 §4 simulate by Reynolds 1987 on the CPU and send places to the GPU; here they stay there. Neighbours are
/// taken in a fixed order (a stable sort by cells), so a device comes to the same flock every time.
pub struct GpuFlock {
    config: FlockConfig,
    uniform: wgpu::Buffer,
    start: wgpu::Buffer,
    boids: wgpu::Buffer,
    instances: wgpu::Buffer,
    cell_boids: (CellBoids, wgpu::BindGroup),
    sort: SortInstances,
    sort_passes: Vec<(SortPass, wgpu::BindGroup)>,
    fill_cells: (FillCells, wgpu::BindGroup),
    steer_boids: (SteerBoids, wgpu::BindGroup),
    place_boids: (PlaceBoids, wgpu::BindGroup),
    steps: u32,
    bytes: u64,
}

impl GpuFlock {
    /// Uploads the start of a flock and compiles its stages. `traits`: one a boid. `config.boid_count` is filled in.
    ///
    /// # Errors
    /// [`Error::Flock`] for numbers that do not fit together, [`Error::Limit`] and [`Error::OutOfMemory`] where the device has no
    /// room.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        config: FlockConfig,
        boids: &[BoidRecord],
        traits: &[BoidTraits],
        movers: &[MoverRecord],
    ) -> Result<Self> {
        check(&config, boids, traits, movers)?;
        let fewer = "simulate fewer";
        let n = boids.len() as u32;
        let config = FlockConfig { boid_count: n, ..config };
        let cells = config.columns * config.rows;
        let mut up = Uploader { device, queue, bytes: 0 };
        let uniform = up.filled("flock config", &[config], Usage::UNIFORM, fewer)?;
        let frame = FrameConfig { instance_count: n, ..Default::default() };
        let frame = up.filled("size of the flock", &[frame], Usage::UNIFORM, fewer)?;
        let kept = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let start = up.filled("bytes of a flock's start", boids, kept, fewer)?;
        let now = up.filled("bytes of a flock", boids, kept, fewer)?;
        let traits = up.filled("bytes of a flock's traits", traits, Usage::STORAGE, fewer)?;
        let movers = up.filled("bytes of a flock's characters", movers, Usage::STORAGE, fewer)?;
        let count = u64::from(n);
        let instances = up.empty::<InstanceRecord>("bytes of a flock's instances", count, kept, fewer)?;
        let mut words = |what, count| up.empty::<u32>(what, count, Usage::STORAGE, fewer);
        let digits = words("digits of a flock's cells", SortInstances::digit_count_words(n))?;
        // The first pass reads the first pair and no values.
        let pairs = [
            (words("cells of a flock", count)?, words("numbers of a flock", count)?),
            (words("sorted cells of a flock", count)?, words("sorted numbers of a flock", count)?),
        ];
        let starts = words("starts of a flock's cells", u64::from(cells) + 1)?;
        let sorted = up.empty::<SortedBoid>("bytes of a sorted flock", count, Usage::STORAGE, fewer)?;

        let cell = CellBoids::new(device);
        let cell_bound = cell.bind(device, &uniform, &now, &pairs[0].0);
        let sort = SortInstances::new(device);
        let mut sort_passes = Vec::new();
        for (p, pass) in SortInstances::passes(cells.max(1) - 1).into_iter().enumerate() {
            let (from, into) = (&pairs[p % 2], &pairs[(p + 1) % 2]);
            let step = up.filled("pass of a flock's sort", &[pass], Usage::UNIFORM, fewer)?;
            let bound = sort.bind(device, &frame, &step, &from.0, &from.1, &digits, &into.0, &into.1);
            sort_passes.push((pass, bound));
        }
        let (sorted_cells, sorted_numbers) = &pairs[sort_passes.len() % 2];
        let fill = FillCells::new(device);
        let fill_bound = fill.bind(device, &uniform, &now, sorted_cells, sorted_numbers, &starts, &sorted);
        let steer = SteerBoids::new(device);
        let steer_bound = steer.bind(device, &uniform, sorted_numbers, &sorted, &starts, &now);
        let place = PlaceBoids::new(device);
        let place_bound = place.bind(device, &uniform, &now, &traits, &movers, &instances);
        Ok(Self {
            config,
            uniform,
            start,
            boids: now,
            instances,
            cell_boids: (cell, cell_bound),
            sort,
            sort_passes,
            fill_cells: (fill, fill_bound),
            steer_boids: (steer, steer_bound),
            place_boids: (place, place_bound),
            steps: 0,
            bytes: up.bytes,
        })
    }

    /// Goes on to so many steps from the start, or begins again to get to fewer, and writes the instances that `time_s` shows.
    /// Submits to `queue`, a few steps at a time; does not wait.
    pub fn advance_to(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, steps: u32, time_s: f32) {
        self.config.time_s = time_s;
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&self.config));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("flock") });
        if steps < self.steps {
            encoder.copy_buffer_to_buffer(&self.start, 0, &self.boids, 0, self.start.size());
            self.steps = 0;
        }
        while self.steps < steps {
            if self.steps % STEPS_A_SUBMISSION == STEPS_A_SUBMISSION - 1 {
                let full = std::mem::replace(&mut encoder, device.create_command_encoder(&Default::default()));
                queue.submit([full.finish()]);
            }
            self.record_step(&mut StageRecorder::new(&mut encoder, None));
            self.steps += 1;
        }
        StageRecorder::new(&mut encoder, None).stage("place_boids", |pass| {
            self.place_boids.0.record(pass, &self.place_boids.1, self.config.boid_count);
        });
        queue.submit([encoder.finish()]);
    }

    fn record_step(&self, recorder: &mut StageRecorder<'_>) {
        let FlockConfig { boid_count, columns, rows, .. } = self.config;
        recorder.stage("cell_boids", |pass| self.cell_boids.0.record(pass, &self.cell_boids.1, boid_count));
        recorder.stage("sort_instances", |pass| {
            for (step, bound) in &self.sort_passes {
                self.sort.record(pass, bound, step, boid_count);
            }
        });
        let cells = columns * rows;
        recorder.stage("fill_cells", |pass| self.fill_cells.0.record(pass, &self.fill_cells.1, boid_count, cells));
        recorder.stage("steer_boids", |pass| self.steer_boids.0.record(pass, &self.steer_boids.1, boid_count));
    }

    /// The instances, in order of the boids' numbers: [`InstanceRecord`]s, `STORAGE` and `COPY_SRC`.
    pub fn instances(&self) -> &wgpu::Buffer {
        &self.instances
    }

    /// The boids, for tests: [`BoidRecord`]s, `COPY_SRC`.
    pub fn boids(&self) -> &wgpu::Buffer {
        &self.boids
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.config.boid_count
    }

    /// Bytes of GPU memory.
    pub fn gpu_bytes(&self) -> u64 {
        self.bytes
    }

    /// The instances as they are now; waits for them.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] when there is no room for the copy, [`Error::DeviceLost`] when the device is lost.
    pub fn read_instances(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<InstanceRecord>> {
        let encoder = device.create_command_encoder(&Default::default());
        super::read_back::read_now(device, queue, encoder, &self.instances, self.config.boid_count as usize)
    }
}

fn check(config: &FlockConfig, boids: &[BoidRecord], traits: &[BoidTraits], movers: &[MoverRecord]) -> Result<()> {
    let wrong = |problem| Err(Error::Flock { problem });
    let most = u32::MAX as usize / size_of::<InstanceRecord>();
    let FlockConfig { columns, rows, sight_m, .. } = *config;
    if boids.len() != traits.len() || boids.len() > most {
        return wrong("as many traits as boids are needed");
    }
    if traits.iter().any(|one| one.mover as usize >= movers.len())
        || boids.iter().any(|boid| boid.gait.max(boid.gait_before) > 2)
    {
        return wrong("a boid names a mover or a gait that is not there");
    }
    let cells = columns.checked_mul(rows).filter(|cells| *cells > 0 && *cells < u32::MAX);
    if cells.is_none() || !(sight_m > 0.0 && sight_m.is_finite()) {
        return wrong("the grid needs cells, fewer than 2^32 - 1, of a size above 0");
    }
    check_rules(config)?;
    let bodies = traits.iter().flat_map(|one| [one.scale, one.start]);
    let clips = movers.iter().flat_map(|mover| &mover.clips);
    let ways =
        clips.clone().flat_map(|clip| clip.root_path_m.as_flattened().iter().copied().chain(clip.displacement_m));
    let times = clips.flat_map(|clip| [clip.duration_s, clip.ground_speed_m_s]);
    let sizes = movers.iter().flat_map(|mover| [mover.scale, mover.run_ahead_turns]);
    if bodies.chain(ways).chain(times).chain(sizes).any(|number| !number.is_finite()) {
        return wrong("a trait or a mover has a number that is not finite");
    }
    let numbers = |boid: &BoidRecord| [boid.place[0], boid.place[1], boid.velocity[0], boid.velocity[1], boid.pace_m_s];
    if boids.iter().flat_map(numbers).any(|number| !number.is_finite()) {
        return wrong("a boid has a number that is not finite");
    }
    let widest_m = boids.iter().map(|boid| boid.wider_m).fold(0.0, f32::max);
    if !boids.iter().all(|boid| boid.wider_m >= 0.0) {
        return wrong("a boid's wider_m is below 0 or not a number");
    }
    if config.apart_m + 2.0 * widest_m > sight_m * 1.0001 {
        return wrong("sight_m is less than what the two widest keep apart");
    }
    Ok(())
}

/// Rules that steps can go by: finite, spans in order, times that go forwards.
fn check_rules(config: &FlockConfig) -> Result<()> {
    let FlockConfig { low, speed_m_s, stands_below_m_s, runs_from_m_s, .. } = *config;
    let FlockConfig { separation, alignment, cohesion, apart_m, sight_m, radius_m, rim, bodies_m, .. } = *config;
    let FlockConfig { most_push_m, most_m_s2, turn_hz, step_s, time_s, .. } = *config;
    let FlockConfig { least_clip_speed_m_s, shortest_gait_s, fade_s, .. } = *config;
    let spans = [speed_m_s, stands_below_m_s, runs_from_m_s];
    let steering = [separation, alignment, cohesion, apart_m, sight_m, radius_m, rim, bodies_m, most_push_m, most_m_s2];
    let times = [turn_hz, step_s, time_s, least_clip_speed_m_s, shortest_gait_s, fade_s];
    let all = spans.as_flattened().iter().chain(&low).chain(&steering).chain(&times);
    if all.into_iter().any(|number| !number.is_finite()) {
        return Err(Error::Flock { problem: "a rule has a number that is not finite" });
    }
    if spans.iter().any(|[low, high]| low > high) || speed_m_s[0] < 0.0 {
        return Err(Error::Flock { problem: "speeds must be in order, the slowest not below 0" });
    }
    if step_s <= 0.0 || fade_s < 0.0 || shortest_gait_s < 0.0 {
        return Err(Error::Flock { problem: "a step must take time, and no time may be below 0" });
    }
    Ok(())
}
