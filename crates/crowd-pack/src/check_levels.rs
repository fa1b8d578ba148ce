//! Checks the levels with index tables against the characters they belong to: counts, places, widths, every index.

use crate::check_contents::{check_vertex, expect, take};
use crate::layout::refuse_above;
use crate::{CharacterRecord, LevelRecord, LevelSetRecord, LodRecord, NONE, PackContents, Result, limits};

/// Elements of each section that the characters so far account for.
#[derive(Default)]
pub(crate) struct CoveredLevels {
    levels: usize,
    indices_16: usize,
    indices_32: usize,
    refit_vertices: usize,
}

impl CoveredLevels {
    /// Section, elements found, elements accounted for.
    pub(crate) fn pairs(&self, contents: &PackContents) -> [(&'static str, usize, usize); 4] {
        [
            ("levels", contents.levels.len(), self.levels),
            ("indices_16", contents.indices_16.len(), self.indices_16),
            ("indices_32", contents.indices_32.len(), self.indices_32),
            ("refit_vertices", contents.refit_vertices.len(), self.refit_vertices),
        ]
    }
}

/// The levels of one character; its own record and LOD table are checked already.
pub(crate) fn check_level_set(
    contents: &PackContents,
    index: usize,
    lods: &[LodRecord],
    covered: &mut CoveredLevels,
) -> Result<()> {
    let (character, set) = (&contents.characters[index], &contents.level_sets[index]);
    let place = |field: &str| format!("character {index}: {field}");
    refuse_above(&place("quantised levels"), set.quantized_count.into(), limits::QUANTIZED_LEVELS)?;
    refuse_above(&place("discrete levels"), set.discrete_count.into(), limits::DISCRETE_LEVELS)?;
    let found = set.quantized_count;
    expect(found >= 1, || place("quantised levels"), found, || "at least 1".to_owned())?;
    let found = set.refit_vertex_offset;
    let start = covered.refit_vertices;
    expect(found as usize == start, || place("refitted vertices: offset"), found, || start.to_string())?;
    let count = u64::from(set.quantized_count) + u64::from(set.discrete_count);
    let levels =
        take(&mut covered.levels, set.level_offset, count, contents.levels.len(), &|| place("levels with tables"))?;
    let levels = &contents.levels[levels];
    check_quantised(set, levels, character, &place)?;
    for (number, level) in levels.iter().enumerate() {
        let here = |field: &str| place(&format!("level with table {number}: {field}"));
        let may_refit = number >= set.quantized_count as usize;
        check_level(contents, character, level, lods, may_refit, covered, &here)?;
    }
    Ok(())
}

/// The first is the coarsest level, the last full detail, and vertices rise between.
fn check_quantised(
    set: &LevelSetRecord,
    levels: &[LevelRecord],
    character: &CharacterRecord,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    let quantized = &levels[..set.quantized_count as usize];
    let counts = |level: &LevelRecord| (level.vertex_count, level.triangle_count);
    let (first, last) = (counts(&quantized[0]), counts(&quantized[quantized.len() - 1]));
    let coarsest = (character.min_vertex_count, character.min_triangle_count);
    let full = (character.vertex_count, character.triangle_count);
    for (field, found, wanted) in [("first quantised level", first, coarsest), ("last quantised level", last, full)] {
        expect(found == wanted, || place(field), format_args!("{found:?}"), || format!("{wanted:?}"))?;
    }
    for (number, pair) in quantized.windows(2).enumerate() {
        let rising = pair[0].vertex_count < pair[1].vertex_count && pair[0].bound_m >= pair[1].bound_m;
        let allowed = || "more vertices and no greater a bound than the one before".to_owned();
        let found = format!("{:?}", pair[1]);
        expect(rising, || place(&format!("quantised level {}", number + 1)), found, allowed)?;
    }
    Ok(())
}

fn check_level(
    contents: &PackContents,
    character: &CharacterRecord,
    level: &LevelRecord,
    lods: &[LodRecord],
    may_refit: bool,
    covered: &mut CoveredLevels,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let bound = level.bound_m;
    expect(bound.is_finite() && bound >= 0.0, || here("bound"), bound, || "finite, at least 0".to_owned())?;
    let found = (level.vertex_count, level.triangle_count);
    if level.refit_vertex_offset == NONE {
        let known = lods.get(level.vertex_count as usize);
        let fits = known.is_some_and(|lod| (lod.vertex_count, lod.triangle_count) == found);
        expect(fits, || here("counts"), format_args!("{found:?}"), || "a level of the LOD table".to_owned())?;
    } else {
        expect(may_refit, || here("refitted vertices"), level.refit_vertex_offset, || format!("{NONE} for none"))?;
        let most = character.triangle_count;
        let fits = level.triangle_count <= most && level.vertex_count <= character.vertex_count;
        let allowed = || format!("at most {} vertices, {most} triangles", character.vertex_count);
        expect(fits, || here("counts"), format_args!("{found:?}"), allowed)?;
        let vertices = take(
            &mut covered.refit_vertices,
            level.refit_vertex_offset,
            level.vertex_count.into(),
            contents.refit_vertices.len(),
            &|| here("refitted vertices"),
        )?;
        for (number, vertex) in contents.refit_vertices[vertices].iter().enumerate() {
            check_vertex(vertex, character, &|field: &str| here(&format!("vertex {number}: {field}")))?;
        }
    }
    check_indices(contents, level, covered, here)
}

fn check_indices(
    contents: &PackContents,
    level: &LevelRecord,
    covered: &mut CoveredLevels,
    here: &dyn Fn(&str) -> String,
) -> Result<()> {
    let width = LevelRecord::index_bytes_for(level.vertex_count);
    expect(level.index_bytes == width, || here("bytes of an index"), level.index_bytes, || width.to_string())?;
    let count = u64::from(level.triangle_count) * 3;
    let words = || here("indices");
    let beyond = if width == 2 {
        let range = take(&mut covered.indices_16, level.index_offset, count, contents.indices_16.len(), &words)?;
        contents.indices_16[range].iter().map(|&i| u32::from(i)).find(|&i| i >= level.vertex_count)
    } else {
        let range = take(&mut covered.indices_32, level.index_offset, count, contents.indices_32.len(), &words)?;
        contents.indices_32[range].iter().copied().find(|&i| i >= level.vertex_count)
    };
    let found = beyond.unwrap_or_default();
    expect(beyond.is_none(), words, found, || format!("below {}", level.vertex_count))
}
