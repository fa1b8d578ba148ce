//! What index tables make possible: one bucket for each quantised level of each character, all drawn from two index buffers.

use crate::dispatch::{
    DOT_LEVELS, DOT_VERTICES, ERROR_ENTRIES, ERROR_FIRST_BITS, ERROR_SHIFT, IMPOSTOR_TRIANGLES, IMPOSTOR_VERTICES,
};
use crate::dots::{DOT_COUNTS, dots_are_coarser};
use crate::impostors::fade_level;
use crate::points::{MOST_POINTS, POINT_COUNTS};
use crate::{BucketCounts, BucketRecord, BucketSet, CrowdData, DiscreteConfig, Error, PointRecord, Result};
use crowd_pack::{CharacterRecord, LevelRecord, LodRecord, NONE};
use glam::Vec3;

/// Bytes of palettes at a time, whatever a device binds: a quarter of a million people of 44 joints seen as meshes.
pub const MOST_PALETTE_BYTES: u64 = 512 << 20;

/// Buckets of a crowd's characters: first all with 16-bit indices, character after character from coarse to fine, then those
/// with 32-bit indices, then five levels of dots a character (see `dots.rs`), or four of points (see `points.rs`), also with
/// 32-bit indices; and last, where the crowd has them, each character's impostor, and each character's coarsest mesh with its impostor.
///
/// Only quantised levels have buckets; levels that someone asked for by name are for other programs. Each triangle begins at
/// its least index, as in [`crate::cpu::reform_level`], so that both ways rasterise the very same triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Buckets {
    /// One a character.
    pub sets: Vec<BucketSet>,
    /// One a bucket.
    pub records: Vec<BucketRecord>,
    /// How many of them have 16-bit indices.
    pub count_16: u32,
    /// How many of them are meshes.
    pub mesh_count: u32,
    /// The first impostor; all where there are none.
    pub first_impostor: u32,
    /// The first of impostors with the coarsest mesh.
    pub first_fade: u32,
    /// Rows of the largest palette, three a joint.
    pub palette_rows: u32,
    /// Palettes there is room for, see [`Self::with_palettes_in`].
    pub palette_slots: u32,
    /// Of each: no point of the level or of full detail is farther from the other, metres.
    pub bounds_m: Vec<f32>,
    /// Indices of the former.
    pub indices_16: Vec<u16>,
    /// Indices of the latter.
    pub indices_32: Vec<u32>,
}

impl Buckets {
    /// From the level tables.
    ///
    /// # Errors
    /// [`Error::Tables`] when a character has no levels with index tables, or tables that are not in the data.
    pub fn of(data: &CrowdData) -> Result<Self> {
        let mut buckets = Self::of_meshes(data)?;
        data.characters.iter().for_each(|character| buckets.add_dots(character));
        buckets.end_stand_ins();
        if data.impostors.is_some() {
            buckets.add_impostors(&data.characters);
        }
        Ok(buckets)
    }

    /// The same with levels of points in the place of those of dots: for each character that has points, of as many as
    /// [`POINT_COUNTS`] says. `points`: of [`crate::surface_points`].
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn with_points(data: &CrowdData, points: &[Option<Vec<PointRecord>>]) -> Result<Self> {
        let mut buckets = Self::of_meshes(data)?;
        buckets.add_points(&data.characters, points);
        buckets.end_stand_ins();
        Ok(buckets)
    }

    fn of_meshes(data: &CrowdData) -> Result<Self> {
        let joints = data.characters.iter().map(|character| character.joint_count).max();
        let palette_rows = joints.unwrap_or(0).max(1) * 3;
        let mut buckets = Self { palette_rows, palette_slots: u32::MAX / palette_rows, ..Self::default() };
        let mut wide = (Vec::new(), Vec::new());
        for character in 0..data.characters.len() {
            let levels = quantized(data, character).ok_or(Error::Tables { character })?;
            let narrow = levels.iter().take_while(|level| level.index_bytes == 2).count();
            buckets.sets.push(BucketSet {
                first_16: buckets.records.len() as u32,
                count_16: narrow as u32,
                first_32: wide.0.len() as u32,
                level_count: levels.len() as u32,
            });
            for (number, level) in levels.iter().enumerate() {
                let coarser_vertex_count = levels[number.saturating_sub(1)].vertex_count;
                let record =
                    buckets.add_table(data, level, coarser_vertex_count, data.characters[character].vertex_offset);
                let record = record.ok_or(Error::Tables { character })?;
                let list = if number < narrow {
                    (&mut buckets.records, &mut buckets.bounds_m)
                } else {
                    (&mut wide.0, &mut wide.1)
                };
                list.0.push(record);
                list.1.push(level.bound_m);
            }
        }
        buckets.count_16 = buckets.records.len() as u32;
        for set in &mut buckets.sets {
            set.first_32 += buckets.count_16;
        }
        buckets.records.extend(wide.0);
        buckets.bounds_m.extend(wide.1);
        buckets.mesh_count = buckets.records.len() as u32;
        Ok(buckets)
    }

