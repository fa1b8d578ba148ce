//! How far points lay at the level before: where neither the point nor what was closest to it has changed, that still holds.

use crate::measure::Sample;

/// Points of full detail that a level lacks: corners and middles of triangles.
pub(super) const CORNERS: Slots =
    Slots { weights: [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0; 2]], on_level: false };
/// Points of a level: middles of edges and of triangles.
pub(super) const EDGES: Slots = Slots { weights: [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0], [1.0 / 3.0; 2]], on_level: true };
/// Of a point that is not remembered.
pub(super) const NO_PLACE: u32 = u32::MAX;

/// Where nothing is known. Levels count from 1.
const NO_LEVEL: u32 = u32::MAX;

/// Points on a triangle that are remembered.
#[derive(Debug)]
pub(super) struct Slots {
    weights: [[f32; 2]; SLOTS],
    /// Whether they lie on the level; else it is what they are measured against.
    on_level: bool,
}

const SLOTS: usize = 4;

impl Slots {
    /// Where a point is remembered. `places`: an order of the triangles, in which neighbours share memory.
    pub fn place(&self, sample: &Sample, places: &[u32]) -> u32 {
        match self.weights.iter().position(|weights| *weights == sample.weights) {
            Some(slot) => {
                places.get(sample.triangle as usize).map_or(NO_PLACE, |place| place * SLOTS as u32 + slot as u32)
            }
            None => NO_PLACE,
        }
    }
}

/// A triangle of the other mesh, and a squared distance that the point does not exceed in any frame of a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    pub triangle: u32,
    pub bound: f32,
    /// The level at which this held last.
    level: u32,
}

/// Bytes that what is known of one side may take in all batches; of more points nothing is remembered, which costs time alone.
const MOST_BYTES: usize = 256 << 20;

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
    /// `triangles`: as many as have places; 0 where no level follows that could ask.
    pub fn of_batch<'m>(&'m mut self, batch: usize, same: &'m [bool], slots: &Slots, triangles: usize) -> Memory<'m> {
        if self.batches.len() <= batch {
            let none = Known { triangle: 0, bound: f32::INFINITY, level: NO_LEVEL };
            let points = triangles * SLOTS;
            let fits = (batch + 1) * points * size_of::<Known>() <= MOST_BYTES;
            self.batches.resize_with(batch + 1, || vec![none; if fits { points } else { 0 }]);
        }
        Memory { known: &mut self.batches[batch], same, on_level: slots.on_level, level: self.level }
    }
}

/// What is known of the points of one side in the frames of a batch.
pub(super) struct Memory<'m> {
    known: &'m mut [Known],
    same: &'m [bool],
    on_level: bool,
    level: u32,
}

impl Memory<'_> {
    /// What is known of a point of a triangle and holds still; it then does at this level too.
    pub fn recall(&mut self, place: u32, triangle: u32) -> Option<Known> {
        let known = self.known.get_mut(place as usize)?;
        let changeable = if self.on_level { triangle } else { known.triangle };
        if known.level != self.level - 1 || !self.same.get(changeable as usize).copied().unwrap_or(false) {
            return None;
        }
        known.level = self.level;
        Some(*known)
    }

    /// Notes what is true of a point at this level.
    pub fn note(&mut self, place: u32, triangle: u32, bound: f32) {
        if let Some(known) = self.known.get_mut(place as usize) {
            *known = Known { triangle, bound, level: self.level };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_holds_while_nothing_changes_and_no_longer() {
        let places = [1, 2, 0];
        for slots in [CORNERS, EDGES] {
            let place = |triangle| slots.place(&Sample { triangle, weights: [1.0 / 3.0; 2] }, &places);
            assert_eq!([0, 1].map(place), [7, 11]);
            assert_eq!(slots.place(&Sample { triangle: 0, weights: [0.2, 0.3] }, &places), NO_PLACE);
            let mut all = Remembered::default();
            let mut at_level = |same: &[bool], noted: Option<u32>| {
                all.next_level();
                let mut memory = all.of_batch(0, same, &slots, 3);
                let known = [0, 1].map(|t| memory.recall(place(t), t).map(|known| known.bound));
                memory.note(NO_PLACE, 0, 9.0);
                assert!(memory.recall(NO_PLACE, 0).is_none());
                noted.into_iter().for_each(|t| memory.note(place(t), t, 0.5));
                known
            };
            assert_eq!(at_level(&[true; 3], Some(1)), [None, None]);
            assert_eq!(at_level(&[true; 3], None), [None, Some(0.5)]);
            assert_eq!(at_level(&[true; 3], None), [None, Some(0.5)], "it holds from level to level");
            assert_eq!(at_level(&[true, false, true], Some(0)), [None, None]);
            assert_eq!(at_level(&[true; 3], None), [Some(0.5), None], "nor once it is as before again");
            assert_eq!(at_level(&[], None), [None, None], "a level of its own");
            assert_eq!(at_level(&[true; 3], Some(1)), [None, None]);
            assert_eq!(at_level(&[true], None), [None, None]);
        }
    }
}
