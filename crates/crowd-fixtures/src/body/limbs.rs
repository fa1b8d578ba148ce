//! Arms with hands, legs with shoes: each bridged from its opening in the trunk.

use glam::Vec3;

use super::{Figure, chart, part, tag};
use crate::profile::{Profile, mix, smoothstep};
use crate::shape::{GridChart, Shape};

impl Figure {
    /// Bridges an arm into its hole and ends it in a hand.
    pub(super) fn add_arm(&self, shape: &mut Shape, rings: &[Vec<u32>], (bottom, top): (usize, usize), side: u16) {
        let b = &self.build;
        let n = b.columns;
        let (half, quarter) = (b.hole.0 / 2, n / 4);
        let col = |j: usize| if side == 0 { j } else { n - j };
        let mut loop_: Vec<u32> = Vec::new();
        loop_.extend((quarter..=quarter + half).map(|j| rings[top][col(j)]));
        loop_.extend((bottom..top).rev().map(|r| rings[r][col(quarter + half)]));
        loop_.extend((quarter - half..quarter + half).rev().map(|j| rings[bottom][col(j)]));
        loop_.extend((bottom + 1..=top).map(|r| rings[r][col(quarter - half)]));
        loop_.extend((quarter - half + 1..quarter).map(|j| rings[top][col(j)]));
        let count = loop_.len();
        let k = (count - 2) / 8;

        let drawn = [0.12, 0.22, 0.37, 0.48, 0.54, 0.61, 0.71, 0.86, 1.0, 1.07, 1.14, 1.22];
        let rows = self.place_rows(&drawn, &b.arm_covers, 0.012);
        let (d, z) = (self.arm_axis(), Vec3::Z);
        let u = Vec3::new(-d.y, d.x, 0.0);
        let mut arm: Vec<Vec<u32>> = vec![loop_];
        let mut along = vec![0.0];
        for &s in &rows {
            let (ru, rz) = self.arm_r(s);
            let boxy = smoothstep(1.0, 1.18, s);
            let centre = self.arm_at(s);
            let ring: Vec<Vec3> = (0..count)
                .map(|i| {
                    let (sn, cs) = libm::sincosf(core::f32::consts::TAU * i as f32 / count as f32);
                    let (row_top, m) = palm_place(i, k);
                    let width = (2.0 * k as f32 - m) / (2.0 * k as f32);
                    let round = (cs * ru, -sn * rz);
                    let arch = 1.0 + 0.25 * (1.0 - width * width);
                    let square = (if row_top { ru * 0.85 * arch } else { -ru * 0.85 }, width * rz);
                    let p = centre + u * mix(round.0, square.0, boxy) + z * mix(round.1, square.1, boxy);
                    self.side(side, p)
                })
                .collect();
            arm.push(shape.add_ring(&ring, tag::ARM + side));
            along.push(s);
        }
        let flip = side == 0;
        let mirrored = side == 1;
        // The seam runs along the underside.
        let start = count / 2;
        let cols: Vec<usize> = (start..=start + count).collect();
        let around: Vec<f32> = cols.iter().map(|&j| j as f32 / count as f32).collect();
        let wrist = 1 + rows.iter().position(|&s| s >= 1.0 - 1e-4).unwrap_or(0);
        let thumb = (
            1 + rows.iter().position(|&s| s >= 1.07 - 1e-4).unwrap_or(0),
            1 + rows.iter().position(|&s| s >= 1.14 - 1e-4).unwrap_or(0),
        );
        let thumb_col = 6 * k + 1;
        let spans = [(0, wrist, chart::ARM, part::ARM), (wrist, arm.len() - 1, chart::HAND, part::HAND)];
        for (from, to, chart, part) in spans {
            let v: Vec<f32> = (from..=to).map(|r| (along[r] - along[from]) / (along[to] - along[from])).collect();
            let gc = GridChart { chart, part, mirrored, lying: false };
            let u = |_: usize, c: usize| c as f32 / count as f32;
            let skip = |r: usize, c: usize| cols[c] % count == thumb_col && from + r >= thumb.0 && from + r < thumb.1;
            shape.add_grid(&arm[from..=to], &cols, &u, &around, &v, &along[from..=to], &gc, flip, &skip);
        }
        self.add_fingers(shape, &arm, k, thumb, side);
    }

