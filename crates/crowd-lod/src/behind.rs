//! How far small parts lie from the rest: what it would cost to lose them.
//!
//! A part is what hangs together. Where one vanishes, the eye sees the surface behind it: an eye's white on a face is missed for its
//! colour, a link of an arm for the gap it leaves. The largest part never vanishes.

use crate::attributes::COLOR_SHARE;
use crate::closest::{ClosestTriangles, LivingNodes, NodeGroups};
use crate::quadrics::{cross, dot, sub};
use crate::split_seams::SplitMesh;
use crate::symmetry::{NO_PARTNER, pair_parts};
use crate::{AttributeWeights, LodMesh};
use rayon::prelude::*;

/// How many times as far off a difference of colours counts where a part vanishes as where a texture slides: all of it is seen at once.
const VANISHED_COLOR: f32 = 3.0;
/// Points of a part that are watched at most.
const MOST_WATCHED: usize = 256;
/// Searches for what lies behind, in all: so many for each point watched. A part whose points need more than are left is not followed when it
/// vanishes; those that need fewer still are.
const SEARCHES: usize = 64;
/// A part is small that has at most one in so many triangles.
const SMALL: usize = 50;
/// Triangles left of a part from which on it follows its mirror image at any price. With more, each is simplified well by itself, and
/// what differs is not seen.
const LAST_OF_TWIN: u32 = 24;
/// Points summed up to prices, in all: so many for each point watched. Afterwards prices stay what they are.
const SUMMED: usize = 1024;

/// What lies behind each part, and what it would cost to lose it, while parts vanish.
///
/// What lay behind a part may vanish before it does: a beard made of lumps that lie on each other would go lump by lump, each for next to
/// nothing. So points of all parts but the largest are watched: each knows the part that stands for it now, what lies behind that, and
/// what was paid for it so far.
///
/// Empty where nobody asks for prices.
#[derive(Debug, Default)]
pub(crate) struct Behind {
    /// For each position, the squared distance to the surface of the other parts, mean over the poses, and the difference in colour as a
    /// squared distance; infinite in the largest part. m².
    losses: Vec<f32>,
    /// Part of each triangle.
    part_of: Vec<u32>,
    /// Triangles that each part has left.
    left: Vec<u32>,
    /// The part that mirrors each, or `NO_PARTNER`.
    twins: Vec<u32>,
    /// What it would cost to lose all that each part stands for, m² times m².
    prices: Vec<Price>,
    points: Vec<Watched>,
    /// Points that each part stands for.
    shown: Vec<Vec<u32>>,
    /// Points that each part lay behind when they last looked.
    backed: Vec<Vec<u32>>,
    scenery: Scenery,
    searches_left: usize,
    sums_left: usize,
}

/// What it costs to lose all that a part stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Price {
    /// What is then off more than before, colours too, m² times m².
    pub cost: f32,
    /// What is then off by its distance alone, m² times m².
    pub distance: f32,
    /// Area that the part stands for, m².
    pub area: f32,
}

/// How far a point is off where another part stands for it, m².
#[derive(Debug, Clone, Copy)]
struct Off {
    /// Colours too.
    all: f32,
    /// The distance alone.
    distance: f32,
}

/// A point of a part.
#[derive(Debug, Clone, Copy)]
struct Watched {
    position: u32,
    /// Area that it stands for, m².
    area: f32,
    /// Part that stands for it now, and the one behind that.
    shown_by: u32,
    next: u32,
    /// What it shows now is this far off, and it would be so far off if that went too, m².
    paid: f32,
    cost: f32,
    /// The farthest that it has been off by its distance alone, were the part that shows it now to go too, m².
    distance: f32,
}

/// The surface at full detail in some poses.
#[derive(Debug, Default)]
struct Scenery {
    triangles: Vec<[u32; 3]>,
    /// Triangles of each part, as far as it is not the only one.
    of_part: Vec<Vec<u32>>,
    /// Those of parts that have triangles left.
    living: LivingNodes,
    posed: Vec<(Vec<[f32; 3]>, ClosestTriangles)>,
    groups: NodeGroups,
    /// Of each position.
    colors: Vec<[f32; 3]>,
    color_scale: f32,
}

