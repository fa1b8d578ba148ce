//! A human body as one closed surface: trunk, neck and head as one stack of rings, arms and legs bridged into it,
//! hands with four fingers and a thumb, feet in shoes.

use glam::Vec3;

mod limbs;

use crate::profile::{Profile, bell, mix, smoothstep};
use crate::shape::{Corner, GridChart, Shape, running_share};

/// Body parts, as the painter knows them.
pub mod part {
    #![allow(missing_docs, reason = "the names say it; their numbers mean nothing outside")]
    pub const TRUNK: u8 = 0;
    pub const HEAD: u8 = 1;
    pub const ARM: u8 = 2;
    pub const HAND: u8 = 3;
    pub const LEG: u8 = 4;
    pub const FOOT: u8 = 5;
    pub const HAIR: u8 = 6;
    pub const TAIL: u8 = 7;
    pub const SKIRT: u8 = 8;
    pub const EAR: u8 = 9;
    pub const COLLAR: u8 = 10;
    pub const BRIM: u8 = 11;
}

/// What the skin weights of a position are computed from.
pub mod tag {
    #![allow(missing_docs, reason = "the names say it; their numbers mean nothing outside")]
    pub const TRUNK: u16 = 0;
    pub const HEAD: u16 = 1;
    pub const HAIR_TAIL: u16 = 2;
    pub const SKIRT: u16 = 3;
    /// Add the side: 0 left (+x), 1 right.
    pub const ARM: u16 = 10;
    pub const LEG: u16 = 20;
    /// Add 2 * finger (0 thumb .. 4 little) + side.
    pub const FINGER: u16 = 30;
}

/// Charts of the human atlas, in the order of [`crate::atlas::HUMAN`].
pub mod chart {
    #![allow(missing_docs, reason = "the names say it; their numbers mean nothing outside")]
    pub const FACE: u16 = 0;
    pub const BACK_HEAD: u16 = 1;
    pub const CROWN: u16 = 2;
    pub const FRONT: u16 = 3;
    pub const BACK: u16 = 4;
    pub const HIP_FRONT: u16 = 5;
    pub const HIP_BACK: u16 = 6;
    pub const ARM: u16 = 7;
    pub const HAND: u16 = 8;
    pub const FINGER: u16 = 9; // five discs, 9..=13
    pub const EAR: u16 = 14;
    pub const LEG: u16 = 15;
    pub const FOOT: u16 = 16;
    pub const TOE: u16 = 17;
    pub const HAIR: u16 = 18;
    pub const TAIL: u16 = 19;
    pub const SKIRT: u16 = 20;
    pub const EXTRA: u16 = 21;
    pub const LINING: u16 = 22;
}

/// A garment (or bare skin) that covers a limb up to `end`: its cloth stands `extra` off the skin and is at least
/// `least` wide (both in body heights).
#[derive(Clone, Copy, Debug)]
pub struct Cover {
    /// Where it ends, in the limb's own measure.
    pub end: f32,
    /// How far it stands off.
    pub extra: f32,
    /// Smallest radius.
    pub least: f32,
}

/// Shorthand for a [`Cover`].
pub const fn cover(end: f32, extra: f32, least: f32) -> Cover {
    Cover { end, extra, least }
}

/// The measures of one body. Lengths are in body heights unless said otherwise.
#[derive(Clone, Debug)]
pub struct Build {
    /// Standing height in metres.
    pub height: f32,
    /// Height of the head, chin to crown.
    pub head: f32,
    /// Head width and depth against the adult's.
    pub head_width: f32,
    /// Height of the crotch.
    pub crotch: f32,
    /// Height of the neck's base.
    pub neck_base: f32,
    /// Half the distance between the shoulder joints.
    pub shoulder: f32,
    /// Trunk rings: share of the way from crotch to neck base, half width, front, back.
    pub trunk: Vec<[f32; 4]>,
    /// How far the bust stands out.
    pub bust: f32,
    /// Neck radius.
    pub neck: f32,
    /// Arm and leg thickness against the slim adult's.
    pub arm_girth: f32,
    /// See `arm_girth`.
    pub leg_girth: f32,
    /// Length of the arm without the hand.
    pub arm: f32,
    /// Covers of trunk (shares), arm (shares of its length) and leg (shares, crotch to ankle).
    pub trunk_covers: Vec<Cover>,
    /// See `trunk_covers`.
    pub arm_covers: Vec<Cover>,
    /// See `trunk_covers`.
    pub leg_covers: Vec<Cover>,
    /// Jaw width against the adult's, 1 = neutral.
    pub jaw: f32,
    /// Nose size, 1 = adult.
    pub nose: f32,
    /// How far a beard stands out, in heads.
    pub beard: f32,
    /// How far eyeballs and lids stand out (only where the mesh is fine enough to show them).
    pub eyes: f32,
    /// Resolution: columns round the trunk (a multiple of 8), rows between drawn rings, arm-hole columns and rows,
    /// positions inside the crotch.
    pub columns: usize,
    /// See `columns`.
    pub rows: usize,
    /// See `columns`.
    pub hole: (usize, usize),
    /// See `columns`.
    pub crotch_columns: usize,
}

