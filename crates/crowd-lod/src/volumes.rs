//! Keeps what the surface encloses: a limb that is cut thinner and thinner, a body that shrinks inward.
//!
//! Squared distances do not care on which side of full detail a level lies; original vertices lie inside every bulge, so its errors
//! add up inward. How much each place's surroundings have gained or lost since full detail is kept, in the posed frames in which
//! flips are tested, and the square of its mean depth is charged, its mean over them (after Lindstrom & Turk 1998, who keep the
//! volume of each step): ridges go where hollows go too.

use crate::criteria::{POSES, Rules};
use crate::quadrics::Quadrics;
use crate::topology::Topology;

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

    /// What it costs that `u` moves to `t`, m² times m²; nothing where that gives back what was lost.
    pub fn charge(&self, topology: &Topology, rules: &Rules, quadrics: &Quadrics, u: u32, t: u32) -> f32 {
        let (at_u, at_t) = (&self.gained[u as usize], &self.gained[t as usize]);
        let moved = gained_by_move(topology, rules, u, t);
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

    /// Hands on what `u` gained when it moves to `t`; before the move.
    pub fn follow(&mut self, topology: &Topology, rules: &Rules, u: u32, t: u32) {
        let moved = gained_by_move(topology, rules, u, t);
        let from = self.gained[u as usize];
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

/// Volume between the triangles around `u` and the same ones around `t` in each pose, m³.
fn gained_by_move(topology: &Topology, rules: &Rules, u: u32, t: u32) -> Lanes {
    let mut sum = Lanes::default();
    for triangle in topology.around(u).filter(|&triangle| !topology.touches(triangle, t)) {
        let corner = topology.corner_at(triangle, u);
        let corners = topology.triangle_positions[triangle as usize];
        rules.add_volumes([u, corners[(corner + 1) % 3], corners[(corner + 2) % 3]], t, &mut sum);
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

    /// Three rows of vertices, a square metre a quad; those of the middle row stand as high as `height` says.
    fn ridge(height: impl Fn(usize) -> f32) -> (Topology, Rules, Quadrics, Vec<[f32; 3]>) {
        let mesh = grid(6, 2, |x, y| if y == 1 { height(x) } else { 0.0 }, |_, _| false);
        let poses = TestPoses::rest();
        let split = split_seams(&mesh.mesh());
        let classes = classify_wedges(&split);
        let quadrics = Quadrics::build(&mesh.mesh(), &poses.poses(), &split, &classes.edge_kinds, Criteria::Wedge);
        let class = &classes.wedge_class;
        let rules = Rules::new(&mesh.mesh(), &poses.poses(), &split, Criteria::Wedge, &classes.non_manifold, class);
        let places: Vec<[f32; 3]> = split.position_source.iter().map(|&v| mesh.positions[v as usize]).collect();
        (Topology::new(&split), rules, quadrics, places)
    }

    fn at(places: &[[f32; 3]], x: f32) -> u32 {
        places.iter().position(|p| p[0] == x && p[1] == 1.0).expect("a vertex of the middle row") as u32
    }

    #[test]
    fn a_peak_that_goes_costs_its_squared_depth_and_a_hollow_gives_it_back() {
        // A peak of 0.3 m and, two places on, a hollow as deep.
        let (topology, rules, quadrics, places) = ridge(|x| [0.0, 0.0, 0.3, 0.0, -0.3, 0.0, 0.0][x]);
        let (peak, between, hollow) = (at(&places, 2.0), at(&places, 3.0), at(&places, 4.0));
        let mut volumes = Volumes::new(places.len());
        let lost = gained_by_move(&topology, &rules, peak, between)[0];
        // Every quad is cut in two: six triangles of half a square metre around, a third of their area times the height.
        assert!((lost + 0.3).abs() < 1.0e-5, "{lost}");
        let charged = volumes.charge(&topology, &rules, &quadrics, peak, between);
        let expected = DEPTH_WEIGHT * lost * lost / quadrics.merged_area(peak, between);
        assert!((charged / expected - 1.0).abs() < 1.0e-5, "{charged} {expected}");
        volumes.follow(&topology, &rules, peak, between);
        let alone = Volumes::new(places.len()).charge(&topology, &rules, &quadrics, hollow, between);
        let after = volumes.charge(&topology, &rules, &quadrics, hollow, between);
        assert!(alone > 0.0 && after == 0.0, "{alone} {after}");
    }

    #[test]
    fn what_moves_within_a_plane_costs_nothing() {
        let (topology, rules, quadrics, places) = ridge(|_| 0.0);
        let volumes = Volumes::new(places.len());
        assert_eq!(volumes.charge(&topology, &rules, &quadrics, at(&places, 2.0), at(&places, 3.0)), 0.0);
    }
}
