//! Gives triangles the colours that full detail shows where they lie, where those are not the colours of their own chart.
//!
//! A triangle of a level has the material and the chart that it had at full detail. Where it came to lie over another one, as those around
//! a belt or a mane do that lost most of their triangles, it may show the wrong colour over most of itself; no move of its corners mends
//! that. It is given the other material, or the other chart's texture, at corners of its own.

use super::full_detail::FullDetail;
use super::pairs::{Pair, mix};
use crate::criteria::uv_area;
use crate::quadrics::{dot, sub};
use crate::split_seams::{skinning_key, zero_signless_bits};
use crate::{CollapseOrder, LevelMesh};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Share of what a triangle's colours are off that other ones have to save: pairs are a sample, not the surface.
const LEAST_GAIN: f32 = 0.1;
/// Pairs below which a triangle stays as it is.
const LEAST_PAIRS: usize = 4;
/// Share of a triangle's pairs that lie on a chart whose texture it may get.
const LEAST_SHARE: f32 = 0.3;
/// What keeps texture coordinates at corners that no pair is near close to the mean, next to all pairs.
const DAMPING: f32 = 0.02;
/// Plain colours that a triangle is tried with at most, those that most of its pairs lie on.
const MOST_COATS: usize = 32;
/// Twice the area that a triangle of a chart has in the texture at least; below, a chart is dots or threads of a palette.
const LEAST_CHART_AREA: f64 = 1.0e-9;

/// What a triangle may show: the material and tint of a vertex of the order, and a texture coordinate for each corner.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Coat {
    dress: u32,
    material: u16,
    tint: [f32; 3],
    uvs: [[f32; 2]; 3],
}

/// Gives each triangle of the level the colours of full detail around it with which it is least off, if that saves something:
/// of plain materials that differ in colour alone, one; of one texture, that of another chart. Vertices are added at its corners, and
/// those that no triangle uses any more are left out. Never more vertices than the order has, for a pack has no room for them:
/// triangles that would need more stay as they are. So does what its alpha cuts out: colours do not tell where its holes are.
///
/// `pairs`: of faces that look the same way, of the level as it is.
pub(crate) fn repaint(full: &FullDetail<'_>, order: &CollapseOrder, pairs: &[Pair], level: &mut LevelMesh) {
    if !full.knows_colors() {
        return;
    }
    let chosen = choose_all(full, order, pairs, level, false);
    if chosen.iter().all(Option::is_none) {
        return;
    }
    let mut known: BTreeMap<Key, u32> = BTreeMap::new();
    for v in 0..level.vertices.len() as u32 {
        known.entry(key(full, order, level, v, level.vertices[v as usize], level.uvs[v as usize])).or_insert(v);
    }
    for (t, coat) in chosen.into_iter().enumerate() {
        let Some(Coat { dress, uvs, .. }) = coat else { continue };
        let corners = level.triangles[t];
        let keys = [0, 1, 2].map(|corner| key(full, order, level, corners[corner], dress, uvs[corner]));
        let new_count = keys.iter().filter(|key| !known.contains_key(*key)).count();
        // Corners that only their texture coordinates told apart would be one.
        let folds = keys[0] == keys[1] || keys[1] == keys[2] || keys[2] == keys[0];
        if folds || level.vertices.len() + new_count > order.vertex_source.len() {
            continue;
        }
        for (corner, key) in keys.into_iter().enumerate() {
            let add = || add_vertex(level, corners[corner], dress, uvs[corner]);
            level.triangles[t][corner] = *known.entry(key).or_insert_with(add);
        }
    }
    drop_unused(level);
}

/// The triangles of the level that get another plain look, and which.
pub(crate) fn find_looks(
    full: &FullDetail<'_>,
    order: &CollapseOrder,
    pairs: &[Pair],
    level: &LevelMesh,
) -> Vec<(usize, Look)> {
    let look = |coat: &Coat| {
        let source = order.attribute_source[coat.dress as usize];
        (coat.material, full.mesh.colors[source as usize])
    };
    let chosen = choose_all(full, order, pairs, level, true);
    chosen.iter().enumerate().filter_map(|(t, coat)| Some((t, look(coat.as_ref()?)))).collect()
}

