//! Collapses edges, cheapest first, until none is allowed any more.
//!
//! The queue holds one entry for each position: its cheapest allowed collapse. Costs only grow (quadrics add up), so an
//! entry whose target has grown since is a lower bound: it is evaluated again when it comes to the front. The order is thus
//! exactly the greedy one; ties fall to the lower position, then to the lower target.

use crate::criteria::{MAX_MOVED_VALENCE, Rules};
use crate::quadrics::Quadrics;
use crate::split_seams::{SplitMesh, cos_between};
use crate::topology::{Spoke, Topology};
use crate::{Blocked, Obstacle};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Share of the squared edge length added to the mean squared distance when ranking: where the surface is flat, short
/// edges go first and triangles stay even. Too small to matter anywhere else.
const LENGTH_SHARE: f32 = 1.0e-5;
/// Triangles at a hub that are searched for a variant to stand in; there is always one at hand to fall back on.
const SEARCHED_TRIANGLES: usize = 256;
/// Collapses between two calls of `progress`.
const PROGRESS_STEPS: usize = 512;

/// The collapses in the order performed. Step `i` drops `dropped[ends..]` and so on: prefix ends, one per step.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    /// Mean squared distance of each step, m².
    pub costs: Vec<f32>,
    /// Variants no triangle uses after their step, each with the variant that stands for it.
    pub dropped: Vec<(u32, u32)>,
    /// End of each step in `dropped`.
    pub dropped_ends: Vec<u32>,
    /// Triangles removed.
    pub removed: Vec<u32>,
    /// End of each step in `removed`.
    pub removed_ends: Vec<u32>,
    /// What held the positions that are left.
    pub blocked: Blocked,
    /// The same for each position; nothing where no triangle is left.
    pub obstacles: Vec<Option<Obstacle>>,
}

/// Queue entry: rank as ordered bits, position, target, stamp of the position, stamp of the target's quadric.
type Entry = Reverse<(u32, u32, u32, u32, u32)>;

/// The cheapest allowed collapse of a position.
#[derive(Debug, Clone, Copy)]
struct Choice {
    rank: f32,
    target: u32,
}

/// Performs all allowed collapses.
///
/// `normals`: of each variant; a variant whose wedge moves goes to the neighbour across a removed triangle, or else
/// to the variant with the closest normal.
pub(crate) fn collapse_edges(
    split: &SplitMesh,
    normals: &[[f32; 3]],
    topology: &mut Topology,
    quadrics: &mut Quadrics,
    rules: &Rules,
    progress: &(dyn Fn(f32) + Sync),
) -> Steps {
    let position_count = split.position_source.len();
    let mut references = vec![0_u32; split.variant_wedge.len()];
    for &v in split.triangles.as_flattened() {
        references[v as usize] += 1;
    }
    let mut run = Run {
        split,
        normals,
        topology,
        quadrics,
        rules,
        references,
        known_costs: vec![Vec::new(); position_count],
        stamps: vec![0; position_count],
        grown: vec![0; position_count],
        queue: BinaryHeap::with_capacity(position_count * 2),
        steps: Steps::default(),
    };
    // A collapse can, where the surface is no manifold, free an edge further away than its neighbours: look again
    // until nothing is found.
    loop {
        let before = run.steps.costs.len();
        run.fill_queue();
        run.drain_queue(progress);
        if run.steps.costs.len() == before {
            break;
        }
    }
    run.steps.obstacles = run.find_obstacles();
    run.steps.blocked = count_blocked(&run.steps.obstacles);
    progress(1.0);
    run.steps
}

struct Run<'a> {
    split: &'a SplitMesh,
    normals: &'a [[f32; 3]],
    topology: &'a mut Topology,
    quadrics: &'a mut Quadrics,
    rules: &'a Rules,
    /// Corners of living triangles that use each variant.
    references: Vec<u32>,
    /// For each position, move costs already computed since its quadric last grew.
    known_costs: Vec<Vec<(u32, f32)>>,
    /// For each position, the number of its current queue entry.
    stamps: Vec<u32>,
    /// For each position, how often its quadric has grown.
    grown: Vec<u32>,
    queue: BinaryHeap<Entry>,
    steps: Steps,
}

