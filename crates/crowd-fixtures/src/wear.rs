//! What is worn over the body as closed shells of its own: hair, tails and buns, ears, skirts, brims.

use glam::Vec3;

use crate::body::{Figure, chart, part, tag};
use crate::profile::{Profile, mix, smoothstep};
use crate::shape::{GridChart, Shape};

const TAU: f32 = core::f32::consts::TAU;

/// The cut of a head of hair: heights are `hy` (0 chin, 1 crown) by angle from the front in degrees (0..180).
#[derive(Clone, Debug)]
pub struct HairCut {
    /// Where the hair ends: (degrees, hy).
    pub rim: Vec<(f32, f32)>,
    /// Thickness in heads at the rim and the crown.
    pub thick: (f32, f32),
    /// Height of the locks in heads, and how many there are around.
    pub locks: (f32, f32),
    /// Below this `hy` hair hangs straight instead of following the head; 0 for short hair.
    pub hang: f32,
    /// Columns and rows.
    pub columns: usize,
    /// See `columns`.
    pub rows: usize,
    /// Swept to one side: the fringe's height difference between left and right.
    pub sweep: f32,
}

/// Adds the hair's shell: from the crown down to the rim, tucked in below it and closed inside the head.
pub fn add_hair(shape: &mut Shape, f: &Figure, cut: &HairCut) {
    let rim = Profile::new(&cut.rim);
    let n = cut.columns;
    let top = 0.985;
    let h = f.head_m();
    let surface = |theta: f32, hy: f32, t: f32| {
        let degrees = theta.abs() * 360.0 / TAU;
        let lock = libm::sinf(theta * cut.locks.1 + 1.3 * libm::sinf(3.0 * theta + 4.0 * t));
        let extra = mix(cut.thick.1, cut.thick.0, t) + cut.locks.0 * lock * smoothstep(0.0, 0.5, t);
        // Below the ears hair hangs straight instead of following the neck.
        let follow = hy.max(cut.hang * mix(0.7, 1.0, smoothstep(80.0, 130.0, degrees)));
        // Grown out from the middle of the skull, so that the crown stays a dome.
        let middle = Vec3::new(0.0, f.chin_y() + 0.55 * h, f.m_z(-0.02));
        let mut p = middle + (f.head_point(follow, theta, 0.0) - middle) * (1.0 + extra / 0.40);
        if follow > hy {
            p.y = f.chin_y() + hy * h;
        }
        if hy < 0.1 && cut.hang > 0.0 {
            p.z -= 0.10 * h * (0.1 - hy) * smoothstep(60.0, 120.0, degrees);
        }
        p
    };
    let angle = |j: usize| {
        let a = TAU * j as f32 / n as f32;
        if a > TAU / 2.0 { a - TAU } else { a }
    };
    let rim_at = |theta: f32| {
        rim.at(theta.abs() * 360.0 / TAU) + cut.sweep * libm::sinf(theta) * smoothstep(1.6, 0.2, theta.abs())
    };
    let mut rings = Vec::new();
    let mut along = Vec::new();
    for row in (0..=cut.rows).rev() {
        let t = (row as f32 + 0.6) / (cut.rows as f32 + 0.6);
        let ring: Vec<Vec3> = (0..n).map(|j| surface(angle(j), mix(top, rim_at(angle(j)), t), t)).collect();
        rings.push(shape.add_ring(&ring, tag::HEAD));
        along.push(1.0 - t);
    }
    let crown = f.head_point(1.0, 0.0, 0.0);
    let tip = shape.add(Vec3::new(0.0, crown.y + 1.12 * cut.thick.1 * h, crown.z), tag::HEAD);
    let gc = GridChart { chart: chart::HAIR, part: part::HAIR, mirrored: false, lying: false };
    shape.add_disc(&rings, tip, &along, &gc, false);
    // The underside: tucked a little under the skin, then closed in the middle of the head.
    let tuck: Vec<Vec3> = (0..n)
        .map(|j| {
            let theta = angle(j);
            let hy = rim_at(theta) + 0.03;
            let inside = if hy > cut.hang.min(0.25) {
                f.head_point(hy.min(0.97), theta, -0.03)
            } else {
                surface(theta, hy, 1.0) * Vec3::new(0.72, 1.0, 0.72)
            };
            Vec3::new(inside.x, f.chin_y() + hy * h, inside.z)
        })
        .collect();
    let under = shape.add_ring(&tuck, tag::HEAD);
    let middle = shape.add(Vec3::new(0.0, f.chin_y() + 0.62 * h, f.m_z(0.0)), tag::HEAD);
    let gc = GridChart { chart: chart::EXTRA, part: part::HAIR, mirrored: false, lying: false };
    shape.add_disc(&[rings[0].clone(), under], middle, &[0.0, 0.0, 0.0], &gc, true);
}

