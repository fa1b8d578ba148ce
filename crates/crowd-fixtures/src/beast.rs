//! Four-legged animals: one stack of rings from rump to muzzle, four legs bridged into it; zebra and gnu.

use glam::{Vec3, vec3};

use crate::assemble::{character, colour_png, regions_png, wedges};
use crate::atlas::{self, paint};
use crate::glb::Document;
use crate::human_rig::Joint;
use crate::profile::{bell, mix, smoothstep};
use crate::shape::{GridChart, Shape, running_share};
use crate::wear::add_spindle;

mod coat;
mod moves;

const TAU: f32 = core::f32::consts::TAU;
/// Columns of the body, of a leg.
const BODY: usize = 12;
const LEG: usize = 6;

#[allow(missing_docs, reason = "the names say it; their numbers mean nothing outside")]
mod part {
    pub const BODY: u8 = 0;
    pub const LEG: u8 = 1;
    pub const EAR: u8 = 2;
    pub const TAIL: u8 = 3;
    pub const MANE: u8 = 4;
    pub const HORN: u8 = 5;
}

mod chart {
    pub const BODY: u16 = 0;
    pub const FORE: u16 = 1;
    pub const HIND: u16 = 2;
    pub const HOOF: u16 = 3;
    pub const EAR: u16 = 4;
    pub const HORN: u16 = 5;
    pub const RUMP: u16 = 6;
    pub const MUZZLE: u16 = 7;
    pub const MANE: u16 = 8;
    pub const TAIL: u16 = 9;
}

mod tag {
    pub const BODY: u16 = 0;
    pub const TAIL: u16 = 1;
    pub const HEAD: u16 = 2;
    /// Add the side.
    pub const EAR: u16 = 4;
    /// Add 2 * hind + side.
    pub const LEG: u16 = 10;
}

/// Which animal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Striped.
    Zebra,
    /// Plain, with horns and a beard.
    Gnu,
}

/// Both animals.
pub const KINDS: [(Kind, &str); 2] = [(Kind::Zebra, "zebra"), (Kind::Gnu, "gnu")];

/// A ring of the body: centre (y, z), half width, half height, how far its plane is turned from upright (degrees).
struct Ring {
    y: f32,
    z: f32,
    wide: f32,
    high: f32,
    lean: f32,
}

fn rings(kind: Kind) -> Vec<Ring> {
    let r = |z: f32, y: f32, wide: f32, high: f32, lean: f32| Ring { y, z, wide, high, lean };
    let mut list = vec![
        r(-0.80, 1.10, 0.13, 0.15, 20.0),
        r(-0.73, 1.08, 0.235, 0.255, 10.0),
        r(-0.56, 1.06, 0.275, 0.295, 0.0),
        r(-0.38, 1.045, 0.285, 0.295, 0.0),
        r(-0.14, 1.02, 0.305, 0.30, 0.0),
        r(0.10, 1.015, 0.30, 0.30, 0.0),
        r(0.29, 1.025, 0.265, 0.30, 0.0),
        r(0.47, 1.065, 0.225, 0.285, -12.0),
        r(0.60, 1.16, 0.165, 0.235, -38.0),
        r(0.71, 1.285, 0.125, 0.180, -50.0),
        r(0.81, 1.42, 0.105, 0.150, -56.0),
        r(0.895, 1.545, 0.098, 0.130, -48.0),
        r(0.975, 1.575, 0.108, 0.125, 2.0),
        r(1.065, 1.525, 0.100, 0.118, 28.0),
        r(1.16, 1.435, 0.072, 0.088, 34.0),
        r(1.245, 1.345, 0.058, 0.066, 34.0),
        r(1.295, 1.292, 0.060, 0.062, 36.0),
    ];
    if kind == Kind::Gnu {
        for (k, ring) in list.iter_mut().enumerate() {
            // A high front, a sloping back, a low heavy head.
            let front = smoothstep(-0.6, 0.5, ring.z);
            if k < 8 {
                ring.y += mix(-0.03, 0.055, front);
                ring.high *= mix(0.88, 1.08, front);
                ring.wide *= mix(0.86, 0.98, front);
            } else {
                let t = (k - 7) as f32 / 9.0;
                ring.y -= 0.02 + 0.30 * smoothstep(0.0, 0.6, t) - 0.02 * t;
                ring.z += 0.04 * smoothstep(0.0, 0.5, t);
                if k < 12 {
                    ring.lean += 14.0;
                    ring.wide *= 1.05;
                } else {
                    ring.lean += 16.0;
                    ring.y -= 0.06 * (t - 0.55);
                    ring.z -= 0.10 * (t - 0.55);
                    ring.wide *= if k == 16 { 1.28 } else { 1.0 };
                    ring.high *= 1.06;
                }
            }
        }
    }
    list
}

