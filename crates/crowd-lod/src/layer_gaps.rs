//! Keeps layers in their order while they collapse: a head under its helmet, a shirt under its coat.
//!
//! Simplification envelopes (Cohen et al. 1996), by points: where at full detail one layer covers another, a point in the gap
//! between them guards both, in each of some poses. The cover should stay outside of the guard and what it covers
//! inside. How far a collapse takes a triangle past its guards, squared, times the area that they stand for, is what it
//! costs. As both keep to their sides of the same point, neither has to know where the other one is by now.

use crate::closest::{ClosestTriangles, line_crosses_triangle};
use crate::interpenetration::{CONTACT_SHARE, REACH_SHARE, layers_of_places};
use crate::measure::{Sample, spread_samples};
use crate::quadrics::{cross, dot, sub};
use crate::topology::Topology;
use rayon::prelude::*;

/// Points looked at for guards in each pose; bounds the time on fine meshes.
const MAX_SAMPLES: u32 = 8192;
/// The same for each triangle.
const SAMPLES_PER_TRIANGLE: u32 = 2;
/// Where in the gap a guard stands, as a share of the way from the covered layer to the cover. At a half or a quarter more
/// comes through: the cover is what is seen, and keeping it out costs nothing else.
const GUARD_SHARE: f32 = 0.75;
/// How much more a surface past its guards costs than the same distance from full detail (docs/decisions/0013): 30 lets a
/// third less through, but costs up to 9 % in distance on characters whose parts interlock.
const PASSED_WEIGHT: f32 = 10.0;

/// A point that a triangle should not pass.
#[derive(Debug, Clone, Copy)]
struct Guard {
    pose: u32,
    place: [f32; 3],
    /// Unit vector to the triangle's side.
    toward: [f32; 3],
    /// How far its triangle lies past it already, squared, m².
    paid: f32,
}

/// Guards and the triangles that they watch.
#[derive(Debug, Default)]
pub(crate) struct LayerGaps {
    guards: Vec<Guard>,
    /// Positions in each pose.
    posed: Vec<Vec<[f32; 3]>>,
    /// For each triangle, its guards.
    watched_by: Vec<Vec<u32>>,
    /// What a metre past a guard costs, squared: m² of area, over the poses.
    weight: f32,
}

impl LayerGaps {
    /// Looks for gaps at full detail. `posed`: positions in each pose. `weight`: what a surface past its guards costs, 1
    /// being the default; 0 sets no guards.
    pub fn find(topology: &Topology, bind: &[[f32; 3]], posed: Vec<Vec<[f32; 3]>>, weight: f32) -> Self {
        let triangles = &topology.triangle_positions;
        let layers = layers_of_places(bind.len(), triangles);
        if weight <= 0.0 || layers.iter().all(|&layer| layer == 0) || posed.is_empty() {
            return Self::default();
        }
        let wanted = (triangles.len() as u32).saturating_mul(SAMPLES_PER_TRIANGLE).min(MAX_SAMPLES);
        let samples = spread_samples(bind, triangles, wanted);
        let (area, diagonal) = (area_of(bind, triangles), crate::behind::diagonal(bind));
        let tree = ClosestTriangles::new(bind, triangles);
        let found: Vec<Vec<(u32, Guard)>> = posed
            .par_iter()
            .enumerate()
            .map(|(pose, positions)| {
                let mut tree = tree.clone();
                tree.refit(positions, triangles);
                let look = Look { tree: &tree, positions, triangles, layers: &layers, diagonal };
                samples.iter().filter_map(|sample| look.guards_at(sample, pose as u32)).flatten().collect()
            })
            .collect();
        let mut gaps = Self {
            guards: Vec::new(),
            watched_by: vec![Vec::new(); triangles.len()],
            weight: PASSED_WEIGHT * weight * area / (samples.len().max(1) * posed.len()) as f32,
            posed,
        };
        for (triangle, guard) in found.into_iter().flatten() {
            gaps.watched_by[triangle as usize].push(gaps.guards.len() as u32);
            gaps.guards.push(guard);
        }
        gaps
    }

    /// What it costs that `u` moves to `t`: how much further the triangles around it then lie past their guards, m² times m².
    pub fn charge(&self, topology: &Topology, u: u32, t: u32) -> f32 {
        if self.guards.is_empty() {
            return 0.0;
        }
        let mut sum = 0.0;
        for triangle in topology.around(u) {
            for &guard in &self.watched_by[triangle as usize] {
                let guard = &self.guards[guard as usize];
                let crossing = nearest_crossing(guard, topology, &self.posed[guard.pose as usize], u, t);
                if let Some((height, _)) = crossing {
                    sum += depth_squared(height) - guard.paid;
                }
            }
        }
        sum.max(0.0) * self.weight
    }

