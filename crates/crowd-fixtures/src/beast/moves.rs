//! How four-legged animals walk, gallop and graze.

use glam::{Vec3, vec3};

use super::{Kind, TAU, joint, leg_joints};
use crate::glb::Clip;
use crate::human_rig::Joint;
use crate::motion::{Pose, clip, turn};
use crate::profile::smoothstep;

/// Puts a hoof `z`, `y` metres from its bind place, its foot folded back by `fold` degrees.
fn put_hoof(pose: &mut Pose, joints: &[Joint], hind: bool, side: usize, z: f32, y: f32, fold: f32) {
    let (first, _) = leg_joints(hind, side);
    if hind {
        let (femur, tibia, cannon, pastern) = (first, first + 1, first + 2, first + 3);
        let swing = turn(Vec3::X, fold * 0.55 - z * 40.0);
        let down = joints[pastern].position - joints[cannon].position;
        let hock = joints[pastern].position + vec3(0.0, y, z) - swing * down;
        pose.reach(joints, femur, tibia, cannon, hock, Vec3::Z, swing);
        pose.rotations[pastern] = (swing.inverse() * turn(Vec3::X, fold)).normalize();
    } else {
        let (humerus, radius, cannon, pastern) = (first + 1, first + 2, first + 3, first + 4);
        pose.rotations[first] = turn(Vec3::X, -z * 22.0);
        pose.rotations[humerus] = turn(Vec3::X, -z * 18.0 - 0.25 * fold);
        let target = joints[pastern].position + vec3(0.0, y, z);
        pose.reach(joints, radius, cannon, pastern, target, Vec3::Z, turn(Vec3::X, fold));
    }
}

/// All clips of one animal.
pub(super) fn clips(kind: Kind, joints: &[Joint]) -> Vec<Clip> {
    vec![
        clip("walk", joints, 1.3, 24, 2, &|p| walk(joints, kind, p)),
        clip("run", joints, 0.62, 20, 2, &|p| gallop(joints, kind, p)),
        clip("graze", joints, 5.0, 30, 2, &|p| graze(joints, kind, p)),
    ]
}

fn wave(p: f32) -> f32 {
    libm::cosf(TAU * p)
}

fn step(phase: f32, stance: f32) -> (f32, f32) {
    let p = phase - libm::floorf(phase);
    if p < stance {
        (0.5 - p / stance, 0.0)
    } else {
        let t = (p - stance) / (1.0 - stance);
        (smoothstep(0.0, 1.0, t) - 0.5, libm::sinf(0.5 * TAU * t))
    }
}

fn tail_and_ears(pose: &mut Pose, p: f32, lift: f32) {
    for n in 0..7 {
        let late = p - 0.07 * n as f32;
        let up = if n < 2 { lift } else { 0.0 };
        pose.rotations[joint::TAIL + n] = turn(Vec3::Z, 5.0 * wave(late)) * turn(Vec3::X, up);
    }
    for side in 0..2 {
        let s = if side == 0 { 1.0 } else { -1.0 };
        pose.rotations[joint::EARS + 2 * side] = turn(Vec3::Y, s * 9.0 * wave(2.0 * p + 0.2 * side as f32));
    }
}