/// For each triangle of the level the coat that it gets. `plain_alone`: none for triangles with a texture.
fn choose_all(
    full: &FullDetail<'_>,
    order: &CollapseOrder,
    pairs: &[Pair],
    level: &LevelMesh,
    plain_alone: bool,
) -> Vec<Option<Coat>> {
    let mut of_triangle: Vec<Vec<u32>> = vec![Vec::new(); level.triangles.len()];
    for (i, pair) in pairs.iter().enumerate() {
        of_triangle[pair.triangle as usize].push(i as u32);
    }
    let plain = plain_coats(full, order);
    let chosen = |(t, seen): (usize, &Vec<u32>)| {
        if seen.len() < LEAST_PAIRS || (plain_alone && !full.is_plain(t as u32)) {
            return None;
        }
        let seen: Vec<&Pair> = seen.iter().map(|&i| &pairs[i as usize]).collect();
        choose(full, order, level, t, &seen, &plain)
    };
    of_triangle.par_iter().enumerate().map(chosen).collect()
}

/// What a plain triangle shows: material and tint.
pub(crate) type Look = (u16, [u8; 4]);

/// The plain looks of full detail that pairs lie on, those with the largest share first.
fn looks_seen(full: &FullDetail<'_>, seen: &[&Pair]) -> Vec<Look> {
    let mut shares: BTreeMap<Look, f32> = BTreeMap::new();
    for pair in seen {
        if let Some(look) = full.plain_look(pair.full_triangle) {
            *shares.entry(look).or_default() += pair.share;
        }
    }
    let mut shares: Vec<(Look, f32)> = shares.into_iter().collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    shares.into_iter().map(|(look, _)| look).collect()
}

/// The charts but for `own` that enough of the pairs lie on, each with the triangle of full detail that the first of them touches.
fn charts_seen(full: &FullDetail<'_>, seen: &[&Pair], own: u32) -> Vec<(u32, usize)> {
    let mut shares: BTreeMap<u32, (f32, usize)> = BTreeMap::new();
    for pair in seen {
        let there = pair.full_triangle as usize;
        shares.entry(full.charts.of_triangle[there]).or_insert((0.0, there)).0 += pair.share;
    }
    let least = LEAST_SHARE * seen.iter().map(|pair| pair.share).sum::<f32>();
    let enough = shares.into_iter().filter(|&(chart, (share, _))| chart != own && share >= least);
    enough.map(|(chart, (_, there))| (chart, there)).collect()
}

/// For each plain material and tint, what the first triangle of full detail has that shows it.
fn plain_coats(full: &FullDetail<'_>, order: &CollapseOrder) -> BTreeMap<Look, Coat> {
    let mut coats = BTreeMap::new();
    for t in 0..full.triangles.len() as u32 {
        let Some(look) = full.plain_look(t) else { continue };
        let first = full.triangles[t as usize][0];
        let (dress, uvs) = (order.triangles[t as usize][0], [full.mesh.uvs[first as usize]; 3]);
        coats.entry(look).or_insert(Coat { dress, material: look.0, tint: full.tint(first), uvs });
    }
    coats
}