/// The angle (from straight down the arm's bind pose, below the horizontal) of the arms in bind pose.
pub const ARM_DROP: f32 = 0.80;

/// Joint places and the smooth curves a [`Build`] stands for.
pub struct Figure {
    /// The measures.
    pub build: Build,
    width: Profile,
    front: Profile,
    back: Profile,
    head_front: Profile,
    head_side: Profile,
    head_back: Profile,
    leg_radius: Profile,
    arm_u: Profile,
    arm_z: Profile,
}

impl Figure {
    /// Prepares the curves of `build`.
    pub fn new(build: Build) -> Self {
        let column = |k: usize| Profile::new(&build.trunk.iter().map(|r| (r[0], r[k])).collect::<Vec<_>>());
        let j = build.jaw;
        Self {
            width: column(1),
            front: column(2),
            back: column(3),
            head_front: Profile::new(&[
                (-0.08, 0.20),
                (-0.02, 0.30),
                (0.03, 0.395),
                (0.10, 0.41),
                (0.2, 0.415),
                (0.32, 0.425),
                (0.42, 0.425),
                (0.5, 0.415),
                (0.59, 0.43),
                (0.7, 0.425),
                (0.83, 0.365),
                (0.93, 0.255),
                (0.985, 0.11),
                (1.0, 0.0),
            ]),
            head_side: Profile::new(&[
                (-0.08, 0.21),
                (-0.02, 0.215 * j),
                (0.03, 0.235 * j),
                (0.10, 0.28 * j),
                (0.2, 0.315 * mix(1.0, j, 0.7)),
                (0.32, 0.342 * mix(1.0, j, 0.3)),
                (0.42, 0.357),
                (0.5, 0.36),
                (0.6, 0.367),
                (0.7, 0.362),
                (0.83, 0.320),
                (0.93, 0.225),
                (0.985, 0.10),
                (1.0, 0.0),
            ]),
            head_back: Profile::new(&[
                (-0.08, 0.25),
                (0.03, 0.26),
                (0.12, 0.28),
                (0.25, 0.34),
                (0.42, 0.405),
                (0.55, 0.43),
                (0.7, 0.425),
                (0.83, 0.37),
                (0.93, 0.265),
                (0.985, 0.12),
                (1.0, 0.0),
            ]),
            leg_radius: Profile::new(&[
                (0.0, 0.053),
                (0.1, 0.0525),
                (0.22, 0.0485),
                (0.34, 0.0435),
                (0.44, 0.039),
                (0.5, 0.0375),
                (0.56, 0.0355),
                (0.67, 0.0375),
                (0.8, 0.0295),
                (0.92, 0.0225),
                (1.0, 0.0215),
            ]),
            arm_u: Profile::new(&[
                (0.0, 0.034),
                (0.10, 0.0325),
                (0.2, 0.0295),
                (0.36, 0.0275),
                (0.48, 0.0255),
                (0.54, 0.0255),
                (0.6, 0.0265),
                (0.68, 0.0265),
                (0.84, 0.0205),
                (1.0, 0.0145),
                (1.07, 0.0135),
                (1.22, 0.0105),
            ]),
            arm_z: Profile::new(&[
                (0.0, 0.032),
                (0.2, 0.0305),
                (0.36, 0.0285),
                (0.54, 0.0255),
                (0.66, 0.026),
                (0.84, 0.021),
                (1.0, 0.0175),
                (1.08, 0.0225),
                (1.15, 0.0255),
                (1.22, 0.0245),
            ]),
            build,
        }
    }

    /// Body heights to metres.
    fn m(&self, x: f32) -> f32 {
        x * self.build.height
    }