    /// Levels of dots; those that are finer than the coarsest mesh stay empty.
    fn add_dots(&mut self, character: &CharacterRecord) {
        let mut first_dot = (self.records.len() as u32 - self.mesh_count) / DOT_LEVELS * DOT_COUNTS.iter().sum::<u32>();
        for dots in DOT_COUNTS {
            let first_index = self.indices_32.len() as u32;
            let is_coarser = dots_are_coarser(character, dots);
            let corners = if is_coarser { dots * DOT_VERTICES } else { 0 };
            self.indices_32.extend((0..corners).map(|corner| first_dot * DOT_VERTICES + corner));
            first_dot += dots;
            let (vertex_count, triangle_count) = (corners, corners / DOT_VERTICES);
            let index_count = corners;
            self.records.push(BucketRecord {
                vertex_count,
                triangle_count,
                first_index,
                index_count,
                ..BucketRecord::default()
            });
        }
    }

    /// No impostors so far.
    fn end_stand_ins(&mut self) {
        self.first_impostor = self.records.len() as u32;
        self.first_fade = self.first_impostor;
    }

    /// Impostors, then coarsest meshes with their impostors, from the vertices of [`crate::Impostors::vertices`]; those of characters that have
    /// no more vertices than an impostor stay empty.
    fn add_impostors(&mut self, characters: &[CharacterRecord]) {
        let quad = self.indices_32.len() as u32;
        self.indices_32.extend([0, 1, 2, 0, 2, 3]);
        let mut both = Vec::new();
        let mut vertex_offset = 0;
        for (number, character) in (0..).zip(characters) {
            let stands_in = character.min_vertex_count > IMPOSTOR_VERTICES;
            let first_index = self.indices_32.len() as u32;
            let mesh = self.triangles(self.at(number, 0));
            let mesh = mesh.into_iter().flatten().map(|corner| IMPOSTOR_VERTICES + corner).filter(|_| stands_in);
            self.indices_32.extend(mesh.collect::<Vec<_>>());
            self.indices_32.extend(if stands_in { &[0, 1, 2, 0, 2, 3][..] } else { &[] });
            let record = |first_index: u32, LodRecord { vertex_count, triangle_count }: LodRecord| BucketRecord {
                vertex_count,
                triangle_count,
                first_index,
                index_count: triangle_count * 3,
                vertex_offset,
                ..BucketRecord::default()
            };
            let alone = LodRecord { vertex_count: IMPOSTOR_VERTICES, triangle_count: IMPOSTOR_TRIANGLES };
            let [alone, faded] = if stands_in { [alone, fade_level(character)] } else { [LodRecord::default(); 2] };
            self.records.push(record(quad, alone));
            both.push(record(first_index, faded));
            vertex_offset += IMPOSTOR_VERTICES + character.min_vertex_count;
        }
        self.first_fade = self.records.len() as u32;
        self.records.extend(both);
    }

    /// Levels of points, which share one run of indices; those that are finer than full detail stay empty.
    fn add_points(&mut self, characters: &[CharacterRecord], points: &[Option<Vec<PointRecord>>]) {
        let first_index = self.indices_32.len() as u32;
        self.indices_32.extend(0..MOST_POINTS);
        for (number, (character, points)) in (0..).zip(characters.iter().zip(points)) {
            for count in POINT_COUNTS {
                let is_coarser = points.is_some() && count < character.vertex_count;
                let count = if is_coarser { count } else { 0 };
                self.records.push(BucketRecord {
                    vertex_count: count,
                    index_count: count,
                    first_index,
                    vertex_offset: number * MOST_POINTS,
                    ..BucketRecord::default()
                });
            }
        }
    }

