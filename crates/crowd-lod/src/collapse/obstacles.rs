//! What holds the positions that are left.

use super::{Run, Scratch};
use crate::{Blocked, Obstacle};

impl Run<'_> {
    /// What holds each position that is left; nothing where no triangle is left.
    pub(super) fn find_obstacles(&self) -> Vec<Option<Obstacle>> {
        let mut scratch = Scratch::default();
        let mut obstacle_at = |p: u32| {
            let topology = &self.surface.topology;
            if topology.valence(p) == 0 {
                return None;
            }
            if !self.rules.may_move(topology, p) {
                return Some(Obstacle::Fixed);
            }
            let Scratch { fan, spokes, on_edge, moved, .. } = &mut scratch;
            fan.gather(topology, p);
            self.measure(fan);
            fan.spokes(spokes);
            let found = spokes.iter().filter_map(|s| {
                fan.find_on_edge(s.to, on_edge);
                self.find_images(fan, s.to, moved);
                match self.allow(fan, spokes, s, on_edge, moved) {
                    Ok(_) => self.has_ended().then_some(Obstacle::Ended),
                    Err(obstacle) => Some(obstacle),
                }
            });
            Some(found.max().unwrap_or(Obstacle::Fixed))
        };
        (0..self.stamps.len() as u32).map(&mut obstacle_at).collect()
    }
}

/// How many positions each obstacle holds.
pub(super) fn count_blocked(obstacles: &[Option<Obstacle>]) -> Blocked {
    let count = |obstacle| obstacles.iter().filter(|&&found| found == Some(obstacle)).count() as u32;
    Blocked {
        fixed: count(Obstacle::Fixed),
        seam: count(Obstacle::Seam),
        topology: count(Obstacle::Topology),
        flip: count(Obstacle::Flip),
        ended: count(Obstacle::Ended),
    }
}