/// A leg's centre line and radii: (height, z offset, half width, half depth), top first.
fn leg_rows(hind: bool) -> Vec<[f32; 4]> {
    if hind {
        vec![
            [0.74, 0.00, 0.085, 0.125],
            [0.62, -0.01, 0.060, 0.085],
            [0.50, -0.065, 0.042, 0.052],
            [0.43, -0.085, 0.042, 0.055],
            [0.26, -0.065, 0.030, 0.033],
            [0.13, -0.055, 0.035, 0.040],
            [0.075, -0.035, 0.032, 0.036],
            [0.07, -0.030, 0.041, 0.046],
            [0.0, -0.010, 0.050, 0.060],
        ]
    } else {
        vec![
            [0.76, 0.00, 0.070, 0.095],
            [0.62, 0.005, 0.050, 0.060],
            [0.50, 0.01, 0.043, 0.047],
            [0.42, 0.015, 0.042, 0.045],
            [0.26, 0.00, 0.029, 0.031],
            [0.13, 0.005, 0.034, 0.038],
            [0.075, 0.020, 0.031, 0.035],
            [0.07, 0.025, 0.040, 0.045],
            [0.0, 0.040, 0.050, 0.060],
        ]
    }
}

/// Rings between which the legs are bridged in, and the legs' places (x, z).
const FORE_RINGS: (usize, usize) = (6, 8);
const HIND_RINGS: (usize, usize) = (1, 3);

fn leg_place(hind: bool) -> (f32, f32) {
    if hind { (0.155, -0.60) } else { (0.135, 0.42) }
}

/// Models, paints, rigs and animates one animal: the document and the region map's PNG.
pub fn make(kind: Kind, name: &str) -> (Document, Vec<u8>) {
    let list = rings(kind);
    let shape = model(kind, &list);
    let painting = paint(&shape, atlas::BEAST, 512, &|s| coat::coat(kind, &list, s));
    let joints = skeleton(kind, &list);
    let body = wedges(&shape, atlas::BEAST, &|p, what| weights(&joints, p, what));
    (character(name, &joints, body, colour_png(&painting), moves::clips(kind, &joints)), regions_png(&painting))
}

fn ring_points(r: &Ring) -> Vec<Vec3> {
    let (s, c) = libm::sincosf(r.lean * TAU / 360.0);
    (0..BODY)
        .map(|j| {
            let (sn, cs) = libm::sincosf(TAU * j as f32 / BODY as f32);
            let soft = |x: f32| libm::powf(x.abs(), 0.92) * x.signum();
            let up = r.high * soft(cs);
            vec3(r.wide * soft(sn) * (1.0 - 0.10 * cs), r.y + up * c, r.z + up * s)
        })
        .collect()
}