    /// Hands the guards around `u` on to the triangles that lie there when it has moved to `t`; before the move.
    pub fn follow(&mut self, topology: &Topology, u: u32, t: u32) {
        if self.guards.is_empty() {
            return;
        }
        let mut left: Vec<u32> = Vec::new();
        for triangle in topology.around(u) {
            left.append(&mut self.watched_by[triangle as usize]);
        }
        for guard in left {
            let at = &self.guards[guard as usize];
            let crossing = nearest_crossing(at, topology, &self.posed[at.pose as usize], u, t);
            // A guard that no triangle lies over any more has nothing left to watch.
            if let Some((height, triangle)) = crossing {
                self.guards[guard as usize].paid = depth_squared(height);
                self.watched_by[triangle as usize].push(guard);
            }
        }
    }
}

/// Squared depth of a surface that crosses a guard's line at a height above it.
fn depth_squared(height: f32) -> f32 {
    let depth = (-height).max(0.0);
    depth * depth
}

/// Of the triangles around `u` moved to `t`, the one whose crossing with the guard's line is nearest to it.
fn nearest_crossing(guard: &Guard, topology: &Topology, positions: &[[f32; 3]], u: u32, t: u32) -> Option<(f32, u32)> {
    let mut nearest: Option<(f32, u32)> = None;
    for triangle in topology.around(u).filter(|&triangle| !topology.touches(triangle, t)) {
        let corners = topology.triangle_positions[triangle as usize];
        let corners = corners.map(|p| positions[if p == u { t } else { p } as usize]);
        if let Some(height) = line_crosses_triangle(guard.place, guard.toward, corners)
            && nearest.is_none_or(|(known, _)| height.abs() < known.abs())
        {
            nearest = Some((height, triangle));
        }
    }
    nearest
}

/// One pose, ready to look for gaps.
struct Look<'a> {
    tree: &'a ClosestTriangles,
    positions: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    layers: &'a [u32],
    diagonal: f32,
}

impl Look<'_> {
    /// Two guards at one place, for the sample's triangle and for the one that covers it next.
    fn guards_at(&self, sample: &Sample, pose: u32) -> Option<[(u32, Guard); 2]> {
        let corners = self.triangles[sample.triangle as usize].map(|p| self.positions[p as usize]);
        let [a, b, c] = corners;
        let normal = cross(sub(b, a), sub(c, a));
        let length = dot(normal, normal).sqrt();
        if length <= f32::MIN_POSITIVE {
            return None;
        }
        let outward = normal.map(|n| n / length);
        let [s, t] = sample.weights;
        let origin = [0, 1, 2].map(|i| s * a[i] + t * b[i] + (1.0 - s - t) * c[i]);
        let layer = self.layers[sample.triangle as usize];
        let contact = CONTACT_SHARE * self.diagonal;
        let mut next: Option<(f32, u32)> = None;
        let mut covered_by_itself = false;
        let reach = REACH_SHARE * self.diagonal;
        self.tree.leaving_line(origin, outward, reach, self.positions, self.triangles, |triangle, height| {
            if height <= contact {
                return;
            }
            if self.layers[triangle as usize] == layer {
                covered_by_itself = true;
            } else if next.is_none_or(|(known, by)| (height, triangle) < (known, by)) {
                next = Some((height, triangle));
            }
        });
        let (height, cover) = next.filter(|_| !covered_by_itself)?;
        let place = [0, 1, 2].map(|i| origin[i] + GUARD_SHARE * height * outward[i]);
        let inward = outward.map(|c| -c);
        Some([
            (sample.triangle, Guard { pose, place, toward: inward, paid: 0.0 }),
            (cover, Guard { pose, place, toward: outward, paid: 0.0 }),
        ])
    }
}

