//! Gives vertices of coarser levels the normals that suit them there.
//!
//! A vertex of a coarse level stands for all that has merged into it, and its triangles are shaded by its normal: that of the one
//! spot where it lies is rarely the best. At some levels on the way down the normals that come closest to full detail's are
//! fitted; where one has turned, the vertex is exchanged for one at the same place with the input's normal next to it. That is a
//! stand-in as for a wedge without an image, used by coarser levels only, and comes when something merges next to it.

use crate::refit::{FittedNormals, NormalsAtLevels};
use crate::reform::settle;
use crate::{CollapseOrder, Level, LodMesh};
use rayon::prelude::*;

/// Triangles of a level that is looked at, as a share of those of the one before.
const STEP_SHARE: f64 = 0.6;
/// Levels with fewer triangles are not looked at.
const LEAST_TRIANGLES: u32 = 8;
/// A normal that has turned less than this stays: cos 8°.
const LEAST_TURN_COS: f32 = 0.990_3;
/// Input normals are told apart in steps of one over this.
const NORMAL_STEPS: f32 = 24.0;

/// A vertex that gets another normal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    /// Vertex of the order as it came.
    vertex: u32,
    /// The level from which on it has the normal, going down.
    level: u32,
    /// Input vertex with the normal.
    normal_source: u32,
}

/// The order with other normals in its coarser levels.
pub(crate) fn dress_normals(mesh: &LodMesh<'_>, mut order: CollapseOrder) -> CollapseOrder {
    let found = find_changes(mesh, &order);
    // What nothing has used before is not exchanged: it comes with the normal.
    let born = first_uses(&order);
    let (at_once, later): (Vec<Change>, Vec<Change>) =
        found.into_iter().partition(|change| born[change.vertex as usize] <= change.level);
    for change in at_once {
        order.normal_source[change.vertex as usize] = change.normal_source;
    }
    if later.is_empty() { order } else { Wardrobe::new(&order, later).dress(order) }
}

/// What changes, by level looked at, the finest first.
fn find_changes(mesh: &LodMesh<'_>, order: &CollapseOrder) -> Vec<Change> {
    let is_flat = |m: u16| mesh.appearance.flat_materials.get(usize::from(m)).copied().unwrap_or(false);
    let looked_at = levels_to_look_at(&order.levels);
    let candidates = distinct_normals(mesh);
    if looked_at.is_empty() || order.vertex_materials.iter().all(|&m| is_flat(m)) {
        return Vec::new();
    }
    let fits = NormalsAtLevels::new(mesh, order);
    let mut sources = order.normal_source.clone();
    let mut above = order.levels.len() - 1;
    let mut changes = Vec::new();
    for at in looked_at {
        let settled = settle(&order.collapse_map, order.levels[at].vertex_count);
        let fitted = fits.fit(&order.levels[at], &settled, &sources);
        let touched = places_touched(order, at, above, &settled, &fitted);
        above = at;
        let change = |i: usize| {
            let (vertex, normal) = (fitted.vertices[i], fitted.normals[i]);
            let level = touched[fitted.places[i] as usize]?;
            let now = cos(normal, mesh.normals[sources[vertex as usize] as usize]);
            if is_flat(order.vertex_materials[vertex as usize]) || now >= LEAST_TURN_COS {
                return None;
            }
            let normal_source = closest(mesh, &candidates, normal)?;
            let then = cos(normal, mesh.normals[normal_source as usize]);
            (then > now).then_some(Change { vertex, level, normal_source })
        };
        let found: Vec<Option<Change>> = (0..fitted.vertices.len()).into_par_iter().map(change).collect();
        for change in found.into_iter().flatten() {
            sources[change.vertex as usize] = change.normal_source;
            changes.push(change);
        }
    }
    changes
}

/// For each vertex the finest level whose triangles use it: full detail, but for stand-ins.
fn first_uses(order: &CollapseOrder) -> Vec<u32> {
    let mut born = vec![0_u32; order.vertex_source.len()];
    for &v in order.triangles.as_flattened() {
        born[v as usize] = u32::MAX;
    }
    let mut level = order.levels.len();
    for v in (0..born.len()).rev() {
        while level > 0 && order.levels[level - 1].vertex_count as usize > v {
            level -= 1;
        }
        // `v` goes on the way to the level before the first one that has it.
        let target = order.collapse_map[v] as usize;
        if let Some(goes_at) = level.checked_sub(1) {
            born[target] = born[target].max(goes_at as u32);
        }
    }
    born
}