    fn add_table(
        &mut self,
        data: &CrowdData,
        level: &LevelRecord,
        coarser_vertex_count: u32,
        vertex_offset: u32,
    ) -> Option<BucketRecord> {
        let first = level.index_offset as usize;
        let range = first..first.checked_add(level.triangle_count as usize * 3)?;
        let first_index = if level.index_bytes == 2 { self.indices_16.len() } else { self.indices_32.len() } as u32;
        if level.index_bytes == 2 {
            let (triangles, _) = data.indices_16.get(range)?.as_chunks::<3>();
            self.indices_16.extend(triangles.iter().copied().flat_map(from_least));
        } else {
            let (triangles, _) = data.indices_32.get(range)?.as_chunks::<3>();
            self.indices_32.extend(triangles.iter().copied().flat_map(from_least));
        }
        let (vertex_count, triangle_count) = (level.vertex_count, level.triangle_count);
        let index_count = triangle_count * 3;
        Some(BucketRecord {
            vertex_count,
            triangle_count,
            first_index,
            coarser_vertex_count,
            vertex_offset,
            index_count,
        })
    }

    /// For the shaders.
    pub fn counts(&self) -> BucketCounts {
        BucketCounts {
            bucket_count: self.records.len() as u32,
            count_16: self.count_16,
            mesh_count: self.mesh_count,
            palette_rows: self.palette_rows,
            first_impostor: self.first_impostor,
            first_fade: self.first_fade,
            palette_slots: self.palette_slots,
            reserved: 0,
        }
    }

    /// The same with palettes for as many at a time as that many bytes hold, `MOST_PALETTE_BYTES` at most.
    pub fn with_palettes_in(self, bytes: u64) -> Self {
        let palette_bytes = u64::from(self.palette_rows) * std::mem::size_of::<[f32; 4]>() as u64;
        let slots = bytes.min(MOST_PALETTE_BYTES) / palette_bytes;
        Self { palette_slots: u32::try_from(slots).unwrap_or(u32::MAX).min(self.palette_slots), ..self }
    }

    /// The first row of the palette in that slot; [`NONE`] where there are fewer. Twin: `palette_row` in `shaders/shared/place.wgsl`.
    pub fn palette_row(&self, slot: u32) -> u32 {
        if slot < self.palette_slots { slot * self.palette_rows } else { NONE }
    }

    /// The key of an instance that is in no bucket: one past the last.
    pub fn nobody(&self) -> u32 {
        self.records.len() as u32
    }

    /// Bucket of a character's quantised level, 0 the coarsest.
    pub fn at(&self, character: u32, level: u32) -> u32 {
        let set = &self.sets[character as usize];
        if level < set.count_16 { set.first_16 + level } else { set.first_32 + level - set.count_16 }
    }

    /// Bucket of a character's impostor, alone or with the coarsest mesh, where the crowd has impostors.
    pub fn impostor(&self, character: u32, fades: bool) -> u32 {
        character + if fades { self.first_fade } else { self.first_impostor }
    }

    /// Bucket of the finest level of at most that many vertices, dots included, or of the coarsest.
    pub fn fitting(&self, character: u32, vertex_count: u32) -> u32 {
        if vertex_count < self.records[self.at(character, 0) as usize].vertex_count && vertex_count >= DOT_VERTICES {
            return self.mesh_count + character * DOT_LEVELS + (vertex_count / DOT_VERTICES).ilog2();
        }
        self.at(character, self.level_of(character, vertex_count))
    }

    /// The finest of a character's levels of at most that many vertices; 0, the coarsest, where all have more.
    ///
    /// Twin: `shaders/shared/levels.wgsl`.
    pub fn level_of(&self, character: u32, vertex_count: u32) -> u32 {
        let levels = self.sets[character as usize].level_count;
        let finer =
            (1..levels).take_while(|l| self.records[self.at(character, *l) as usize].vertex_count <= vertex_count);
        finer.last().unwrap_or(0)
    }

    /// Bucket of the next finer level of a character, if there is one.
    pub fn finer(&self, character: u32, bucket: u32) -> Option<u32> {
        let mut levels = 0..self.sets[character as usize].level_count;
        let level = levels.find(|level| self.at(character, *level) == bucket)?;
        (level + 1 < levels.end).then(|| self.at(character, level + 1))
    }

    /// A bucket's triangles, indices local to the character.
    pub fn triangles(&self, bucket: u32) -> Vec<[u32; 3]> {
        let record = &self.records[bucket as usize];
        let range = record.first_index as usize..(record.first_index + record.triangle_count * 3) as usize;
        if bucket < self.count_16 {
            self.indices_16[range].as_chunks::<3>().0.iter().map(|t| t.map(u32::from)).collect()
        } else {
            self.indices_32[range].as_chunks::<3>().0.to_vec()
        }
    }