fn model(kind: Kind, list: &[Ring]) -> Shape {
    let mut shape = Shape::default();
    let grid: Vec<Vec<u32>> = list.iter().map(|r| shape.add_ring(&ring_points(r), tag::BODY)).collect();
    let holes = [(FORE_RINGS, false), (HIND_RINGS, true)];
    let in_hole = |row: usize, j: usize| {
        holes.iter().any(|((a, b), _)| row >= *a && row < *b) && (j % BODY == 4 || j % BODY == 7)
    };
    let along: Vec<f32> = path_lengths(list);
    let total = along[along.len() - 1];
    // The chart is cut along the belly.
    let cols: Vec<usize> = (BODY / 2..=BODY / 2 + BODY).collect();
    let around: Vec<f32> = cols.iter().map(|&j| j as f32 / BODY as f32).collect();
    let v: Vec<f32> = along.iter().map(|a| a / total).collect();
    let gc = GridChart { chart: chart::BODY, part: part::BODY, mirrored: false, lying: true };
    let share = running_share(&[1.0; BODY]);
    shape.add_grid(&grid, &cols, &|_, k| share[k], &around, &v, &along, &gc, true, &|r, k| in_hole(r, cols[k]));
    for (ring, chart, out, flip, at) in [
        (0, chart::RUMP, vec3(0.0, 0.02, -0.045), false, 0.0),
        (grid.len() - 1, chart::MUZZLE, vec3(0.0, -0.022, 0.020), true, total),
    ] {
        let tip = shape.add(vec3(0.0, list[ring].y, list[ring].z) + out, tag::BODY);
        let gc = GridChart { chart, part: part::BODY, mirrored: false, lying: false };
        shape.add_disc(&grid[ring..=ring], tip, &[at, at], &gc, flip);
    }
    for side in 0..2 {
        for ((a, b), hind) in holes {
            add_leg(&mut shape, &grid, (a, b), hind, side);
        }
    }
    soften(&mut shape, &grid);
    add_ears_and_more(&mut shape, kind, list);
    shape
}

fn path_lengths(list: &[Ring]) -> Vec<f32> {
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for w in list.windows(2) {
        sum += libm::sqrtf((w[1].y - w[0].y) * (w[1].y - w[0].y) + (w[1].z - w[0].z) * (w[1].z - w[0].z));
        out.push(sum);
    }
    out
}

fn add_leg(shape: &mut Shape, grid: &[Vec<u32>], (a, b): (usize, usize), hind: bool, side: u16) {
    let col = |j: usize| if side == 0 { j } else { BODY - j };
    let (place_x, place_z) = leg_place(hind);
    // Round the hole, seen from below: outer front corner first, then backwards along the outside.
    let (outer, inner) = (col(4), col(5));
    let mut first: Vec<u32> = (a..=b).rev().map(|r| grid[r][outer]).collect();
    first.extend((a..=b).map(|r| grid[r][inner]));
    let what = tag::LEG + 2 * u16::from(hind) + side;
    let flip_x = if side == 0 { 1.0 } else { -1.0 };
    let mut rows = vec![first];
    let mut along = vec![0.0];
    let table = leg_rows(hind);
    for r in &table {
        let ring: Vec<Vec3> = (0..LEG)
            .map(|i| {
                let (s, c) = libm::sincosf(TAU * (i as f32 - 1.0) / LEG as f32);
                let x = mix(place_x, place_x - 0.012, smoothstep(0.8, 0.4, r[0])) + r[2] * c;
                vec3(x * flip_x, r[0], place_z + r[1] - r[3] * s)
            })
            .collect();
        rows.push(shape.add_ring(&ring, what));
        along.push(1.0 - r[0]);
    }
    let cols: Vec<usize> = (4..=4 + LEG).collect();
    let around: Vec<f32> = cols.iter().map(|&j| j as f32 / LEG as f32).collect();
    let last = along[along.len() - 1];
    let hoof = rows.len() - 2;
    let v: Vec<f32> = along.iter().map(|x| x / last).collect();
    let gc = GridChart {
        chart: if hind { chart::HIND } else { chart::FORE },
        part: part::LEG,
        mirrored: side == 1,
        lying: false,
    };
    shape.add_grid(
        &rows[..=hoof],
        &cols,
        &|_, k| k as f32 / LEG as f32,
        &around,
        &v,
        &along,
        &gc,
        side == 0,
        &|_, _| false,
    );
    let sole = shape.add(vec3((place_x - 0.012) * flip_x, 0.0, place_z + table[table.len() - 1][1]), what);
    let gc = GridChart { chart: chart::HOOF, part: part::LEG, mirrored: side == 1 || hind, lying: false };
    shape.add_disc(&rows[hoof..], sole, &[along[hoof], last, last], &gc, side == 0);
}