fn area_of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f32 {
    let doubled = triangles.iter().map(|t| {
        let [a, b, c] = t.map(|p| positions[p as usize]);
        let normal = cross(sub(b, a), sub(c, a));
        f64::from(dot(normal, normal).sqrt())
    });
    (0.5 * doubled.sum::<f64>()) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split_seams::split_seams;
    use crate::test_meshes::{TestMesh, TestPoses, grid, quick, uv_sphere};
    use crate::{AttributeWeights, LayeredMesh, LodOptions, find_layers, measure_interpenetration, reform, simplify};

    /// A square of 2 x 2 quads at height 0 and a cover at 0.1 over it.
    fn covered_square() -> (Topology, Vec<[f32; 3]>) {
        let mut mesh = grid(2, 2, |_, _| 0.0, |_, _| false);
        let mut cover = mesh.clone();
        cover.positions.iter_mut().for_each(|p| p[2] = 0.1);
        mesh.append(&cover);
        let split = split_seams(&mesh.mesh());
        let places = split.position_source.iter().map(|&v| mesh.positions[v as usize]).collect();
        (Topology::new(&split), places)
    }

    fn place_at(places: &[[f32; 3]], place: [f32; 3]) -> u32 {
        places.iter().position(|&p| p == place).expect("a vertex of the squares") as u32
    }

    #[test]
    fn guards_stand_in_the_gap_and_watch_both_sides() {
        let (topology, places) = covered_square();
        let gaps = LayerGaps::find(&topology, &places, vec![places.clone()], 1.0);
        // Two samples a triangle, of which those on the lower half are covered; two guards each.
        assert_eq!(gaps.guards.len(), 2 * 16);
        for (triangle, guards) in gaps.watched_by.iter().enumerate() {
            let is_cover = places[topology.triangle_positions[triangle][0] as usize][2] > 0.0;
            for &guard in guards {
                let guard = &gaps.guards[guard as usize];
                assert!((guard.place[2] - 0.1 * GUARD_SHARE).abs() < 1.0e-6);
                assert_eq!(guard.toward, if is_cover { [0.0, 0.0, 1.0] } else { [0.0, 0.0, -1.0] });
            }
        }
        assert!(LayerGaps::find(&topology, &places, vec![places.clone()], 0.0).guards.is_empty());
    }

    /// In the pose tested the whole cover lies 0.3 below the square. The star of its middle, three of its four square metres, is
    /// past its guards by 0.3 and their height.
    #[test]
    fn charge_is_area_times_squared_depth() {
        let (mut topology, places) = covered_square();
        let mut gaps = LayerGaps::find(&topology, &places, vec![places.clone()], 1.0);
        let (u, t) = (place_at(&places, [1.0, 1.0, 0.1]), place_at(&places, [1.0, 0.0, 0.1]));
        assert_eq!(gaps.charge(&topology, u, t), 0.0, "flat: nothing passes");
        let mut sunk = places.clone();
        sunk.iter_mut().filter(|p| p[2] > 0.0).for_each(|p| p[2] = -0.3);
        gaps.posed = vec![sunk];
        let depth = 0.3 + 0.1 * GUARD_SHARE;
        let expected = PASSED_WEIGHT * 3.0 * depth * depth;
        let found = gaps.charge(&topology, u, t);
        assert!((found / expected - 1.0).abs() < 0.35, "sixteen samples know the area roughly: {found} {expected}");
        let handed: usize = gaps.watched_by.iter().map(Vec::len).sum();
        gaps.follow(&topology, u, t);
        let dying: Vec<u32> = topology.around(u).filter(|&i| topology.touches(i, t)).collect();
        dying.iter().for_each(|&i| topology.remove(i));
        let moving: Vec<u32> = topology.around(u).collect();
        topology.move_triangles(u, t, &moving);
        assert_eq!(gaps.watched_by.iter().map(Vec::len).sum::<usize>(), handed, "every guard found a triangle");
        assert!(dying.iter().all(|&i| gaps.watched_by[i as usize].is_empty()));
        let paid = gaps.guards.iter().filter(|guard| (guard.paid - depth * depth).abs() < 1.0e-5).count();
        assert!(paid > 0, "what lies past its guard has paid for it");
    }

    #[test]
    fn one_layer_has_no_guards() {
        let mesh = uv_sphere(8, 6);
        let split = split_seams(&mesh.mesh());
        let places: Vec<[f32; 3]> = split.position_source.iter().map(|&v| mesh.positions[v as usize]).collect();
        let gaps = LayerGaps::find(&Topology::new(&split), &places, vec![places.clone()], 1.0);
        assert!(gaps.guards.is_empty() && gaps.charge(&Topology::new(&split), 3, 4) == 0.0);
    }

    /// Share poked through at 10 % of a fine ball in a shell that is closer than the shell's own facets are deep there.
    fn poked_share(layers: f32, shell_radius: f32) -> f32 {
        let mut mesh: TestMesh = uv_sphere(24, 16);
        let mut shell = uv_sphere(20, 14);
        shell.positions.iter_mut().for_each(|p| *p = p.map(|c| c * shell_radius));
        mesh.append(&shell);
        let attribute_weights = AttributeWeights { layers, ..AttributeWeights::default() };
        let options = LodOptions { attribute_weights, ..quick() };
        let poses = TestPoses::rest();
        let order = simplify(&mesh.mesh(), &poses.poses(), &options, &|_| ()).expect("a valid mesh");
        let tenth = order.triangles.len() as u32 / 10;
        let level = order.levels.iter().rfind(|level| level.triangle_count <= tenth).expect("10 % is reached");
        let level_triangles = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
        let positions: Vec<_> = order.vertex_source.iter().map(|&v| mesh.positions[v as usize]).collect();
        let layers = find_layers(&positions, &order.triangles);
        let (joints, weights) = (vec![[0; 4]; positions.len()], vec![[1.0, 0.0, 0.0, 0.0]; positions.len()]);
        let full = LayeredMesh {
            positions: &positions,
            joints: &joints,
            weights: &weights,
            triangles: &order.triangles,
            triangle_layers: &layers,
        };
        let level =
            LayeredMesh { triangles: &level_triangles, triangle_layers: &layers[..level_triangles.len()], ..full };
        measure_interpenetration(&full, &[level], &poses.poses(), &[0], 4000)[0].mean_share
    }

    #[test]
    fn guards_keep_the_ball_in_its_shell() {
        // One pair of meshes is chance: three shells together.
        let all = |layers: f32| [1.02, 1.03, 1.04].map(|radius| poked_share(layers, radius)).iter().sum::<f32>();
        let (without, with) = (all(0.0), all(1.0));
        assert!(without > 0.01, "nothing to keep in: {without}");
        assert!(with < 0.8 * without, "{with} {without}");
    }
}