/// Adds a closed spindle along a path: a tail, a bun, a plait, a horn.
///
/// `path`: (centre, half width, half depth), from the root to the tip; the ends are closed.
pub fn add_spindle(
    shape: &mut Shape,
    path: &[(Vec3, f32, f32)],
    columns: usize,
    chart: u16,
    part: u8,
    what: u16,
    mirrored: bool,
) {
    let last = path.len() - 1;
    let mut rings = Vec::new();
    for i in 0..=last {
        let axis = (path[(i + 1).min(last)].0 - path[i.saturating_sub(1)].0).normalize();
        let side = if axis.cross(Vec3::Z).length() > 0.3 { axis.cross(Vec3::Z).normalize() } else { Vec3::X };
        let depth = side.cross(axis).normalize();
        let (c, rx, rz) = path[i];
        let ring: Vec<Vec3> = (0..columns)
            .map(|j| {
                let (s, co) = libm::sincosf(TAU * j as f32 / columns as f32);
                c + side * (rx * s) + depth * (rz * co)
            })
            .collect();
        rings.push(shape.add_ring(&ring, what));
    }
    let (first, end) = (path[0].0, path[last].0);
    let out = (end - path[last - 1].0).normalize() * path[last].1 * 0.8;
    let back = (first - path[1].0).normalize() * path[0].1 * 0.6;
    let tip = shape.add(end + out, what);
    let root = shape.add(first + back, what);
    let along: Vec<f32> = (0..=last + 1).map(|i| i as f32 / (last + 1) as f32).collect();
    let half = rings.len() / 2;
    let gc = GridChart { chart, part, mirrored, lying: false };
    // Which way round the rings run depends on the axis; the volume tells.
    let flip = spindle_runs_inwards(shape, &rings);
    if rings.len() < 3 {
        shape.add_disc(&rings, tip, &along, &gc, flip);
        let reversed: Vec<Vec<u32>> = vec![rings[0].clone()];
        shape.add_disc(&reversed, root, &along, &gc, !flip);
        return;
    }
    shape.add_disc(&rings[half..], tip, &along[half..], &gc, flip);
    let lower: Vec<Vec<u32>> = rings[..=half].iter().rev().cloned().collect();
    let lower_along: Vec<f32> = along[..=half].iter().rev().copied().collect();
    let gc = GridChart { chart, part, mirrored: true, lying: false };
    shape.add_disc(&lower, root, &lower_along, &gc, !flip);
}

fn spindle_runs_inwards(shape: &Shape, rings: &[Vec<u32>]) -> bool {
    let at = |r: usize, j: usize| shape.positions[rings[r][j % rings[r].len()] as usize];
    let n = rings[0].len();
    let mid = (0..n).map(|j| at(0, j) + at(1, j)).sum::<Vec3>() / (2 * n) as f32;
    let outward: f32 = (0..n).map(|j| (at(0, j + 1) - at(0, j)).cross(at(1, j) - at(0, j)).dot(at(0, j) - mid)).sum();
    outward < 0.0
}

/// Adds one ear on each side.
pub fn add_ears(shape: &mut Shape, f: &Figure, columns: usize) {
    let h = f.head_m();
    for side in [1.0, -1.0] {
        let root = f.head_point(0.47, TAU * 0.25, -0.03);
        let out = Vec3::new(0.9, 0.05, -0.42).normalize();
        let up = Vec3::new(0.06, 1.0, -0.16).normalize();
        let deep = out.cross(up).normalize();
        let ring = |d: f32, ru: f32, rd: f32, drop: f32| -> Vec<Vec3> {
            (0..columns)
                .map(|j| {
                    // Half a column on, so that a coarse ear ends in an edge instead of a point.
                    let (s, c) = libm::sincosf(TAU * (j as f32 + 0.5) / columns as f32);
                    let narrow = if c < 0.0 { 0.75 } else { 1.0 };
                    let p = root + (out * d + up * (ru * c + drop) + deep * (rd * s * narrow)) * h;
                    Vec3::new(p.x * side, p.y, p.z)
                })
                .collect()
        };
        let rings = vec![
            shape.add_ring(&ring(-0.02, 0.08, 0.035, 0.0), tag::HEAD),
            shape.add_ring(&ring(0.075, 0.115, 0.065, 0.01), tag::HEAD),
        ];
        let middle = root + (out * 0.055 + deep * -0.008) * h;
        let tip = shape.add(Vec3::new(middle.x * side, middle.y, middle.z), tag::HEAD);
        let gc = GridChart { chart: chart::EAR, part: part::EAR, mirrored: side < 0.0, lying: false };
        let inward = spindle_runs_inwards(shape, &rings);
        shape.add_disc(&rings, tip, &[0.0, 0.6, 1.0], &gc, inward);
        let root_tip = root - out * 0.04 * h;
        let back = shape.add(Vec3::new(root_tip.x * side, root_tip.y, root_tip.z), tag::HEAD);
        shape.add_disc(&rings[..1], back, &[0.0, 0.0], &GridChart { mirrored: true, ..gc }, !inward);
    }
}