fn walk(joints: &[Joint], kind: Kind, p: f32) -> Pose {
    let mut pose = Pose::rest(joints);
    pose.root = vec3(0.012 * wave(p), -0.018 + 0.010 * wave(2.0 * p), 0.0);
    pose.rotations[joint::HIPS] = turn(Vec3::Y, 2.5 * wave(p + 0.1)) * turn(Vec3::Z, 1.5 * wave(p));
    pose.rotations[joint::SPINE] = turn(Vec3::Y, -2.0 * wave(p + 0.1));
    pose.rotations[joint::SPINE + 2] = turn(Vec3::Y, -1.5 * wave(p + 0.1));
    for n in 0..4 {
        let low = if kind == Kind::Zebra { 3.0 } else { 2.0 };
        pose.rotations[joint::NECK + n] = turn(Vec3::X, low + 1.6 * wave(2.0 * p - 0.15));
    }
    pose.rotations[joint::HEAD] = turn(Vec3::X, -6.0 - 3.0 * wave(2.0 * p - 0.05));
    tail_and_ears(&mut pose, p, 2.0);
    // Lateral sequence: left hind, left fore, right hind, right fore.
    for (hind, side, phase) in [(true, 0, 0.0), (false, 0, 0.77), (true, 1, 0.5), (false, 1, 0.27)] {
        let (z, up) = step(p + phase, 0.62);
        let reach = if hind { 0.50 } else { 0.48 };
        put_hoof(&mut pose, joints, hind, side, z * reach, 0.09 * up, 42.0 * up);
    }
    pose
}

fn gallop(joints: &[Joint], kind: Kind, p: f32) -> Pose {
    let mut pose = Pose::rest(joints);
    let rock = wave(p - 0.12);
    pose.root = vec3(0.0, -0.03 + 0.055 * wave(p - 0.42), 0.0);
    pose.rotations[joint::HIPS] = turn(Vec3::X, 6.0 * rock);
    for n in 0..3 {
        pose.rotations[joint::SPINE + n] = turn(Vec3::X, 4.0 * wave(p - 0.35));
    }
    pose.rotations[joint::CHEST] = turn(Vec3::X, -5.0 * wave(p - 0.30));
    for n in 0..4 {
        let stretch = if kind == Kind::Zebra { 6.0 } else { 3.0 };
        pose.rotations[joint::NECK + n] = turn(Vec3::X, stretch - 4.0 * wave(p - 0.2));
    }
    pose.rotations[joint::HEAD] = turn(Vec3::X, -14.0 + 7.0 * wave(p - 0.15));
    tail_and_ears(&mut pose, p, 18.0);
    for (hind, side, phase) in [(true, 0, 0.0), (true, 1, -0.10), (false, 0, -0.46), (false, 1, -0.58)] {
        let (z, up) = step(p + phase, 0.30);
        let reach = if hind { 0.78 } else { 0.80 };
        let forward = if hind { 0.05 } else { -0.02 };
        put_hoof(&mut pose, joints, hind, side, z * reach + forward, 0.20 * up, if hind { 66.0 } else { 54.0 } * up);
    }
    pose
}

fn graze(joints: &[Joint], kind: Kind, p: f32) -> Pose {
    let mut pose = Pose::rest(joints);
    let down = smoothstep(0.02, 0.26, p) * smoothstep(0.98, 0.76, p);
    let munch = down * wave(5.0 * p);
    pose.root = vec3(0.0, -0.015 - 0.05 * down, -0.03 * down);
    pose.rotations[joint::SPINE + 1] = turn(Vec3::X, 3.0 * down);
    pose.rotations[joint::CHEST] = turn(Vec3::X, 12.0 * down);
    let bend = if kind == Kind::Zebra { [46.0, 32.0, 12.0, 0.0] } else { [40.0, 28.0, 6.0, 0.0] };
    for (n, b) in bend.into_iter().enumerate() {
        pose.rotations[joint::NECK + n] =
            turn(Vec3::X, b * down) * turn(Vec3::Y, 3.0 * down * libm::sinf(TAU * 2.0 * p));
    }
    pose.rotations[joint::HEAD] = turn(Vec3::X, -44.0 * down + 2.0 * munch);
    pose.rotations[joint::JAW] = turn(Vec3::X, 3.0 * down + 3.0 * munch);
    tail_and_ears(&mut pose, 2.0 * p, 1.0);
    for (hind, side, z) in [(true, 0, 0.03), (true, 1, -0.05), (false, 0, 0.20), (false, 1, -0.14)] {
        put_hoof(&mut pose, joints, hind, side, z, 0.0, 0.0);
    }
    pose
}