    /// The head axis' distance in front of the body's middle, `z` heads further.
    pub fn m_z(&self, z: f32) -> f32 {
        self.m(0.004) + z * self.head_m()
    }

    /// The height in metres of trunk share `t` (0 crotch, 1 base of the neck).
    pub fn trunk_y(&self, t: f32) -> f32 {
        self.m(mix(self.build.crotch, self.build.neck_base, t))
    }

    /// The chin's height in metres.
    pub fn chin_y(&self) -> f32 {
        self.m(1.0 - self.build.head)
    }

    /// The head's height in metres.
    pub fn head_m(&self) -> f32 {
        self.m(self.build.head)
    }

    /// Shoulder joint of the left side.
    pub fn shoulder(&self) -> Vec3 {
        Vec3::new(self.m(self.build.shoulder), self.trunk_y(0.90), self.m(-0.008))
    }

    /// Direction of the left arm in bind pose.
    pub fn arm_axis(&self) -> Vec3 {
        let (s, c) = libm::sincosf(ARM_DROP);
        Vec3::new(c, -s, 0.0)
    }

    /// The left arm's centre line at share `s` (0 shoulder joint, 1 wrist).
    pub fn arm_at(&self, s: f32) -> Vec3 {
        self.shoulder() + self.arm_axis() * self.m(self.build.arm) * s
    }

    /// The left leg's centre line at share `q` (0 crotch height, 1 ankle).
    pub fn leg_at(&self, q: f32) -> Vec3 {
        let hip = 0.56 * self.width.at(0.0) * mix(1.0, self.build.leg_girth, 0.2);
        let x = mix(hip.max(0.052), 0.049, smoothstep(-0.2, 1.0, q));
        let z = 0.004 - 0.014 * smoothstep(0.3, 0.8, q);
        Vec3::new(self.m(x), mix(self.m(self.build.crotch), self.m(0.05), q), self.m(z))
    }

    /// The trunk's surface at share `t` and angle `theta` (0 front, a quarter turn = left), `extra` metres off.
    pub fn trunk_point(&self, t: f32, theta: f32, extra: f32) -> Vec3 {
        let (s, c) = libm::sincosf(theta);
        let e = 0.88;
        let soft = |x: f32| libm::powf(x.abs(), e) * x.signum();
        let depth = if c > 0.0 { self.front.at(t) } else { self.back.at(t) };
        let x = (self.m(self.width.at(t)) + extra) * soft(s);
        let mut z = (self.m(depth) + extra) * soft(c);
        let b = self.build.bust;
        if c > 0.0 && b > 0.0 {
            let h = self.m(1.0);
            let cup = bell(x.abs() / h - 0.046, 0.026) * bell(t - 0.69, if t > 0.69 { 0.085 } else { 0.055 });
            z += self.m(b) * cup;
        }
        // The spine leans a little: hips forward, chest back, neck forward.
        z += self.m(0.006 - 0.016 * smoothstep(0.1, 0.75, t) + 0.008 * smoothstep(0.85, 1.0, t));
        Vec3::new(x, self.trunk_y(t), z)
    }

    /// The head's surface at `hy` (0 chin, 1 crown) and angle `theta`, `extra` heads off; face included.
    pub fn head_point(&self, hy: f32, theta: f32, extra: f32) -> Vec3 {
        let h = self.head_m();
        let (s, c) = libm::sincosf(theta);
        let depth = if c > 0.0 { self.head_front.at(hy) } else { self.head_back.at(hy) };
        let flat = if c > 0.0 { 0.86 } else { 0.95 };
        let soft = |x: f32, e: f32| libm::powf(x.abs(), e) * x.signum();
        let wide = self.build.head_width;
        let x = (self.head_side.at(hy) * wide + extra) * soft(s, 0.93);
        let mut z = (depth * mix(1.0, wide, 0.5) + extra) * soft(c, flat);
        let mut y = hy;
        // Jaw and nape: the ring of the chin rises towards the ears.
        let tilt = 0.17 * (1.0 - smoothstep(0.02, 0.5, hy));
        y += tilt * 0.5 * (1.0 - c) * smoothstep(-0.1, 0.02, hy).max(0.6);
        if c > 0.0 && hy > -0.01 {
            let ax = x.abs();
            let n = self.build.nose;
            let bridge =
                Profile::new(&[(0.29, 0.0), (0.315, 0.055), (0.36, 0.085), (0.45, 0.048), (0.53, 0.018), (0.6, 0.0)]);
            z += n * bridge.at(hy) * bell(x, mix(0.045, 0.028, smoothstep(0.33, 0.5, hy)));
            z += n * 0.03 * bell(ax - 0.05, 0.025) * bell(hy - 0.325, 0.025);
            z -= 0.030 * bell(ax - 0.15, 0.065) * bell(hy - 0.5, 0.045);
            z += self.build.eyes * 0.020 * bell(ax - 0.155, 0.05) * bell(hy - 0.495, 0.032);
            z += 0.012 * bell(ax - 0.13, 0.10) * bell(hy - 0.59, 0.03);
            z += 0.016 * bell(x, 0.085) * bell(hy - 0.2, 0.035);
            z -= 0.010 * bell(x, 0.08) * bell(hy - 0.135, 0.022);
            z += 0.020 * bell(x, 0.08) * bell(hy - 0.06, 0.04);
            z += 0.014 * bell(ax - 0.2, 0.08) * bell(hy - 0.36, 0.07);
            let beard = self.build.beard;
            if beard > 0.0 {
                let low = 1.0 - smoothstep(0.10, 0.30, hy);
                z += beard * low * c;
                y -= beard * 0.9 * (1.0 - smoothstep(0.0, 0.16, hy)) * c;
            }
        }
        Vec3::new(x * h, self.chin_y() + y * h, self.m(0.004) + z * h)
    }