impl Scenery {
    /// How far a position is off where the closest surface of the parts that are `wanted` stands for it, m², and which part that is.
    fn look(&self, position: u32, wanted: impl Fn(u32) -> bool) -> Option<(Off, u32)> {
        let (mut sum, mut apart, mut first) = (0.0, 0.0, None);
        for (pose, tree) in &self.posed {
            let point = pose[position as usize];
            let (distance, triangle) =
                tree.closest_of_groups(point, pose, &self.triangles, &self.groups, &self.living, &wanted)?;
            let there = self.triangles[triangle as usize].map(|q| self.colors[q as usize]);
            let own = self.colors[position as usize];
            let difference = [0, 1, 2].map(|i| (there[0][i] + there[1][i] + there[2][i]) / 3.0 - own[i]);
            sum += distance + self.color_scale * self.color_scale * dot(difference, difference);
            apart += distance;
            first = first.or(Some(triangle));
        }
        let count = self.posed.len() as f32;
        let off = Off { all: sum / count, distance: apart / count };
        first.map(|triangle| (off, self.groups.group_of(triangle)))
    }

    /// A part vanished.
    fn remove(&mut self, part: u32) {
        let gone = self.of_part.get_mut(part as usize).map(std::mem::take);
        gone.into_iter().flatten().for_each(|triangle| self.living.remove(triangle));
    }
}

impl Behind {
    /// Looks behind all parts in the poses given, one array of positions each. `partners`: for each position its mirror image.
    pub fn measure(
        mesh: &LodMesh<'_>,
        split: &SplitMesh,
        partners: &[u32],
        posed: impl IntoIterator<Item = Vec<[f32; 3]>>,
        weights: &AttributeWeights,
        diagonal: f32,
    ) -> Self {
        let triangles: Vec<[u32; 3]> = split.triangles.iter().map(|t| t.map(|v| split.position_of(v))).collect();
        let part_of_position = number_parts(split.position_source.len(), &triangles);
        let part_of: Vec<u32> = triangles.iter().map(|t| part_of_position[t[0] as usize]).collect();
        let mut left = vec![0_u32; part_of_position.len()];
        for &part in &part_of {
            left[part as usize] += 1;
        }
        let largest = (0..left.len()).max_by_key(|&part| (left[part], std::cmp::Reverse(part))).unwrap_or(0) as u32;
        let mut twins = pair_parts(&part_of_position, partners);
        // What never vanishes takes nothing along.
        if let Some(&twin) = twins.get(largest as usize).filter(|&&twin| twin != NO_PARTNER) {
            twins[twin as usize] = NO_PARTNER;
            twins[largest as usize] = NO_PARTNER;
        }
        let lone = left.iter().filter(|&&count| count > 0).count() < 2;
        // Nothing is behind the only part: nothing to look at.
        let posed: Vec<Vec<[f32; 3]>> = posed.into_iter().filter(|_| !lone).collect();
        let (triangles, groups) = if lone { (Vec::new(), Vec::new()) } else { (triangles, part_of.clone()) };
        let bind = posed.first().map_or(&[][..], Vec::as_slice);
        let areas = areas_of(bind, &triangles);
        let tree = ClosestTriangles::new(bind, &triangles);
        let living = tree.count_living();
        let mut of_part = vec![Vec::new(); left.len()];
        for (t, &part) in groups.iter().enumerate() {
            of_part[part as usize].push(t as u32);
        }
        let groups = tree.group_by(groups);
        let with_tree = |pose: Vec<[f32; 3]>| {
            let mut tree = tree.clone();
            tree.refit(&pose, &triangles);
            (pose, tree)
        };
        let posed = posed.into_iter().map(with_tree).collect();
        let color_scale = weights.color * VANISHED_COLOR * COLOR_SHARE as f32 * diagonal;
        let colors = if lone { Vec::new() } else { shown_colors(mesh, split) };
        let scenery = Scenery { triangles, of_part, living, posed, groups, colors, color_scale };
        let found: Vec<Option<(Off, u32)>> = (0..part_of_position.len() as u32)
            .into_par_iter()
            .map(|p| {
                let own = part_of_position[p as usize];
                if own == largest { None } else { scenery.look(p, |part| part != own) }
            })
            .collect();
        let losses = found.iter().map(|found| found.map_or(f32::INFINITY, |f| f.0.all)).collect();
        let points = watch(&part_of_position, &areas, &found);
        let count = left.len();
        let never = Price { cost: f32::INFINITY, distance: f32::INFINITY, area: 0.0 };
        let mut prices = vec![never; count];
        let (mut shown, mut backed) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for (i, point) in points.iter().enumerate() {
            shown[point.shown_by as usize].push(i as u32);
            backed[point.next as usize].push(i as u32);
        }
        for (part, shown) in shown.iter().enumerate().filter(|(_, shown)| !shown.is_empty()) {
            prices[part] = price(shown, &points);
        }
        let (searches_left, sums_left) = (points.len() * SEARCHES, points.len() * SUMMED);
        Self { losses, part_of, left, twins, prices, points, shown, backed, scenery, searches_left, sums_left }
    }