/// Levels at which normals are fitted, finest first: each with a share of the triangles of the one before.
fn levels_to_look_at(levels: &[Level]) -> Vec<usize> {
    let full = levels.last().map_or(0, |level| level.triangle_count);
    let mut found: Vec<usize> = Vec::new();
    let mut wanted = f64::from(full) * STEP_SHARE;
    while wanted >= f64::from(LEAST_TRIANGLES) {
        let at = levels.partition_point(|level| f64::from(level.triangle_count) <= wanted);
        if at == 0 {
            break;
        }
        if at < levels.len() && found.last() != Some(&(at - 1)) {
            found.push(at - 1);
        }
        wanted *= STEP_SHARE;
    }
    found
}

/// For each place of level `at`, the coarsest level down to it, below level `above`, on the way to which a triangle around it goes.
fn places_touched(
    order: &CollapseOrder,
    at: usize,
    above: usize,
    settled: &[u32],
    fitted: &FittedNormals,
) -> Vec<Option<u32>> {
    let mut place_of = vec![u32::MAX; settled.len()];
    for (&v, &place) in fitted.vertices.iter().zip(&fitted.places) {
        place_of[v as usize] = place;
    }
    let mut touched = vec![None; fitted.vertices.len()];
    for level in at..above {
        let [from, to] = [level, level + 1].map(|l| order.levels[l].triangle_count as usize);
        for &v in order.triangles[from..to].as_flattened() {
            // A place that went with its whole part is none of this level's.
            if let Some(touched) = touched.get_mut(place_of[settled[v as usize] as usize] as usize) {
                touched.get_or_insert(level as u32);
            }
        }
    }
    touched
}

/// Input vertices whose normals differ, the lowest of each kind.
fn distinct_normals(mesh: &LodMesh<'_>) -> Vec<u32> {
    let mut used: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let unit = |&v: &u32| (cos(mesh.normals[v as usize], mesh.normals[v as usize]) - 1.0).abs() < 0.1;
    let key = |v: u32| mesh.normals[v as usize].map(|c| (c * NORMAL_STEPS + 0.5).floor() as i32);
    let mut keyed: Vec<([i32; 3], u32)> = used.iter().filter(|v| unit(v)).map(|&v| (key(v), v)).collect();
    keyed.sort_unstable();
    keyed.dedup_by_key(|k| k.0);
    keyed.into_iter().map(|k| k.1).collect()
}

/// Of some input vertices, the one whose normal is closest.
fn closest(mesh: &LodMesh<'_>, candidates: &[u32], normal: [f32; 3]) -> Option<u32> {
    let mut best: Option<(f32, u32)> = None;
    for &v in candidates {
        let cos = cos(normal, mesh.normals[v as usize]);
        if best.is_none_or(|b| cos > b.0) {
            best = Some((cos, v));
        }
    }
    best.map(|b| b.1)
}

