//! A flock that the GPU simulates: from the scene's flock and cast to the stages' records, and the hand-over of its instances.

use crate::Result;
use crate::crowd::Crowd;
use crate::gpu_device::Gpu;
use crate::plan::Simulator;
use crowd_scene::{FLOCK_STEP_S, Flock, Gait, GaitClip, LEAST_CLIP_SPEED_M_S, Mover};
use crowd_stages::gpu::{CrowdRenderer, GpuFlock, InstanceFeed};
use crowd_stages::{
    BoidRecord, BoidTraits, CrowdBounds, CrowdData, FlockConfig, GaitClipRecord, InstanceRecord, MoverRecord,
};
use glam::Vec3;

/// A gait that never changed did so this long ago.
const NEVER_S: f32 = 1e9;

/// A flock on the GPU whose instances a renderer has borrowed.
pub struct Simulation {
    flock: GpuFlock,
}

impl Simulation {
    /// Sets up the crowd's flock and lends its instances to `renderer`; `None` where the crowd has none, or the CPU is to simulate it:
    /// by itself it does so where the adapter is software, for that would be the same cores with more to do.
    ///
    /// # Errors
    /// [`crate::Error::Stages`] where the GPU has no room.
    pub fn of(gpu: &Gpu, renderer: &mut CrowdRenderer, crowd: &Crowd) -> Result<Option<Self>> {
        let Some((flock, cast)) = crowd.moving.as_ref().and_then(|moving| moving.flock()) else { return Ok(None) };
        let by_gpu = match crowd.simulator {
            Simulator::Auto => !gpu.is_software(),
            Simulator::Gpu => true,
            Simulator::Cpu => false,
        };
        if !by_gpu {
            return Ok(None);
        }
        let boids: Vec<BoidRecord> = flock.boids().iter().map(boid_record).collect();
        let traits: Vec<BoidTraits> = (0..boids.len() as u32).map(|id| boid_traits(&cast.traits_of(id))).collect();
        let movers: Vec<MoverRecord> = cast
            .movers
            .iter()
            .zip(&crowd.shown)
            .map(|(mover, shown)| mover_record(&crowd.data, mover, shown.0))
            .collect();
        let characters: Vec<u32> = crowd.instances.iter().map(|one| one.character).collect();
        let config = FlockConfig { fade_s: cast.fade_s, ..flock_config(flock) };
        let mut flock_now = GpuFlock::new(&gpu.device, &gpu.queue, config, &boids, &traits, &movers)?;
        flock_now.advance_to(&gpu.device, &gpu.queue, 0, 0.0);
        let feed = InstanceFeed {
            instances: flock_now.instances(),
            count: None,
            most: flock_now.count(),
            bounds: reach(&crowd.data, &crowd.instances, flock),
            characters: &characters,
        };
        renderer.borrow_instances(&gpu.device, &gpu.queue, &feed)?;
        Ok(Some(Self { flock: flock_now }))
    }

    /// Goes on to a time; the GPU has its work when this returns, and may not be done.
    pub fn advance(&mut self, gpu: &Gpu, time_s: f32) {
        self.flock.advance_to(&gpu.device, &gpu.queue, Flock::steps_at(time_s), time_s);
    }

    /// Everyone as they are now; waits.
    ///
    /// # Errors
    /// [`crate::Error::Stages`] where there is no room for a copy.
    pub fn instances(&self, gpu: &Gpu) -> Result<Vec<InstanceRecord>> {
        Ok(self.flock.read_instances(&gpu.device, &gpu.queue)?)
    }

    /// Bytes of GPU memory.
    pub fn gpu_bytes(&self) -> u64 {
        self.flock.gpu_bytes()
    }
}

/// A flock's rules and grid as the stages have them; gaits change at once.
pub fn flock_config(flock: &Flock) -> FlockConfig {
    let (rules, grid) = (flock.rules(), flock.grid());
    FlockConfig {
        boid_count: flock.boids().len() as u32,
        columns: grid.columns,
        rows: grid.rows,
        most_followed: rules.most_followed,
        low: grid.low.to_array(),
        speed_m_s: rules.speed_m_s,
        separation: rules.separation,
        alignment: rules.alignment,
        cohesion: rules.cohesion,
        apart_m: rules.apart_m,
        sight_m: rules.sight_m,
        radius_m: flock.radius_m(),
        rim: rules.rim,
        bodies_m: rules.bodies_m,
        most_push_m: rules.most_push_m,
        most_m_s2: rules.most_m_s2,
        turn_hz: rules.turn_hz,
        step_s: FLOCK_STEP_S,
        stands_below_m_s: Gait::STANDS_BELOW_M_S,
        runs_from_m_s: Gait::RUNS_FROM_M_S,
        time_s: 0.0,
        least_clip_speed_m_s: LEAST_CLIP_SPEED_M_S,
        shortest_gait_s: Gait::SHORTEST_S,
        fade_s: 0.0,
    }
}

/// One of a flock as the stages have it.
pub fn boid_record(boid: &crowd_scene::Boid) -> BoidRecord {
    BoidRecord {
        place: boid.place.to_array(),
        velocity: boid.velocity.to_array(),
        yaw_rad: boid.yaw_rad,
        walked_m: boid.walked_m,
        pace_m_s: boid.pace_m_s,
        gait: boid.gait as u32,
        gait_before: boid.gait_before as u32,
        ran_m: boid.ran_m,
        // Never is a number of seconds, too: shaders need not know infinity.
        changed_s: boid.changed_s.min(NEVER_S),
        wider_m: boid.wider_m,
    }
}

/// What stays the same of it.
pub fn boid_traits(traits: &crowd_scene::WalkerTraits) -> BoidTraits {
    BoidTraits { mover: traits.mover, scale: traits.scale, start: traits.start, reserved: 0 }
}

/// A mover as the stages have it; `character`: its index in the pack.
pub fn mover_record(data: &CrowdData, mover: &Mover, character: u32) -> MoverRecord {
    let first = data.characters[character as usize].clip_offset;
    let clip = |clip: GaitClip| GaitClipRecord {
        displacement_m: clip.displacement_m.to_array(),
        duration_s: clip.duration_s,
        ground_speed_m_s: clip.ground_speed_m_s,
        clip: first + clip.clip,
        root_path_m: *clip.root_path.points(),
        ..Default::default()
    };
    let (scale, run_ahead_turns) = (mover.scale, mover.run_ahead_turns);
    MoverRecord { clips: mover.clips.map(clip), character, scale, run_ahead_turns, reserved: 0 }
}

/// A box that nobody of the flock ever leaves, whatever their pose.
fn reach(data: &CrowdData, instances: &[InstanceRecord], flock: &Flock) -> CrowdBounds {
    let of = |one: &InstanceRecord| {
        let [x, y, z, radius] = data.characters[one.character as usize].sphere;
        (Vec3::new(x, y, z).length() + radius) * one.scale.abs()
    };
    let body_m = instances.iter().map(of).fold(0.0, f32::max);
    let mut bounds = CrowdBounds::default();
    let out = -flock.grid().low;
    for corner in [-out, out] {
        bounds.add(Vec3::new(corner.x, 0.0, corner.y), body_m);
    }
    bounds
}
