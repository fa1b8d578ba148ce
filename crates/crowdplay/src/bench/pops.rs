//! What changes from frame to frame by levels alone: the frame with the levels of the frame before and with its own, in one pose
//! from one camera; how far the picture is from itself, and how far the surface moves.
//!
//! The picture sees what eyes see, and what they do not: a rasteriser turns the smallest move of an edge into whole pixels. The
//! surface's move is that of each vertex of full detail, which lies at a level where the vertex is that stands for it.

use crate::Result;
use crate::cpu_levels::CpuLevels;
use crate::crowd::Crowd;
use crate::gpu_backend::GpuBackend;
use crate::picture::Picture;
use crowd_stages::{DrawOptions, FrameConfig, InstanceRecord, LodChoice, MorphRecord, Technique, cpu};
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

/// Part of the picture at each side that does not count: there people come into the picture, whatever their level.
const RIM_PART: u32 = 16;

/// What changed, over all frames.
#[derive(Debug, Clone)]
pub struct Pops {
    squares: f64,
    values: u64,
    /// Pixels by the largest difference of their channels.
    histogram: [u64; 256],
    moves: Moves,
    steps: LevelSteps,
}

impl Pops {
    /// Nothing yet.
    pub fn new() -> Self {
        Self { squares: 0.0, values: 0, histogram: [0; 256], moves: Moves::default(), steps: LevelSteps::default() }
    }

    /// Adds a frame: two pictures of one size.
    pub fn add(&mut self, before: &Picture, after: &Picture) {
        let inside = |length: u32| (length / RIM_PART)..(length - length / RIM_PART);
        for y in inside(after.height) {
            for x in inside(after.width) {
                let i = (y * after.width + x) as usize;
                let channels = before.pixels[i].iter().zip(&after.pixels[i]).take(3);
                let differences = channels.map(|(a, b)| a.abs_diff(*b));
                let mut most = 0;
                for difference in differences {
                    most = most.max(difference);
                    let share = f64::from(difference) / 255.0;
                    self.squares += share * share;
                }
                self.values += 3;
                self.histogram[usize::from(most)] += 1;
            }
        }
    }

    /// Root of the mean square over all channels, of sRGB 0 to 1.
    pub fn rmse(&self) -> f32 {
        if self.values == 0 { 0.0 } else { (self.squares / self.values as f64).sqrt() as f32 }
    }

    /// How far the surface moved.
    pub fn moves(&self) -> &Moves {
        &self.moves
    }

    /// How far levels changed.
    pub fn steps(&self) -> &LevelSteps {
        &self.steps
    }

    /// The difference that one pixel in a thousand exceeds, 0 to 1.
    pub fn p999(&self) -> f32 {
        let mut beyond: u64 = self.histogram.iter().sum::<u64>() / 1000;
        for (difference, &pixels) in self.histogram.iter().enumerate().rev() {
            if pixels > beyond {
                return difference as f32 / 255.0;
            }
            beyond -= pixels;
        }
        0.0
    }
}

/// How far the surface moves, in pixels.
#[derive(Debug, Clone, Default)]
pub struct Moves {
    squares: f64,
    count: u64,
    /// Vertices that move farther than a quarter of a pixel.
    far_count: u64,
}

impl Moves {
    fn join(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            count: self.count + other.count,
            far_count: self.far_count + other.far_count,
        }
    }

    /// Root of the mean square, pixels.
    pub fn rms_px(&self) -> f32 {
        if self.count == 0 { 0.0 } else { (self.squares / self.count as f64).sqrt() as f32 }
    }

    /// Share of the vertices that move farther than a quarter of a pixel.
    pub fn far_share(&self) -> f32 {
        if self.count == 0 { 0.0 } else { (self.far_count as f64 / self.count as f64) as f32 }
    }
}

/// How many quantised levels instances go from one frame to the next, of those that both frames show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LevelSteps {
    /// Instances, of all frames together.
    pub shown: u64,
    /// Those of them that have another level than in the frame before.
    pub changed: u64,
    /// Those that have gone farther than to the next level.
    pub beyond_next: u64,
    /// The most levels that anybody has gone to a finer one.
    pub most_finer: u32,
    /// The same to a coarser one.
    pub most_coarser: u32,
    /// Instances that come into the picture.
    pub entered: u64,
}