    /// The coarsest level for an error, [`ERROR_ENTRIES`] entries a character: entry e is for one over the metres allowed from
    /// `2^(e / 32 - 16)` on, up to the next entry's, for which its bound holds. The first entry is the coarsest level whatever
    /// its bound, the last full detail.
    pub fn error_lods(&self) -> Vec<LodRecord> {
        let end_of = |entry: u32| f32::from_bits(ERROR_FIRST_BITS + ((entry + 1) << ERROR_SHIFT));
        let mut lods = Vec::new();
        for (character, set) in self.sets.iter().enumerate() {
            let at = |level: u32| self.at(character as u32, level) as usize;
            let mut level = 0;
            for entry in 0..ERROR_ENTRIES {
                let is_good = |level: u32| entry == 0 || self.bounds_m[at(level)] * end_of(entry) <= 1.0;
                while level + 1 < set.level_count && (!is_good(level) || entry + 1 == ERROR_ENTRIES) {
                    level += 1;
                }
                let BucketRecord { vertex_count, triangle_count, .. } = self.records[at(level)];
                lods.push(LodRecord { vertex_count, triangle_count });
            }
        }
        lods
    }

    /// LOD tables like those of the data, of quantised levels and dots: entry k is the finest of at most k vertices, or one dot.
    /// Below the coarsest mesh nobody looks who may not be dots ([`crate::cpu::fill_budget`], [`crate::cpu::fit_budget`]).
    pub fn quantized_lods(&self, data: &CrowdData) -> Vec<LodRecord> {
        let mut lods = data.lods.clone();
        for (number, character) in data.characters.iter().enumerate() {
            let level = |l: u32| self.records[self.at(number as u32, l) as usize];
            let mut current = 0;
            for k in 0..=character.vertex_count {
                while current + 1 < self.sets[number].level_count && level(current + 1).vertex_count <= k {
                    current += 1;
                }
                let BucketRecord { vertex_count, triangle_count, .. } = level(current);
                lods[(character.lod_offset + k) as usize] = LodRecord { vertex_count, triangle_count };
            }
            for dots in DOT_COUNTS.into_iter().filter(|dots| dots_are_coarser(character, *dots)) {
                let lod = LodRecord { vertex_count: dots * DOT_VERTICES, triangle_count: dots };
                let first = if dots == 1 { 0 } else { dots * DOT_VERTICES };
                lods[(character.lod_offset + first) as usize
                    ..(character.lod_offset + character.min_vertex_count) as usize]
                    .fill(lod);
            }
        }
        lods
    }
}

/// Shares of full detail's triangles that [`crate::Technique::Discrete`] draws.
pub const DISCRETE_SHARES: [f32; 3] = [1.0, 0.3, 0.1];

impl Buckets {
    /// Buckets of each character's three discrete levels, the finest first: the quantised levels whose triangles are nearest
    /// to [`DISCRETE_SHARES`].
    pub fn discrete_levels(&self) -> Vec<u32> {
        let nearest = |character: u32, share: f32| {
            let levels = 0..self.sets[character as usize].level_count;
            let count = |bucket: u32| self.records[bucket as usize].triangle_count as f32;
            let wanted = share * count(self.at(character, levels.end - 1));
            let buckets = levels.map(|level| self.at(character, level));
            let off = |bucket: &u32| (count(*bucket) - wanted).abs();
            buckets.min_by(|a, b| off(a).total_cmp(&off(b))).expect("every character has a level")
        };
        let characters = 0..self.sets.len() as u32;
        characters.flat_map(|c| DISCRETE_SHARES.map(|share| nearest(c, share))).collect()
    }
}

/// What culling by depth is told of the characters.
pub fn discrete_config(characters: &[CharacterRecord]) -> DiscreteConfig {
    let diagonal = |c: &CharacterRecord| (Vec3::from_array(c.box_max) - Vec3::from_array(c.box_min)).length();
    let half_diagonal_m = 0.5 * characters.iter().map(diagonal).fold(0.0, f32::max);
    DiscreteConfig { half_diagonal_m, ..Default::default() }
}

/// The quantised levels of a character, if there are any and their ends are the character's.
fn quantized(data: &CrowdData, character: usize) -> Option<&[LevelRecord]> {
    let set = data.level_sets.get(character)?;
    let first = set.level_offset as usize;
    let levels = data.levels.get(first..first.checked_add(set.quantized_count as usize)?)?;
    let CharacterRecord { vertex_count, min_vertex_count, .. } = data.characters[character];
    let ends = levels.first()?.vertex_count == min_vertex_count && levels.last()?.vertex_count == vertex_count;
    let narrow_first = levels.is_sorted_by_key(|level| level.index_bytes);
    (ends && narrow_first).then_some(levels)
}