    /// What it would cost, for each square metre, if a position vanished with its part, at full detail; infinite in the largest part. m².
    pub fn loss(&self, position: u32) -> f32 {
        self.losses.get(position as usize).copied().unwrap_or(f32::INFINITY)
    }

    /// What it costs that triangles of one part die, when they are all that it has left. While the part that mirrors it is there, it costs
    /// what the dearer of the two does: they go together.
    pub fn price_of_last(&self, dying: &[u32]) -> Option<Price> {
        let part = self.part_of_last(dying)?;
        let (own, twin) = (self.prices[part], self.twins[part]);
        if twin == NO_PARTNER || self.left[twin as usize] == 0 {
            return Some(own);
        }
        Some(Price { cost: own.cost.max(self.prices[twin as usize].cost), ..own })
    }

    /// The living part that mirrors the one whose last triangles die.
    pub fn twin_of_last(&self, dying: &[u32]) -> Option<u32> {
        let twin = self.twins[self.part_of_last(dying)?];
        (twin != NO_PARTNER && self.left[twin as usize] > 0).then_some(twin)
    }

    /// Whether triangles are of a small part that another one mirrors, and that is all but gone.
    pub fn are_of_last_of_twin(&self, triangles: &[u32]) -> bool {
        let part = triangles.first().and_then(|&triangle| self.part_of.get(triangle as usize));
        part.is_some_and(|&part| {
            let size = self.scenery.of_part[part as usize].len();
            let small = size * SMALL <= self.part_of.len() && self.left[part as usize] <= LAST_OF_TWIN;
            self.twins[part as usize] != NO_PARTNER && small
        })
    }

    /// Triangles of a part at full detail, how many of them are left.
    pub fn triangles_of(&self, part: u32) -> (&[u32], u32) {
        (&self.scenery.of_part[part as usize], self.left[part as usize])
    }

    /// The part of which these triangles are all that is left.
    fn part_of_last(&self, dying: &[u32]) -> Option<usize> {
        let part = *self.part_of.get(*dying.first()? as usize)? as usize;
        (self.left[part] as usize == dying.len()).then_some(part)
    }

    /// A triangle died.
    pub fn remove(&mut self, triangle: u32) {
        let Some(&part) = self.part_of.get(triangle as usize) else { return };
        self.left[part as usize] -= 1;
        if self.left[part as usize] == 0 {
            self.follow(part);
        }
    }

    /// A part vanished: what it stood for is shown by what lay behind it, and what it lay behind looks for something else.
    fn follow(&mut self, part: u32) {
        self.scenery.remove(part);
        let shown = std::mem::take(&mut self.shown[part as usize]);
        let mut looking: Vec<u32> = Vec::new();
        for i in shown {
            let point = &mut self.points[i as usize];
            point.paid = point.paid.max(point.cost);
            point.shown_by = point.next;
            // What the largest part stands for is safe.
            if self.prices[point.next as usize].cost.is_finite() {
                self.shown[point.next as usize].push(i);
                looking.push(i);
            }
        }
        let backed = std::mem::take(&mut self.backed[part as usize]);
        looking.extend(backed.into_iter().filter(|&i| {
            let point = &self.points[i as usize];
            point.next == part && self.prices[point.shown_by as usize].cost.is_finite()
        }));
        looking.sort_unstable();
        looking.dedup();
        if looking.len() > self.searches_left {
            return;
        }
        self.searches_left -= looking.len();
        let mut touched: Vec<u32> = Vec::new();
        for i in looking {
            let Watched { position, shown_by, .. } = self.points[i as usize];
            let wanted = |other: u32| other != shown_by && self.left[other as usize] > 0;
            let Some((off, next)) = self.scenery.look(position, wanted) else { continue };
            let point = &mut self.points[i as usize];
            (point.cost, point.next) = (off.all, next);
            point.distance = point.distance.max(off.distance);
            self.backed[next as usize].push(i);
            touched.push(shown_by);
        }
        touched.sort_unstable();
        touched.dedup();
        for part in touched {
            let shown = &self.shown[part as usize];
            if shown.len() <= self.sums_left {
                self.sums_left -= shown.len();
                self.prices[part as usize] = price(shown, &self.points);
            }
        }
    }
}