impl LevelSteps {
    /// Adds an instance whose level was the one and is the other; none where it is not shown.
    fn add(&mut self, before: Option<u32>, after: Option<u32>) {
        let (Some(before), Some(after)) = (before, after) else {
            self.entered += u64::from(after.is_some());
            return;
        };
        self.shown += 1;
        self.changed += u64::from(before != after);
        self.beyond_next += u64::from(before.abs_diff(after) > 1);
        self.most_finer = self.most_finer.max(after.saturating_sub(before));
        self.most_coarser = self.most_coarser.max(before.saturating_sub(after));
    }

    /// The most levels that anybody has gone.
    pub fn most(&self) -> u32 {
        self.most_finer.max(self.most_coarser)
    }

    /// Share that has gone farther than to the next level.
    pub fn share_beyond_next(&self) -> f32 {
        if self.shown == 0 { 0.0 } else { (self.beyond_next as f64 / self.shown as f64) as f32 }
    }

    /// In words.
    pub fn words(&self) -> String {
        let Self { shown, changed, beyond_next, most_finer, most_coarser, entered } = self;
        format!(
            "of {shown} shown in two frames in a row {changed} have another level in the second, {beyond_next} farther than the next one; at most {most_finer} levels finer and {most_coarser} coarser; {entered} came into the picture"
        )
    }
}

/// An instance's level and where it is on its way.
type Level = (LodChoice, MorphRecord);

/// Moves of all vertices of full detail of those who are drawn in both frames.
fn moves_between(crowd: &Crowd, before: &cpu::CpuFrame, after: &cpu::CpuFrame, config: &FrameConfig) -> Moves {
    let level = |frame: &cpu::CpuFrame, i: usize| -> Level {
        let choice = frame.choices[i];
        let at_home = MorphRecord { coarser_vertex_count: choice.vertex_count, fraction: 1.0 };
        (choice, frame.morphs.get(i).copied().unwrap_or(at_home))
    };
    let of = |i: usize| moves_of(crowd, &crowd.instances[i], level(before, i), level(after, i), config);
    // Summed in the instances' order: the same for any number of threads.
    let all: Vec<Moves> = (0..crowd.instances.len()).into_par_iter().map(of).collect();
    all.into_iter().fold(Moves::default(), Moves::join)
}

fn moves_of(crowd: &Crowd, instance: &InstanceRecord, before: Level, after: Level, config: &FrameConfig) -> Moves {
    if before.0.vertex_count == 0 || after.0.vertex_count == 0 {
        return Moves::default();
    }
    let data = &crowd.data;
    let character = &data.characters[instance.character as usize];
    let mut moves = Moves { count: character.vertex_count.into(), ..Moves::default() };
    if before == after {
        return moves;
    }
    let pose = |(choice, morph): Level| cpu::pose_between(data, instance, choice, morph, config.time_s).positions;
    let (a, b) = (pose(before), pose(after));
    let collapse_map = &data.collapse_map[character.vertex_offset as usize..][..character.vertex_count as usize];
    let distance_m = Vec3::from_array(instance.position).distance(Vec3::from_array(config.eye)).max(0.1);
    for v in 0..character.vertex_count {
        let place = |positions: &[[f32; 3]]| {
            Vec3::from_array(positions[cpu::surviving(collapse_map, v, positions.len() as u32) as usize])
        };
        let px = f64::from(place(&a).distance(place(&b)) * config.focal_px / distance_m);
        moves.squares += px * px;
        moves.far_count += u64::from(px > 0.25);
    }
    moves
}