/// The coat that the pairs of one triangle are least off with, if that saves enough.
fn choose(
    full: &FullDetail<'_>,
    order: &CollapseOrder,
    level: &LevelMesh,
    t: usize,
    seen: &[&Pair],
    plain: &BTreeMap<Look, Coat>,
) -> Option<Coat> {
    let textures = full.mesh.appearance.textures?;
    let corners = level.triangles[t];
    let ordered = corners.map(|v| level.vertices[v as usize]);
    let sources = ordered.map(|v| order.attribute_source[v as usize]);
    let material = order.vertex_materials[ordered[0] as usize];
    if !textures.is_opaque(material) {
        return None;
    }
    let wanted: Vec<[f32; 3]> = seen.iter().map(|p| full.color_in(p.full_triangle, p.full_weights)).collect();
    let cost = |material: u16, uvs: [[f32; 2]; 3], tints: [[f32; 3]; 3]| -> f32 {
        let off = |(pair, wanted): (&&Pair, &[f32; 3])| {
            let uv = [0, 1].map(|i| (0..3).map(|c| uvs[c][i] * pair.weights[c]).sum());
            let off = sub(textures.color(material, uv, mix(tints, pair.weights)), *wanted);
            pair.share * dot(off, off)
        };
        seen.iter().zip(&wanted).map(off).sum()
    };
    let now = cost(material, corners.map(|v| level.uvs[v as usize]), sources.map(|v| full.tint(v)));
    if now <= 0.0 {
        return None;
    }
    let mut coats: Vec<Coat> = Vec::new();
    if textures.differ_in_color_alone(material, material) {
        let alpha = full.mesh.colors[sources[0] as usize][3];
        let same_alpha = sources.iter().all(|&v| full.mesh.colors[v as usize][3] == alpha);
        if !same_alpha || !full.is_plain(t as u32) {
            return None;
        }
        let fits = |look: &Look| look.1[3] == alpha && textures.differ_in_color_alone(material, look.0);
        coats.extend(looks_seen(full, seen).into_iter().filter(fits).take(MOST_COATS).filter_map(|l| plain.get(&l)));
    } else {
        let tint_of = |v: u32| full.mesh.colors[v as usize];
        for (chart, there) in charts_seen(full, seen, full.charts.of_triangle[t]) {
            let first = full.triangles[there][0];
            let one_tint = sources.iter().chain(&full.triangles[there]).all(|&v| tint_of(v) == tint_of(first));
            if full.materials[there] != material || !one_tint {
                continue;
            }
            let (dress, tint) = (order.triangles[there][0], full.tint(first));
            coats.extend(uvs_on(full, chart, seen).map(|uvs| Coat { dress, material, tint, uvs }));
        }
    }
    let costs = coats.into_iter().map(|coat| (cost(coat.material, coat.uvs, [coat.tint; 3]), coat));
    let best = costs.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.dress.cmp(&b.1.dress)))?;
    (best.0 < now * (1.0 - LEAST_GAIN)).then_some(best.1)
}

/// Texture coordinates of a triangle's corners that lie on a chart of full detail as its pairs there do, by least squares; `None` where few do,
/// or where it would lie flat or turned over in the texture and the chart does not.
fn uvs_on(full: &FullDetail<'_>, chart: u32, seen: &[&Pair]) -> Option<[[f32; 2]; 3]> {
    let there = || seen.iter().filter(|p| full.charts.of_triangle[p.full_triangle as usize] == chart);
    let share: f32 = there().map(|p| p.share).sum();
    if there().count() < LEAST_PAIRS {
        return None;
    }
    let (mut low, mut high, mut mean) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2], [0.0_f32; 2]);
    for pair in there() {
        let uv = full.uv_at(pair);
        for i in 0..2 {
            (low[i], high[i]) = (low[i].min(uv[i]), high[i].max(uv[i]));
            mean[i] += uv[i] * pair.share / share;
        }
    }
    // Rows of the normal equations, around the mean.
    let mut rows = [[0.0_f64; 5]; 3];
    for (i, row) in rows.iter_mut().enumerate() {
        row[i] = f64::from(DAMPING * share);
    }
    for pair in there() {
        let uv = full.uv_at(pair);
        for i in 0..3 {
            let weight = f64::from(pair.share * pair.weights[i]);
            (0..3).for_each(|j| rows[i][j] += weight * f64::from(pair.weights[j]));
            (0..2).for_each(|k| rows[i][3 + k] += weight * f64::from(uv[k] - mean[k]));
        }
    }
    for i in 0..3 {
        let pivot = rows[i];
        for j in (0..3).filter(|&j| j != i) {
            let by = rows[j][i] / pivot[i];
            (0..5).for_each(|k| rows[j][k] -= by * pivot[k]);
        }
    }
    let solved = [0, 1, 2].map(|i| [0, 1].map(|k| mean[k] + (rows[i][3 + k] / rows[i][i]) as f32));
    if !solved.as_flattened().iter().all(|c| c.is_finite()) {
        return None;
    }
    // Not far beyond what was seen: other charts may lie beside it in the texture.
    let uvs = solved.map(|uv| [0, 1].map(|k| uv[k].clamp(low[k], high[k])));
    let chart_area = |pair: &Pair| {
        let corners = full.triangles[pair.full_triangle as usize].map(|v| full.mesh.uvs[v as usize].map(f64::from));
        uv_area(corners) * f64::from(pair.share / share)
    };
    let way: f64 = there().map(|pair| chart_area(pair)).sum();
    let turned = uv_area(uvs.map(|uv| uv.map(f64::from))) * way <= 0.0;
    (way.abs() <= LEAST_CHART_AREA || !turned).then_some(uvs)
}