fn soften(shape: &mut Shape, grid: &[Vec<u32>]) {
    let mut amount = vec![0.0_f32; shape.positions.len()];
    for (a, b) in [FORE_RINGS, HIND_RINGS] {
        for row in a..=b {
            for j in [4, 5, 7, 8] {
                amount[grid[row][j] as usize] = 0.4;
            }
        }
    }
    for i in 0..amount.len() {
        if shape.tags[i] >= tag::LEG {
            amount[i] = 0.35 * smoothstep(0.60, 0.76, shape.positions[i].y);
        }
    }
    shape.relax(&amount, 2);
}

fn head_frame(list: &[Ring]) -> (Vec3, Vec3, Vec3) {
    let poll = &list[12];
    let muzzle = &list[16];
    let along = vec3(0.0, muzzle.y - poll.y, muzzle.z - poll.z).normalize();
    (vec3(0.0, poll.y, poll.z), along, Vec3::X.cross(along).normalize() * -1.0)
}

fn add_ears_and_more(shape: &mut Shape, kind: Kind, list: &[Ring]) {
    let (poll, along, up) = head_frame(list);
    for side in [1.0_f32, -1.0] {
        let mirrored = side < 0.0;
        let side_tag = tag::EAR + u16::from(mirrored);
        let root = poll + up * 0.085 + vec3(0.065 * side, 0.0, 0.0) - along * 0.02;
        let axis = if kind == Kind::Zebra { vec3(0.35 * side, 0.9, -0.12) } else { vec3(0.95 * side, -0.02, -0.25) }
            .normalize();
        let path: Vec<(Vec3, f32, f32)> = [(0.0, 0.022, 0.016), (0.075, 0.042, 0.020), (0.15, 0.022, 0.012)]
            .iter()
            .map(|&(t, a, b)| (root + axis * t, a, b))
            .collect();
        add_spindle(shape, &path, 6, chart::EAR, part::EAR, side_tag, mirrored);
        if kind == Kind::Gnu {
            let root = poll + up * 0.10;
            let steps = [
                (0.02, 0.00, 0.045),
                (0.12, -0.02, 0.038),
                (0.22, -0.01, 0.028),
                (0.27, 0.09, 0.019),
                (0.23, 0.18, 0.007),
            ];
            let path: Vec<(Vec3, f32, f32)> =
                steps.iter().map(|&(x, y, g)| (root + vec3(x * side, y, 0.03 * (x / 0.27)), g, g)).collect();
            add_spindle(shape, &path, 4, chart::HORN, part::HORN, tag::HEAD, mirrored);
        }
    }
    let rump = &list[0];
    let base = vec3(0.0, rump.y + 0.10, rump.z + 0.035);
    let tail = [
        (0.0, 0.0, 0.030),
        (-0.085, -0.07, 0.026),
        (-0.115, -0.26, 0.019),
        (-0.12, -0.40, 0.036),
        (-0.115, -0.58, 0.030),
        (-0.11, -0.68, 0.008),
    ];
    let thick = if kind == Kind::Gnu { 1.35 } else { 1.0 };
    let path: Vec<(Vec3, f32, f32)> = tail
        .iter()
        .map(|&(z, y, g)| {
            (base + vec3(0.0, y, z), g * if y < -0.3 { thick } else { 1.0 }, g * if y < -0.3 { thick } else { 1.0 })
        })
        .collect();
    add_spindle(shape, &path, 6, chart::TAIL, part::TAIL, tag::TAIL, false);
    // The mane stands on the crest from the withers to the poll; a gnu has a beard under its throat as well.
    let crest = |k: usize, out: f32| {
        let p = ring_points(&list[k])[0];
        let n = (p - vec3(0.0, list[k].y, list[k].z)).normalize();
        p + n * out
    };
    let first = if kind == Kind::Zebra { 7 } else { 8 };
    let path: Vec<(Vec3, f32, f32)> = (first..=12)
        .map(|k| {
            let t = (k - first) as f32 / 5.0;
            let high = (0.028 + 0.038 * smoothstep(0.0, 0.3, t)) * if k == 12 { 0.75 } else { 1.0 };
            (crest(k, high * 0.35), 0.020, high)
        })
        .collect();
    add_spindle(shape, &path, if kind == Kind::Zebra { 6 } else { 4 }, chart::MANE, part::MANE, tag::BODY, false);
    if kind == Kind::Gnu {
        let throat = |k: usize, out: f32| {
            let p = ring_points(&list[k])[6];
            let n = (p - vec3(0.0, list[k].y, list[k].z)).normalize();
            p + n * out
        };
        let path: Vec<(Vec3, f32, f32)> =
            (8..=14).map(|k| (throat(k, 0.01), 0.018, 0.055 - 0.007 * (k as f32 - 10.0).abs())).collect();
        add_spindle(shape, &path, 4, chart::MANE, part::MANE, tag::BODY, true);
    }
}

