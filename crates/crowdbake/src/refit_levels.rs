//! Refitted levels: moved, rounded as a pack stores them, and measured. For a distance, coarser ones than without refitting are tried.

use crate::bake_levels::{BakedLevel, cache_order};
use crate::lod_target::Distance;
use crate::measure_levels::{LevelError, LevelShape};
use crate::ordered_mesh::{DecodedVertices, OrderedMesh};
use crowd_lod::{Level, LodPoses, RefitOptions, SurfaceError, refit};
use crowd_pack::VertexRecord;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Share of a level's bound below which no refit brings the largest distance.
const MISSED_SHARE: f32 = 0.1;
/// Levels refitted for one distance, beside the one that keeps it without: each takes seconds on a large character.
const STEPS: usize = 3;

/// A level of the order and what was measured of it before the refit.
pub(crate) type Before = (Level, SurfaceError);

/// Refits levels of one character.
pub(crate) struct Refitting<'a> {
    pub mesh: &'a OrderedMesh,
    pub poses: &'a LodPoses<'a>,
    pub measure: &'a dyn Fn(&[LevelShape]) -> Vec<SurfaceError>,
    pub poke: &'a dyn Fn(&[LevelShape]) -> Vec<f32>,
}

impl Refitting<'_> {
    /// Refits, rounds to what the pack stores, and measures that: in the order of the table, which is all that a pack keeps.
    /// Layers are known by the order's sequence.
    pub fn refit(&self, levels: &[Before]) -> Vec<BakedLevel> {
        let lod_mesh = self.mesh.mesh();
        let refitted: Vec<(Vec<VertexRecord>, Vec<[u32; 3]>, Vec<u32>)> =
            levels.par_iter().map(|(level, _)| Self::refit_one(self.mesh, &lod_mesh, self.poses, level)).collect();
        let vertices = |records: &[VertexRecord]| DecodedVertices::new(records);
        let in_order: Vec<LevelShape> = refitted
            .iter()
            .map(|(records, triangles, _)| LevelShape::Own(vertices(records), triangles.clone()))
            .collect();
        let as_drawn: Vec<LevelShape> = refitted
            .iter()
            .map(|(records, _, table)| LevelShape::Own(vertices(records), table.as_chunks::<3>().0.to_vec()))
            .collect();
        let (errors, poked) = ((self.measure)(&as_drawn), (self.poke)(&in_order));
        let mut baked = Vec::new();
        for (((records, _, indices), (_, before)), (mut surface, poked_share)) in
            refitted.into_iter().zip(levels).zip(errors.into_iter().zip(poked))
        {
            // Moving vertices mends a good part of the largest distance, but not all of it: then it was missed, on a fold as
            // narrow as a triangle.
            if surface.max_m < MISSED_SHARE * before.bound_m {
                surface.bound_m = surface.bound_m.max(before.bound_m);
            }
            let error = LevelError { surface, poked_share };
            baked.push(BakedLevel { vertex_count: records.len() as u32, indices, own: Some(records), error });
        }
        baked
    }

    fn refit_one(
        mesh: &OrderedMesh,
        lod_mesh: &crowd_lod::LodMesh<'_>,
        poses: &LodPoses<'_>,
        level: &Level,
    ) -> (Vec<VertexRecord>, Vec<[u32; 3]>, Vec<u32>) {
        let refitted = refit(lod_mesh, poses, &mesh.order, level, &RefitOptions::default());
        let records = mesh.refit_records(&refitted);
        let table = cache_order(&refitted.triangles, records.len() as u32);
        (records, refitted.triangles, table)
    }

    /// For each limit a coarser level that keeps it once it is refitted, if one is found among the quantised ones: the errors of levels
    /// are taken to shrink by one factor, which says where to look next. `refitted`: those that keep the limits without, refitted.
    /// `quantized`: coarsest first.
    pub fn coarser(
        &self,
        quantized: &[Before],
        limits: &[(Distance, f32)],
        refitted: &[(Before, &BakedLevel)],
    ) -> Vec<Option<(Before, BakedLevel)>> {
        let mut brackets: Vec<Bracket> = limits
            .iter()
            .zip(refitted)
            .map(|(&limit, (before, after))| Bracket::new(quantized, limit, before, after))
            .collect();
        let mut known: BTreeMap<usize, BakedLevel> = BTreeMap::new();
        for _ in 0..STEPS {
            let mut new: Vec<usize> = brackets.iter().filter_map(|bracket| bracket.next(quantized)).collect();
            new.sort_unstable();
            new.dedup();
            new.retain(|index| !known.contains_key(index));
            let levels: Vec<Before> = new.iter().map(|&index| quantized[index]).collect();
            known.extend(new.into_iter().zip(self.refit(&levels)));
            for bracket in &mut brackets {
                if let Some(index) = bracket.next(quantized) {
                    bracket.look(index, &quantized[index].1, &known[&index].error.surface);
                }
            }
        }
        let found = |bracket: Bracket| Some((quantized[bracket.found?], known[&bracket.found?].clone()));
        brackets.into_iter().map(found).collect()
    }
}

