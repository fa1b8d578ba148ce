//! How fast a clip walks over the ground, also where it walks on the spot: what a player needs so that feet do not slide.

use crate::skin::skin;
use crate::{Mat3x4, SampledClip};

/// Points of the soles that are followed, at most.
const SOLE_POINTS: usize = 512;
/// Frames that the soles are looked for in.
const SEARCHED_FRAMES: usize = 16;
/// A point this near to the lowest one of the clip, as a share of the height, belongs to a sole.
const SOLE_SHARE: f32 = 0.05;
/// The ground: in this share of the frames the lowest point lies below it. A single frame in which a paw dips, or a run that is
/// in the air for more than half of its time, must not hide the steps.
const GROUND_QUANTILE: f32 = 0.25;
/// A point no higher than this over the ground before and after a step in time stands on it, as a share of the height.
const PLANTED_SHARE: f32 = 0.02;
/// A point that moves over the ground faster than this share of the walking speed does not stand, however low it is: it swings.
pub(crate) const STANDING_SHARE: f32 = 0.5;
/// A clip whose soles are planted in a smaller share of its time does not walk.
const LEAST_PLANTED: f32 = 0.3;
/// Nor does one that sways, slower than this share of the height a second.
const SWAYING_SHARE: f32 = 0.05;
/// Nor does one that ends this far from where it began, as a share of the height: a fall, lying down.
const LOOP_SHARE: f32 = 0.1;
/// The steps of points that agree best, as a share of them, tell the speed: feet roll, and swing low between.
const AGREEING_SHARE: f32 = 1.0 / 3.0;

/// Speed, metres a second, at which a character must move over the ground so that its planted feet stay where they are.
///
/// Between two frames the planted points are those of the mesh that lie no more than 2 % of the height over the ground in both,
/// the ground being where the lowest point is in a quarter of the frames. Their horizontal movement, root motion included, is
/// what the feet slide by when the character stands; the third of all these movements that agree best tell the velocity: most points stand, those of a foot that
/// swings low do not agree; or that of each step's mean, where the standing points then agree better. Where some foot stands at all times it is then evened out, so that standing feet do not drift over a turn.
/// Less the root's own mean velocity, that is the speed of the walk: of a clip with root motion the root's, of one on the
/// spot the ground's under the feet. 0 for what is no walk: a single pose, a clip that does not end where it began (a tenth
/// of the height), that stands on the ground in less than three tenths of its time, whose planted points do not agree to
/// within the speed itself, or that is slower than a twentieth of the height a second.
///
/// `positions`, `joints`, `weights`: one per vertex, bind space, metres, Y up; `joint_count`: matrices a frame in the clip's
/// palettes.
pub fn ground_speed(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    clip: &SampledClip,
    joint_count: usize,
) -> f32 {
    let Some(soles) = Soles::of(positions, joints, weights, clip, joint_count) else { return 0.0 };
    walking_velocity(&soles, clip).map_or(0.0, speed_of)
}

/// The velocity along x and z with which the character must move over the ground, the root's own included: see [`ground_speed`]. `None` for
/// what is no walk.
pub(crate) fn walking_velocity(soles: &Soles, clip: &SampledClip) -> Option<[f32; 2]> {
    // Of each point, and of each step's mean: feet that swing low spoil means, feet that roll spoil points.
    let (mut of_points, mut of_steps) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    for pair in soles.paths.windows(2) {
        let (mut sum, mut count) = ([0.0_f32; 2], 0.0_f32);
        for (before, after) in pair[0].iter().zip(&pair[1]) {
            if soles.is_planted(before) && soles.is_planted(after) {
                let velocity = [after[0] - before[0], after[2] - before[2]].map(|way| way / soles.step_s);
                of_points.iter_mut().zip(velocity).for_each(|(all, one)| all.push(one));
                sum = [sum[0] + velocity[0], sum[1] + velocity[1]];
                count += 1.0;
            }
        }
        if count > 0.0 {
            of_steps.iter_mut().zip(sum).for_each(|(all, sum)| all.push(sum / count));
        }
    }
    let planted_share = of_steps[0].len() as f32 / (soles.paths.len() - 1) as f32;
    if planted_share < LEAST_PLANTED || clip.loop_gap_m > LOOP_SHARE * soles.height {
        return None;
    }
    let root = [0, 2].map(|axis| clip.root_motion.displacement_m[axis] / clip.duration_s);
    let candidates = [of_points, of_steps].into_iter().filter_map(|velocities| {
        let [(x, spread_x), (z, spread_z)] = velocities.map(most_agreed);
        let over_ground = [root[0] - x, root[1] - z];
        let speed = speed_of(over_ground);
        let agree = spread_x.max(spread_z) <= speed;
        let walks = speed.is_finite() && agree && speed >= SWAYING_SHARE * soles.height;
        walks.then(|| even_out(soles, over_ground, root))
    });
    let disagreement = |&over_ground: &[f32; 2]| disagreement(soles, over_ground, root);
    candidates.min_by(|a, b| disagreement(a).total_cmp(&disagreement(b)))
}