/// What tells a vertex of a level from another: place, skinning, normal, texture coordinate, material and tint.
type Key = ([u32; 3], [(u16, u16); 4], [u32; 3], [u32; 2], u16, [u8; 4]);

/// That of a vertex of the level, with the material and tint of a vertex of the order and a texture coordinate.
fn key(full: &FullDetail<'_>, order: &CollapseOrder, level: &LevelMesh, v: u32, dress: u32, uv: [f32; 2]) -> Key {
    let (v, source) = (v as usize, order.attribute_source[dress as usize] as usize);
    (
        level.positions[v].map(zero_signless_bits),
        skinning_key(level.joints[v], level.weights[v]),
        level.normals[v].map(zero_signless_bits),
        uv.map(zero_signless_bits),
        order.vertex_materials[dress as usize],
        full.mesh.colors[source],
    )
}

/// A vertex like `v` with the material and tint of a vertex of the order and a texture coordinate.
fn add_vertex(level: &mut LevelMesh, v: u32, dress: u32, uv: [f32; 2]) -> u32 {
    let v = v as usize;
    level.vertices.push(dress);
    level.uvs.push(uv);
    level.positions.push(level.positions[v]);
    level.normals.push(level.normals[v]);
    level.joints.push(level.joints[v]);
    level.weights.push(level.weights[v]);
    level.stands_at.push(level.stands_at[v]);
    level.vertices.len() as u32 - 1
}