/// The same triangle, turned so that its least index comes first.
pub(crate) fn from_least<T: Ord + Copy>([a, b, c]: [T; 3]) -> [T; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::LevelSetRecord;

    /// Two characters of 5 and 4 vertices; the first one's finest level has wide indices.
    fn data() -> CrowdData {
        let character = |lod_offset, vertex_count| CharacterRecord {
            lod_offset,
            vertex_count,
            min_vertex_count: 3,
            ..Default::default()
        };
        let level = |vertex_count, triangle_count, index_offset, index_bytes| LevelRecord {
            vertex_count,
            triangle_count,
            index_offset,
            index_bytes,
            refit_vertex_offset: crowd_pack::NONE,
            bound_m: 0.0,
        };
        CrowdData {
            characters: vec![character(0, 5), character(6, 4)],
            lods: vec![LodRecord::default(); 11],
            level_sets: vec![
                LevelSetRecord { level_offset: 0, quantized_count: 2, ..Default::default() },
                LevelSetRecord { level_offset: 2, quantized_count: 2, ..Default::default() },
            ],
            levels: vec![level(3, 1, 0, 2), level(5, 2, 0, 4), level(3, 1, 3, 2), level(4, 2, 6, 2)],
            indices_16: vec![2, 0, 1, 0, 1, 2, 3, 2, 1, 0, 2, 3],
            indices_32: vec![4, 3, 2, 0, 1, 4],
            ..Default::default()
        }
    }

    #[test]
    fn narrow_tables_come_first_and_triangles_begin_at_their_least_index() {
        let buckets = Buckets::of(&data()).expect("both characters have tables");
        assert_eq!((buckets.count_16, buckets.mesh_count, buckets.nobody()), (3, 4, 14));
        assert_eq!([buckets.at(0, 0), buckets.at(0, 1), buckets.at(1, 0), buckets.at(1, 1)], [0, 3, 1, 2]);
        assert_eq!(buckets.triangles(0), [[0, 1, 2]]);
        assert_eq!(buckets.triangles(3), [[2, 4, 3], [0, 1, 4]]);
        assert_eq!(buckets.triangles(2), [[1, 3, 2], [0, 2, 3]]);
        assert_eq!(buckets.records[3].coarser_vertex_count, 3);
    }

    #[test]
    fn counts_between_levels_are_rounded_down() {
        let data = data();
        let buckets = Buckets::of(&data).expect("both characters have tables");
        assert_eq!([0, 3, 4, 5, 9].map(|k| buckets.fitting(0, k)), [0, 0, 0, 3, 3]);
        let lods = buckets.quantized_lods(&data);
        assert_eq!(lods.iter().map(|l| l.vertex_count).collect::<Vec<_>>(), [3, 3, 3, 3, 3, 5, 3, 3, 3, 3, 4]);
    }

    #[test]
    fn impostors_come_last_alone_and_with_the_coarsest_mesh() {
        let mut data = data();
        data.impostors = Some(Default::default());
        data.characters[0].min_vertex_count = 5;
        data.characters[0].min_triangle_count = 2;
        data.level_sets[0] = LevelSetRecord { level_offset: 1, quantized_count: 1, ..Default::default() };
        let buckets = Buckets::of(&data).expect("both characters have tables");
        let counts = buckets.counts();
        assert_eq!((counts.mesh_count, counts.first_impostor, counts.first_fade, counts.bucket_count), (3, 13, 15, 17));
        assert_eq!([(0, false), (0, true), (1, true)].map(|(c, fades)| buckets.impostor(c, fades)), [13, 15, 16]);
        assert_eq!(buckets.triangles(13), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(buckets.triangles(15), [[6, 8, 7], [4, 5, 8], [0, 1, 2], [0, 2, 3]]);
        assert_eq!((buckets.records[15].vertex_count, buckets.records[15].vertex_offset), (9, 0));
        // Three vertices are fewer than an impostor has.
        assert_eq!((buckets.records[14].index_count, buckets.records[16].index_count), (0, 0));
        assert_eq!(buckets.records[16].vertex_offset, 9);
    }

    #[test]
    fn a_character_without_tables_is_named() {
        let mut data = data();
        data.level_sets[1].quantized_count = 0;
        assert!(Buckets::of(&data).expect_err("no levels").to_string().contains("character 1"));
        data.level_sets.pop();
        assert!(Buckets::of(&data).is_err());
    }
}
