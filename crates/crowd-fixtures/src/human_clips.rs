//! How people stand, walk, run, sit and bend. Feet are put where they belong and the legs follow.

use glam::{Quat, Vec3};

use crate::body::ARM_DROP;
use crate::glb::Clip;
use crate::human_rig::{Joint, joint};
use crate::motion::{Pose, clip, turn};
use crate::profile::{Profile, mix, smoothstep};

const TAU: f32 = core::f32::consts::TAU;

/// Manners that differ from person to person.
#[derive(Clone, Copy, Debug)]
pub struct Manner {
    /// Seconds of one walking cycle (two steps).
    pub walk_seconds: f32,
    /// Step length against the leg's.
    pub step: f32,
    /// Hip sway and roll, 1 = ordinary.
    pub sway: f32,
    /// Arm swing, 1 = ordinary.
    pub swing: f32,
    /// How far the arms are held off the body, degrees.
    pub arms_out: f32,
    /// Stoop of the back, degrees.
    pub stoop: f32,
}

/// Turns a left-side rotation into the right side's.
fn mirror(q: Quat, side: usize) -> Quat {
    if side == 0 { q } else { Quat::from_xyzw(q.x, -q.y, -q.z, q.w) }
}

/// Hangs an arm down, swings it forward by `forward` degrees, holds it `out` degrees off and bends the elbow.
fn pose_arm(pose: &mut Pose, side: usize, forward: f32, out: f32, elbow: f32, inward: f32) {
    let base = side * joint::RIGHT;
    let drop = 90.0 - ARM_DROP * 360.0 / TAU - out;
    let hang = turn(Vec3::Z, -drop);
    let upper = turn(Vec3::X, -forward) * hang;
    let axis = hang.inverse() * Vec3::X;
    let forearm = turn(axis, -elbow);
    pose.rotations[base + joint::UPPER_ARM] = mirror(turn(Vec3::Y, -inward) * upper, side);
    pose.rotations[base + joint::FOREARM] = mirror(forearm, side);
    pose.rotations[base + joint::CLAVICLE] = mirror(turn(Vec3::Z, -3.0) * turn(Vec3::Y, -forward * 0.12), side);
}

fn curl_fingers(pose: &mut Pose, side: usize, amount: f32) {
    let base = side * joint::RIGHT + joint::FINGERS;
    for k in 0..5 {
        let axis = if k == 0 { Vec3::new(0.3, -1.0, 0.2) } else { Vec3::NEG_Z };
        let grip = if k == 0 { 0.4 } else { 1.0 + 0.1 * k as f32 };
        pose.rotations[base + 2 * k] = mirror(turn(axis, amount * grip), side);
        pose.rotations[base + 2 * k + 1] = mirror(turn(axis, amount * grip * 1.1), side);
    }
}

/// Puts a foot: `ankle` offset from its bind place, `pitch` degrees toes-down, ball of the foot bent by `toes`.
fn put_foot(pose: &mut Pose, joints: &[Joint], side: usize, offset: Vec3, pitch: f32, toes: f32) {
    let base = side * joint::RIGHT;
    let ankle = joints[base + joint::FOOT].position;
    let q = turn(Vec3::X, pitch);
    // Toes down: the ball stays where it is and the ankle rises about it. Toes up: the heel stays.
    let pivot = if pitch > 0.0 {
        joints[base + joint::TOES].position
    } else {
        ankle + Vec3::new(0.0, -ankle.y, -0.7 * ankle.y)
    };
    let target = pivot + q * (ankle - pivot) + offset;
    pose.reach(joints, base + joint::THIGH, base + joint::SHIN, base + joint::FOOT, target, Vec3::Z, q);
    pose.rotations[base + joint::TOES] = turn(Vec3::X, -toes);
}

fn leg_length(joints: &[Joint]) -> f32 {
    joints[joint::THIGH].position.y - joints[joint::FOOT].position.y
}

fn wave(p: f32) -> f32 {
    libm::cosf(TAU * p)
}