/// Leaves out the vertices that no triangle uses; the others come by the vertex of the order that they are.
fn drop_unused(level: &mut LevelMesh) {
    let mut kept: Vec<u32> = level.triangles.as_flattened().to_vec();
    kept.sort_unstable_by_key(|&v| (level.vertices[v as usize], v));
    kept.dedup();
    let mut number = vec![0_u32; level.vertices.len()];
    for (i, &v) in kept.iter().enumerate() {
        number[v as usize] = i as u32;
    }
    level.triangles.as_flattened_mut().iter_mut().for_each(|corner| *corner = number[*corner as usize]);
    fn pick<T: Copy>(values: &[T], kept: &[u32]) -> Vec<T> {
        kept.iter().map(|&v| values[v as usize]).collect()
    }
    level.vertices = pick(&level.vertices, &kept);
    level.stands_at = pick(&level.stands_at, &kept);
    level.positions = pick(&level.positions, &kept);
    level.normals = pick(&level.normals, &kept);
    level.uvs = pick(&level.uvs, &kept);
    level.joints = pick(&level.joints, &kept);
    level.weights = pick(&level.weights, &kept);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refit::pairs::Probes;
    use crate::refit::shape::Shape;
    use crate::test_meshes::{TestMesh, TestPoses, grid, quick};
    use crate::{Appearance, LodMesh, ShownColors, level_mesh, simplify};

    /// Materials are gray steps and nothing else, or one ramp along u.
    #[derive(Debug, Default)]
    struct Grays {
        plain: bool,
        /// Alpha cuts holes.
        cut: bool,
    }

    impl ShownColors for Grays {
        fn color(&self, material: u16, [u, _]: [f32; 2], _: [f32; 3]) -> [f32; 3] {
            [if self.plain { f32::from(material) * 0.5 } else { u }; 3]
        }

        fn differ_in_color_alone(&self, _: u16, _: u16) -> bool {
            self.plain
        }

        fn is_opaque(&self, _: u16) -> bool {
            !self.cut
        }
    }

    /// Repaints full detail of a grid after the pairs of its triangle 0 were sent to triangle `to`.
    fn repainted(mesh: &TestMesh, textures: &Grays, to: u32) -> (LevelMesh, LevelMesh, CollapseOrder) {
        repainted_in(mesh, textures, Some(to), 1)
    }

    /// The same at `room` times the vertices that full detail has, or with the pairs as found.
    fn repainted_in(
        mesh: &TestMesh,
        textures: &Grays,
        to: Option<u32>,
        room: usize,
    ) -> (LevelMesh, LevelMesh, CollapseOrder) {
        let appearance = Appearance { textures: Some(textures), ..Appearance::default() };
        let lod_mesh = LodMesh { appearance, ..mesh.mesh() };
        let poses = TestPoses::rest();
        let mut order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        let before = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        let full = FullDetail::new(&lod_mesh, &poses.poses(), &order, 1);
        let shape = Shape::new(&before);
        let mut pairs = Probes::new(&full, &shape, 2000).pair_seen(&full, &shape, &shape.blend(&full.frames));
        let number = |source: u32| order.triangle_source.iter().position(|&t| t == source).expect("kept") as u32;
        let moved = pairs.iter_mut().filter(|pair| pair.triangle == number(0));
        if let Some(to) = to.map(number) {
            moved.for_each(|pair| pair.full_triangle = to);
        }
        let mut after = before.clone();
        // Vertices that no triangle uses: what a coarser level has left.
        order.vertex_source.resize(before.vertices.len() * room, 0);
        repaint(&full, &order, &pairs, &mut after);
        (before, after, order)
    }

    fn materials(level: &LevelMesh, order: &CollapseOrder) -> Vec<u16> {
        let of = |t: &[u32; 3]| {
            let all = t.map(|v| order.vertex_materials[level.vertices[v as usize] as usize]);
            assert!(all.iter().all(|&m| m == all[0]), "one triangle, one material");
            all[0]
        };
        level.triangles.iter().map(of).collect()
    }

    #[test]
    fn a_triangle_over_another_plain_color_gets_it_and_stays_where_it_is() {
        let mut mesh = grid(4, 2, |_, _| 0.0, |_, _| false);
        let count = mesh.materials.len();
        mesh.materials[count / 2..].fill(1);
        let plain = Grays { plain: true, ..Grays::default() };
        let last = Some(count as u32 - 1);
        let (before, after, order) = repainted_in(&mesh, &plain, last, 2);
        let (old, new) = (materials(&before, &order), materials(&after, &order));
        for (t, (old, new)) in old.iter().zip(&new).enumerate() {
            let sent = order.triangle_source[t] == 0;
            assert_eq!(old != new, sent, "{t}");
            let places = |level: &LevelMesh| level.triangles[t].map(|v| level.positions[v as usize]);
            assert_eq!(places(&before), places(&after));
        }
        assert!(after.vertices.is_sorted());
        // Between places that look alike anyway, and where materials are not to be exchanged, nothing changes.
        for (plain, to) in [(true, 1), (false, 1)] {
            let (before, after, _) = repainted(&mesh, &Grays { plain, ..Grays::default() }, to);
            assert_eq!(before, after);
        }
        // Nor where full detail leaves no room for more vertices, where alpha cuts holes, or where the other one's alpha is another.
        let (before, after, _) = repainted_in(&mesh, &plain, last, 1);
        assert_eq!(before, after);
        let (before, after, _) = repainted_in(&mesh, &Grays { cut: true, plain: true }, last, 2);
        assert_eq!(before, after);
        let kept = mesh.colors.clone();
        let of_last = *mesh.triangles.last().expect("a triangle");
        mesh.colors.fill([200, 200, 200, 128]);
        of_last.iter().for_each(|&v| mesh.colors[v as usize] = [200; 4]);
        let (before, after, _) = repainted_in(&mesh, &plain, last, 2);
        assert_eq!(before, after);
        // Nor where the colour runs across the triangle.
        mesh.colors = kept;
        mesh.colors[mesh.triangles[0][1] as usize] = [0, 0, 0, 255];
        let (before, after, _) = repainted_in(&mesh, &plain, last, 2);
        assert_eq!(before, after);
    }

    #[test]
    fn of_two_shells_at_one_place_each_keeps_its_color() {
        let mut mesh = grid(6, 6, |_, _| 0.0, |_, _| false);
        let mut other = grid(5, 5, |_, _| 0.0, |_, _| false);
        other.positions.iter_mut().for_each(|p| *p = [p[0] * 1.2, p[1] * 1.2, p[2]]);
        other.materials.fill(1);
        mesh.append(&other);
        let (before, after, _) = repainted_in(&mesh, &Grays { plain: true, ..Grays::default() }, None, 2);
        assert_eq!(before, after);
    }

    #[test]
    fn a_triangle_whose_corners_would_be_one_stays_as_it_is() {
        let mut mesh = grid(4, 2, |_, _| 0.0, |_, _| false);
        let count = mesh.materials.len();
        mesh.materials[count / 2..].fill(1);
        let textures = Grays { plain: true, ..Grays::default() };
        let appearance = Appearance { textures: Some(&textures), ..Appearance::default() };
        let lod_mesh = LodMesh { appearance, ..mesh.mesh() };
        let poses = TestPoses::rest();
        let mut order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        let mut level = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        let full = FullDetail::new(&lod_mesh, &poses.poses(), &order, 1);
        let shape = Shape::new(&level);
        let mut pairs = Probes::new(&full, &shape, 2000).pair_seen(&full, &shape, &shape.blend(&full.frames));
        let number = |source: u32| order.triangle_source.iter().position(|&t| t == source).expect("kept") as u32;
        let first = number(0);
        let last = number(count as u32 - 1);
        pairs.iter_mut().filter(|pair| pair.triangle == first).for_each(|pair| pair.full_triangle = last);
        order.vertex_source.resize(level.vertices.len() * 2, 0);
        // Two corners at one place, told apart by their texture coordinates alone.
        let [a, b, _] = level.triangles[first as usize].map(|v| v as usize);
        level.positions[b] = level.positions[a];
        level.normals[b] = level.normals[a];
        let before = level.clone();
        repaint(&full, &order, &pairs, &mut level);
        assert_eq!(level, before);
    }

    #[test]
    fn a_triangle_over_another_chart_gets_its_texture() {
        // Two charts: the right half has its texture elsewhere.
        let mut mesh = grid(2, 2, |_, _| 0.0, |_, _| false);
        let right = grid(2, 2, |_, _| 0.0, |_, _| false);
        let first = mesh.positions.len();
        mesh.append(&right);
        mesh.positions[first..].iter_mut().for_each(|p| p[0] += 2.0);
        mesh.uvs[first..].iter_mut().for_each(|uv| uv[0] += 3.0);
        let (_, after, order) = repainted_in(&mesh, &Grays::default(), Some(mesh.triangles.len() as u32 - 1), 2);
        for (t, corners) in after.triangles.iter().enumerate() {
            let elsewhere =
                order.triangle_source[t] == 0 || order.triangle_source[t] as usize >= mesh.triangles.len() / 2;
            for &v in corners {
                assert_eq!(after.uvs[v as usize][0] >= 3.0, elsewhere, "{t}: {:?}", after.uvs[v as usize]);
            }
        }
    }
}
