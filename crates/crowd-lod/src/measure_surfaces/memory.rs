//! How far points lay at the level before: where neither the point nor what was closest to it has changed, that still holds.

use crate::measure::Sample;

/// Weights of the points that are remembered, one slot each: corners and middle, and middles of edges and middle.
pub(super) const CORNERS: Slots =
    Slots { weights: [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0; 2]], of_target: true };
pub(super) const EDGES: Slots =
    Slots { weights: [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0], [1.0 / 3.0; 2]], of_target: false };

/// Points on a triangle that are remembered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slots {
    weights: [[f32; 2]; SLOTS],
    /// Whether the level is what they are measured against; else they lie on it.
    of_target: bool,
}

const SLOTS: usize = 4;

/// A triangle of the other mesh, and a squared distance that the point does not exceed in any frame of a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    pub triangle: u32,
    pub bound: f32,
    /// The level at which this held last.
    level: u32,
}

/// What is known of all points of one side.
#[derive(Debug, Default)]
pub(super) struct Remembered {
    batches: Vec<Vec<Known>>,
    level: u32,
}

impl Remembered {
    /// What was known of the level before this one is from here on that of the level before.
    pub fn next_level(&mut self) {
        self.level += 1;
    }

    /// What is known in one batch. `same`: whether a triangle of the level is that of the level before; those beyond are not.
    /// `triangles`: of the mesh that the points lie on. Without `kept` nothing is known or noted.
    pub fn of_batch<'m>(
        &'m mut self,
        batch: usize,
        same: &'m [bool],
        slots: Slots,
        triangles: usize,
        kept: bool,
    ) -> Memory<'m> {
        if self.batches.len() <= batch {
            self.batches.resize_with(batch + 1, Vec::new);
        }
        let known = &mut self.batches[batch];
        if kept && known.len() < triangles * SLOTS {
            known.resize(triangles * SLOTS, Known { triangle: 0, bound: f32::INFINITY, level: 0 });
        }
        Memory { known: if kept { known } else { &mut [] }, same, slots, level: self.level }
    }
}

/// What is known of the points of one side in the frames of a batch.
pub(super) struct Memory<'m> {
    known: &'m mut [Known],
    same: &'m [bool],
    slots: Slots,
    level: u32,
}

impl Memory<'_> {
    /// What is known of a point and holds still; it then does at this level too.
    pub fn recall(&mut self, sample: &Sample) -> Option<Known> {
        let (level, same, of_target) = (self.level, self.same, self.slots.of_target);
        let known = self.place(sample)?;
        let changeable = if of_target { known.triangle } else { sample.triangle };
        if known.level + 1 != level || !same.get(changeable as usize).copied().unwrap_or(false) {
            return None;
        }
        known.level = level;
        Some(*known)
    }

    /// Notes what is true of a point at this level.
    pub fn note(&mut self, sample: &Sample, triangle: u32, bound: f32) {
        let level = self.level;
        if let Some(known) = self.place(sample) {
            *known = Known { triangle, bound, level };
        }
    }

    fn place(&mut self, sample: &Sample) -> Option<&mut Known> {
        if self.known.is_empty() {
            return None;
        }
        let slot = self.slots.weights.iter().position(|weights| *weights == sample.weights)?;
        self.known.get_mut(sample.triangle as usize * SLOTS + slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_holds_while_nothing_changes_and_no_longer() {
        let middle = |triangle| Sample { triangle, weights: [1.0 / 3.0; 2] };
        let elsewhere = Sample { triangle: 0, weights: [0.2, 0.3] };
        for slots in [CORNERS, EDGES] {
            let mut all = Remembered::default();
            let mut at_level = |same: &[bool], kept: bool, noted: Option<u32>| {
                all.next_level();
                let mut memory = all.of_batch(0, same, slots, 3, kept);
                let known = [0, 1].map(|t| memory.recall(&middle(t)).map(|known| known.bound));
                memory.note(&elsewhere, 0, 9.0);
                assert!(memory.recall(&elsewhere).is_none());
                noted.into_iter().for_each(|t| memory.note(&middle(t), t, 0.5));
                known
            };
            assert_eq!(at_level(&[true; 3], true, Some(1)), [None, None]);
            assert_eq!(at_level(&[true; 3], true, None), [None, Some(0.5)]);
            assert_eq!(at_level(&[true; 3], true, None), [None, Some(0.5)], "it holds from level to level");
            assert_eq!(at_level(&[true, false, true], true, Some(0)), [None, None]);
            assert_eq!(at_level(&[true; 3], true, None), [Some(0.5), None], "nor once it is as before again");
            assert_eq!(at_level(&[], false, None), [None, None], "a level of its own");
            assert_eq!(at_level(&[true; 3], true, None), [None, None]);
            assert_eq!(at_level(&[true], true, None), [None, None]);
        }
    }
}