    fn add_fingers(&self, shape: &mut Shape, arm: &[Vec<u32>], k: usize, thumb: (usize, usize), side: u16) {
        let palm = &arm[arm.len() - 1];
        let (d, z) = (self.arm_axis(), Vec3::Z);
        let u = Vec3::new(-d.y, d.x, 0.0);
        let rows = if self.build.rows > 1 { 4 } else { 2 };
        let grow = |shape: &mut Shape, base: Vec<u32>, axis: Vec3, length: f32, radius: f32, finger: u16| {
            let centre =
                base.iter().map(|&i| self.side(side, shape.positions[i as usize])).sum::<Vec3>() / base.len() as f32;
            let (a, b) = (axis.cross(u).normalize(), u);
            let b = (b - axis * axis.dot(b)).normalize();
            let mut rings = vec![base.clone()];
            for r in 1..=rows {
                let t = r as f32 / (rows as f32 + 0.35);
                let girth = radius * (1.0 - 0.35 * t * t);
                let curl = -b * (0.10 * length * t * t);
                let ring: Vec<Vec3> = base
                    .iter()
                    .map(|&i| {
                        let o = self.side(side, shape.positions[i as usize]) - centre;
                        let (x, y) = (o.dot(a), o.dot(b));
                        let len = (x * x + y * y).sqrt().max(1e-6);
                        let p = centre + axis * length * t + curl + (a * x + b * y) * (girth / len);
                        self.side(side, p)
                    })
                    .collect();
                rings.push(shape.add_ring(&ring, tag::FINGER + 2 * finger + side));
            }
            let tip = shape
                .add(self.side(side, centre + axis * length - b * (0.11 * length)), tag::FINGER + 2 * finger + side);
            let gc = GridChart { chart: chart::FINGER + finger, part: part::HAND, mirrored: side == 1, lying: false };
            let along: Vec<f32> = (0..=rows + 1).map(|r| r as f32 / (rows + 1) as f32).collect();
            shape.add_disc(&rings, tip, &along, &gc, side == 0);
        };
        let index_of = |top: bool, m: usize| {
            let i = if top { m as isize - 2 * k as isize } else { (6 * k + 1) as isize - m as isize };
            palm[i.rem_euclid((8 * k + 2) as isize) as usize]
        };
        let lengths = [0.046, 0.051, 0.047, 0.037];
        for f in 0..4 {
            let mut base: Vec<u32> = (f * k..=(f + 1) * k).map(|m| index_of(true, m)).collect();
            base.extend((f * k..=(f + 1) * k).rev().map(|m| index_of(false, m)));
            let spread = z * (0.10 * (1.5 - f as f32) / 1.5);
            let axis = (d + spread).normalize();
            grow(
                shape,
                base,
                axis,
                self.m(lengths[f]),
                self.m(0.0072 * mix(1.0, self.build.arm_girth, 0.4)),
                1 + f as u16,
            );
        }
        let (t0, b0) = (6 * k + 2, 6 * k + 1);
        let n = 8 * k + 2;
        let mut base: Vec<u32> = (thumb.0..=thumb.1).map(|r| arm[r][t0 % n]).collect();
        base.extend((thumb.0..=thumb.1).rev().map(|r| arm[r][b0]));
        let axis = (d * 0.72 + z * 0.66 - u * 0.2).normalize();
        grow(shape, base, axis, self.m(0.040), self.m(0.0085 * mix(1.0, self.build.arm_girth, 0.4)), 0);
    }

    /// Joins a leg to its half of the lowest trunk ring and ends it in a shoe.
    pub(super) fn add_leg(&self, shape: &mut Shape, hip_ring: &[u32], side: u16) {
        let b = &self.build;
        let n = b.columns;
        let half = n / 2;
        let c = b.crotch_columns;
        let count = half + 1 + c;
        let mut first: Vec<u32> = (0..=half).map(|j| hip_ring[if side == 0 { j } else { (n - j) % n }]).collect();
        let (back, front) = (shape.positions[hip_ring[half] as usize], shape.positions[hip_ring[0] as usize]);
        for i in 1..=c {
            let t = i as f32 / (c + 1) as f32;
            let sag = 4.0 * t * (1.0 - t);
            first.push(shape.add(back.lerp(front, t) - Vec3::Y * self.m(0.012) * sag, tag::TRUNK));
        }
        let drawn = [0.085, 0.2, 0.33, 0.44, 0.5, 0.56, 0.67, 0.8, 0.92, 0.985];
        let rows = self.place_rows(&drawn, &b.leg_covers, 0.012);
        let mut rings = vec![first];
        let mut along = vec![0.0];
        let deg = core::f32::consts::PI / 180.0;
        for &q in &rows {
            let blend = smoothstep(0.0, 0.45, q);
            let r = self.leg_r(q);
            let ring: Vec<Vec3> = (0..count)
                .map(|i| {
                    let top = if i <= half {
                        mix(-38.0, 218.0, i as f32 / half as f32)
                    } else {
                        mix(218.0, 322.0, (i - half) as f32 / (c + 1) as f32)
                    };
                    let even = -38.0 + 360.0 * i as f32 / count as f32 - 12.0;
                    let (s, co) = libm::sincosf(mix(top, even, blend) * deg);
                    let mut p = self.leg_at(q) + Vec3::new(s * r, 0.0, co * r * 1.04);
                    // Thighs do not cross the middle.
                    p.x = p.x.max(self.m(0.0035));
                    self.side(side, p)
                })
                .collect();
            rings.push(shape.add_ring(&ring, tag::LEG + side));
            along.push(q);
        }
        let flip = side == 0;
        let start = half + c.div_ceil(2);
        let cols: Vec<usize> = (start..=start + count).collect();
        let around: Vec<f32> = cols.iter().map(|&j| j as f32 / count as f32).collect();
        let v: Vec<f32> = along.iter().map(|a| a / along[along.len() - 1]).collect();
        let gc = GridChart { chart: chart::LEG, part: part::LEG, mirrored: side == 1, lying: true };
        let u = |_: usize, k: usize| k as f32 / count as f32;
        shape.add_grid(&rings, &cols, &u, &around, &v, &along, &gc, flip, &|_, _| false);
        self.add_foot(shape, &rings[rings.len() - 1], side);
    }

