//! Collapses edges, cheapest first, until none is allowed any more.
//!
//! The queue holds one entry for each position: its cheapest allowed collapse. Costs only grow (quadrics add up), so an
//! entry whose target has grown since is a lower bound: it is evaluated again when it comes to the front. Ties fall to the
//! lower position, then to the lower target.
//!
//! After a collapse, the places around it look at their edge to the target alone: the others cost what they did, or are found dearer
//! when their turn comes. An edge that turns a triangle less than it did is thus noticed late, in the next look around: that halves
//! the time. Under Peng 2011 every place around looks at all its edges, and the order is exactly the greedy one.

use crate::attributes::Attributes;
use crate::behind::Behind;
use crate::criteria::Rules;
use crate::fan::Fan;
use crate::find_images::{ImageFinder, Moved};
use crate::layer_gaps::LayerGaps;
use crate::quadrics::Quadrics;
use crate::split_seams::SplitMesh;
use crate::symmetry::NO_PARTNER;
use crate::topology::{Spoke, Topology};
use crate::volumes::Volumes;
use crate::{Blocked, Criteria, Obstacle};
use obstacles::count_blocked;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

mod costs;
mod obstacles;
mod perform;
mod twins;

/// How much dearer a queued collapse may be when its turn comes, without another look around.
const STILL_SAME: f32 = 1.000_01;
/// How much dearer the mirror image of a collapse may be and still follow it at once. In a small part that mirrors another one it follows at
/// any price: two eyes that once differ never come to be alike again (docs/decisions/0075).
const MIRROR_SLACK: f32 = 2.0;
/// A place with more triangles is a hub: with all that collapses onto it, it grows, and all others that would go there have to be looked at again.
const HUB_VALENCE: usize = 1024;
/// Times that a place is looked at again whose best way leads to a hub; then it goes there when its turn comes, if that is allowed, though it may be dearer than
/// others by now. All of a thousand pages on one edge would take the square of their number.
const MOST_HUB_LOOKS: u8 = 64;
/// Beyond all costs that are numbers, and still a number with [`STILL_SAME`].
const ANY_COST: f32 = f32::MAX / 2.0;
/// Collapses between two calls of `progress`.
const PROGRESS_STEPS: usize = 512;

/// The collapses in the order performed. Step `i` drops `dropped[ends..]` and so on: prefix ends, one per step.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    /// Mean squared distance of each step, what vanished in it included, m².
    pub costs: Vec<f32>,
    /// Variants no triangle uses after their step, each with the variant that stands for it.
    pub dropped: Vec<(u32, u32)>,
    /// End of each step in `dropped`.
    pub dropped_ends: Vec<u32>,
    /// Triangles removed.
    pub removed: Vec<u32>,
    /// End of each step in `removed`.
    pub removed_ends: Vec<u32>,
    /// Collapses onto hubs that were not compared with others once more ([`MOST_HUB_LOOKS`]).
    pub hurried_count: u32,
    /// What held the positions that are left.
    pub blocked: Blocked,
    /// The same for each position; nothing where no triangle is left.
    pub obstacles: Vec<Option<Obstacle>>,
}

/// Queue entry: rank as ordered bits above the position, and the position's stamp.
type Entry = Reverse<(u64, u32)>;

/// The cheapest allowed collapse of a position.
#[derive(Debug, Clone, Copy)]
struct Choice {
    rank: f32,
    target: u32,
    /// How often the quadric of the target had grown.
    grown: u32,
}

/// What is collapsed, and what each collapse costs.
pub(crate) struct Surface<'a> {
    /// Variants; grows by stand-ins.
    pub split: &'a mut SplitMesh,
    /// Unit normal of each variant; grows with them.
    pub normals: &'a mut Vec<[f32; 3]>,
    pub topology: &'a mut Topology,
    pub quadrics: &'a mut Quadrics,
    pub attributes: &'a mut Attributes,
    pub gaps: &'a mut LayerGaps,
    /// For each position its mirror image, or `NO_PARTNER`.
    pub partners: &'a [u32],
    /// What lies behind each part.
    pub behind: &'a mut Behind,
}