    fn leg_r(&self, q: f32) -> f32 {
        let girth = mix(self.build.leg_girth, mix(1.0, self.build.leg_girth, 0.6), smoothstep(0.3, 1.0, q));
        let covers = &self.build.leg_covers;
        let c = covers.iter().find(|c| q < c.end).unwrap_or(&covers[covers.len() - 1]);
        self.m((self.leg_radius.at(q) * girth + c.extra).max(c.least))
    }

    fn arm_r(&self, s: f32) -> (f32, f32) {
        let g = mix(self.build.arm_girth, mix(1.0, self.build.arm_girth, 0.35), smoothstep(0.8, 1.05, s));
        let covers = &self.build.arm_covers;
        let c = covers.iter().find(|c| s < c.end).unwrap_or(&covers[covers.len() - 1]);
        let r = |p: &Profile| self.m((p.at(s) * g + c.extra).max(c.least));
        (r(&self.arm_u), r(&self.arm_z))
    }

    /// The ring heights of a part: the drawn ones, a pair at every hem, and `rows` - 1 more between neighbours.
    fn place_rows(&self, drawn: &[f32], covers: &[Cover], ledge: f32) -> Vec<f32> {
        let mut keys: Vec<f32> = drawn.to_vec();
        let (low, high) = (drawn[0], drawn[drawn.len() - 1]);
        for c in covers.iter().filter(|c| c.end > low + ledge && c.end < high - ledge) {
            keys.retain(|k| *k == low || *k == high || (k - c.end).abs() > 3.0 * ledge);
            keys.extend([c.end - 0.5 * ledge, c.end + 0.5 * ledge]);
        }
        keys.sort_by(f32::total_cmp);
        let mut rows = vec![keys[0]];
        for w in keys.windows(2) {
            let n = if w[1] - w[0] < 1.5 * ledge { 1 } else { self.build.rows };
            rows.extend((1..=n).map(|i| if i == n { w[1] } else { mix(w[0], w[1], i as f32 / n as f32) }));
        }
        rows
    }

    /// Builds the closed body.
    pub fn model(&self) -> Shape {
        let mut shape = Shape::default();
        let (rings, patch_rows) = self.add_trunk_and_head(&mut shape);
        for side in 0..2 {
            self.add_arm(&mut shape, &rings, patch_rows, side);
            self.add_leg(&mut shape, &rings[0], side);
        }
        self.unite_crotch(&mut shape);
        self.soften_junctions(&mut shape, &rings, patch_rows);
        shape
    }

