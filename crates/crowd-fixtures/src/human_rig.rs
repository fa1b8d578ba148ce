//! The human skeleton: joints with real names, and smooth skin weights of up to four of them per position.

use glam::Vec3;

use crate::body::{Figure, tag};
use crate::profile::{mix, smoothstep};

/// One joint: name, parent, bind position in metres. Rest rotations are none: every joint's axes are the world's.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Parent's index, smaller than its own.
    pub parent: Option<usize>,
    /// Bind position.
    pub position: Vec3,
}

/// Joint indices of the left side's chains; the right side's are `RIGHT` further on.
#[allow(missing_docs, reason = "the names say it; their numbers mean nothing outside")]
pub mod joint {
    pub const HIPS: usize = 0;
    pub const SPINE: usize = 1;
    pub const CHEST: usize = 2;
    pub const UPPER_CHEST: usize = 3;
    pub const NECK: usize = 4;
    pub const HEAD: usize = 5;
    pub const CLAVICLE: usize = 6;
    pub const UPPER_ARM: usize = 7;
    pub const FOREARM: usize = 8;
    pub const HAND: usize = 9;
    /// Five fingers of two joints: 10..=19.
    pub const FINGERS: usize = 10;
    pub const THIGH: usize = 20;
    pub const SHIN: usize = 21;
    pub const FOOT: usize = 22;
    pub const TOES: usize = 23;
    /// Distance from a left joint to its right twin.
    pub const RIGHT: usize = 18;
    pub const HAIR: usize = 42;
}

/// The skeleton of `f`: 42 joints, and two more where the hair hangs free.
pub fn skeleton(f: &Figure, hair_tail: Option<[Vec3; 2]>) -> Vec<Joint> {
    let h = f.build.height;
    let mut joints: Vec<Joint> = Vec::new();
    let mut add = |name: String, parent: Option<usize>, position: Vec3| {
        joints.push(Joint { name, parent, position });
    };
    let at = |t: f32, z: f32| Vec3::new(0.0, f.trunk_y(t), z * h);
    add("hips".into(), None, at(0.16, -0.004));
    add("spine".into(), Some(0), at(0.32, -0.010));
    add("chest".into(), Some(1), at(0.52, -0.014));
    add("upper_chest".into(), Some(2), at(0.74, -0.016));
    add("neck".into(), Some(3), at(1.0, -0.012));
    let head_y = f.chin_y() + 0.08 * f.head_m();
    add("head".into(), Some(4), Vec3::new(0.0, head_y, -0.004 * h));
    for side in 0..2 {
        let letter = ["l", "r"][side];
        let base = side * joint::RIGHT;
        let flip = |p: Vec3| if side == 0 { p } else { Vec3::new(-p.x, p.y, p.z) };
        let shoulder = f.shoulder();
        let clavicle = Vec3::new(0.018 * h, shoulder.y + 0.002 * h, -0.004 * h);
        add(format!("clavicle_{letter}"), Some(3), flip(clavicle));
        add(format!("upper_arm_{letter}"), Some(base + joint::CLAVICLE), flip(shoulder));
        add(format!("forearm_{letter}"), Some(base + joint::UPPER_ARM), flip(f.arm_at(0.54)));
        add(format!("hand_{letter}"), Some(base + joint::FOREARM), flip(f.arm_at(1.02)));
        for (k, finger) in ["thumb", "index", "middle", "ring", "little"].iter().enumerate() {
            let root = finger_root(f, k);
            let parent = base + joint::HAND;
            add(format!("{finger}_1_{letter}"), Some(parent), flip(root.0));
            add(format!("{finger}_2_{letter}"), Some(base + joint::FINGERS + 2 * k), flip(root.0 + root.1 * 0.45));
        }
        let hip = f.leg_at(-0.10);
        add(format!("thigh_{letter}"), Some(0), flip(hip));
        add(format!("shin_{letter}"), Some(base + joint::THIGH), flip(f.leg_at(0.5)));
        let ankle = f.leg_at(1.0);
        add(format!("foot_{letter}"), Some(base + joint::SHIN), flip(ankle));
        let ball = Vec3::new(ankle.x + 0.014 * h, 0.012 * h, ankle.z + 0.088 * h);
        add(format!("toes_{letter}"), Some(base + joint::FOOT), flip(ball));
    }
    if let Some(tail) = hair_tail {
        add("hair_1".into(), Some(joint::HEAD), tail[0]);
        add("hair_2".into(), Some(joint::HAIR), tail[1]);
    }
    joints
}