/// How little the points that stand agree with each other in a step, as a share of the speed, and the more the rarer anything stands.
fn disagreement(soles: &Soles, over_ground: [f32; 2], root: [f32; 2]) -> f32 {
    let ground = [over_ground[0] - root[0], over_ground[1] - root[1]];
    let standing = soles.standing(ground, STANDING_SHARE * speed_of(over_ground));
    let (mut apart, mut count, mut steps) = (0.0_f32, 0.0_f32, 0.0_f32);
    for points in &standing {
        let middle = [median(points, 0), median(points, 1)];
        for (_, velocity) in points {
            apart += speed_of([velocity[0] - middle[0], velocity[1] - middle[1]]);
            count += 1.0;
        }
        steps += f32::from(u8::from(!points.is_empty()));
    }
    if count == 0.0 { f32::INFINITY } else { apart / count / speed_of(over_ground) * standing.len() as f32 / steps }
}

/// The velocity at which feet that always stand somewhere do not drift over a turn of the clip; as it was where somebody is in the air at times.
fn even_out(soles: &Soles, over_ground: [f32; 2], root: [f32; 2]) -> [f32; 2] {
    let ground = [over_ground[0] - root[0], over_ground[1] - root[1]];
    let standing = soles.standing(ground, STANDING_SHARE * speed_of(over_ground));
    if standing.iter().any(Vec::is_empty) {
        return over_ground;
    }
    let drift = |axis: usize| standing.iter().map(|points| median(points, axis)).sum::<f32>() / standing.len() as f32;
    [over_ground[0] - drift(0), over_ground[1] - drift(1)]
}

