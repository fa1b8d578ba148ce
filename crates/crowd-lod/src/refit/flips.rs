//! Turns edges of a level to the other diagonal of their two triangles where that shows full detail better.
//!
//! A level of the order has the triangles that its collapses left. A refitted one has a table of its own: of two triangles that
//! lie in one chart and share both vertices of their edge, either diagonal will do.

use super::Dress;
use super::full_detail::FullDetail;
use super::pairs::{Pair, mix};
use super::shape::Shape;
use crate::behind::diagonal;
use crate::closest::closest_on_triangle;
use crate::quadrics::{cross, dot, sub};
use crate::{LevelMesh, Mat3x4};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Share of what the pairs of two triangles cost that a flip has to save; they are taken to cost a tenth of the mean at least.
const LEAST_GAIN: f64 = 0.03;
const LEAST_COST: f64 = 0.3;
/// The new triangles face where the old ones did together, in every frame, up to this cosine.
const FACING_COS: f32 = 0.2;
/// A new triangle is at least this high, as a share of its longest side.
const LEAST_HEIGHT: f32 = 0.02;
/// In the texture it has at least this share of what both have.
const LEAST_AREA: f32 = 0.1;
/// Errors that are none: a share of the diagonal, a difference of unit normals, and of colours.
const NOISE: [f64; 3] = [1.0e-5, 1.0e-3, 1.0e-3];

/// Errors at a point: squared distance, difference of normals, squared difference of colours.
type Errors = [f64; 3];

/// A triangle of the level and the corners that it gets.
pub(crate) type Turned = (usize, [u32; 3]);

struct Flips<'a> {
    full: &'a FullDetail<'a>,
    shape: &'a Shape,
    level: &'a LevelMesh,
    first_uvs: &'a [[f32; 2]],
    dress: &'a Dress,
    /// Places of the skins in each frame.
    posed: Vec<Vec<[f32; 3]>>,
    targets: Vec<Target>,
    /// What each error is divided by: its mean over the level, and a little more.
    means: Errors,
}

/// What full detail shows at a pair.
#[derive(Clone, Copy)]
struct Target {
    frame: u32,
    place: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    color: [f32; 3],
    /// Shaded by the triangle's own normal.
    flat: bool,
    share: f64,
}

/// One pass: each triangle takes part in at most one flip. Returns the triangles that change.
///
/// `level`: with what it shows now; `first_uvs`: its texture coordinates before the fit. `pairs`: of faces that look the same way.
pub(crate) fn flip_edges(
    full: &FullDetail<'_>,
    shape: &Shape,
    level: &LevelMesh,
    first_uvs: &[[f32; 2]],
    dress: &Dress,
    matrices: &[Vec<Mat3x4>],
    pairs: &[Pair],
) -> Vec<Turned> {
    let posed: Vec<Vec<[f32; 3]>> = matrices.par_iter().map(|m| shape.pose(m)).collect();
    let targets: Vec<Target> = pairs.par_iter().map(|pair| target_of(full, pair)).collect();
    let mut flips = Flips { full, shape, level, first_uvs, dress, posed, targets, means: [1.0; 3] };
    flips.means = flips.mean_errors(pairs);
    let diagonal = f64::from(diagonal(full.mesh.positions));
    let noise = [(NOISE[0] * diagonal) * (NOISE[0] * diagonal), NOISE[1], NOISE[2] * NOISE[2]];
    (0..3).for_each(|i| flips.means[i] += noise[i]);
    let mut of_triangle: Vec<Vec<u32>> = vec![Vec::new(); level.triangles.len()];
    for (i, pair) in pairs.iter().enumerate() {
        of_triangle[pair.triangle as usize].push(i as u32);
    }
    let edges = place_edges(shape);
    let mut known: BTreeSet<(usize, usize)> = edges.iter().map(|e| (e.0, e.1)).collect();
    let inner: Vec<[u32; 2]> = edges
        .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
        .filter(|group| group.len() == 2)
        .map(|group| [group[0].2, group[1].2])
        .collect();
    let mut gains: Vec<(f64, [Turned; 2])> = inner
        .par_iter()
        .filter_map(|&edge| {
            let turned = flips.turn(edge, &known)?;
            let here = turned.map(|(t, _)| of_triangle[t].as_slice()).concat();
            let before = flips.cost(&here, turned.map(|(t, _)| level.triangles[t]));
            let gain = before - flips.cost(&here, turned.map(|(_, corners)| corners));
            let least = LEAST_GAIN
                * before.max(LEAST_COST * here.iter().map(|&i| flips.targets[i as usize].share).sum::<f64>());
            (gain > least).then_some((gain, turned))
        })
        .collect();
    gains.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut locked = vec![false; level.triangles.len()];
    let mut changed = Vec::new();
    for (_, turned) in gains {
        let (c, d) = (place_of(shape, turned[0].1[0]), place_of(shape, turned[0].1[1]));
        if turned.iter().any(|&(t, _)| locked[t]) || !known.insert((c.min(d), c.max(d))) {
            continue;
        }
        turned.iter().for_each(|&(t, _)| locked[t] = true);
        changed.extend(turned);
    }
    changed
}