#[allow(missing_docs, reason = "the names say it; their numbers mean nothing outside")]
mod joint {
    pub const HIPS: usize = 0;
    pub const SPINE: usize = 1; // 1..=3
    pub const CHEST: usize = 4;
    pub const NECK: usize = 5; // 5..=8
    pub const HEAD: usize = 9;
    pub const JAW: usize = 10;
    pub const EARS: usize = 11; // left 11, 12, right 13, 14
    pub const TAIL: usize = 15; // 15..=21
    pub const LEGS: usize = 22;
}

/// First joint of a leg and its length in joints: fore legs have six, hind legs five.
fn leg_joints(hind: bool, side: usize) -> (usize, usize) {
    if hind { (joint::LEGS + 12 + 5 * side, 5) } else { (joint::LEGS + 6 * side, 6) }
}

fn skeleton(kind: Kind, list: &[Ring]) -> Vec<Joint> {
    let mut joints: Vec<Joint> = Vec::new();
    let mut add = |name: String, parent: Option<usize>, p: Vec3| joints.push(Joint { name, parent, position: p });
    let ring = |k: usize, up: f32| vec3(0.0, list[k].y + up, list[k].z);
    let spine = 0.12;
    add("hips".into(), None, ring(2, spine));
    for (n, k) in [3, 4, 5].into_iter().enumerate() {
        add(format!("spine_{}", n + 1), Some(n), ring(k, spine));
    }
    add("chest".into(), Some(3), ring(6, spine));
    for (n, k) in [7, 8, 9, 10].into_iter().enumerate() {
        add(format!("neck_{}", n + 1), Some(4 + n), ring(k, 0.02));
    }
    let (poll, along, up) = head_frame(list);
    add("head".into(), Some(8), ring(11, 0.02));
    add("jaw".into(), Some(9), poll + along * 0.10 - up * 0.05);
    for (side, x) in [("l", 1.0), ("r", -1.0)] {
        let parent = if x > 0.0 { 11 } else { 13 };
        let root = poll + up * 0.085 + vec3(0.065 * x, 0.0, 0.0);
        let axis = if kind == Kind::Zebra { vec3(0.35 * x, 0.9, -0.12) } else { vec3(0.95 * x, 0.0, -0.25) };
        add(format!("ear_1_{side}"), Some(9), root);
        add(format!("ear_2_{side}"), Some(parent), root + axis * 0.08);
    }
    let base = vec3(0.0, list[0].y + 0.10, list[0].z + 0.035);
    for n in 0..7 {
        let at = base + vec3(0.0, -0.105 * n as f32, if n == 0 { 0.0 } else { -0.10 });
        add(format!("tail_{}", n + 1), Some(if n == 0 { 0 } else { joint::TAIL + n - 1 }), at);
    }
    for side in 0..2 {
        let s = if side == 0 { 1.0 } else { -1.0 };
        let (x, z) = leg_place(false);
        let places = [
            (1.17, -0.06, "scapula"),
            (0.86, 0.07, "humerus"),
            (0.72, -0.04, "radius"),
            (0.435, 0.015, "cannon_fore"),
            (0.13, 0.005, "pastern_fore"),
            (0.07, 0.025, "hoof_fore"),
        ];
        for (n, (y, dz, name)) in places.into_iter().enumerate() {
            let parent = if n == 0 { joint::CHEST } else { joint::LEGS + 6 * side + n - 1 };
            add(format!("{name}_{}", ["l", "r"][side]), Some(parent), vec3(x * s, y, z + dz));
        }
    }
    for side in 0..2 {
        let s = if side == 0 { 1.0 } else { -1.0 };
        let (x, z) = leg_place(true);
        let places = [
            (1.02, 0.0, "femur"),
            (0.72, 0.10, "tibia"),
            (0.455, -0.085, "cannon_hind"),
            (0.13, -0.055, "pastern_hind"),
            (0.07, -0.030, "hoof_hind"),
        ];
        for (n, (y, dz, name)) in places.into_iter().enumerate() {
            let parent = if n == 0 { joint::HIPS } else { joint::LEGS + 12 + 5 * side + n - 1 };
            add(format!("{name}_{}", ["l", "r"][side]), Some(parent), vec3(x * s, y, z + dz));
        }
    }
    joints
}