    /// Trunk, neck and head: all rings, and the rows of the arm holes.
    fn add_trunk_and_head(&self, shape: &mut Shape) -> (Vec<Vec<u32>>, (usize, usize)) {
        let b = &self.build;
        let n = b.columns;
        let tau = core::f32::consts::TAU;
        let drawn: Vec<f32> = b.trunk.iter().map(|r| r[0]).collect();
        let trunk_rows = self.place_rows(&drawn, &b.trunk_covers, 0.008);
        let head_drawn = [-0.08, -0.015, 0.03, 0.11, 0.2, 0.29, 0.355, 0.44, 0.515, 0.6, 0.71, 0.84, 0.935];
        let head_rows = self.place_rows(&head_drawn, &[], 0.001);
        let mut rings = Vec::new();
        let mut along = Vec::new();
        for &t in &trunk_rows {
            let c = b.trunk_covers.iter().find(|c| t < c.end).unwrap_or(&b.trunk_covers[b.trunk_covers.len() - 1]);
            let ring: Vec<Vec3> = (0..n)
                .map(|j| {
                    let mut p = self.trunk_point(t, tau * j as f32 / n as f32, self.m(c.extra));
                    if t == trunk_rows[0] {
                        // The leg opening is cut high at the side.
                        let share = p.x / self.m(self.width.at(t));
                        p.y += self.m(0.030) * share * share;
                    }
                    p
                })
                .collect();
            rings.push(shape.add_ring(&ring, tag::TRUNK));
            along.push(self.trunk_y(t));
        }
        let neck_row = rings.len();
        // Columns crowd towards the face, where the shape is.
        let angle = |j: usize, crowd: f32| {
            let a = tau * j as f32 / n as f32;
            a - crowd * libm::sinf(a)
        };
        let neck_y = (self.trunk_y(1.0), self.chin_y() - 0.08 * self.head_m());
        for i in 1..=b.rows.min(2) {
            let t = i as f32 / (b.rows.min(2) + 1) as f32;
            let ring: Vec<Vec3> = (0..n)
                .map(|j| {
                    let (s, c) = libm::sincosf(angle(j, 0.2));
                    let r = self.m(b.neck);
                    Vec3::new(r * s, mix(neck_y.0, neck_y.1, t) - 0.012 * c, mix(self.m(-0.004), 0.0, t) + r * 1.05 * c)
                })
                .collect();
            rings.push(shape.add_ring(&ring, tag::TRUNK));
            along.push(mix(neck_y.0, neck_y.1, t));
        }
        let head_start = rings.len();
        for &hy in &head_rows {
            let crowd = mix(0.25, 0.5, smoothstep(-0.08, 0.1, hy));
            let ring: Vec<Vec3> = (0..n).map(|j| self.head_point(hy, angle(j, crowd), 0.0)).collect();
            rings.push(shape.add_ring(&ring, tag::HEAD));
            along.push(self.chin_y() + hy * self.head_m());
        }
        let crown_row = head_start + head_rows.iter().position(|&h| h >= 0.83).unwrap_or(0);
        let belt_row = trunk_rows.iter().position(|&t| t >= 0.225).unwrap_or(1);

        let top = trunk_rows.iter().position(|&t| (t - 0.93).abs() < 1e-4).expect("the shoulder ring is drawn");
        let bottom = top - b.hole.1;
        let half_hole = b.hole.0 / 2;
        let quarter = n / 4;
        let in_hole = |row: usize, j: usize| {
            let near = |c: usize| j + half_hole >= c && j < c + half_hole;
            row >= bottom && row < top && (near(quarter) || near(n - quarter))
        };
        let front: Vec<usize> = (n - quarter..=n + quarter).collect();
        let back: Vec<usize> = (quarter..=n - quarter).collect();
        let slit_row = trunk_rows.iter().position(|&t| t >= 0.7).unwrap_or(top);
        let spans = [
            (0, belt_row, chart::HIP_FRONT, chart::HIP_BACK, part::TRUNK),
            (belt_row, neck_row - 1, chart::FRONT, chart::BACK, part::TRUNK),
            (neck_row - 1, crown_row, chart::FACE, chart::BACK_HEAD, part::HEAD),
        ];
        for (from, to, front_chart, back_chart, part) in spans {
            let v = |r: usize| 1.0 - (along[r] - along[from]) / (along[to] - along[from]);
            let v: Vec<f32> = (from..=to).map(v).collect();
            for (cols, chart) in [(&front, front_chart), (&back, back_chart)] {
                let share = self.column_share(shape, &rings[(from + to) / 2], cols);
                let mid = cols.len() / 2;
                // The shirt's front is slit from the neck down: a seam that ends inside its chart.
                let slit = |row: usize, right: bool| {
                    let open = 0.05 * (row.saturating_sub(slit_row)) as f32 / (to - slit_row).max(1) as f32;
                    if chart != chart::FRONT || row <= slit_row { 0.0 } else { open * if right { 1.0 } else { -1.0 } }
                };
                for right in [false, true] {
                    let piece: Vec<usize> = if right { cols[mid..].to_vec() } else { cols[..=mid].to_vec() };
                    let first = if right { mid } else { 0 };
                    let u = |row: usize, k: usize| {
                        let (x, g) = (share[first + k], slit(from + row, right));
                        if right { mix(0.5 + g, 1.0, (x - 0.5) * 2.0) } else { mix(0.0, 0.5 + g, x * 2.0) }
                    };
                    let around: Vec<f32> = piece.iter().map(|&j| j as f32 / n as f32).collect();
                    let gc = GridChart { chart, part, mirrored: false, lying: false };
                    let skip = |row: usize, k: usize| in_hole(from + row, piece[k] % n);
                    shape.add_grid(&rings[from..=to], &piece, &u, &around, &v, &along[from..=to], &gc, false, &skip);
                }
            }
        }
        let tip = shape.add(self.head_point(1.0, 0.0, 0.0).with_x(0.0), tag::HEAD);
        let gc = GridChart { chart: chart::CROWN, part: part::HEAD, mirrored: false, lying: false };
        shape.add_disc(&rings[crown_row..], tip, &along[crown_row..], &gc, false);
        (rings, (bottom, top))
    }