/// One step's curve over its phase: (z in steps, lift, pitch).
fn walk_foot(phase: f32) -> (f32, f32, f32) {
    let p = phase - libm::floorf(phase);
    let stance = 0.61;
    let z = if p < stance { 0.5 - p / stance } else { smoothstep(stance, 1.0, p) - 0.5 };
    let lift = Profile::new(&[(0.0, 0.0), (0.60, 0.0), (0.72, 0.55), (0.82, 0.42), (0.92, 0.35), (1.0, 0.0)]).at(p);
    let pitch = Profile::new(&[
        (0.0, -18.0),
        (0.10, 0.0),
        (0.38, 0.0),
        (0.52, 18.0),
        (0.62, 38.0),
        (0.72, 30.0),
        (0.85, -6.0),
        (0.95, -18.0),
        (1.0, -18.0),
    ]);
    (z, lift, pitch.at(p))
}

fn run_foot(phase: f32) -> (f32, f32, f32) {
    let p = phase - libm::floorf(phase);
    let stance = 0.34;
    let z = if p < stance { 0.42 - 0.92 * p / stance } else { 0.92 * smoothstep(stance + 0.06, 0.94, p) - 0.50 };
    let lift =
        Profile::new(&[(0.0, 0.0), (0.34, 0.0), (0.48, 2.6), (0.60, 3.3), (0.74, 2.3), (0.90, 0.7), (1.0, 0.0)]).at(p);
    let pitch = Profile::new(&[
        (0.0, -6.0),
        (0.08, 0.0),
        (0.2, 8.0),
        (0.34, 45.0),
        (0.5, 62.0),
        (0.75, 12.0),
        (0.92, -10.0),
        (1.0, -6.0),
    ]);
    (z, lift, pitch.at(p))
}

/// The clips of one person; `nodes` is the first joint's node.
pub fn clips(joints: &[Joint], manner: &Manner, strong: &str, nodes: usize) -> Vec<Clip> {
    let m = *manner;
    let strong_pose: &dyn Fn(f32) -> Pose =
        if strong == "sit" { &|p| sit(joints, &m, p) } else { &|p| bend(joints, &m, p) };
    vec![
        clip("idle", joints, 4.0, 24, nodes, &|p| idle(joints, &m, p)),
        clip("walk", joints, m.walk_seconds, 24, nodes, &|p| walk(joints, &m, p)),
        clip("run", joints, m.walk_seconds * 0.64, 20, nodes, &|p| run(joints, &m, p)),
        clip(strong, joints, 4.0, 32, nodes, strong_pose),
    ]
}

fn hair_sways(pose: &mut Pose, forward: f32, sideways: f32) {
    if pose.rotations.len() > joint::HAIR + 1 {
        let q = turn(Vec3::X, forward) * turn(Vec3::Z, sideways);
        pose.rotations[joint::HAIR] = q;
        pose.rotations[joint::HAIR + 1] = q;
    }
}

fn idle(joints: &[Joint], m: &Manner, p: f32) -> Pose {
    let mut pose = Pose::rest(joints);
    let leg = leg_length(joints);
    let breath = -wave(2.0 * p);
    let shift = libm::sinf(TAU * p);
    pose.root = Vec3::new(0.018 * shift * m.sway, leg * (-0.012 + 0.003 * breath), 0.0);
    pose.rotations[joint::HIPS] = turn(Vec3::Z, -1.6 * shift * m.sway) * turn(Vec3::Y, 2.0 * shift);
    pose.rotations[joint::SPINE] = turn(Vec3::Z, 1.5 * shift * m.sway) * turn(Vec3::X, 0.4 * m.stoop);
    pose.rotations[joint::CHEST] = turn(Vec3::X, 0.3 * m.stoop - 0.8 * breath) * turn(Vec3::Z, 0.8 * shift);
    pose.rotations[joint::UPPER_CHEST] = turn(Vec3::X, 0.3 * m.stoop - 0.8 * breath);
    pose.rotations[joint::NECK] = turn(Vec3::X, -0.4 * m.stoop + 0.8 * breath);
    pose.rotations[joint::HEAD] =
        turn(Vec3::Y, 9.0 * libm::sinf(TAU * p + 0.8)) * turn(Vec3::X, -0.5 * m.stoop + 1.5 * shift);
    for side in 0..2 {
        let s = if side == 0 { 1.0 } else { -1.0 };
        pose_arm(
            &mut pose,
            side,
            2.0 + 1.5 * breath * 0.5 + s * shift,
            m.arms_out + 1.0 + 0.8 * breath,
            14.0 + s * 2.0,
            6.0,
        );
        curl_fingers(&mut pose, side, 16.0);
        put_foot(&mut pose, joints, side, Vec3::new(s * 0.004, 0.0, s * 0.015), 0.0, 0.0);
    }
    hair_sways(&mut pose, 0.0, -1.5 * shift);
    pose
}

