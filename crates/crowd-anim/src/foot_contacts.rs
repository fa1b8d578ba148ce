//! When feet stand on the ground during a clip, and how much they slide when it is played as fast as it walks.

use crate::SampledClip;
use crate::ground_speed::{STANDING_SHARE, Soles, median, speed_of, walking_velocity};

/// Where nobody walks: faster than this share of the height a second.
const STILL_SHARE: f32 = 0.15;

/// A joint whose sole stands on the ground for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootContact {
    /// The joint, an index into the palette.
    pub joint: u32,
    /// Seconds into the clip.
    pub start_s: f32,
    /// Seconds into the clip, after `start_s`.
    pub end_s: f32,
}

/// The feet of a clip.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FootContacts {
    /// How fast the clip walks over the ground, metres a second, as [`crate::ground_speed`] says.
    pub ground_speed_m_s: f32,
    /// By joint, then by time.
    pub contacts: Vec<FootContact>,
    /// Mean speed over the ground of the points that stand, metres a second, when the character moves at the clip's ground speed
    /// ([`crate::ground_speed`]); of clips that do not walk, when it stays.
    pub slide_m_s: f32,
    /// Where the character has to be, x and z in metres beside its even way, for standing feet to stay: frame by frame, the last as the first, around
    /// zero. A body that walks is faster and slower within a step. Empty where the clip does not walk.
    pub root_path_m: Vec<[f32; 2]>,
    /// The slide that is left along that path: feet that roll, and two that disagree.
    pub rooted_slide_m_s: f32,
}

/// The contacts of a clip's feet.
///
/// Soles and ground as in [`crate::ground_speed`]. A point stands between two frames when it is no more than 2 % of the height over the ground
/// in both and moves over the ground slower than half of the walking speed (of clips that do not walk: than 15 % of the height a second).
/// A joint stands while one of the points does that follow it most. Single poses have no contacts.
///
/// `positions`, `joints`, `weights`: one per vertex, bind space, metres, Y up; `joint_count`: matrices a frame in the clip's palettes.
pub fn foot_contacts(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    clip: &SampledClip,
    joint_count: usize,
) -> FootContacts {
    let Some(soles) = Soles::of(positions, joints, weights, clip, joint_count) else { return FootContacts::default() };
    let velocity = walking_velocity(&soles, clip);
    // The root's own part of it is in the poses.
    let root = [0, 2].map(|axis| clip.root_motion.displacement_m[axis] / clip.duration_s);
    let ground = velocity.map_or([0.0; 2], |velocity| [velocity[0] - root[0], velocity[1] - root[1]]);
    let slow = velocity.map_or(STILL_SHARE * soles.height, |velocity| STANDING_SHARE * speed_of(velocity));
    let leading: Vec<u16> =
        soles.vertices.iter().map(|&vertex| leading_joint(&joints[vertex], &weights[vertex])).collect();

    let standing = soles.standing(ground, slow);
    // `[step][joint]`.
    let mut stands = vec![vec![false; joint_count]; standing.len()];
    for (points, stands) in standing.iter().zip(&mut stands) {
        for &(point, _) in points {
            if let Some(stands) = stands.get_mut(usize::from(leading[point])) {
                *stands = true;
            }
        }
    }
    let contacts = (0..joint_count).flat_map(|joint| runs(&stands, joint, soles.step_s));
    let still = vec![[0.0; 2]; standing.len()];
    let mut feet = FootContacts {
        ground_speed_m_s: velocity.map_or(0.0, speed_of),
        contacts: contacts.collect(),
        slide_m_s: mean_speed(&standing, &still),
        ..FootContacts::default()
    };
    if velocity.is_some() {
        let drifts = even_drifts(&standing);
        feet.rooted_slide_m_s = mean_speed(&standing, &drifts);
        feet.root_path_m = path_against(&drifts, soles.step_s);
    }
    feet
}

/// Mean speed of the points that stand, less a velocity a step.
fn mean_speed(standing: &[Vec<(usize, [f32; 2])>], less: &[[f32; 2]]) -> f32 {
    let apart = |((_, [x, z]), less): (&(usize, [f32; 2]), &[f32; 2])| f64::from(speed_of([x - less[0], z - less[1]]));
    let pairs = standing.iter().zip(less).flat_map(|(points, less)| points.iter().map(move |point| (point, less)));
    let (sum, count) = pairs.fold((0.0, 0_u32), |(sum, count), pair| (sum + apart(pair), count + 1));
    (sum / f64::from(count.max(1))) as f32
}

/// The median velocity of each step's standing points, and what they drift by in all taken out again: in the steps in which nobody stands, or, where
/// there is none, in all alike.
fn even_drifts(standing: &[Vec<(usize, [f32; 2])>]) -> Vec<[f32; 2]> {
    let mut drifts: Vec<[f32; 2]> = standing.iter().map(|points| [median(points, 0), median(points, 1)]).collect();
    let in_air = standing.iter().filter(|points| points.is_empty()).count();
    for axis in 0..2 {
        let sum: f32 = drifts.iter().map(|drift| drift[axis]).sum();
        for (drift, points) in drifts.iter_mut().zip(standing) {
            if in_air == 0 {
                drift[axis] -= sum / standing.len() as f32;
            } else if points.is_empty() {
                drift[axis] = -sum / in_air as f32;
            }
        }
    }
    drifts
}

/// The way that takes the drifts back, around zero.
fn path_against(drifts: &[[f32; 2]], step_s: f32) -> Vec<[f32; 2]> {
    let mut path = vec![[0.0; 2]];
    for (frame, drift) in drifts.iter().enumerate() {
        path.push([0, 1].map(|axis| path[frame][axis] - drift[axis] * step_s));
    }
    // It closes but for rounding.
    path.pop();
    path.push(path[0]);
    let middle = [0, 1].map(|axis| path[1..].iter().map(|at| at[axis]).sum::<f32>() / (path.len() - 1) as f32);
    path.iter().map(|at| [at[0] - middle[0], at[1] - middle[1]]).collect()
}

/// The joint of the largest weight, the first of equals.
fn leading_joint(joints: &[u16; 4], weights: &[f32; 4]) -> u16 {
    let best = (1..4).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
    joints[best]
}

/// The unbroken times in which a joint stands.
fn runs(stands: &[Vec<bool>], joint: usize, step_s: f32) -> Vec<FootContact> {
    let mut runs = Vec::new();
    let mut start = None;
    for step in 0..=stands.len() {
        let standing = stands.get(step).is_some_and(|joints| joints[joint]);
        match (standing, start) {
            (true, None) => start = Some(step),
            (false, Some(first)) => {
                let [start_s, end_s] = [first, step].map(|step| step as f32 * step_s);
                runs.push(FootContact { joint: joint as u32, start_s, end_s });
                start = None;
            }
            _ => {}
        }
    }
    runs
}