fn cos(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The changes by vertex, and where everything comes to lie.
struct Wardrobe {
    /// By vertex, for each from the finest level on down.
    changes: Vec<Change>,
    /// Changes of each vertex: `offsets[v]..offsets[v + 1]`.
    offsets: Vec<u32>,
    /// New index of each vertex as it is at the end, and, for each change, as it was before.
    last: Vec<u32>,
    before: Vec<u32>,
    /// Changes on the way to each level from the next finer one.
    coming: Vec<u32>,
}

impl Wardrobe {
    fn new(order: &CollapseOrder, mut changes: Vec<Change>) -> Self {
        changes.sort_unstable_by_key(|c| (c.vertex, std::cmp::Reverse(c.level)));
        let mut offsets = vec![0_u32; order.vertex_source.len() + 1];
        let mut coming = vec![0_u32; order.levels.len()];
        for change in &changes {
            offsets[change.vertex as usize + 1] += 1;
            coming[change.level as usize] += 1;
        }
        for v in 1..offsets.len() {
            offsets[v] += offsets[v - 1];
        }
        let mut by_level: Vec<u32> = (0..changes.len() as u32).collect();
        by_level.sort_by_key(|&c| changes[c as usize].level);
        let mut by_level = by_level.into_iter().peekable();
        let (mut last, mut before) = (Vec::with_capacity(offsets.len()), vec![0; changes.len()]);
        let mut next = 0;
        // What goes on the way to a level lies behind that level: its old vertices, then the exchanged ones.
        let kept = order.levels.first().map_or(0, |level| level.vertex_count);
        let ends = order.levels.iter().skip(1).map(|level| level.vertex_count);
        for (level, end) in std::iter::once(kept).chain(ends).enumerate() {
            while (last.len() as u32) < end {
                last.push(next);
                next += 1;
            }
            // Behind the vertices that go on the way to level - 1 lie those exchanged on that way.
            while let Some(c) = by_level.next_if(|&c| changes[c as usize].level + 1 == level as u32) {
                before[c as usize] = next;
                next += 1;
            }
        }
        Self { changes, offsets, last, before, coming }
    }

    fn changes_of(&self, v: u32) -> std::ops::Range<usize> {
        self.offsets[v as usize] as usize..self.offsets[v as usize + 1] as usize
    }

    /// New index of a vertex as it is at full detail.
    fn at_first(&self, v: u32) -> u32 {
        self.changes_of(v).next().map_or(self.last[v as usize], |c| self.before[c])
    }

    /// New index of a vertex as it is at a level.
    fn at_level(&self, v: u32, level: u32) -> u32 {
        let coarser = self.changes_of(v).find(|&c| self.changes[c].level < level);
        coarser.map_or(self.last[v as usize], |c| self.before[c])
    }

    /// The order with everything where it belongs.
    fn dress(&self, order: CollapseOrder) -> CollapseOrder {
        let count = order.vertex_source.len() + self.changes.len();
        let mut was = vec![0_u32; count];
        let mut normal_source = vec![0_u32; count];
        let mut collapse_map = vec![0_u32; count];
        let mut level = 0;
        for v in 0..order.vertex_source.len() as u32 {
            // The level for which `v` goes.
            while level < order.levels.len() && order.levels[level].vertex_count <= v {
                level += 1;
            }
            let mut normal = order.normal_source[v as usize];
            for c in self.changes_of(v) {
                let at = self.before[c] as usize;
                (was[at], normal_source[at]) = (v, normal);
                collapse_map[at] = self.at_level(v, self.changes[c].level);
                normal = self.changes[c].normal_source;
            }
            let at = self.last[v as usize] as usize;
            (was[at], normal_source[at]) = (v, normal);
            let target = order.collapse_map[v as usize];
            let stays = target == v || level == 0;
            collapse_map[at] = if stays { at as u32 } else { self.at_level(target, level as u32 - 1) };
        }
        let mut more = 0;
        let levels = order.levels.iter().zip(&self.coming).map(|(level, coming)| {
            let level = Level { vertex_count: level.vertex_count + more, ..*level };
            more += coming;
            level
        });
        let levels = levels.collect();
        let of = |from: &[u32]| -> Vec<u32> { was.iter().map(|&v| from[v as usize]).collect() };
        CollapseOrder {
            vertex_source: of(&order.vertex_source),
            attribute_source: of(&order.attribute_source),
            normal_source,
            vertex_materials: was.iter().map(|&v| order.vertex_materials[v as usize]).collect(),
            vertex_classes: was.iter().map(|&v| order.vertex_classes[v as usize]).collect(),
            triangles: order.triangles.iter().map(|t| t.map(|v| self.at_first(v))).collect(),
            collapse_map,
            levels,
            ..order
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{TestMesh, TestPoses, quick, simplify_checked, uv_sphere};
    use crate::{AttributeWeights, LodOptions, level_mesh};

    /// A ball with bumps, and normals to match.
    fn bumpy() -> TestMesh {
        let mut mesh = uv_sphere(48, 32);
        for (place, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
            let bump = 1.0 + 0.1 * libm::sinf(9.0 * place[1]) * libm::cosf(7.0 * place[0] + 2.0 * place[2]);
            *place = place.map(|c| c * bump);
            *normal = place.map(|c| c / cos(*place, *place).sqrt());
        }
        let mut sums = vec![[0.0_f32; 3]; mesh.positions.len()];
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let normal = crate::quadrics::cross(crate::quadrics::sub(b, a), crate::quadrics::sub(c, a));
            t.iter().for_each(|&v| (0..3).for_each(|i| sums[v as usize][i] += normal[i]));
        }
        // Vertices at one place have one normal: the texture has seams, the light none.
        let places = &mesh.positions;
        let alike = |v: usize| (0..places.len()).filter(move |&w| places[w] == places[v]);
        let normals = (0..sums.len()).map(|v| {
            let sum = alike(v).fold([0.0; 3], |sum: [f32; 3], w| [0, 1, 2].map(|i| sum[i] + sums[w][i]));
            sum.map(|c| c / cos(sum, sum).sqrt())
        });
        mesh.normals = normals.collect();
        mesh
    }

    fn mean_turn(mesh: &TestMesh, order: &CollapseOrder, triangles: u32) -> f32 {
        let level = order.levels.iter().rfind(|level| level.triangle_count <= triangles).expect("reached");
        let mesh = mesh.mesh();
        let settled = settle(&order.collapse_map, level.vertex_count);
        let fitted = NormalsAtLevels::new(&mesh, order).fit(level, &settled, &order.normal_source);
        let own = level_mesh(&mesh, order, level).normals;
        let turns = own.iter().zip(&fitted.normals).map(|(&own, &best)| libm::acosf(cos(own, best).min(1.0)));
        turns.sum::<f32>() / own.len() as f32
    }

    #[test]
    fn coarse_levels_have_normals_that_suit_them() {
        let mesh = bumpy();
        let no_normals = AttributeWeights { normal: 0.0, ..AttributeWeights::default() };
        let without = LodOptions { attribute_weights: no_normals, ..quick() };
        for triangles in [200, 70] {
            let [plain, dressed] = [&without, &quick()].map(|options| {
                let order = simplify_checked(&mesh, &TestPoses::rest(), options);
                mean_turn(&mesh, &order, triangles)
            });
            assert!(plain > 0.1 && dressed < 0.7 * plain, "{triangles}: {plain} {dressed}");
        }
    }

    #[test]
    fn light_has_no_seam_where_only_the_texture_has_one() {
        let mesh = bumpy();
        let no_normals = AttributeWeights { normal: 0.0, ..AttributeWeights::default() };
        let options = LodOptions { attribute_weights: no_normals, ..quick() };
        let plain = simplify_checked(&mesh, &TestPoses::rest(), &options);
        let dressed = dress_normals(&mesh.mesh(), plain.clone());
        assert!(dressed.vertex_source.len() > plain.vertex_source.len(), "some vertices are exchanged");
        // Stand-ins may come with normals of their own.
        let first: std::collections::BTreeSet<u32> = plain.triangles.as_flattened().iter().copied().collect();
        let mut shared = 0;
        for (plain_level, level) in plain.levels.iter().zip(&dressed.levels).step_by(7) {
            assert_eq!(plain_level.triangle_count, level.triangle_count);
            let [before, after] =
                [(&plain, plain_level), (&dressed, level)].map(|(order, level)| level_mesh(&mesh.mesh(), order, level));
            let mut seen = std::collections::BTreeMap::new();
            for (&v, &w) in before.triangles.as_flattened().iter().zip(after.triangles.as_flattened()) {
                let (v, w) = (v as usize, w as usize);
                assert_eq!(before.positions[v], after.positions[w]);
                if first.contains(&before.vertices[v]) {
                    let key = [before.positions[v], before.normals[v]].map(|c| c.map(f32::to_bits));
                    let (other, normal) = *seen.entry(key).or_insert((before.vertices[v], after.normals[w]));
                    assert_eq!(normal, after.normals[w], "{:?} at {level:?}", before.positions[v]);
                    shared += usize::from(other != before.vertices[v]);
                }
            }
        }
        assert!(shared > 0);
    }
}