impl Run<'_> {
    fn fill_queue(&mut self) {
        let found: Vec<(Option<Choice>, Vec<(u32, f32)>)> = (0..self.stamps.len() as u32)
            .into_par_iter()
            .map_init(Vec::new, |spokes, p| {
                let mut known = self.known_costs[p as usize].clone();
                (self.choose(p, &mut known, spokes), known)
            })
            .collect();
        self.queue.clear();
        for (p, (choice, known)) in found.into_iter().enumerate() {
            self.known_costs[p] = known;
            self.enqueue(p as u32, choice);
        }
    }

    fn drain_queue(&mut self, progress: &(dyn Fn(f32) + Sync)) {
        let mut spokes = Vec::new();
        let mut ring = Vec::new();
        while let Some(Reverse((_, u, t, stamp, grown))) = self.queue.pop() {
            if stamp != self.stamps[u as usize] {
                continue;
            }
            self.topology.spokes(u, &mut spokes);
            let edge = spokes.iter().find(|s| s.to == t).copied();
            let fresh = grown == self.grown[t as usize];
            match edge {
                Some(edge) if fresh && self.rules.check(self.topology, u, &spokes, &edge).is_ok() => {
                    self.collapse(u, &edge);
                    ring.clear();
                    ring.extend(spokes.iter().map(|s| s.to));
                    for &p in &ring {
                        self.evaluate(p, &mut spokes);
                    }
                    if self.steps.costs.len().is_multiple_of(PROGRESS_STEPS) {
                        progress(self.steps.costs.len() as f32 / self.stamps.len() as f32);
                    }
                }
                _ => self.evaluate(u, &mut spokes),
            }
        }
    }

    /// Finds the cheapest allowed collapse of `p` and queues it in place of the one before.
    fn evaluate(&mut self, p: u32, spokes: &mut Vec<Spoke>) {
        let mut known = std::mem::take(&mut self.known_costs[p as usize]);
        let choice = self.choose(p, &mut known, spokes);
        self.known_costs[p as usize] = known;
        self.enqueue(p, choice);
    }

    fn enqueue(&mut self, p: u32, choice: Option<Choice>) {
        self.stamps[p as usize] += 1;
        if let Some(Choice { rank, target }) = choice {
            let (stamp, grown) = (self.stamps[p as usize], self.grown[target as usize]);
            self.queue.push(Reverse((rank.to_bits(), p, target, stamp, grown)));
        }
    }

    /// The cheapest allowed collapse of `p`. Rules cost more than a known cost, so edges are tried by cost.
    fn choose(&self, p: u32, known: &mut Vec<(u32, f32)>, spokes: &mut Vec<Spoke>) -> Option<Choice> {
        if !self.rules.may_move(self.topology, p) {
            return None;
        }
        self.topology.spokes(p, spokes);
        let mut tried = [(u32::MAX, u32::MAX); 2 * MAX_MOVED_VALENCE];
        let count = spokes.len();
        for (i, spoke) in spokes.iter().enumerate() {
            let move_cost = match known.iter().find(|k| k.0 == spoke.to) {
                Some(&(_, cost)) => cost,
                None => {
                    let cost = self.quadrics.move_cost(p, spoke.to);
                    known.push((spoke.to, cost));
                    cost
                }
            };
            tried[i] = (self.rank(p, spoke.to, move_cost).to_bits(), i as u32);
        }
        let tried = &mut tried[..count];
        tried.sort_unstable_by_key(|&(rank, i)| (rank, spokes[i as usize].to));
        tried.iter().find_map(|&(rank, i)| {
            let edge = &spokes[i as usize];
            let allowed = self.rules.check(self.topology, p, spokes, edge).is_ok();
            allowed.then_some(Choice { rank: f32::from_bits(rank), target: edge.to })
        })
    }

    /// What the queue sorts by: never negative and never NaN, so that its bits sort as it does.
    fn rank(&self, u: u32, t: u32, move_cost: f32) -> f32 {
        let area = self.quadrics.merged_area(u, t);
        let even = LENGTH_SHARE * self.rules.bind_distance_squared(u, t) * area;
        let rank = self.quadrics.total_cost(move_cost, t) + even;
        if rank.is_nan() { f32::INFINITY } else { rank.max(0.0) }
    }

    /// Moves `u` to the other end of `edge` and logs the step.
    fn collapse(&mut self, u: u32, edge: &Spoke) {
        let t = edge.to;
        let move_cost = match self.known_costs[u as usize].iter().find(|k| k.0 == t) {
            Some(&(_, cost)) => cost,
            None => self.quadrics.move_cost(u, t),
        };
        let area = self.quadrics.merged_area(u, t);
        let mean = if area > 0.0 { self.quadrics.total_cost(move_cost, t) / area } else { 0.0 };
        self.steps.costs.push(mean);

        let dying = &edge.triangles[..edge.triangle_count.min(2) as usize];
        let moving: Vec<u32> = self.topology.around(u).filter(|i| !dying.contains(i)).collect();
        let images = self.map_variants(u, t, dying, &moving);
        let mut touched: Vec<u32> = Vec::new();
        for &i in dying {
            for v in self.topology.triangles[i as usize] {
                self.references[v as usize] -= 1;
                touched.push(v);
            }
            self.topology.remove(i);
            self.steps.removed.push(i);
        }
        for &i in &moving {
            let corner = self.topology.corner_at(i, u);
            let variant = self.topology.triangles[i as usize][corner];
            let image = image_of(&images, variant);
            self.topology.triangles[i as usize][corner] = image;
            self.references[variant as usize] -= 1;
            self.references[image as usize] += 1;
        }
        self.topology.move_triangles(u, t, &moving);
        self.drop_unreferenced(&images, touched);
        self.steps.dropped_ends.push(self.steps.dropped.len() as u32);
        self.steps.removed_ends.push(self.steps.removed.len() as u32);

        self.quadrics.merge(u, t, move_cost);
        self.known_costs[t as usize].clear();
        self.known_costs[u as usize] = Vec::new();
        self.stamps[u as usize] += 1;
        self.grown[t as usize] += 1;
    }

    /// For each variant at `u`, the variant at `t` that it becomes.
    fn map_variants(&self, u: u32, t: u32, dying: &[u32], moving: &[u32]) -> Vec<(u32, u32)> {
        let at =
            |triangle: u32, p: u32| self.topology.triangles[triangle as usize][self.topology.corner_at(triangle, p)];
        let wedge = |v: u32| self.split.variant_wedge[v as usize];
        let across: Vec<(u32, u32)> = dying.iter().map(|&i| (at(i, u), at(i, t))).collect();
        let mut images: Vec<(u32, u32)> = Vec::new();
        for v in dying.iter().chain(moving).map(|&i| at(i, u)) {
            if images.iter().any(|&(from, _)| from == v) {
                continue;
            }
            let shared = across.iter().filter(|&&(from, _)| from == v).map(|&(_, to)| to);
            let image = self.closest(v, shared).or_else(|| {
                let (_, on_target) = *across
                    .iter()
                    .find(|&&(from, _)| wedge(from) == wedge(v))
                    .expect("the wedge test found an image for every wedge");
                let around = self.topology.around(t).take(SEARCHED_TRIANGLES).map(|i| at(i, t));
                let group = around.filter(|&to| wedge(to) == wedge(on_target)).chain([on_target]);
                self.closest(v, group)
            });
            images.push((v, image.expect("the image wedge has a variant in a triangle on the edge")));
        }
        images
    }

    /// Of some variants, the one whose normal is closest to that of `v`.
    fn closest(&self, v: u32, candidates: impl Iterator<Item = u32>) -> Option<u32> {
        let mut best: Option<(f32, u32)> = None;
        for candidate in candidates {
            let cos = cos_between(self.normals[v as usize], self.normals[candidate as usize]);
            if best.is_none_or(|(best_cos, best_id)| cos > best_cos || (cos == best_cos && candidate < best_id)) {
                best = Some((cos, candidate));
            }
        }
        best.map(|(_, candidate)| candidate)
    }

    /// Logs the variants that no triangle uses any more: those of the position that moved, and those on its old
    /// neighbours whose last triangle died.
    fn drop_unreferenced(&mut self, images: &[(u32, u32)], mut touched: Vec<u32>) {
        touched.sort_unstable();
        touched.dedup();
        let start = self.steps.dropped.len();
        for v in touched {
            let moved = images.iter().any(|&(from, _)| from == v);
            if self.references[v as usize] > 0 || moved {
                continue;
            }
            let p = self.split.position_of(v);
            let wedge = self.split.variant_wedge[v as usize];
            let variant = |i: u32| self.topology.triangles[i as usize][self.topology.corner_at(i, p)];
            let around = || self.topology.around(p).take(SEARCHED_TRIANGLES).map(variant);
            let same_wedge = around().filter(|&w| self.split.variant_wedge[w as usize] == wedge);
            let stand_in = self.closest(v, same_wedge).or_else(|| self.closest(v, around()));
            self.steps.dropped.push((v, stand_in.expect("the link condition leaves every neighbour a triangle")));
        }
        for &(from, to) in images {
            // The image may itself have been used by dying triangles only.
            let to = self.steps.dropped[start..].iter().find(|d| d.0 == to).map_or(to, |d| d.1);
            self.steps.dropped.push((from, to));
        }
        self.steps.dropped[start..].sort_unstable();
    }

    fn find_obstacles(&self) -> Vec<Option<Obstacle>> {
        let mut spokes = Vec::new();
        let mut obstacle_at = |p: u32| {
            if self.topology.valence(p) == 0 {
                return None;
            }
            if !self.rules.may_move(self.topology, p) {
                return Some(Obstacle::Fixed);
            }
            self.topology.spokes(p, &mut spokes);
            let found = spokes.iter().filter_map(|s| self.rules.check(self.topology, p, &spokes, s).err());
            Some(found.max().unwrap_or(Obstacle::Fixed))
        };
        (0..self.stamps.len() as u32).map(&mut obstacle_at).collect()
    }
}

fn count_blocked(obstacles: &[Option<Obstacle>]) -> Blocked {
    let count = |obstacle| obstacles.iter().filter(|&&found| found == Some(obstacle)).count() as u32;
    Blocked {
        fixed: count(Obstacle::Fixed),
        seam: count(Obstacle::Seam),
        topology: count(Obstacle::Topology),
        flip: count(Obstacle::Flip),
    }
}

fn image_of(images: &[(u32, u32)], variant: u32) -> u32 {
    images.iter().find(|&&(from, _)| from == variant).expect("every variant of the position was mapped").1
}