/// Draws all frames but the first with the levels of the one before, and with their own.
///
/// `levels`: of the crowd; they know no dots, so who is dots counts as the coarsest mesh, as does who is an impostor. `config_of`: of a frame, with its time. The static floor is baked for each frame and has no frame before: `None`.
pub fn measure_pops(
    backend: &mut GpuBackend,
    crowd: &mut Crowd,
    levels: &CpuLevels,
    options: DrawOptions,
    frames: u32,
    config_of: &dyn Fn(u32) -> FrameConfig,
) -> Result<Option<Pops>> {
    if options.technique == Technique::StaticFloor || options.occludes() {
        return Ok(None);
    }
    let mut pops = Pops::new();
    // What was drawn before it is somebody else's: the height of its water is searched for.
    let first = FrameConfig { slack: 0, ..config_of(0) };
    if crowd.advance(first.time_s) {
        backend.set_instances(&crowd.instances)?;
    }
    crowd.play(first.time_s);
    backend.draw(&first, options)?;
    // As on the GPU, every frame but the first knows how high the water was in the one before.
    let mut water_before_bits = 0;
    let mut select = |crowd: &Crowd, config: &FrameConfig| {
        let frame = levels.select_over_impostors(crowd, &FrameConfig { water_before_bits, ..*config }, options);
        water_before_bits = frame.water_bits;
        frame
    };
    let mut before = select(crowd, &first);
    for frame in 1..frames {
        let config = config_of(frame);
        if crowd.advance(config.time_s) {
            backend.set_instances(&crowd.instances)?;
        }
        crowd.play(config.time_s);
        // What was drawn last is the frame before.
        backend.draw(&config, DrawOptions { frozen: true, ..options })?;
        let with_its_levels = backend.picture()?;
        backend.draw(&config, options)?;
        pops.add(&with_its_levels, &backend.picture()?);
        let after = select(crowd, &config);
        // When people come or leave, nobody has a frame before.
        if before.choices.len() == after.choices.len() {
            let moves = moves_between(crowd, &before, &after, &config);
            pops.moves = std::mem::take(&mut pops.moves).join(moves);
            for (one, (before, after)) in crowd.instances.iter().zip(before.choices.iter().zip(&after.choices)) {
                let level = |choice: &LodChoice| {
                    (choice.vertex_count > 0).then(|| levels.level_of(one.character, choice.vertex_count))
                };
                pops.steps.add(level(before), level(after));
            }
        }
        before = after;
    }
    Ok(Some(pops))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(side: u32, value: impl Fn(u32, u32) -> u8) -> Picture {
        let pixels = (0..side * side).map(|i| [value(i % side, i / side), 0, 0, 255]).collect();
        Picture { width: side, height: side, pixels }
    }

    #[test]
    fn what_changes_counts_but_not_at_the_rim() {
        let still = picture(64, |_, _| 0);
        let mut pops = Pops::new();
        pops.add(&still, &picture(64, |x, y| if x < 4 || y >= 60 { 255 } else { 0 }));
        assert_eq!((pops.rmse(), pops.p999()), (0.0, 0.0));
        pops.add(&still, &picture(64, |_, _| 255));
        // Half of all frames change, in one of three channels.
        assert!((pops.rmse() - (0.5f32 / 3.0).sqrt()).abs() < 1e-6);
        assert_eq!(pops.p999(), 1.0);
    }

    #[test]
    fn levels_are_counted_and_who_comes_is_not_a_change() {
        let mut steps = LevelSteps::default();
        for (before, after) in [(4, 4), (4, 5), (9, 6), (2, 7)] {
            steps.add(Some(before), Some(after));
        }
        steps.add(None, Some(60));
        steps.add(Some(60), None);
        let expected = LevelSteps { shown: 4, changed: 3, beyond_next: 2, most_finer: 5, most_coarser: 3, entered: 1 };
        assert_eq!((steps, steps.most(), steps.share_beyond_next()), (expected, 5, 0.5));
    }

    #[test]
    fn one_pixel_in_a_thousand_is_found_and_fewer_are_not() {
        let still = picture(160, |_, _| 0);
        let of = |pixels: u32| {
            let mut pops = Pops::new();
            pops.add(&still, &picture(160, |x, y| if y == 80 && (20..20 + pixels).contains(&x) { 51 } else { 0 }));
            pops.p999()
        };
        // 140 x 140 pixels count.
        assert_eq!((of(19), of(21)), (0.0, 0.2));
    }
}