fn place_of(shape: &Shape, v: u32) -> usize {
    shape.skins[shape.skin_of[v as usize] as usize].place as usize
}

/// Edges as places, the lower one first, with triangle times three plus corner; sorted.
fn place_edges(shape: &Shape) -> Vec<(usize, usize, u32)> {
    let mut edges = Vec::with_capacity(shape.triangles.len() * 3);
    for t in 0..shape.triangles.len() {
        let corners = shape.corner_places(t);
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            edges.push((a.min(b), a.max(b), (t * 3 + i) as u32));
        }
    }
    edges.sort_unstable();
    edges
}

fn target_of(full: &FullDetail<'_>, pair: &Pair) -> Target {
    let [a, b, c] = full.corners_at(pair);
    let flat = full.is_flat(pair.full_triangle);
    let normals = full.triangles[pair.full_triangle as usize].map(|v| full.mesh.normals[v as usize]);
    Target {
        frame: pair.frame,
        place: mix([a, b, c], pair.full_weights),
        normal: unit(if flat { cross(sub(b, a), sub(c, a)) } else { mix(normals, pair.full_weights) }),
        uv: full.uv_at(pair),
        color: full.color_in(pair.full_triangle, pair.full_weights),
        flat,
        share: f64::from(pair.share),
    }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    if length > f32::MIN_POSITIVE { v.map(|c| c / length) } else { [0.0; 3] }
}