/// Performs all allowed collapses.
///
/// Ends once at most `ends_at` triangles are left. A variant whose wedge moves goes to the neighbour across a removed triangle, or else where `find_images` says.
pub(crate) fn collapse_edges(
    surface: Surface<'_>,
    rules: &Rules,
    ends_at: u32,
    progress: &(dyn Fn(f32) + Sync),
) -> Steps {
    let position_count = surface.split.position_source.len();
    let mut references = vec![0_u32; surface.split.variant_wedge.len()];
    for &v in surface.split.triangles.as_flattened() {
        references[v as usize] += 1;
    }
    let lost = (0..position_count as u32).map(|p| surface.behind.loss(p) * surface.quadrics.area(p)).collect();
    let mut run = Run {
        surface,
        rules,
        references,
        lost,
        volumes: Volumes::new(position_count),
        known_costs: vec![Vec::new(); position_count],
        stamps: vec![0; position_count],
        queued: vec![None; position_count],
        grown: vec![0; position_count],
        hub_looks: vec![0; position_count],
        first_alive: 0,
        queue: BinaryHeap::with_capacity(position_count * 2),
        ends_at,
        steps: Steps::default(),
    };
    // A collapse can, where the surface is no manifold, free an edge further away than its neighbours: look again
    // until nothing is found.
    loop {
        let before = run.steps.costs.len();
        run.fill_queue();
        run.drain_queue(progress);
        if run.steps.costs.len() == before || run.has_ended() {
            break;
        }
    }
    run.steps.obstacles = run.find_obstacles();
    run.steps.blocked = count_blocked(&run.steps.obstacles);
    progress(1.0);
    run.steps
}

struct Run<'a> {
    surface: Surface<'a>,
    rules: &'a Rules,
    /// Corners of living triangles that use each variant.
    references: Vec<u32>,
    /// For each position, what it would cost if all that it stands for vanished: area times squared distance to what lies behind.
    lost: Vec<f32>,
    /// What the surroundings of each position have gained or lost by now.
    volumes: Volumes,
    /// For each position, move costs already computed since its quadric last grew.
    known_costs: Vec<Vec<(u32, f32)>>,
    /// For each position, the number of its current queue entry.
    stamps: Vec<u32>,
    /// For each position, what that entry holds.
    queued: Vec<Option<Choice>>,
    /// For each position, how often its quadric has grown.
    grown: Vec<u32>,
    /// For each position, how often it was looked at again when its best way led to a hub.
    hub_looks: Vec<u8>,
    /// No living triangle comes before this one.
    first_alive: usize,
    queue: BinaryHeap<Entry>,
    /// Triangles at which enough is collapsed.
    ends_at: u32,
    steps: Steps,
}

/// Room to work in, kept between evaluations.
#[derive(Default)]
struct Scratch {
    fan: Fan,
    tried: Vec<(f32, u32)>,
    spokes: Vec<Spoke>,
    on_edge: Vec<u32>,
    moved: Vec<Moved>,
}