/// The median along an axis of a step's standing points; 0 of none.
pub(crate) fn median(points: &[(usize, [f32; 2])], axis: usize) -> f32 {
    let mut values: Vec<f32> = points.iter().map(|(_, velocity)| velocity[axis]).collect();
    values.sort_unstable_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Length of a velocity along the ground.
pub(crate) fn speed_of([x, z]: [f32; 2]) -> f32 {
    (x * x + z * z).sqrt()
}

/// The soles of a moving character.
pub(crate) struct Soles {
    /// Their points, by number of the vertex.
    pub(crate) vertices: Vec<usize>,
    /// Where they are: `[frame][point]`, metres.
    pub(crate) paths: Vec<Vec<[f32; 3]>>,
    /// Of the character, metres.
    pub(crate) height: f32,
    /// Seconds from frame to frame.
    pub(crate) step_s: f32,
    ground: f32,
}

impl Soles {
    /// `None` for a single pose.
    pub(crate) fn of(
        positions: &[[f32; 3]],
        joints: &[[u16; 4]],
        weights: &[[f32; 4]],
        clip: &SampledClip,
        joint_count: usize,
    ) -> Option<Self> {
        let frames: Vec<&[Mat3x4]> = clip.palettes.chunks_exact(joint_count.max(1)).collect();
        if frames.len() < 2 || clip.duration_s <= 0.0 {
            return None;
        }
        let place =
            |vertex: usize, frame: usize| skin(positions[vertex], &joints[vertex], &weights[vertex], frames[frame]);
        let (vertices, height) = find_soles(positions.len(), frames.len(), place);
        let paths: Vec<Vec<[f32; 3]>> =
            (0..frames.len()).map(|frame| vertices.iter().map(|&vertex| place(vertex, frame)).collect()).collect();
        let low = |points: &Vec<[f32; 3]>| points.iter().fold(f32::INFINITY, |low, point| low.min(point[1]));
        let ground = quantile(paths.iter().map(low).collect(), GROUND_QUANTILE);
        let step_s = clip.duration_s / (frames.len() - 1) as f32;
        Some(Self { vertices, paths, height, step_s, ground })
    }

    /// Step by step, the points that stand and their velocities along x and z over the ground: those that are low enough before and after, and
    /// no faster than `slow`. `ground`: what the character moves by beside what is in its poses.
    pub(crate) fn standing(&self, ground: [f32; 2], slow: f32) -> Vec<Vec<(usize, [f32; 2])>> {
        let step = |pair: &[Vec<[f32; 3]>]| {
            let points = pair[0].iter().zip(&pair[1]).enumerate();
            let low = points.filter(|(_, (before, after))| self.is_planted(before) && self.is_planted(after));
            let moving = low.map(|(point, (before, after))| {
                (point, [0, 1].map(|axis| (after[axis * 2] - before[axis * 2]) / self.step_s + ground[axis]))
            });
            moving.filter(|(_, velocity)| speed_of(*velocity) <= slow).collect()
        };
        self.paths.windows(2).map(step).collect()
    }

    /// Low enough to stand.
    pub(crate) fn is_planted(&self, point: &[f32; 3]) -> bool {
        point[1] <= self.ground + PLANTED_SHARE * self.height
    }
}

/// The median of the shortest interval that holds [`AGREEING_SHARE`] of the values, and how long it is.
fn most_agreed(mut values: Vec<f32>) -> (f32, f32) {
    values.sort_unstable_by(f32::total_cmp);
    let count = ((values.len() as f32 * AGREEING_SHARE).ceil() as usize).clamp(1, values.len());
    let length = |interval: &&[f32]| interval[count - 1] - interval[0];
    let shortest = values.windows(count).min_by(|a, b| length(a).total_cmp(&length(b)));
    shortest.map_or((0.0, 0.0), |interval| (interval[count / 2], length(&interval)))
}

/// Vertices that come near to the ground in some of the frames, and the character's height in them.
fn find_soles(vertex_count: usize, frame_count: usize, place: impl Fn(usize, usize) -> [f32; 3]) -> (Vec<usize>, f32) {
    let searched = frame_count.min(SEARCHED_FRAMES);
    let mut lowest = vec![f32::INFINITY; vertex_count];
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for i in 0..searched {
        let frame = i * (frame_count - 1) / (searched - 1).max(1);
        for (vertex, lowest) in lowest.iter_mut().enumerate() {
            let y = place(vertex, frame)[1];
            *lowest = lowest.min(y);
            (low, high) = (low.min(y), high.max(y));
        }
    }
    let height = (high - low).max(0.0);
    let near: Vec<usize> = (0..vertex_count).filter(|&v| lowest[v] <= low + SOLE_SHARE * height).collect();
    let stride = near.len().div_ceil(SOLE_POINTS).max(1);
    (near.into_iter().step_by(stride).collect(), height)
}

/// The value that this share of the values lies below.
fn quantile(mut values: Vec<f32>, share: f32) -> f32 {
    values.sort_unstable_by(f32::total_cmp);
    values[((values.len() as f32 * share) as usize).min(values.len() - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RootMotion;

    const FRAMES: usize = 41;
    const DURATION_S: f32 = 1.0;
    const STRIDE_M: f32 = 0.7;

    /// Two legs of one point each at the sole and one at the hip, each with its joint: half the time a sole stands and slides back by
    /// the stride, half the time it swings forward through the air.
    fn walk(carried_m_s: f32) -> (Vec<[f32; 3]>, Vec<[u16; 4]>, Vec<[f32; 4]>, SampledClip) {
        let positions = vec![[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 1.8, 0.0]];
        let joints = vec![[0; 4], [1, 0, 0, 0], [2, 0, 0, 0]];
        let weights = vec![[1.0, 0.0, 0.0, 0.0]; 3];
        let mut palettes = Vec::new();
        for frame in 0..FRAMES {
            let time = frame as f32 / (FRAMES - 1) as f32;
            let carried = carried_m_s * time * DURATION_S;
            for leg in [0.0, 0.5] {
                let turn = (time + leg).fract();
                let (z, y) = if turn < 0.5 {
                    (STRIDE_M * (0.5 - turn * 2.0), 0.0)
                } else {
                    let swing = turn * 2.0 - 1.0;
                    (STRIDE_M * (swing - 0.5), 0.3 * libm::sinf(swing * std::f32::consts::PI))
                };
                palettes.push(moved([0.0, y, z + carried]));
            }
            palettes.push(moved([0.0, 0.0, carried]));
        }
        let root_motion = RootMotion { node: Some(0), displacement_m: [0.0, 0.0, carried_m_s * DURATION_S] };
        let clip = SampledClip {
            name: "walk".to_owned(),
            duration_s: DURATION_S,
            frame_count: FRAMES as u32,
            worlds: Vec::new(),
            palettes,
            root_motion,
            loop_gap_m: 0.0,
        };
        (positions, joints, weights, clip)
    }

    fn moved([x, y, z]: [f32; 3]) -> Mat3x4 {
        [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]
    }

    fn speed(carried_m_s: f32) -> f32 {
        let (positions, joints, weights, clip) = walk(carried_m_s);
        ground_speed(&positions, &joints, &weights, &clip, 3)
    }

    #[test]
    fn a_walk_on_the_spot_is_as_fast_as_its_feet_slide_back() {
        let expected = STRIDE_M / 0.5;
        assert!((speed(0.0) - expected).abs() < 0.02 * expected, "{}", speed(0.0));
    }

    #[test]
    fn a_walk_that_goes_along_is_as_fast_as_its_root() {
        // Carried at the speed of the walk the planted feet stand still; at half of it they slide by the other half.
        let expected = STRIDE_M / 0.5;
        for carried in [expected, expected / 2.0, -0.3] {
            assert!((speed(carried) - expected).abs() < 0.02 * expected, "{carried}: {}", speed(carried));
        }
    }

    #[test]
    fn who_stands_shuffles_or_hops_does_not_walk() {
        let (positions, joints, weights, mut clip) = walk(0.0);
        let still: Vec<Mat3x4> = (0..FRAMES * 3).map(|_| moved([0.0; 3])).collect();
        clip.palettes = still;
        assert_eq!(ground_speed(&positions, &joints, &weights, &clip, 3), 0.0);
        let shuffled = |i: usize| moved([0.1 * libm::sinf(((i / 3) * (i / 3)) as f32), 0.0, 0.0]);
        clip.palettes = (0..FRAMES * 3).map(shuffled).collect();
        assert_eq!(ground_speed(&positions, &joints, &weights, &clip, 3), 0.0, "now here, now there");
        clip.palettes.clone_from(&walk(0.0).3.palettes);
        clip.loop_gap_m = 0.5;
        assert_eq!(ground_speed(&positions, &joints, &weights, &clip, 3), 0.0, "does not end where it began");
        clip.loop_gap_m = 0.0;
        let hopping = |i: usize| moved([0.02 * i as f32, if (i / 3).is_multiple_of(2) { 0.0 } else { 0.5 }, 0.0]);
        clip.palettes = (0..FRAMES * 3).map(hopping).collect();
        assert_eq!(ground_speed(&positions, &joints, &weights, &clip, 3), 0.0, "never on the ground for two frames");
        clip.palettes.truncate(3);
        assert_eq!(ground_speed(&positions, &joints, &weights, &clip, 3), 0.0, "a single pose");
        assert_eq!(ground_speed(&[], &[], &[], &walk(0.0).3, 3), 0.0, "nobody");
    }
}