impl Flips<'_> {
    fn corners(&self, frame: usize, triangle: [u32; 3]) -> [[f32; 3]; 3] {
        triangle.map(|v| self.posed[frame][self.shape.skin_of[v as usize] as usize])
    }

    fn normal(&self, frame: usize, triangle: [u32; 3]) -> [f32; 3] {
        let [a, b, c] = self.corners(frame, triangle);
        cross(sub(b, a), sub(c, a))
    }

    /// What the level is off at a target, where it touches a triangle with these weights, `squared` away.
    fn errors_at(&self, target: &Target, triangle: [u32; 3], weights: [f32; 3], squared: f32) -> Errors {
        let shaded = if target.flat {
            self.normal(target.frame as usize, triangle)
        } else {
            mix(triangle.map(|v| self.level.normals[v as usize]), weights)
        };
        let turned = sub(unit(shaded), target.normal);
        let uvs = triangle.map(|v| self.level.uvs[v as usize]);
        let uv = [0, 1].map(|i| (0..3).map(|k| uvs[k][i] * weights[k]).sum::<f32>());
        let painted = if self.full.knows_colors() {
            let tint = mix(triangle.map(|v| self.dress.tints[v as usize]), weights);
            let color = self.full.color(self.dress.materials[triangle[0] as usize], uv, tint);
            let off = sub(color, target.color);
            dot(off, off)
        } else {
            let slide = [uv[0] - target.uv[0], uv[1] - target.uv[1]];
            slide[0] * slide[0] + slide[1] * slide[1]
        };
        [f64::from(squared), f64::from(dot(turned, turned)).sqrt(), f64::from(painted)]
    }

    fn mean_errors(&self, pairs: &[Pair]) -> Errors {
        let sum = |(pairs, targets): (&[Pair], &[Target])| {
            let mut sum = [0.0; 3];
            for (pair, target) in pairs.iter().zip(targets) {
                let triangle = self.level.triangles[pair.triangle as usize];
                let errors = self.errors_at(target, triangle, pair.weights, dot(pair.offset, pair.offset));
                (0..3).for_each(|i| sum[i] += target.share * errors[i] / 2.0);
            }
            sum
        };
        let parts: Vec<Errors> = pairs.par_chunks(4096).zip(self.targets.par_chunks(4096)).map(sum).collect();
        parts.iter().fold([0.0; 3], |all, part| [0, 1, 2].map(|i| all[i] + part[i]))
    }

    /// The two triangles of an edge with the corners that a flip gives them; `None` where it must stay. `edge`: triangle times three
    /// plus corner, from both sides.
    fn turn(&self, edge: [u32; 2], known: &BTreeSet<(usize, usize)>) -> Option<[Turned; 2]> {
        let [(t, i), (s, j)] = edge.map(|e| (e as usize / 3, e as usize % 3));
        let (first, second) = (self.level.triangles[t], self.level.triangles[s]);
        let (a, b, c, d) = (first[i], first[(i + 1) % 3], first[(i + 2) % 3], second[(j + 2) % 3]);
        let charts = &self.full.charts.of_triangle;
        if charts[t] != charts[s] || (second[j], second[(j + 1) % 3]) != (b, a) {
            return None;
        }
        let (at_c, at_d) = (place_of(self.shape, c), place_of(self.shape, d));
        if at_c == at_d || known.contains(&(at_c.min(at_d), at_c.max(at_d))) {
            return None;
        }
        let turned = [[c, d, b], [d, c, a]];
        let lies_well = |uvs: &[[f32; 2]]| {
            let area = |t: [u32; 3]| {
                let [a, b, c] = t.map(|v| uvs[v as usize]);
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            let both = area(first) + area(second);
            turned.iter().all(|&t| area(t) * both.signum() >= LEAST_AREA * both.abs())
        };
        let stands_well = |frame: usize| {
            let (n, m) = (self.normal(frame, first), self.normal(frame, second));
            let both = [0, 1, 2].map(|k| n[k] + m[k]);
            turned.iter().all(|&t| {
                let own = self.normal(frame, t);
                let [a, b, c] = self.corners(frame, t);
                let longest = [sub(b, a), sub(c, b), sub(a, c)].map(|e| dot(e, e)).into_iter().fold(0.0, f32::max);
                dot(own, both) > FACING_COS * (dot(own, own) * dot(both, both)).sqrt()
                    && dot(own, own).sqrt() > LEAST_HEIGHT * longest
            })
        };
        let well = lies_well(self.first_uvs) && lies_well(&self.level.uvs) && (0..self.posed.len()).all(stands_well);
        well.then_some([(t, turned[0]), (s, turned[1])])
    }

    /// What the targets cost when their two triangles are these.
    fn cost(&self, targets: &[u32], triangles: [[u32; 3]; 2]) -> f64 {
        let one = |&i: &u32| {
            let target = &self.targets[i as usize];
            let hits = triangles.map(|t| closest_on_triangle(target.place, self.corners(target.frame as usize, t)));
            let k = usize::from(hits[1].1 < hits[0].1);
            let errors = self.errors_at(target, triangles[k], hits[k].0, hits[k].1);
            target.share * (0..3).map(|i| errors[i] / self.means[i]).sum::<f64>()
        };
        targets.iter().map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refit::Probes;
    use crate::test_meshes::{TestMesh, TestPoses, grid, quick};
    use crate::{CollapseOrder, simplify};

    /// Full detail with a crease along one diagonal of its square, and a level of two triangles split along the other one.
    fn creased(cut: bool) -> (TestMesh, CollapseOrder, LevelMesh) {
        let lift = |x: usize, y: usize| (x as f32 - y as f32).abs() * 0.4;
        let mesh = grid(8, 8, lift, |x, _| cut && x == 4);
        let order = simplify(&mesh.mesh(), &TestPoses::rest().poses(), &quick(), &|_| ()).expect("a valid mesh");
        let mut level = TestMesh::default();
        for (x, y) in [(0, 0), (8, 0), (8, 8), (0, 8)] {
            level.vertex([x as f32, y as f32, lift(x, y)], [x as f32 / 8.0, y as f32 / 8.0]);
        }
        let level = LevelMesh {
            vertices: (0..4).collect(),
            stands_at: (0..4).collect(),
            triangles: vec![[1, 2, 3], [1, 3, 0]],
            positions: level.positions,
            normals: level.normals,
            uvs: level.uvs,
            joints: level.joints,
            weights: level.weights,
        };
        (mesh, order, level)
    }

    fn flipped(mesh: &TestMesh, order: &CollapseOrder, level: &LevelMesh) -> Vec<Turned> {
        let (mesh, poses) = (mesh.mesh(), TestPoses::rest());
        let full = FullDetail::new(&mesh, &poses.poses(), order, 1);
        let shape = Shape::new(level);
        let matrices = shape.blend(&full.frames);
        let (pairs, _) = Probes::new(&full, &shape, 2000).pair(&full, &shape, &matrices, true);
        let dress = Dress { materials: vec![0; 4], tints: vec![[1.0; 3]; 4] };
        flip_edges(&full, &shape, level, &level.uvs, &dress, &matrices, &pairs)
    }

    #[test]
    fn an_edge_turns_into_the_crease() {
        let (mesh, order, mut level) = creased(false);
        let turned = flipped(&mesh, &order, &level);
        assert_eq!(turned.len(), 2);
        for (t, corners) in turned {
            level.triangles[t] = corners;
            assert!(corners.contains(&0) && corners.contains(&2), "{corners:?}");
        }
        assert!(flipped(&mesh, &order, &level).is_empty(), "it lies well now");
    }

    #[test]
    fn an_edge_stays_where_nothing_is_won_or_charts_part() {
        let flat = grid(8, 8, |_, _| 0.0, |_, _| false);
        let (creased_mesh, order, level) = creased(true);
        let (_, plain_order, mut plain) = creased(false);
        plain.positions.iter_mut().for_each(|p| p[2] = 0.0);
        assert!(flipped(&flat, &plain_order, &plain).is_empty());
        // A level whose two triangles are of two charts.
        let charts = |order: &CollapseOrder| {
            let mesh = creased_mesh.mesh();
            FullDetail::new(&mesh, &TestPoses::rest().poses(), order, 1).charts.of_triangle
        };
        let of = charts(&order);
        let other = of.iter().position(|&chart| chart != of[0]).expect("two charts");
        let mut order = order;
        order.triangle_source.swap(1, other);
        order.triangles.swap(1, other);
        assert_ne!(charts(&order)[0], charts(&order)[1]);
        assert!(flipped(&creased_mesh, &order, &level).is_empty());
    }
}