/// Where a limit is kept after the refit, by places among the quantised levels.
struct Bracket {
    distance: Distance,
    limit_m: f32,
    /// Kept from here on.
    keeps: usize,
    /// Not kept below here.
    least: usize,
    /// What the refit makes of an error, as far as is known.
    factor: f32,
    found: Option<usize>,
}

impl Bracket {
    fn new(quantized: &[Before], (distance, limit_m): (Distance, f32), before: &Before, after: &BakedLevel) -> Self {
        let keeps = quantized.partition_point(|(level, _)| level.triangle_count < before.0.triangle_count);
        let mut bracket = Self { distance, limit_m, keeps, least: 0, factor: 1.0, found: None };
        bracket.learn(&before.1, &after.error.surface);
        bracket
    }

    fn learn(&mut self, before: &SurfaceError, after: &SurfaceError) {
        let (before, after) = (self.distance.of(before), self.distance.of(after));
        if before > 0.0 {
            self.factor = after / before;
        }
    }

    /// The coarsest level from which on errors as foretold keep the limit; none where nothing coarser does.
    fn next(&self, quantized: &[Before]) -> Option<usize> {
        let keeps = |(_, error): &&Before| self.distance.of(error) * self.factor <= self.limit_m;
        let run = quantized[self.least..self.keeps].iter().rev().take_while(keeps).count();
        (run > 0).then(|| self.keeps - run)
    }

    fn look(&mut self, index: usize, before: &SurfaceError, after: &SurfaceError) {
        self.learn(before, after);
        if self.distance.of(after) <= self.limit_m && after.rms_m <= before.rms_m {
            (self.keeps, self.found) = (index, Some(index));
        } else {
            self.least = index + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bracket_finds_a_coarser_one_that_keeps_and_never_one_that_does_not() {
        let error = |rms_m: f32| SurfaceError { rms_m, max_m: rms_m, bound_m: rms_m, ..SurfaceError::default() };
        let level = |triangle_count| Level { vertex_count: triangle_count, triangle_count, error_m: 0.0 };
        let quantized: Vec<Before> = (0..10).map(|i| (level(10 * (i + 1)), error((10 - i) as f32))).collect();
        let after = |i: usize, factor: f32| error((10 - i) as f32 * factor);
        let base = BakedLevel { error: LevelError { surface: error(2.0), poked_share: 0.0 }, ..BakedLevel::default() };
        // Without a refit the level of 70 triangles keeps 4; refits halve errors at first, and less from 40 on.
        let mut bracket = Bracket::new(&quantized, (Distance::Rms, 4.0), &quantized[6], &base);
        let (mut looked, mut found) = (Vec::new(), Vec::new());
        while let Some(index) = bracket.next(&quantized) {
            looked.push(index);
            bracket.look(index, &quantized[index].1, &after(index, if index <= 3 { 0.7 } else { 0.5 }));
            found.push(bracket.found);
        }
        // Foretold by half it is 2, then by 0.7 it is 5, then by half again what is left, 3; of 4 nothing good is foretold.
        assert_eq!(looked, [2, 5, 3]);
        assert_eq!(found, [None, Some(5), Some(5)]);
    }
}