/// A skirt or coat tail: a bell from the waist down, with an inside, so that it is a closed shell.
#[derive(Clone, Debug)]
pub struct Skirt {
    /// Trunk share of its waistband.
    pub waist: f32,
    /// Height of the hem in body heights.
    pub hem: f32,
    /// Half width and half depth at the hem, in body heights.
    pub flare: (f32, f32),
    /// Depth and number of the folds.
    pub folds: (f32, f32),
    /// Columns and rows.
    pub columns: usize,
    /// See `columns`.
    pub rows: usize,
}

/// Adds a skirt.
pub fn add_skirt(shape: &mut Shape, f: &Figure, skirt: &Skirt) {
    let n = skirt.columns;
    let h = f.build.height;
    let top = f.trunk_y(skirt.waist);
    let hem = skirt.hem * h;
    let point = |t: f32, theta: f32, inner: f32| {
        let y = mix(top, hem, t);
        let (s, c) = libm::sincosf(theta);
        let waist = f.trunk_point(skirt.waist, theta, 0.018 - inner);
        let open = smoothstep(0.0, 0.32, t) * 0.45 + 0.55 * t;
        let fold = 1.0 + skirt.folds.0 * libm::cosf(theta * skirt.folds.1) * t;
        let wide = Vec3::new(skirt.flare.0 * h * s, 0.0, skirt.flare.1 * h * c - 0.008 * h) * fold;
        let mut p = Vec3::new(waist.x, 0.0, waist.z).lerp(wide * (1.0 - inner * 3.0), open);
        // Stays outside the belly and the hips.
        let share = (y - f.trunk_y(0.0)) / (f.trunk_y(1.0) - f.trunk_y(0.0));
        let under = f.trunk_point(share.max(0.06), theta, 0.026 - 0.5 * inner);
        let grow = (Vec3::new(under.x, 0.0, under.z).length() / Vec3::new(p.x, 0.0, p.z).length()).max(1.0);
        p *= mix(1.0, grow, smoothstep(-0.12, 0.0, share));
        p.y = y + if inner > 0.0 { inner } else { 0.0 };
        p
    };
    let mut rings = Vec::new();
    let mut along = Vec::new();
    for row in 0..=skirt.rows {
        let t = row as f32 / skirt.rows as f32;
        let ring: Vec<Vec3> = (0..n).map(|j| point(t, TAU * j as f32 / n as f32, 0.0)).collect();
        rings.push(shape.add_ring(&ring, tag::SKIRT));
        along.push(mix(top, hem, t));
    }
    let cols: Vec<usize> = (n / 2..=n / 2 + n).collect();
    let around: Vec<f32> = cols.iter().map(|&j| j as f32 / n as f32).collect();
    let v: Vec<f32> = (0..=skirt.rows).map(|r| r as f32 / skirt.rows as f32).collect();
    let gc = GridChart { chart: chart::SKIRT, part: part::SKIRT, mirrored: false, lying: false };
    let u = |_: usize, k: usize| k as f32 / n as f32;
    shape.add_grid(&rings, &cols, &u, &around, &v, &along, &gc, true, &|_, _| false);
    // The lining: from the hem back up to the waistband, so that the cloth has an inside.
    let inner = |t: f32| -> Vec<Vec3> { (0..n).map(|j| point(t, TAU * j as f32 / n as f32, 0.012)).collect() };
    let lining = [
        rings[skirt.rows].clone(),
        shape.add_ring(&inner(0.93), tag::SKIRT),
        shape.add_ring(&inner(0.5), tag::SKIRT),
        rings[0].clone(),
    ];
    let gc = GridChart { chart: chart::LINING, part: part::SKIRT, mirrored: false, lying: false };
    let v = [0.0, 0.1, 0.5, 1.0];
    shape.add_grid(&lining, &cols, &u, &around, &v, &[hem; 4], &gc, true, &|_, _| false);
}
