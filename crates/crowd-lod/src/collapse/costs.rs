//! What a collapse costs: what the queue sorts by, and what is logged.

use super::{Run, Surface};
use crate::behind::Price;
use crate::fan::Fan;
use crate::find_images::Moved;
use crate::topology::Spoke;
use crate::{Criteria, Obstacle};

/// Share of the squared edge length added to the mean squared distance when ranking: where the surface is flat, short
/// edges go first and triangles stay even. Too small to matter anywhere else.
const LENGTH_SHARE: f32 = 1.0e-5;

/// What vanishes in a collapse.
#[derive(Debug, Clone, Copy, Default)]
struct Lost {
    /// Area times squared distance, m² times m², with what colours count.
    cost: f32,
    /// Area of the places that are left without any triangle, but for the two that meet, m².
    area: f32,
    /// All that goes with the last of a part.
    part: Option<Price>,
}

impl Run<'_> {
    /// What a collapse does to the shape: the part of what the queue sorts by that is known without its images.
    pub(super) fn shape_rank(&self, u: u32, t: u32, move_cost: f32) -> f32 {
        let quadrics = &self.surface.quadrics;
        let even = LENGTH_SHARE * self.rules.bind_distance_squared(u, t) * quadrics.merged_area(u, t);
        // What the collapse adds to all that was paid, so that the sum stays least; the paper ranks by the sum itself.
        match self.rules.criteria() {
            Criteria::Wedge => move_cost - quadrics.paid(u) + even,
            Criteria::Peng2011 => quadrics.total_cost(move_cost, t) + even,
        }
    }

    /// What the queue sorts by, but for what the rules charge: shape, and what the images add to what was paid for what they show. Never
    /// negative and never NaN, so that its bits sort as it does.
    pub(super) fn shown_rank(&self, shape: f32, moved: &[Moved]) -> f32 {
        let attributes = &self.surface.attributes;
        let shown: f64 = moved.iter().map(|m| m.cost - attributes.paid(m.variant)).sum();
        let rank = shape + shown as f32;
        if rank.is_nan() { f32::INFINITY } else { rank.max(0.0) }
    }

    /// Whether the rules allow a collapse of the centre of `fan`, and what they charge for it, but for the volume: nothing below zero.
    pub(super) fn allow(
        &self,
        fan: &Fan,
        spokes: &[Spoke],
        edge: &Spoke,
        on_edge: &[u32],
        moved: &[Moved],
    ) -> Result<f32, Obstacle> {
        let Surface { split, topology, .. } = &self.surface;
        let u = fan.center;
        match self.rules.criteria() {
            Criteria::Peng2011 => self.rules.check(topology, split, u, spokes, edge).map(|()| 0.0),
            Criteria::Wedge => {
                let turned = self.rules.charge(split, fan, spokes, edge, moved)?;
                let pressed = self.surface.gaps.charge(topology, u, edge.to);
                Ok(turned + pressed + self.charge_lost(u, edge.to, on_edge)?.cost)
            }
        }
    }

    /// What it costs that the surface then encloses more or less. Never below zero.
    pub(super) fn charge_volume(&self, fan: &Fan, t: u32) -> f32 {
        match self.rules.criteria() {
            Criteria::Wedge => self.volumes.charge(fan, self.rules, self.surface.quadrics, t),
            Criteria::Peng2011 => 0.0,
        }
    }

    /// What it costs that places are left without any triangle: what they stood for is then as far away as the target, or, when the target
    /// goes too, as what lies behind the part.
    fn charge_lost(&self, u: u32, t: u32, on_edge: &[u32]) -> Result<Lost, Obstacle> {
        let Surface { topology, quadrics, .. } = &self.surface;
        let dies = |triangle: u32| topology.touches(triangle, u) && topology.touches(triangle, t);
        let u_moves_nothing = topology.valence(u) == on_edge.len();
        let target_lost = u_moves_nothing && topology.valence(t) == on_edge.len();
        let (mut cost, mut area, mut part) = (0.0, 0.0, None);
        for (i, &triangle) in on_edge.iter().enumerate() {
            let c = topology.third(triangle, u, t);
            let seen = on_edge[..i].iter().any(|&other| topology.touches(other, c));
            if seen || topology.valence(c) > on_edge.len() || !topology.around(c).all(dies) {
                continue;
            }
            area += quadrics.area(c);
            cost +=
                if target_lost { self.lost[c as usize] } else { quadrics.area(c) * quadrics.distance_squared(c, t) };
        }
        if target_lost {
            cost += self.lost[u as usize] + self.lost[t as usize];
            part = self.surface.behind.price_of_last(on_edge);
            cost = part.map_or(cost, |whole| whole.cost);
            if !cost.is_finite() || topology.alive_count as usize <= on_edge.len() {
                return Err(Obstacle::Topology);
            }
        } else if u_moves_nothing {
            cost += quadrics.area(u) * quadrics.distance_squared(u, t);
        }
        Ok(Lost { cost, area, part })
    }

    /// What a collapse has cost by now, for each square metre that it concerns: shape, and what vanishes.
    pub(super) fn mean_cost(&self, u: u32, t: u32, move_cost: f32, on_edge: &[u32]) -> f32 {
        let quadrics = &self.surface.quadrics;
        let lost = match self.rules.criteria() {
            Criteria::Wedge => self.charge_lost(u, t, on_edge).unwrap_or_default(),
            Criteria::Peng2011 => Lost::default(),
        };
        // What vanishes with a whole part is seen from afar: its colours are no distance, and it may stand for more than its own area.
        let of_triangles = quadrics.merged_area(u, t) + lost.area;
        let area = lost.part.map_or(of_triangles, |part| part.area.max(of_triangles));
        let lost = Lost { cost: lost.part.map_or(lost.cost, |part| part.distance), ..lost };
        if area > 0.0 { (quadrics.total_cost(move_cost, t) + lost.cost) / area } else { 0.0 }
    }
}
