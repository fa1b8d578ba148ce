//! The coarsest level of an order that stays within a distance: between two quantised ones by bisection, each level measured.

use crate::lod_target::Distance;
use crowd_lod::{Level, SurfaceError};
use std::collections::{BTreeMap, BTreeSet};

/// A level of the order and what was measured of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Its place in the order's levels.
    pub index: usize,
    /// Its error; the bound is at least that of the next finer quantised level.
    pub error: SurfaceError,
}

/// A distance that is kept at one place of the order and not at a coarser one.
struct Bracket {
    distance: Distance,
    limit_m: f32,
    /// The coarsest known to keep it, measured.
    keeps: Found,
    /// Not kept there.
    exceeds: Option<usize>,
    /// The bound of the quantised level on the fine side.
    finer_bound_m: f32,
}

impl Bracket {
    /// The level to look at next; none where nothing lies between.
    fn middle(&self) -> Option<usize> {
        let exceeds = self.exceeds?;
        (self.keeps.index - exceeds > 1).then(|| exceeds + (self.keeps.index - exceeds) / 2)
    }

    fn look(&mut self, index: usize, mut error: SurfaceError) {
        error.bound_m = error.bound_m.max(self.finer_bound_m);
        if self.distance.of(&error) <= self.limit_m {
            self.keeps = Found { index, error };
        } else {
            self.exceeds = Some(index);
        }
    }
}

/// For each limit the coarsest level found that keeps it.
///
/// `quantized`: places of the quantised levels in `levels`, coarsest first, full detail last, which keeps every limit. `errors`: theirs.
/// Among these the finest run that keeps a limit counts; between its coarsest level and the next, levels are measured half way
/// until two neighbours are left. `measure` gets levels of the order. Distances need not rise with every collapse: a coarser level that happens to keep a
/// limit may be passed over, but one that does not keep it is never given.
pub fn search_levels(
    levels: &[Level],
    quantized: &[usize],
    errors: &[SurfaceError],
    limits: &[(Distance, f32)],
    measure: impl Fn(&[Level]) -> Vec<SurfaceError>,
) -> Vec<Found> {
    let mut brackets: Vec<Bracket> = limits
        .iter()
        .map(|&(distance, limit_m)| {
            let keeping = errors.iter().rev().take_while(|error| distance.of(error) <= limit_m).count().max(1);
            let first = quantized.len() - keeping;
            Bracket {
                distance,
                limit_m,
                keeps: Found { index: quantized[first], error: errors[first] },
                exceeds: first.checked_sub(1).map(|coarser| quantized[coarser]),
                finer_bound_m: errors[first].bound_m,
            }
        })
        .collect();
    let mut known: BTreeMap<usize, SurfaceError> = BTreeMap::new();
    loop {
        let wanted: BTreeSet<usize> = brackets.iter().filter_map(Bracket::middle).collect();
        if wanted.is_empty() {
            return brackets.into_iter().map(|bracket| bracket.keeps).collect();
        }
        let new: Vec<usize> = wanted.into_iter().filter(|index| !known.contains_key(index)).collect();
        let new_levels: Vec<Level> = new.iter().map(|&index| levels[index]).collect();
        known.extend(new.into_iter().zip(measure(&new_levels)));
        for bracket in &mut brackets {
            if let Some(index) = bracket.middle() {
                bracket.look(index, known[&index]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels() -> Vec<Level> {
        (0..1000).map(|i| Level { vertex_count: i + 3, triangle_count: i + 1, error_m: 0.0 }).collect()
    }

    /// A level of the order is as far off as triangles are gone; the bound is twice that.
    fn error(level: &Level) -> SurfaceError {
        let rms_m = (1000 - level.triangle_count) as f32 * 1.0e-3;
        SurfaceError { rms_m, max_m: rms_m * 1.5, bound_m: rms_m * 2.0, ..SurfaceError::default() }
    }

    fn found(limits: &[(Distance, f32)]) -> Vec<u32> {
        let levels = levels();
        let quantized = [0, 100, 400, 900, 999];
        let errors = quantized.map(|index: usize| error(&levels[index]));
        let measure = |asked: &[Level]| asked.iter().map(error).collect();
        let found = search_levels(&levels, &quantized, &errors, limits, measure);
        found.iter().map(|found| levels[found.index].triangle_count).collect()
    }

    #[test]
    fn the_coarsest_within_is_found_between_quantised_levels() {
        let (rms, most) = (Distance::Rms, Distance::EveryPoint);
        let limits = [(rms, 0.0505), (most, 0.0505), (rms, 0.3005), (rms, 5.0), (most, 0.0001), (rms, 0.9505)];
        assert_eq!(found(&limits), [950, 975, 700, 1, 1000, 50]);
    }

    #[test]
    fn a_level_is_measured_once_for_all_limits() {
        let levels = levels();
        let quantized = [0, 999];
        let errors = quantized.map(|index: usize| error(&levels[index]));
        let measured = std::cell::RefCell::new(Vec::new());
        let measure = |asked: &[Level]| {
            measured.borrow_mut().extend(asked.iter().map(|level| level.triangle_count));
            asked.iter().map(error).collect()
        };
        let limits = [(Distance::Rms, 0.3005), (Distance::Rms, 0.3015), (Distance::EveryPoint, 0.601)];
        search_levels(&levels, &quantized, &errors, &limits, measure);
        let mut measured = measured.into_inner();
        let count = measured.len();
        measured.sort_unstable();
        measured.dedup();
        assert_eq!(measured.len(), count);
        assert!(count < 20, "{count}");
    }

    #[test]
    fn a_finer_quantised_level_that_exceeds_ends_the_search() {
        let levels = levels();
        let quantized = [0, 500, 800, 999];
        // The level of 800 is worse than that of 500.
        let mut errors = quantized.map(|index: usize| error(&levels[index]));
        errors[2].rms_m = 0.9;
        let measure = |asked: &[Level]| asked.iter().map(error).collect();
        let found = search_levels(&levels, &quantized, &errors, &[(Distance::Rms, 0.6)], measure)[0];
        assert!(found.index > 800 && found.error.rms_m <= 0.6, "{found:?}");
    }
}