/// A left finger's root and the vector to its tip; 0 is the thumb.
fn finger_root(f: &Figure, k: usize) -> (Vec3, Vec3) {
    let h = f.build.height;
    let d = f.arm_axis();
    if k == 0 {
        return (f.arm_at(1.09) + Vec3::Z * 0.020 * h, (d * 0.72 + Vec3::Z * 0.66).normalize() * 0.04 * h);
    }
    let z = (1.5 - (k as f32 - 1.0)) * 0.012 * h;
    (f.arm_at(1.22) + Vec3::Z * z, d * 0.045 * h)
}

/// Skin weights of one position: at most four joints, adding up to 1.
pub fn weights(f: &Figure, joints: &[Joint], p: Vec3, what: u16) -> Vec<(usize, f32)> {
    let mut w = vec![0.0_f32; joints.len()];
    let h = f.build.height;
    let side = usize::from(p.x < 0.0);
    let q = Vec3::new(p.x.abs(), p.y, p.z);
    match what {
        tag::HEAD => head_weights(f, &mut w, p),
        tag::HAIR_TAIL => {
            let (a, b) = (joints[joint::HAIR].position, joints[joint::HAIR + 1].position);
            let t = (p - a).dot((b - a).normalize()) / a.distance(b);
            let (one, two) = (smoothstep(-0.25, 0.45, t), smoothstep(0.55, 1.45, t));
            w[joint::HEAD] = 1.0 - one;
            w[joint::HAIR] = one * (1.0 - two);
            w[joint::HAIR + 1] = one * two;
        }
        tag::TRUNK | tag::SKIRT => {
            let shoulder = f.shoulder();
            let out = (q - shoulder).dot(f.arm_axis()) / h;
            let arm = smoothstep(-0.030, 0.050, out)
                * smoothstep(0.60, 0.74, (p.y - f.trunk_y(0.0)) / (f.trunk_y(1.0) - f.trunk_y(0.0)));
            let clavicle = smoothstep(0.2, 0.95, q.x / shoulder.x)
                * smoothstep(f.trunk_y(0.66), f.trunk_y(0.88), p.y)
                * (1.0 - arm);
            // A skirt hangs from the hips a little further down than the skin under it.
            let low = if what == tag::SKIRT { -0.10 } else { -0.06 };
            let leg = smoothstep(f.trunk_y(0.20), f.trunk_y(low), p.y);
            spine_weights(f, &mut w, p, 1.0 - arm - 0.7 * clavicle - leg);
            w[side * joint::RIGHT + joint::UPPER_ARM] += arm;
            w[side * joint::RIGHT + joint::CLAVICLE] += 0.7 * clavicle;
            let wide = if what == tag::SKIRT { 0.06 } else { 0.028 };
            let left = smoothstep(-wide * h, wide * h, p.x);
            w[joint::THIGH] += leg * left;
            w[joint::THIGH + joint::RIGHT] += leg * (1.0 - left);
        }
        t if (tag::ARM..tag::ARM + 2).contains(&t) => arm_weights(f, &mut w, q, side),
        t if (tag::LEG..tag::LEG + 2).contains(&t) => leg_weights(f, &mut w, q, side),
        t => {
            let finger = ((t - tag::FINGER) / 2) as usize;
            let (root, reach) = finger_root(f, finger);
            let s = (q - root).dot(reach) / reach.length_squared();
            let two = smoothstep(0.25, 0.6, s);
            let one = smoothstep(-0.1, 0.25, s);
            let base = side * joint::RIGHT;
            w[base + joint::HAND] = 1.0 - one;
            w[base + joint::FINGERS + 2 * finger] = one * (1.0 - two);
            w[base + joint::FINGERS + 2 * finger + 1] = one * two;
        }
    }
    strongest_four(w)
}