/// Shares of a chain of joints for a point: smooth steps at each joint along the way.
fn chain(w: &mut [f32], joints: &[Joint], list: &[usize], p: Vec3, amount: f32, soft: f32) {
    let mut left = amount;
    for k in 0..list.len() - 1 {
        let (a, b) = (joints[list[k]].position, joints[list[k + 1]].position);
        let prior = if k == 0 { b - a } else { b - joints[list[k - 1]].position };
        let t = (p - b).dot(prior.normalize()) / soft;
        let up = left * smoothstep(-1.0, 1.0, t);
        w[list[k]] += left - up;
        left = up;
    }
    w[list[list.len() - 1]] += left;
}

fn weights(joints: &[Joint], p: Vec3, what: u16) -> Vec<(usize, f32)> {
    let mut w = vec![0.0_f32; joints.len()];
    let side = usize::from(p.x < 0.0);
    match what {
        tag::TAIL => chain(&mut w, joints, &(joint::TAIL..joint::TAIL + 7).collect::<Vec<_>>(), p, 1.0, 0.05),
        tag::HEAD => w[joint::HEAD] = 1.0,
        t if t == tag::EAR || t == tag::EAR + 1 => {
            let ear = joint::EARS + 2 * (t - tag::EAR) as usize;
            chain(&mut w, joints, &[ear, ear + 1], p, 1.0, 0.04);
        }
        t if t >= tag::LEG => {
            let hind = (t - tag::LEG) >= 2;
            let (first, count) = leg_joints(hind, side);
            let body = smoothstep(0.70, 0.88, p.y) * 0.6;
            let start = if hind { first } else { first + 1 };
            let list: Vec<usize> = (start..first + count).collect();
            let mut left = 1.0 - body;
            // Legs hang down: steps by height are enough, wide at the stifle, narrow at the hoof.
            for k in 0..list.len() - 1 {
                let y = joints[list[k + 1]].position.y;
                let soft = mix(0.03, 0.075, smoothstep(0.15, 0.5, y));
                let up = left * smoothstep(y + soft, y - soft, p.y);
                w[list[k]] += left - up;
                left = up;
            }
            w[list[list.len() - 1]] += left;
            w[if hind { joint::HIPS } else { joint::CHEST }] += body;
        }
        _ => {
            let muzzle = p - joints[joint::JAW].position;
            let spine: Vec<usize> = (joint::HIPS..=joint::HEAD).collect();
            let low = smoothstep(1.05, 0.80, p.y) * smoothstep(0.06, 0.14, p.x.abs());
            let fore = 0.65 * low * bell(p.z - 0.40, 0.13);
            let hind = 0.65 * low * bell(p.z + 0.58, 0.14);
            chain(&mut w, joints, &spine, p, 1.0 - fore - hind, 0.10);
            w[leg_joints(false, side).0 + 1] += fore;
            w[leg_joints(true, side).0] += hind;
            let jaw = if muzzle.y < 0.0 && p.z > joints[joint::JAW].position.z { 0.3 * w[joint::HEAD] } else { 0.0 };
            w[joint::JAW] += jaw;
            w[joint::HEAD] -= jaw;
        }
    }
    let mut list: Vec<(usize, f32)> = w.into_iter().enumerate().filter(|x| x.1 > 0.004).collect();
    list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    list.truncate(4);
    let total: f32 = list.iter().map(|x| x.1).sum();
    list.iter_mut().for_each(|x| x.1 /= total);
    list
}