    /// A shoe from the ankle ring: rings that turn from lying to standing, heel first.
    fn add_foot(&self, shape: &mut Shape, ankle: &[u32], side: u16) {
        let count = ankle.len();
        let centre = self.leg_at(1.0);
        let g = mix(1.0, self.build.leg_girth, 0.25);
        // Instep (z, y), heel or sole (z, y), half width: in body heights from the ankle's centre line and the floor.
        let drawn = [
            [0.026, 0.048, -0.032, 0.036, 0.0245],
            [0.038, 0.043, -0.040, 0.016, 0.0265],
            [0.052, 0.038, -0.034, -0.001, 0.0275],
            [0.072, 0.032, 0.010, -0.001, 0.0285],
            [0.092, 0.026, 0.058, -0.001, 0.0315],
            [0.110, 0.021, 0.092, -0.001, 0.0300],
            [0.124, 0.015, 0.117, 0.0005, 0.0215],
        ];
        let keys: Vec<f32> = (0..drawn.len()).map(|i| i as f32).collect();
        let curve = |k: usize| Profile::new(&keys.iter().zip(&drawn).map(|(&x, d)| (x, d[k])).collect::<Vec<_>>());
        let curves = [curve(0), curve(1), curve(2), curve(3), curve(4)];
        let places = self.place_rows(&keys, &[], 0.01);
        let turn = 0.16_f32;
        let (ts, tc) = libm::sincosf(turn);
        // The ankle ring's column 0 looks inner-front; the shoe's front is a little further on.
        let offset = 50.0 / 360.0;
        let mut rings = vec![ankle.to_vec()];
        let mut along = vec![0.0];
        for &x in &places {
            let f: Vec<f32> = curves.iter().map(|c| self.m(c.at(x))).collect();
            let (top, low) = (Vec3::new(0.0, f[1], f[0]), Vec3::new(0.0, f[3], f[2]));
            let (mid, axis) = ((top + low) * 0.5, (top - low) * 0.5);
            let ring: Vec<Vec3> = (0..count)
                .map(|i| {
                    let (s, c) = libm::sincosf(core::f32::consts::TAU * (i as f32 / count as f32 - offset));
                    let soft = |x: f32, e: f32| libm::powf(x.abs(), e) * x.signum();
                    let sole = if c < 0.0 { 0.55 } else { 0.9 };
                    let mut p = mid + axis * soft(c, sole) + Vec3::X * (soft(s, 0.8) * f[4] * g);
                    p.y = p.y.max(0.0);
                    let p = Vec3::new(p.x * tc + p.z * ts, p.y, p.z * tc - p.x * ts);
                    self.side(side, Vec3::new(centre.x + p.x, p.y, centre.z + p.z))
                })
                .collect();
            rings.push(shape.add_ring(&ring, tag::LEG + side));
            along.push(1.0 + x);
        }
        let tip = Vec3::new(ts, 0.0, tc) * self.m(0.128);
        let tip = Vec3::new(centre.x + tip.x, self.m(0.007), centre.z + tip.z);
        let tip = shape.add(self.side(side, tip), tag::LEG + side);
        let cap = rings.len() - 2;
        let start = (count as f32 * (0.5 + offset)) as usize;
        let cols: Vec<usize> = (start..=start + count).collect();
        let around: Vec<f32> = cols.iter().map(|&j| j as f32 / count as f32).collect();
        let v: Vec<f32> = along[..=cap].iter().map(|a| a / along[cap]).collect();
        let gc = GridChart { chart: chart::FOOT, part: part::FOOT, mirrored: side == 1, lying: false };
        let u = |_: usize, k: usize| k as f32 / count as f32;
        shape.add_grid(&rings[..=cap], &cols, &u, &around, &v, &along[..=cap], &gc, side == 0, &|_, _| false);
        let gc = GridChart { chart: chart::TOE, part: part::FOOT, mirrored: side == 1, lying: false };
        shape.add_disc(&rings[cap..], tip, &along[cap..], &gc, side == 0);
    }
}

/// Which palm place the ring index `i` of `8k + 2` is: on the back of the hand or not, and its number from the thumb side.
fn palm_place(i: usize, k: usize) -> (bool, f32) {
    if i <= 2 * k {
        (true, (2 * k + i) as f32)
    } else if i <= 6 * k + 1 {
        (false, (6 * k + 1 - i) as f32)
    } else {
        (true, (i - 6 * k - 2) as f32)
    }
}
