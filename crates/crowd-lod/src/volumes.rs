//! Keeps what the surface encloses: a limb that is cut thinner and thinner, a body that shrinks inward.
//!
//! Squared distances do not care on which side of full detail a level lies; original vertices lie inside every bulge, so its errors
//! add up inward. How much each place's surroundings have gained or lost since full detail is kept, in the posed frames in which
//! flips are tested, and the square of its mean depth is charged, its mean over them (after Lindstrom & Turk 1998, who keep the
//! volume of each step): ridges go where hollows go too.

use crate::criteria::{POSES, Places, Rules, product};
use crate::fan::Fan;
use crate::quadrics::Quadrics;
use fearless_simd::dispatch;

/// What the squared mean depth weighs next to a mean squared distance (docs/decisions/0031).
const DEPTH_WEIGHT: f32 = 20.0;

/// What the surroundings of each position have gained since full detail in each tested pose, m³; less than zero where they lost.
#[derive(Debug)]
pub(crate) struct Volumes {
    gained: Vec<Lanes>,
}

/// One number for each tested pose.
type Lanes = [f32; POSES];

impl Volumes {
    /// Full detail: nothing gained.
    pub fn new(position_count: usize) -> Self {
        Self { gained: vec![Lanes::default(); position_count] }
    }

    /// What it costs that the centre of `fan`, which is measured, moves to `t`, m² times m²; nothing where that gives back what was lost.
    pub fn charge(&self, fan: &Fan, rules: &Rules, quadrics: &Quadrics, t: u32) -> f32 {
        let u = fan.center;
        let (at_u, at_t) = (&self.gained[u as usize], &self.gained[t as usize]);
        let moved = gained_by_move(fan, rules, t);
        // The areas hardly change from frame to frame.
        let over = |area: f32| if area > 0.0 { 1.0 / area } else { 0.0 };
        let (over_u, over_t) = (over(quadrics.area(u)), over(quadrics.area(t)));
        let over_both = over(quadrics.merged_area(u, t));
        let mut more = Lanes::default();
        for i in 0..POSES {
            let together = at_u[i] + at_t[i] + moved[i];
            more[i] = together * together * over_both - at_u[i] * at_u[i] * over_u - at_t[i] * at_t[i] * over_t;
        }
        let mean: f32 = more.iter().zip(rules.pose_weights()).map(|(more, weight)| weight * more).sum();
        DEPTH_WEIGHT * mean.max(0.0)
    }

    /// Hands on what the centre of `fan`, which is measured, gained when it moves to `t`.
    pub fn follow(&mut self, fan: &Fan, rules: &Rules, t: u32) {
        let moved = gained_by_move(fan, rules, t);
        let from = self.gained[fan.center as usize];
        for i in 0..POSES {
            self.gained[t as usize][i] += from[i] + moved[i];
        }
    }

    /// Hands on what a place gained that has no triangle left.
    pub fn inherit(&mut self, from: u32, to: u32) {
        let from = self.gained[from as usize];
        self.gained[to as usize].iter_mut().zip(from).for_each(|(to, from)| *to += from);
    }
}

/// Volume between the triangles around the centre of a measured fan and the same ones around `t` in each pose, m³: that of the tetrahedra with
/// their tip there, positive before their front.
fn gained_by_move(fan: &Fan, rules: &Rules, t: u32) -> Lanes {
    let (from, tip) = (rules.places(fan.center), rules.places(t));
    dispatch!(rules.vectors(), _ => volumes_below(fan, t, from, tip))
}

/// The same; `from`: the places of the centre, `tip`: those of `t`.
#[inline(always)]
fn volumes_below(fan: &Fan, t: u32, from: &Places, tip: &Places) -> Lanes {
    let mut above = [Lanes::default(); 3];
    for k in 0..3 {
        for i in 0..POSES {
            above[k][i] = tip[k][i] - from[k][i];
        }
    }
    let mut sum = Lanes::default();
    for (_, lie) in fan.staying(t) {
        let heights = product(&lie.normals, &above);
        for i in 0..POSES {
            sum[i] += heights[i] / 6.0;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Criteria;
    use crate::classify::classify_wedges;
    use crate::split_seams::split_seams;
    use crate::test_meshes::{TestPoses, grid};
    use crate::topology::Topology;

    /// Three rows of vertices, a square metre a quad; those of the middle row stand as high as `height` says.
    fn ridge(height: impl Fn(usize) -> f32) -> (impl Fn(u32) -> Fan, Rules, Quadrics, Vec<[f32; 3]>) {
        let mesh = grid(6, 2, |x, y| if y == 1 { height(x) } else { 0.0 }, |_, _| false);
        let poses = TestPoses::rest();
        let split = split_seams(&mesh.mesh());
        let classes = classify_wedges(&split);
        let quadrics = Quadrics::build(&mesh.mesh(), &poses.poses(), &split, &classes.edge_kinds, Criteria::Wedge);
        let class = &classes.wedge_class;
        let rules = Rules::new(&mesh.mesh(), &poses.poses(), &split, Criteria::Wedge, &classes.non_manifold, class);
        let places: Vec<[f32; 3]> = split.position_source.iter().map(|&v| mesh.positions[v as usize]).collect();
        let (topology, fan_rules) = (Topology::new(&split), rules.clone());
        let fan = move |center: u32| {
            let mut fan = Fan::default();
            fan.gather(&topology, center);
            fan.measure(&fan_rules, &split);
            fan
        };
        (fan, rules, quadrics, places)
    }

    fn at(places: &[[f32; 3]], x: f32) -> u32 {
        places.iter().position(|p| p[0] == x && p[1] == 1.0).expect("a vertex of the middle row") as u32
    }

    #[test]
    fn a_peak_that_goes_costs_its_squared_depth_and_a_hollow_gives_it_back() {
        // A peak of 0.3 m and, two places on, a hollow as deep.
        let (fan, rules, quadrics, places) = ridge(|x| [0.0, 0.0, 0.3, 0.0, -0.3, 0.0, 0.0][x]);
        let (peak, between, hollow) = (at(&places, 2.0), at(&places, 3.0), at(&places, 4.0));
        let mut volumes = Volumes::new(places.len());
        let lost = gained_by_move(&fan(peak), &rules, between)[0];
        // Every quad is cut in two: six triangles of half a square metre around, a third of their area times the height.
        assert!((lost + 0.3).abs() < 1.0e-5, "{lost}");
        let charged = volumes.charge(&fan(peak), &rules, &quadrics, between);
        let expected = DEPTH_WEIGHT * lost * lost / quadrics.merged_area(peak, between);
        assert!((charged / expected - 1.0).abs() < 1.0e-5, "{charged} {expected}");
        volumes.follow(&fan(peak), &rules, between);
        let alone = Volumes::new(places.len()).charge(&fan(hollow), &rules, &quadrics, between);
        let after = volumes.charge(&fan(hollow), &rules, &quadrics, between);
        assert!(alone > 0.0 && after == 0.0, "{alone} {after}");
    }

    #[test]
    fn what_moves_within_a_plane_costs_nothing() {
        let (fan, rules, quadrics, places) = ridge(|_| 0.0);
        let volumes = Volumes::new(places.len());
        assert_eq!(volumes.charge(&fan(at(&places, 2.0)), &rules, &quadrics, at(&places, 3.0)), 0.0);
    }
}