impl Run<'_> {
    fn fill_queue(&mut self) {
        let mut known_costs = std::mem::take(&mut self.known_costs);
        let choose = |scratch: &mut Scratch, (p, known): (usize, &mut _)| self.choose(p as u32, known, scratch);
        let found: Vec<Option<Choice>> =
            known_costs.par_iter_mut().enumerate().map_init(Scratch::default, choose).collect();
        self.known_costs = known_costs;
        self.queue.clear();
        for (p, choice) in found.into_iter().enumerate() {
            self.enqueue(p as u32, choice);
        }
    }

    fn has_ended(&self) -> bool {
        self.surface.topology.alive_count <= self.ends_at
    }

    fn drain_queue(&mut self, progress: &(dyn Fn(f32) + Sync)) {
        let mut scratch = Scratch::default();
        let mut ring = Vec::new();
        while let Some(Reverse((key, stamp))) = self.queue.pop() {
            if self.has_ended() {
                return;
            }
            let u = key as u32;
            if stamp != self.stamps[u as usize] {
                continue;
            }
            let Choice { rank, target: t, grown } = self.queued[u as usize].expect("its stamp is that of this entry");
            let fresh = grown == self.grown[t as usize];
            let onto_hub = self.surface.topology.valence(t) > HUB_VALENCE;
            let in_turn = fresh && self.still_costs(u, t, true, rank, &mut scratch);
            let may_hurry = !in_turn && onto_hub && self.hub_looks[u as usize] >= MOST_HUB_LOOKS;
            let hurried = may_hurry && self.still_costs(u, t, true, ANY_COST, &mut scratch);
            if in_turn || hurried {
                self.steps.hurried_count += u32::from(hurried);
                // What was hurried costs more than its rank by now, and so does its mirror image.
                let at_any_price = hurried || self.surface.behind.are_of_last_of_twin(&scratch.on_edge);
                let slack = if at_any_price { ANY_COST } else { rank * MIRROR_SLACK };
                self.collapse_and_look_around(u, t, &mut scratch, &mut ring);
                let (u, t) = (self.surface.partners[u as usize], self.surface.partners[t as usize]);
                // Not asked for its volume: of two that go to one target, the second takes from what the first has taken.
                let alike = u != NO_PARTNER && t != NO_PARTNER && self.rules.may_move(self.surface.topology, u);
                if alike && self.still_costs(u, t, false, slack, &mut scratch) {
                    self.collapse_and_look_around(u, t, &mut scratch, &mut ring);
                }
                if self.steps.costs.len().is_multiple_of(PROGRESS_STEPS) {
                    progress(self.steps.costs.len() as f32 / self.stamps.len() as f32);
                }
            } else {
                self.hub_looks[u as usize] = self.hub_looks[u as usize].saturating_add(u8::from(onto_hub));
                self.evaluate(u, &mut scratch);
            }
        }
    }

    /// Performs a collapse that was just looked at, and evaluates its neighbours again.
    fn collapse_and_look_around(&mut self, u: u32, t: u32, scratch: &mut Scratch, ring: &mut Vec<u32>) {
        let twin = self.surface.behind.twin_of_last(&scratch.on_edge);
        ring.clear();
        ring.extend(scratch.spokes.iter().map(|s| s.to));
        self.collapse(t, scratch);
        for &p in ring.iter() {
            self.look_again(p, u, t, scratch);
        }
        if let Some(twin) = twin {
            self.let_vanish(twin, scratch, ring);
        }
    }

    /// Whether a collapse is still there and allowed, and no dearer than when it was queued. `by_volume`: whether it is charged for that.
    /// Leaves the fan and the spokes of `u`, the triangles on the edge and the images in `scratch`.
    fn still_costs(&self, u: u32, t: u32, by_volume: bool, rank: f32, scratch: &mut Scratch) -> bool {
        let Scratch { fan, spokes, on_edge, moved, .. } = scratch;
        fan.gather(self.surface.topology, u);
        fan.spokes(spokes);
        let Some(edge) = spokes.iter().find(|s| s.to == t) else { return false };
        let Some(&(_, move_cost)) = self.known_costs[u as usize].iter().find(|k| k.0 == t) else { return false };
        fan.find_on_edge(t, on_edge);
        self.find_images(fan, t, moved);
        let limit = rank * STILL_SAME;
        let now = self.shown_rank(self.shape_rank(u, t, move_cost), moved);
        self.measure(fan);
        let volume = if by_volume { self.charge_volume(fan, t) } else { 0.0 };
        if now + volume > limit {
            return false;
        }
        match self.allow(fan, spokes, edge, on_edge, moved) {
            Ok(extra) => now + extra + volume <= limit,
            Err(_) => false,
        }
    }

    /// Brings the entry of `p` up to date after its neighbour `u` moved to `t`.
    fn look_again(&mut self, p: u32, u: u32, t: u32, scratch: &mut Scratch) {
        let queued = match self.queued[p as usize] {
            Some(queued) if p != t && queued.target != u && self.rules.criteria() == Criteria::Wedge => queued,
            _ => return self.evaluate(p, scratch),
        };
        let mut known = std::mem::take(&mut self.known_costs[p as usize]);
        let choice = self.price(p, t, queued.rank, &mut known, scratch);
        self.known_costs[p as usize] = known;
        if choice.is_some() {
            self.enqueue(p, choice);
        }
    }

    /// What it costs that `p` moves to `t`, if that is allowed and cheaper than `limit`.
    fn price(&self, p: u32, t: u32, limit: f32, known: &mut Vec<(u32, f32)>, scratch: &mut Scratch) -> Option<Choice> {
        let Scratch { fan, spokes, on_edge, moved, .. } = scratch;
        let shape = self.shape_rank(p, t, self.known_cost(p, t, known));
        if shape >= limit {
            return None;
        }
        fan.gather(self.surface.topology, p);
        fan.find_on_edge(t, on_edge);
        if on_edge.is_empty() {
            return None;
        }
        self.find_images(fan, t, moved);
        let rank = self.shown_rank(shape, moved);
        if rank >= limit {
            return None;
        }
        self.measure(fan);
        let volume = self.charge_volume(fan, t);
        if rank + volume >= limit {
            return None;
        }
        fan.spokes(spokes);
        let edge = spokes.iter().find(|s| s.to == t)?;
        let rank = rank + self.allow(fan, spokes, edge, on_edge, moved).ok()? + volume;
        (rank < limit).then(|| self.choice(rank, t))
    }

    fn choice(&self, rank: f32, target: u32) -> Choice {
        Choice { rank, target, grown: self.grown[target as usize] }
    }

    /// Finds the cheapest allowed collapse of `p` and queues it in place of the one before.
    fn evaluate(&mut self, p: u32, scratch: &mut Scratch) {
        let mut known = std::mem::take(&mut self.known_costs[p as usize]);
        let choice = self.choose(p, &mut known, scratch);
        self.known_costs[p as usize] = known;
        self.enqueue(p, choice);
    }

    fn enqueue(&mut self, p: u32, choice: Option<Choice>) {
        self.stamps[p as usize] += 1;
        self.queued[p as usize] = choice;
        if let Some(Choice { rank, .. }) = choice {
            let key = u64::from(rank.to_bits()) << 32 | u64::from(p);
            self.queue.push(Reverse((key, self.stamps[p as usize])));
        }
    }

    /// The cheapest allowed collapse of `p`. What it does to the shape costs less to know than what it shows and whether it is allowed:
    /// edges are tried by that, until it alone is dearer than the best. (An edge that makes the texture lie better than it did could
    /// be cheaper than its shape; it is not waited for.)
    fn choose(&self, p: u32, known: &mut Vec<(u32, f32)>, scratch: &mut Scratch) -> Option<Choice> {
        if !self.rules.may_move(self.surface.topology, p) {
            return None;
        }
        let Scratch { fan, tried, spokes, on_edge, moved } = scratch;
        fan.gather(self.surface.topology, p);
        fan.spokes(spokes);
        tried.clear();
        for (i, spoke) in spokes.iter().enumerate() {
            tried.push((self.shape_rank(p, spoke.to, self.known_cost(p, spoke.to, known)), i as u32));
        }
        tried.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(spokes[a.1 as usize].to.cmp(&spokes[b.1 as usize].to)));
        let mut best: Option<Choice> = None;
        for &(shape, i) in tried.iter() {
            let dear = |rank: f32| best.is_some_and(|b| b.rank <= rank);
            if dear(shape) {
                break;
            }
            let edge = &spokes[i as usize];
            fan.find_on_edge(edge.to, on_edge);
            self.find_images(fan, edge.to, moved);
            let rank = self.shown_rank(shape, moved);
            if dear(rank) {
                continue;
            }
            self.measure(fan);
            // The rules charge nothing below zero.
            let volume = self.charge_volume(fan, edge.to);
            if dear(rank + volume) {
                continue;
            }
            if let Ok(extra) = self.allow(fan, spokes, edge, on_edge, moved) {
                let choice = self.choice(rank + extra + volume, edge.to);
                if best.is_none_or(|b| choice.rank < b.rank) {
                    best = Some(choice);
                }
            }
        }
        best.filter(|b| b.rank.is_finite())
    }

    /// The move cost of an edge, computed once for as long as the quadric of `p` stays.
    fn known_cost(&self, p: u32, t: u32, known: &mut Vec<(u32, f32)>) -> f32 {
        if let Some(&(_, cost)) = known.iter().find(|k| k.0 == t) {
            return cost;
        }
        let cost = self.surface.quadrics.move_cost(p, t);
        known.push((t, cost));
        cost
    }

    fn find_images(&self, fan: &Fan, t: u32, moved: &mut Vec<Moved>) {
        let Surface { split, normals, topology, attributes, .. } = &self.surface;
        ImageFinder { split, topology, attributes, normals, stand_ins: self.rules.criteria() == Criteria::Wedge }
            .find(fan, t, moved);
    }

    /// Looks how the triangles around a place lie; the paper's rules look for themselves.
    fn measure(&self, fan: &mut Fan) {
        if self.rules.criteria() == Criteria::Wedge {
            fan.measure(self.rules, self.surface.split);
        }
    }
}