/// What it costs to lose some points.
fn price(shown: &[u32], points: &[Watched]) -> Price {
    let sum = |one: &dyn Fn(&Watched) -> f32| shown.iter().map(|&i| one(&points[i as usize])).sum();
    Price {
        cost: sum(&|point| point.area * (point.cost - point.paid).max(0.0)),
        distance: sum(&|point| point.area * point.distance),
        area: sum(&|point| point.area),
    }
}

/// Points of all parts behind which something was found: all positions of a part, or as many as are watched, with its area.
fn watch(part_of_position: &[u32], areas: &[f32], found: &[Option<(Off, u32)>]) -> Vec<Watched> {
    let mut by_part: Vec<u32> = (0..found.len() as u32).filter(|&p| found[p as usize].is_some()).collect();
    by_part.sort_by_key(|&p| part_of_position[p as usize]);
    let mut points = Vec::new();
    for part in by_part.chunk_by(|&a, &b| part_of_position[a as usize] == part_of_position[b as usize]) {
        let chosen = || part.iter().copied().step_by(part.len().div_ceil(MOST_WATCHED));
        let sum = |positions: &mut dyn Iterator<Item = u32>| positions.map(|p| areas[p as usize]).sum::<f32>();
        let (whole, watched) = (sum(&mut part.iter().copied()), sum(&mut chosen()));
        let scale = if watched > 0.0 { whole / watched } else { 1.0 };
        points.extend(chosen().filter_map(|position| {
            let (off, next) = found[position as usize]?;
            let (area, shown_by) = (areas[position as usize] * scale, part_of_position[position as usize]);
            Some(Watched { position, area, shown_by, next, paid: 0.0, cost: off.all, distance: off.distance })
        }));
    }
    points
}

/// For each position, the area of the triangles around it: what its quadric stands for.
fn areas_of(places: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let mut areas = vec![0.0; places.len()];
    for t in triangles {
        let [a, b, c] = t.map(|p| places[p as usize]);
        let n = cross(sub(b, a), sub(c, a));
        let area = dot(n, n).sqrt() / 2.0;
        t.iter().for_each(|&p| areas[p as usize] += area);
    }
    areas
}

/// For each position, the lowest position that it hangs together with.
fn number_parts(position_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..position_count as u32).collect();
    let root = |parents: &mut Vec<u32>, mut at: u32| {
        while parents[at as usize] != at {
            parents[at as usize] = parents[parents[at as usize] as usize];
            at = parents[at as usize];
        }
        at
    };
    for t in triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2])] {
            let (a, b) = (root(&mut parents, a), root(&mut parents, b));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    (0..position_count as u32).map(|p| root(&mut parents, p)).collect()
}

/// For each position, the mean colour of its variants.
fn shown_colors(mesh: &LodMesh<'_>, split: &SplitMesh) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0_f32; 4]; split.position_source.len()];
    for (v, &source) in split.variant_source.iter().enumerate() {
        let sum = &mut sums[split.position_of(v as u32) as usize];
        let color = match mesh.appearance.shown_colors.get(source as usize) {
            Some(&color) => color,
            None => [0, 1, 2].map(|i| f32::from(mesh.colors[source as usize][i]) / 255.0),
        };
        for i in 0..3 {
            sum[i] += color[i];
        }
        sum[3] += 1.0;
    }
    sums.into_iter().map(|s| [0, 1, 2].map(|i| s[i] / s[3].max(1.0))).collect()
}