    /// Running share of a ring's length at each of `cols`, made symmetric about the middle.
    fn column_share(&self, shape: &Shape, ring: &[u32], cols: &[usize]) -> Vec<f32> {
        let at = |j: usize| shape.positions[ring[j % ring.len()] as usize];
        let lengths: Vec<f32> = cols.windows(2).map(|w| at(w[0]).distance(at(w[1]))).collect();
        let even = lengths.iter().sum::<f32>() / lengths.len() as f32;
        let n = lengths.len();
        // Half way between true length and equal columns: the face, with its crowded columns, gets more texels.
        let lengths: Vec<f32> = (0..n).map(|i| mix(0.5 * (lengths[i] + lengths[n - 1 - i]), even, 0.4)).collect();
        running_share(&lengths)
    }

    fn side(&self, side: u16, p: Vec3) -> Vec3 {
        if side == 0 { p } else { Vec3::new(-p.x, p.y, p.z) }
    }

    /// The two legs each made the crotch's positions: make them the same ones.
    fn unite_crotch(&self, shape: &mut Shape) {
        let mut to: Vec<u32> = (0..shape.positions.len() as u32).collect();
        let middle: Vec<usize> = (0..to.len())
            .filter(|&i| shape.tags[i] == tag::TRUNK && shape.positions[i].x.abs() < 1e-5)
            .filter(|&i| shape.positions[i].y < self.trunk_y(0.05))
            .collect();
        for (n, &i) in middle.iter().enumerate() {
            shape.positions[i].x = 0.0;
            for &j in &middle[n + 1..] {
                if shape.positions[i].distance(shape.positions[j]) < 1e-4 {
                    to[j] = to[i];
                }
            }
        }
        for f in &mut shape.faces {
            f.corners.iter_mut().for_each(|c: &mut Corner| c.position = to[c.position as usize]);
        }
    }

    /// Smooths where limbs meet the trunk; rows further off keep their drawn shape.
    fn soften_junctions(&self, shape: &mut Shape, rings: &[Vec<u32>], (bottom, top): (usize, usize)) {
        let b = &self.build;
        let n = b.columns;
        let mut amount = vec![0.0_f32; shape.positions.len()];
        let reach = b.hole.0 / 2;
        for row in bottom..=top {
            for side in [n / 4, n - n / 4] {
                for j in side - reach..=side + reach {
                    amount[rings[row][j % n] as usize] = 0.5;
                }
            }
        }
        let shoulder = self.shoulder();
        for i in 0..amount.len() {
            let p = shape.positions[i];
            if (tag::ARM..tag::ARM + 2).contains(&shape.tags[i]) {
                let s = (Vec3::new(p.x.abs(), p.y, p.z) - shoulder).dot(self.arm_axis()) / self.m(b.arm);
                amount[i] = 0.5 * smoothstep(0.30, 0.05, s);
            } else if (tag::LEG..tag::LEG + 2).contains(&shape.tags[i]) {
                amount[i] = 0.45 * smoothstep(self.trunk_y(-0.20), self.trunk_y(0.0), p.y);
            } else if shape.tags[i] == tag::TRUNK && p.y < self.trunk_y(0.10) {
                amount[i] = 0.35;
            }
        }
        shape.relax(&amount, 2 * b.rows);
    }
}
