//! Poses in motion, shared by two-legged and four-legged characters: a pose, two-bone legs, and clips from pose functions.

use glam::{Mat3, Quat, Vec3};

use crate::glb::{Clip, Curve};
use crate::human_rig::Joint;

/// A pose: one local rotation per joint (rest is none) and the root joint's offset in metres.
#[derive(Clone, Debug)]
pub struct Pose {
    /// Local rotations.
    pub rotations: Vec<Quat>,
    /// Offset of joint 0 from its bind position.
    pub root: Vec3,
}

impl Pose {
    /// The bind pose.
    pub fn rest(joints: &[Joint]) -> Self {
        Self { rotations: vec![Quat::IDENTITY; joints.len()], root: Vec3::ZERO }
    }

    /// World rotation and position of every joint.
    pub fn globals(&self, joints: &[Joint]) -> Vec<(Quat, Vec3)> {
        let mut out: Vec<(Quat, Vec3)> = Vec::with_capacity(joints.len());
        for (i, j) in joints.iter().enumerate() {
            out.push(match j.parent {
                None => (self.rotations[i], j.position + self.root),
                Some(p) => {
                    let (q, at) = out[p];
                    ((q * self.rotations[i]).normalize(), at + q * (j.position - joints[p].position))
                }
            });
        }
        out
    }

    /// Multiplies a joint's rotation from the right.
    pub fn turn(&mut self, joint: usize, q: Quat) {
        self.rotations[joint] = (self.rotations[joint] * q).normalize();
    }

    /// Bends the two bones `upper`, `lower` so that `end` comes to `target` (world, metres) and is turned by `end_turn`
    /// (world). The middle joint points towards `pole`. A target out of reach is approached.
    pub fn reach(
        &mut self,
        joints: &[Joint],
        upper: usize,
        lower: usize,
        end: usize,
        target: Vec3,
        pole: Vec3,
        end_turn: Quat,
    ) {
        let globals = self.globals(joints);
        let parent = joints[upper].parent.map_or(Quat::IDENTITY, |p| globals[p].0);
        let hip = globals[upper].1;
        let (b1, b2) = (joints[lower].position - joints[upper].position, joints[end].position - joints[lower].position);
        let (l1, l2) = (b1.length(), b2.length());
        let to = target - hip;
        let d = to.length().clamp((l1 - l2).abs() + 1e-4, (l1 + l2) * 0.9995);
        let dir = to.normalize();
        let out = (pole - dir * pole.dot(dir)).normalize();
        let along = (l1 * l1 - l2 * l2 + d * d) / (2.0 * d);
        let high = (l1 * l1 - along * along).max(0.0).sqrt();
        let knee = hip + dir * along + out * high;
        let foot = hip + dir * d;
        let q1 = frame_turn(b1, pole, knee - hip, out);
        let q2 = frame_turn(b2, pole, foot - knee, out);
        self.rotations[upper] = (parent.inverse() * q1).normalize();
        self.rotations[lower] = (q1.inverse() * q2).normalize();
        self.rotations[end] = (q2.inverse() * end_turn).normalize();
    }
}

/// The rotation that takes bone `from` (with its hinge across `from_pole`) to `to` (with its hinge across `to_pole`).
fn frame_turn(from: Vec3, from_pole: Vec3, to: Vec3, to_pole: Vec3) -> Quat {
    let frame = |bone: Vec3, pole: Vec3| {
        let y = bone.normalize();
        let x = y.cross(pole).normalize();
        Mat3::from_cols(x, y, x.cross(y))
    };
    Quat::from_mat3(&(frame(to, to_pole) * frame(from, from_pole).transpose())).normalize()
}

/// A rotation of `degrees` about an axis.
pub fn turn(axis: Vec3, degrees: f32) -> Quat {
    let (s, c) = libm::sincosf(degrees * core::f32::consts::PI / 360.0);
    let a = axis.normalize() * s;
    Quat::from_xyzw(a.x, a.y, a.z, c)
}

/// Samples `pose_at` (phase 0..1) into a clip of `keys` + 1 keys; the last key is the first, bit for bit.
///
/// Curves that stay at rest are left out.
pub fn clip(
    name: &str,
    joints: &[Joint],
    seconds: f32,
    keys: usize,
    first_node: usize,
    pose_at: &dyn Fn(f32) -> Pose,
) -> Clip {
    let mut poses: Vec<Pose> = (0..keys).map(|k| pose_at(k as f32 / keys as f32)).collect();
    poses.push(poses[0].clone());
    let times = (0..=keys).map(|k| seconds * k as f32 / keys as f32).collect();
    let mut curves = Vec::new();
    let moved: Vec<Vec3> = poses.iter().map(|p| joints[0].position + p.root).collect();
    curves.push((first_node, Curve::Translation(moved)));
    for j in 0..joints.len() {
        let mut list: Vec<Quat> = poses.iter().map(|p| p.rotations[j]).collect();
        for k in 1..keys {
            if list[k].dot(list[k - 1]) < 0.0 {
                list[k] = -list[k];
            }
        }
        if list.iter().any(|q| q.w.abs() < 1.0 - 1e-7) {
            curves.push((first_node + j, Curve::Rotation(list)));
        }
    }
    Clip { name: name.to_string(), times, curves }
}