/// Length of the diagonal of the box around the positions in use, metres.
pub(crate) fn diagonal(places: &[[f32; 3]]) -> f32 {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for place in places {
        for i in 0..3 {
            low[i] = low[i].min(place[i]);
            high[i] = high[i].max(place[i]);
        }
    }
    let d = sub(high, low);
    if places.is_empty() { 0.0 } else { dot(d, d).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split_seams::split_seams;
    use crate::test_meshes::{TestMesh, uv_sphere};

    /// A ball, a lump beside it and a lump on that one, and what lies behind them. Each lump has a triangle named: the near one's, the far one's.
    fn lumps() -> (TestMesh, [u32; 2]) {
        let mut mesh = uv_sphere(24, 16);
        let mut named = [0; 2];
        for (i, named) in named.iter_mut().enumerate() {
            *named = mesh.triangles.len() as u32;
            let mut lump = uv_sphere(6, 4);
            lump.positions.iter_mut().for_each(|p| *p = [p[0] * 0.1 + 3.0 + 0.07 * i as f32, p[1] * 0.1, p[2] * 0.1]);
            mesh.append(&lump);
        }
        (mesh, named)
    }

    fn behind(mesh: &TestMesh) -> (Behind, Vec<u32>) {
        let split = split_seams(&mesh.mesh());
        let places = split.position_source.iter().map(|&v| mesh.positions[v as usize]).collect();
        let weights = AttributeWeights { uv: 0.0, normal: 0.0, color: 0.0, layers: 0.0 };
        (Behind::measure(&mesh.mesh(), &split, &[], [places], &weights, 4.0), split.triangle_source.clone())
    }

    /// Removes the part of a triangle. Returns its price.
    fn vanish(behind: &mut Behind, sources: &[u32], triangle: u32) -> Price {
        let part = behind.part_of[sources.iter().position(|&t| t == triangle).expect("no triangle is degenerate")];
        let of_part: Vec<u32> = (0..sources.len() as u32).filter(|&t| behind.part_of[t as usize] == part).collect();
        let price = behind.price_of_last(&of_part).expect("the whole part");
        of_part.iter().for_each(|&t| behind.remove(t));
        price
    }

    #[test]
    fn what_lay_behind_stands_for_what_vanished() {
        let (mesh, [near, far]) = lumps();
        let (mut behind, sources) = behind(&mesh);
        let first = vanish(&mut behind, &sources, near);
        let second = vanish(&mut behind, &sources, far);
        assert!(first.cost < 0.02 * first.area, "the other lump is behind it: {first:?}");
        assert!(second.distance > 3.0 * second.area, "nothing but the ball, some 2 m off: {second:?}");
        assert!((second.area - 2.0 * first.area).abs() < 1.0e-3 * second.area, "{first:?} {second:?}");
    }

    #[test]
    fn parts_vanish_unfollowed_when_the_searches_are_spent() {
        let (mesh, [near, far]) = lumps();
        let (mut behind, sources) = behind(&mesh);
        behind.searches_left = 0;
        let first = vanish(&mut behind, &sources, near);
        let second = vanish(&mut behind, &sources, far);
        assert!((second.area - first.area).abs() < 1.0e-3 * first.area && first.cost > 0.0, "{first:?} {second:?}");
        assert!(behind.searches_left == 0 && second.distance < 0.02 * second.area, "priced as at first: {second:?}");
    }

    #[test]
    fn a_twin_follows_at_any_price_once_few_triangles_are_left() {
        // A ball of more than fifty times as many triangles as each of the two lumps on its sides.
        let mut mesh = uv_sphere(80, 60);
        for side in [-1.0, 1.0] {
            let mut lump = uv_sphere(6, 5);
            lump.positions.iter_mut().for_each(|p| *p = [side * (p[0] * 0.1 + 1.2), p[1] * 0.1, p[2] * 0.1]);
            mesh.append(&lump);
        }
        let (mut behind, sources) = behind(&mesh);
        let last = sources.iter().max().copied().expect("triangles");
        let lump = behind.part_of[sources.iter().position(|&t| t == last).expect("no triangle is degenerate")];
        let of_lump: Vec<u32> = (0..sources.len() as u32).filter(|&t| behind.part_of[t as usize] == lump).collect();
        let other = behind.part_of[of_lump[0] as usize - of_lump.len()];
        (behind.twins[lump as usize], behind.twins[other as usize]) = (other, lump);
        assert!(other != lump && of_lump.len() as u32 > LAST_OF_TWIN, "{other} {lump} {}", of_lump.len());
        let mut follow = Vec::new();
        for &triangle in &of_lump {
            follow.push((behind.left[lump as usize], behind.are_of_last_of_twin(&of_lump[..1])));
            behind.remove(triangle);
        }
        assert!(follow.iter().all(|&(left, follows)| follows == (left <= LAST_OF_TWIN)), "{follow:?}");
        assert!(!behind.are_of_last_of_twin(&[0]), "the ball has no twin");
    }

    #[test]
    fn nothing_is_asked_of_an_empty_one() {
        let mut behind = Behind::default();
        behind.remove(3);
        assert_eq!((behind.price_of_last(&[3]), behind.loss(3)), (None, f32::INFINITY));
    }
}