fn walk(joints: &[Joint], m: &Manner, p: f32) -> Pose {
    let mut pose = Pose::rest(joints);
    let leg = leg_length(joints);
    // The body is lowest just after each heel strike and highest over the standing leg.
    pose.root = Vec3::new(0.022 * m.sway * wave(p - 0.30), leg * (-0.036 - 0.018 * wave(2.0 * (p - 0.04))), 0.0);
    let yaw = 7.0 * wave(p);
    let roll = 3.2 * m.sway * libm::sinf(TAU * (p - 0.03));
    pose.rotations[joint::HIPS] = turn(Vec3::Y, -yaw) * turn(Vec3::Z, roll) * turn(Vec3::X, 2.0);
    pose.rotations[joint::SPINE] = turn(Vec3::Y, 0.7 * yaw) * turn(Vec3::Z, -0.7 * roll) * turn(Vec3::X, 0.4 * m.stoop);
    pose.rotations[joint::CHEST] = turn(Vec3::Y, 0.7 * yaw) * turn(Vec3::Z, -0.5 * roll) * turn(Vec3::X, 0.3 * m.stoop);
    pose.rotations[joint::UPPER_CHEST] = turn(Vec3::Y, 0.5 * yaw) * turn(Vec3::X, 0.3 * m.stoop);
    pose.rotations[joint::NECK] = turn(Vec3::Y, -0.4 * yaw) * turn(Vec3::X, -0.5 * m.stoop);
    pose.rotations[joint::HEAD] =
        turn(Vec3::Y, -0.5 * yaw) * turn(Vec3::X, -2.0 - 0.5 * m.stoop + 1.2 * wave(2.0 * p + 0.2));
    for side in 0..2 {
        let q = p + 0.5 * side as f32;
        let swing = -24.0 * m.swing * wave(q - 0.04);
        pose_arm(&mut pose, side, swing + 2.0, m.arms_out, 15.0 + 8.0 * m.swing * (1.0 - wave(q - 0.1)), 4.0);
        curl_fingers(&mut pose, side, 20.0);
        let (z, lift, pitch) = walk_foot(q);
        let s = if side == 0 { 1.0 } else { -1.0 };
        let offset = Vec3::new(-s * 0.018, 0.055 * leg * lift, z * m.step * leg);
        put_foot(
            &mut pose,
            joints,
            side,
            offset,
            pitch,
            if z < 0.1 { pitch.max(0.0) * smoothstep(0.66, 0.55, q - libm::floorf(q)) } else { 0.0 },
        );
    }
    hair_sways(&mut pose, -4.0 + 5.0 * wave(2.0 * p + 0.15), 6.0 * wave(p - 0.1));
    pose
}

fn run(joints: &[Joint], m: &Manner, p: f32) -> Pose {
    let mut pose = Pose::rest(joints);
    let leg = leg_length(joints);
    pose.root = Vec3::new(0.010 * m.sway * wave(p - 0.17), leg * (-0.050 - 0.055 * wave(2.0 * (p - 0.15))), 0.0);
    let yaw = 11.0 * wave(p);
    pose.rotations[joint::HIPS] = turn(Vec3::Y, -yaw) * turn(Vec3::X, 9.0) * turn(Vec3::Z, 3.0 * libm::sinf(TAU * p));
    pose.rotations[joint::SPINE] = turn(Vec3::Y, 0.8 * yaw) * turn(Vec3::X, 2.0 + 0.3 * m.stoop);
    pose.rotations[joint::CHEST] = turn(Vec3::Y, 0.8 * yaw) * turn(Vec3::X, 2.0);
    pose.rotations[joint::UPPER_CHEST] = turn(Vec3::Y, 0.6 * yaw);
    pose.rotations[joint::NECK] = turn(Vec3::Y, -0.5 * yaw) * turn(Vec3::X, -5.0);
    pose.rotations[joint::HEAD] = turn(Vec3::Y, -0.7 * yaw) * turn(Vec3::X, -6.0 + 2.0 * wave(2.0 * p));
    for side in 0..2 {
        let q = p + 0.5 * side as f32;
        let swing = -44.0 * m.swing.min(1.2) * wave(q - 0.02);
        pose_arm(&mut pose, side, swing - 6.0, m.arms_out + 6.0, 88.0 - 16.0 * wave(q), 12.0);
        curl_fingers(&mut pose, side, 55.0);
        let (z, lift, pitch) = run_foot(q);
        let s = if side == 0 { 1.0 } else { -1.0 };
        let offset = Vec3::new(-s * 0.026, 0.10 * leg * lift, z * 1.15 * leg * mix(1.0, m.step / 0.72, 0.5));
        put_foot(&mut pose, joints, side, offset, pitch, 0.0);
    }
    hair_sways(&mut pose, -18.0 + 10.0 * wave(2.0 * p + 0.2), 9.0 * wave(p - 0.1));
    pose
}