fn strongest_four(w: Vec<f32>) -> Vec<(usize, f32)> {
    let mut list: Vec<(usize, f32)> = w.into_iter().enumerate().filter(|x| x.1 > 0.004).collect();
    list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    list.truncate(4);
    let total: f32 = list.iter().map(|x| x.1).sum();
    list.iter_mut().for_each(|x| x.1 /= total);
    list
}

fn head_weights(f: &Figure, w: &mut [f32], p: Vec3) {
    let hy = (p.y - f.chin_y()) / f.head_m();
    // The chin moves with the head; the throat and nape below it with the neck.
    let front = smoothstep(-0.1, 0.35, p.z / f.head_m());
    let head = smoothstep(-0.16, mix(0.14, 0.0, front), hy);
    w[joint::HEAD] = head;
    w[joint::NECK] = 1.0 - head;
}

fn spine_weights(f: &Figure, w: &mut [f32], p: Vec3, amount: f32) {
    let t = (p.y - f.trunk_y(0.0)) / (f.trunk_y(1.0) - f.trunk_y(0.0));
    let steps = [(0.22, 0.42), (0.44, 0.62), (0.64, 0.84), (0.95, 1.04), (1.12, 1.35)];
    let mut left = amount;
    for (k, (a, b)) in steps.iter().enumerate() {
        let up = left * smoothstep(*a, *b, t);
        w[k] += left - up;
        left = up;
    }
    w[joint::HEAD] += left;
}

fn arm_weights(f: &Figure, w: &mut [f32], q: Vec3, side: usize) {
    let base = side * joint::RIGHT;
    let s = (q - f.shoulder()).dot(f.arm_axis()) / (f.build.arm * f.build.height);
    let shoulder = smoothstep(-0.12, 0.22, s);
    let elbow = smoothstep(0.44, 0.64, s);
    let wrist = smoothstep(0.93, 1.07, s);
    // The armpit hangs on the chest, the top of the shoulder on the clavicle.
    w[joint::UPPER_CHEST] += 0.45 * (1.0 - shoulder);
    w[base + joint::CLAVICLE] += 0.55 * (1.0 - shoulder);
    w[base + joint::UPPER_ARM] += shoulder * (1.0 - elbow);
    w[base + joint::FOREARM] += elbow * (1.0 - wrist);
    w[base + joint::HAND] += wrist;
}

fn leg_weights(f: &Figure, w: &mut [f32], q: Vec3, side: usize) {
    let base = side * joint::RIGHT;
    let (top, ankle) = (f.leg_at(0.0).y, f.leg_at(1.0).y);
    let s = (top - q.y) / (top - ankle);
    let h = f.build.height;
    let hip = smoothstep(-0.20, 0.12, s);
    let knee = smoothstep(0.40, 0.60, s);
    let foot =
        smoothstep(0.93, 1.03, s).max(smoothstep(0.030, 0.05, (q.z - f.leg_at(1.0).z) / h) * smoothstep(0.8, 0.9, s));
    let toes = smoothstep(0.070, 0.100, (q.z - f.leg_at(1.0).z) / h) * foot;
    // The inside of the thigh shares a little with the other leg, so that the crotch stays whole.
    let other = 0.5 * smoothstep(0.024 * h, 0.0, q.x) * smoothstep(0.10, 0.0, s);
    w[joint::HIPS] += 1.0 - hip;
    w[base + joint::THIGH] += hip * (1.0 - knee) * (1.0 - other);
    w[(1 - side) * joint::RIGHT + joint::THIGH] += hip * (1.0 - knee) * other;
    w[base + joint::SHIN] += knee * (1.0 - foot);
    w[base + joint::FOOT] += knee * foot * (1.0 - toes);
    w[base + joint::TOES] += knee * toes;
}
