//! Lets a part go with its mirror image: both eyes or none.

use super::{Choice, Run, Scratch};

/// Triangles that a part may have left to go at once when its mirror image is gone.
const MOST_LEFT: u32 = 16;

impl Run<'_> {
    /// Collapses what a part has left, cheapest first, at any price: its mirror image has just vanished, for which both have paid.
    pub(super) fn let_vanish(&mut self, part: u32, scratch: &mut Scratch, ring: &mut Vec<u32>) {
        if self.surface.behind.triangles_of(part).1 > MOST_LEFT {
            return;
        }
        let mut places: Vec<u32> = Vec::new();
        loop {
            let Run { surface, .. } = &*self;
            let topology = &surface.topology;
            let living = surface.behind.triangles_of(part).0.iter().filter(|&&t| topology.alive[t as usize]);
            places.clear();
            places.extend(living.flat_map(|&t| topology.triangle_positions[t as usize]));
            places.sort_unstable();
            places.dedup();
            let mut best: Option<(u32, Choice)> = None;
            for &p in &places {
                let mut known = std::mem::take(&mut self.known_costs[p as usize]);
                let choice = self.choose(p, &mut known, scratch);
                self.known_costs[p as usize] = known;
                if let Some(choice) = choice
                    && best.is_none_or(|(_, found)| choice.rank < found.rank)
                {
                    best = Some((p, choice));
                }
            }
            let Some((u, Choice { rank, target, .. })) = best else { return };
            if !self.still_costs(u, target, true, rank, scratch) {
                return;
            }
            self.collapse_and_look_around(u, target, scratch, ring);
        }
    }
}