/// 0 standing, 1 down; the same at both ends of the clip.
fn there_and_back(p: f32) -> f32 {
    smoothstep(0.04, 0.36, p) * smoothstep(0.96, 0.66, p)
}

fn sit(joints: &[Joint], m: &Manner, p: f32) -> Pose {
    let mut pose = idle(joints, m, 0.0);
    let a = there_and_back(p);
    // Bowing forward is strongest half way down.
    let bow = 4.0 * a * (1.0 - a);
    let hip = joints[joint::THIGH].position;
    let seat = joints[joint::SHIN].position.y + 0.02;
    let leg = leg_length(joints);
    pose.root = Vec3::new(0.0, mix(pose.root.y, seat - hip.y, a), -0.46 * leg * a);
    pose.rotations[joint::HIPS] = turn(Vec3::X, 26.0 * bow - 8.0 * a);
    pose.rotations[joint::SPINE] = turn(Vec3::X, 12.0 * bow + 5.0 * a + 0.4 * m.stoop);
    pose.rotations[joint::CHEST] = turn(Vec3::X, 6.0 * bow + 4.0 * a + 0.3 * m.stoop);
    pose.rotations[joint::NECK] = turn(Vec3::X, -16.0 * bow - 0.4 * m.stoop);
    pose.rotations[joint::HEAD] =
        turn(Vec3::X, -10.0 * bow + 2.0 * a) * turn(Vec3::Y, 14.0 * a * libm::sinf(TAU * 2.0 * p));
    for side in 0..2 {
        let s = if side == 0 { 1.0 } else { -1.0 };
        pose_arm(
            &mut pose,
            side,
            2.0 + 17.0 * a + 20.0 * bow,
            m.arms_out + 3.0 * a,
            14.0 + s * 2.0 * (1.0 - a) + 42.0 * a,
            6.0 + 6.0 * a,
        );
        curl_fingers(&mut pose, side, 16.0);
        put_foot(&mut pose, joints, side, Vec3::new(s * 0.02 * a, 0.0, 0.0), 0.0, 0.0);
    }
    hair_sways(&mut pose, -10.0 * bow, 0.0);
    pose
}

fn bend(joints: &[Joint], m: &Manner, p: f32) -> Pose {
    let mut pose = idle(joints, m, 0.0);
    let a = there_and_back(p);
    let leg = leg_length(joints);
    pose.root = Vec3::new(0.0, mix(pose.root.y, -0.20 * leg, a), -0.20 * leg * a);
    pose.rotations[joint::HIPS] = turn(Vec3::X, 46.0 * a);
    pose.rotations[joint::SPINE] = turn(Vec3::X, 22.0 * a + 0.4 * m.stoop);
    pose.rotations[joint::CHEST] = turn(Vec3::X, 18.0 * a + 0.3 * m.stoop);
    pose.rotations[joint::UPPER_CHEST] = turn(Vec3::X, 8.0 * a + 0.3 * m.stoop);
    pose.rotations[joint::NECK] = turn(Vec3::X, -14.0 * a - 0.4 * m.stoop);
    pose.rotations[joint::HEAD] = turn(Vec3::X, -16.0 * a);
    for side in 0..2 {
        let s = if side == 0 { 1.0 } else { -1.0 };
        let reach = if side == 0 { 84.0 } else { 62.0 };
        pose_arm(&mut pose, side, 2.0 + reach * a, m.arms_out, 14.0 + s * 2.0 * (1.0 - a), 6.0);
        curl_fingers(&mut pose, side, 16.0 + 30.0 * a);
        put_foot(&mut pose, joints, side, Vec3::new(s * 0.02 * a, 0.0, s * 0.03 * a), 0.0, 0.0);
    }
    hair_sways(&mut pose, -50.0 * a, 0.0);
    pose
}
