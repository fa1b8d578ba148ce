//! Measures where the layers of a character have changed places: a head that comes through its helmet, a shirt through
//! its coat.
//!
//! A *layer* is a surface of its own: triangles joined by shared places. A point of full detail is *covered* when a line along
//! its normal leaves the character through the front of another layer within reach: who looks from there sees that one. It is
//! *poked through* when on that same line the level shows the point's own layer outermost, with one of the covering
//! layers behind it. Only fronts count, so a lining is neither cover nor covered. What lies crosswise in the source
//! already counts for nothing: each point is compared with its own order at full detail, in the same pose. A cover that
//! withdraws leaves a bare spot, which is no interpenetration: the distance measures see it.

use crate::closest::ClosestTriangles;
use crate::measure::{Sample, spread_samples};
use crate::quadrics::{cross, dot, pose_position, sub};
use crate::{LodPoses, Mat3x4};
use rayon::prelude::*;

/// How far layers are looked for along a normal, as a share of the character's diagonal in bind pose.
pub(crate) const REACH_SHARE: f32 = 0.05;
/// Layers closer than this share of the diagonal lie on each other and are in no order.
pub(crate) const CONTACT_SHARE: f32 = 1.0e-5;

/// A skinned mesh whose triangles belong to layers.
#[derive(Debug, Clone, Copy)]
pub struct LayeredMesh<'a> {
    /// Bind-space positions, metres.
    pub positions: &'a [[f32; 3]],
    /// Joint indices, one entry per position, below the poses' `joint_count`.
    pub joints: &'a [[u16; 4]],
    /// Weights, one entry per position.
    pub weights: &'a [[f32; 4]],
    /// Indices into `positions`.
    pub triangles: &'a [[u32; 3]],
    /// Layer of each triangle, as [`find_layers`] numbers them at full detail. A level of a
    /// [`crate::CollapseOrder`] has those of the order's triangles, as many as it keeps.
    pub triangle_layers: &'a [u32],
}

/// How much of a character's surface has come out through a layer that covers it at full detail.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Interpenetration {
    /// Area poked through, mean over the frames, m² of the bind pose.
    pub mean_area_m2: f32,
    /// The same as a share of the whole surface, 0..=1.
    pub mean_share: f32,
    /// Largest share in one frame.
    pub max_share: f32,
    /// Frame of the largest, an index into the poses given.
    pub max_frame: u32,
    /// Share of the surface that another layer covers at full detail, mean over the frames: what could poke through.
    pub covered_share: f32,
}

/// Numbers the surfaces that hang together: triangles that share a place belong to one layer.
///
/// Returns one number per triangle, counted from 0 in the order in which triangles begin a new layer. Places are equal when
/// their bind positions are, whatever else differs.
///
/// Panics if an index lies outside `positions`.
pub fn find_layers(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<u32> {
    let key = |v: u32| positions[v as usize].map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.par_sort_unstable_by_key(|&v| (key(v), v));
    let mut toward_root: Vec<u32> = (0..positions.len() as u32).collect();
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &v in group {
            toward_root[v as usize] = group[0];
        }
    }
    join(toward_root, triangles)
}

/// The same where equal places have one number already.
pub(crate) fn layers_of_places(place_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    join((0..place_count as u32).collect(), triangles)
}

/// Numbers what triangles join. `toward_root`: for each vertex a lower one that it hangs together with, or itself.
fn join(mut toward_root: Vec<u32>, triangles: &[[u32; 3]]) -> Vec<u32> {
    for &[a, b, c] in triangles {
        for (one, other) in [(a, b), (b, c)] {
            let (one, other) = (root(&mut toward_root, one), root(&mut toward_root, other));
            toward_root[one.max(other) as usize] = one.min(other);
        }
    }
    let mut number = vec![u32::MAX; toward_root.len()];
    let mut count = 0;
    let mut layer_of = |t: &[u32; 3]| {
        let number = &mut number[root(&mut toward_root, t[0]) as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        *number
    };
    triangles.iter().map(&mut layer_of).collect()
}

fn root(toward_root: &mut [u32], mut at: u32) -> u32 {
    while toward_root[at as usize] != at {
        toward_root[at as usize] = toward_root[toward_root[at as usize] as usize];
        at = toward_root[at as usize];
    }
    at
}

/// Measures what has poked through at each of some levels, over the frames given.
///
/// `frames`: indices into `poses`, each counted alike; [`crate::measured_frames`] chooses some. `samples_per_frame`
/// points are spread over full detail by its area in bind pose and looked at in every frame; a share is thus known to
/// about `1 / samples_per_frame`. Levels may have vertices of their own (refitted ones do). One result per level; all
/// zero where nothing covers anything.
///
/// Panics if an index lies outside its slice.
///
/// Cost: a line through full detail per sample and frame, and one through each level where the sample is covered.
pub fn measure_interpenetration(
    full: &LayeredMesh<'_>,
    levels: &[LayeredMesh<'_>],
    poses: &LodPoses<'_>,
    frames: &[usize],
    samples_per_frame: u32,
) -> Vec<Interpenetration> {
    let none = vec![Interpenetration::default(); levels.len()];
    let samples = spread_samples(full.positions, full.triangles, samples_per_frame);
    if samples.is_empty() || frames.is_empty() || full.triangle_layers.iter().all(|&layer| layer == 0) {
        return none;
    }
    let diagonal = diagonal_of(full);
    let (reach, contact) = (REACH_SHARE * diagonal, CONTACT_SHARE * diagonal);
    let full_tree = ClosestTriangles::new(full.positions, full.triangles);
    let level_trees: Vec<ClosestTriangles> =
        levels.par_iter().map(|level| ClosestTriangles::new(level.positions, level.triangles)).collect();

    // Covered samples, and for each level those poked through, by frame.
    let by_frame: Vec<(u32, Vec<u32>)> = frames
        .par_iter()
        .map(|&frame| {
            let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
            let posed_full = PosedMesh::new(full, &full_tree, palette);
            let covered: Vec<CoveredPoint> =
                samples.iter().filter_map(|sample| posed_full.cover(sample, reach, contact)).collect();
            let count_poked = |(level, tree): (&LayeredMesh<'_>, &ClosestTriangles)| {
                let posed = PosedMesh::new(level, tree, palette);
                covered.iter().filter(|point| posed.is_poked_through(point, reach, contact)).count() as u32
            };
            let poked = levels.par_iter().zip(&level_trees).map(count_poked).collect();
            (covered.len() as u32, poked)
        })
        .collect();

    let sample_count = samples.len() as f64;
    let area = area_of(full);
    let observed = sample_count * frames.len() as f64;
    let covered_share = (by_frame.iter().map(|f| f64::from(f.0)).sum::<f64>() / observed) as f32;
    let summed = |level: usize| {
        let mean = by_frame.iter().map(|f| f64::from(f.1[level])).sum::<f64>() / observed;
        let mut worst = (0, 0);
        for (&frame, counts) in frames.iter().zip(&by_frame) {
            if counts.1[level] > worst.0 {
                worst = (counts.1[level], frame);
            }
        }
        Interpenetration {
            mean_area_m2: (mean * area) as f32,
            mean_share: mean as f32,
            max_share: (f64::from(worst.0) / sample_count) as f32,
            max_frame: worst.1 as u32,
            covered_share,
        }
    };
    (0..levels.len()).map(summed).collect()
}

/// A point of full detail that other layers cover, in one pose.
struct CoveredPoint {
    origin: [f32; 3],
    /// Unit normal of full detail.
    outward: [f32; 3],
    layer: u32,
    covers: Vec<u32>,
}

/// A mesh in one pose, ready for lines.
struct PosedMesh<'a> {
    mesh: &'a LayeredMesh<'a>,
    positions: Vec<[f32; 3]>,
    tree: ClosestTriangles,
}

impl<'a> PosedMesh<'a> {
    fn new(mesh: &'a LayeredMesh<'a>, tree: &ClosestTriangles, palette: &[Mat3x4]) -> Self {
        let pose = |i: usize| pose_position(mesh.positions[i], mesh.joints[i], mesh.weights[i], palette);
        let positions: Vec<[f32; 3]> = (0..mesh.positions.len()).map(pose).collect();
        let mut tree = tree.clone();
        tree.refit(&positions, mesh.triangles);
        Self { mesh, positions, tree }
    }

    /// The outermost fronts of all layers on a line, within `reach` of its origin to both sides.
    fn layers_on_line(&self, origin: [f32; 3], outward: [f32; 3], reach: f32) -> Vec<(u32, f32)> {
        let mut outermost: Vec<(u32, f32)> = Vec::new();
        self.tree.leaving_line(origin, outward, reach, &self.positions, self.mesh.triangles, |triangle, height| {
            let layer = self.mesh.triangle_layers[triangle as usize];
            match outermost.iter_mut().find(|known| known.0 == layer) {
                Some(known) => known.1 = known.1.max(height),
                None => outermost.push((layer, height)),
            }
        });
        outermost
    }

    /// The sample with what covers it, if anything does.
    fn cover(&self, sample: &Sample, reach: f32, contact: f32) -> Option<CoveredPoint> {
        let [a, b, c] = self.mesh.triangles[sample.triangle as usize].map(|v| self.positions[v as usize]);
        let normal = cross(sub(b, a), sub(c, a));
        let length = dot(normal, normal).sqrt();
        if length <= f32::MIN_POSITIVE {
            return None;
        }
        let outward = normal.map(|n| n / length);
        let [s, t] = sample.weights;
        let origin = [0, 1, 2].map(|i| s * a[i] + t * b[i] + (1.0 - s - t) * c[i]);
        let layer = self.mesh.triangle_layers[sample.triangle as usize];
        let found = self.layers_on_line(origin, outward, reach);
        let own = found.iter().filter(|known| known.0 == layer).fold(0.0, |own: f32, known| own.max(known.1));
        let covers: Vec<u32> =
            found.iter().filter(|known| known.0 != layer && known.1 > own + contact).map(|known| known.0).collect();
        (!covers.is_empty()).then_some(CoveredPoint { origin, outward, layer, covers })
    }

    /// Whether the point's own layer lies outside all of its covers here, and one of them behind it.
    fn is_poked_through(&self, point: &CoveredPoint, reach: f32, contact: f32) -> bool {
        let (mut own, mut cover) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        for (layer, height) in self.layers_on_line(point.origin, point.outward, reach) {
            if layer == point.layer {
                own = height;
            } else if point.covers.contains(&layer) {
                cover = cover.max(height);
            }
        }
        cover > f32::NEG_INFINITY && own > cover + contact
    }
}

fn diagonal_of(mesh: &LayeredMesh<'_>) -> f32 {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]) {
        low = [0, 1, 2].map(|i| low[i].min(p[i]));
        high = [0, 1, 2].map(|i| high[i].max(p[i]));
    }
    let extent = sub(high, low);
    dot(extent, extent).sqrt()
}

fn area_of(mesh: &LayeredMesh<'_>) -> f64 {
    let doubled = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let normal = cross(sub(b, a), sub(c, a));
        f64::from(dot(normal, normal).sqrt())
    });
    0.5 * doubled.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{REST, TestMesh, TestPoses, uv_sphere};

    /// A mesh and the layer of each of its triangles.
    fn layered<'a>(mesh: &'a TestMesh, layers: &'a [u32]) -> LayeredMesh<'a> {
        LayeredMesh {
            positions: &mesh.positions,
            joints: &mesh.joints,
            weights: &mesh.weights,
            triangles: &mesh.triangles,
            triangle_layers: layers,
        }
    }

    fn measure(full: &TestMesh, level: &TestMesh, poses: &TestPoses) -> Interpenetration {
        let full_layers = find_layers(&full.positions, &full.triangles);
        let level_layers = find_layers(&level.positions, &level.triangles);
        let frames: Vec<usize> = (0..poses.frame_weights.len()).collect();
        let (full, level) = (layered(full, &full_layers), layered(level, &level_layers));
        measure_interpenetration(&full, &[level], &poses.poses(), &frames, 4000)[0]
    }

    /// A square metre at the heights given: at x = 0 and at x = 1. Faces +z.
    fn sheet(near: f32, far: f32) -> TestMesh {
        let mut mesh = TestMesh::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            mesh.vertex([x, y, if x == 0.0 { near } else { far }], [x, y]);
        }
        mesh.quad([0, 1, 2, 3]);
        mesh
    }

    fn stack(sheets: &[TestMesh]) -> TestMesh {
        let mut mesh = TestMesh::default();
        sheets.iter().for_each(|sheet| mesh.append(sheet));
        mesh
    }

    fn scaled(mut mesh: TestMesh, factor: f32) -> TestMesh {
        mesh.positions.iter_mut().for_each(|p| *p = p.map(|c| c * factor));
        mesh
    }

    /// ```text
    ///            ____----  tilted cover: from -0.02 to 0.06, through the sheet at a quarter of its width
    ///  ====x=============  sheet at 0, covered by one at 0.03 at full detail
    /// ----
    /// ```
    #[test]
    fn a_tilted_cover_shows_a_quarter_of_the_sheet() {
        let full = stack(&[sheet(0.0, 0.0), sheet(0.03, 0.03)]);
        let level = stack(&[sheet(0.0, 0.0), sheet(-0.02, 0.06)]);
        let found = measure(&full, &level, &TestPoses::rest());
        assert!((found.mean_share - 0.125).abs() < 0.002, "a quarter of one of two square metres: {found:?}");
        assert!((found.mean_area_m2 - 0.25).abs() < 0.004, "{found:?}");
        assert!((found.covered_share - 0.5).abs() < 0.002, "{found:?}");
        assert_eq!(found.max_share, found.mean_share);
    }

    #[test]
    fn full_detail_pokes_through_nowhere() {
        let full = stack(&[uv_sphere(32, 24), scaled(uv_sphere(32, 24), 1.04)]);
        let found = measure(&full, &full, &TestPoses::rest());
        assert_eq!((found.mean_share, found.max_share), (0.0, 0.0));
        assert!((found.covered_share - 0.48).abs() < 0.01, "the inner sphere: {found:?}");
    }

    /// The sagitta of an octagon, 7.6 % of its radius, is more than the gap of 4 %.
    #[test]
    fn a_coarse_shell_shows_the_ball_inside() {
        let ball = uv_sphere(32, 24);
        let full = stack(&[ball.clone(), scaled(uv_sphere(32, 24), 1.04)]);
        let coarse = stack(&[ball.clone(), scaled(uv_sphere(8, 8), 1.04)]);
        let found = measure(&full, &coarse, &TestPoses::rest());
        assert!((0.1..0.4).contains(&found.mean_share), "{found:?}");
        // Where the ball shrinks as much, it stays inside.
        let both = stack(&[uv_sphere(8, 8), scaled(uv_sphere(8, 8), 1.04)]);
        assert_eq!(measure(&full, &both, &TestPoses::rest()).mean_share, 0.0);
    }

    #[test]
    fn what_crosses_in_the_source_counts_for_nothing() {
        let full = stack(&[sheet(0.0, 0.0), sheet(-0.01, 0.03)]);
        assert_eq!(measure(&full, &full, &TestPoses::rest()).mean_share, 0.0);
        let turned = stack(&[sheet(0.0, 0.0), sheet(0.03, -0.01)]);
        let found = measure(&full, &turned, &TestPoses::rest());
        // Three quarters of the sheet were covered, of which the last quarter of its width is not any more; and a quarter of
        // the tilted one was under the sheet and lies above it now.
        assert!((found.mean_share - 0.25).abs() < 0.004, "{found:?}");
    }

    #[test]
    fn inside_the_wall_of_a_thick_cover_nothing_shows() {
        let wall = |low: f32, high: f32| {
            let mut bottom = sheet(low, low);
            bottom.triangles.iter_mut().for_each(|t| t.reverse());
            let mut mesh = stack(&[bottom, sheet(high, high)]);
            // One layer: the two faces hang together at one side.
            mesh.quad([1, 2, 6, 5]);
            mesh
        };
        let full = stack(&[sheet(0.0, 0.0), wall(0.02, 0.05)]);
        let within = stack(&[sheet(0.03, 0.03), wall(0.02, 0.05)]);
        assert_eq!(measure(&full, &within, &TestPoses::rest()).mean_share, 0.0);
        let beyond = stack(&[sheet(0.06, 0.06), wall(0.02, 0.05)]);
        assert!(measure(&full, &beyond, &TestPoses::rest()).mean_share > 0.3);
    }

    #[test]
    fn a_cover_that_withdraws_is_a_bare_spot_and_no_poking_through() {
        let full = stack(&[sheet(0.0, 0.0), sheet(0.03, 0.03)]);
        let mut level = full.clone();
        level.positions[4..].iter_mut().for_each(|p| p[0] += 2.0);
        let found = measure(&full, &level, &TestPoses::rest());
        assert_eq!(found.mean_share, 0.0);
        assert!(found.covered_share > 0.4);
    }

    /// In the second frame joint 1 lifts the inner sheet by 0.05, and with it the cover at full detail, which the level has
    /// left behind on joint 0.
    #[test]
    fn a_frame_alone_can_poke_through_and_is_named() {
        let lift = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.05]];
        let poses = TestPoses::even(vec![REST, REST, REST, lift], 2);
        let mut full = stack(&[sheet(0.0, 0.0), sheet(0.03, 0.03)]);
        full.joints.fill([1, 0, 0, 0]);
        let mut level = full.clone();
        assert_eq!(measure(&full, &level, &poses).mean_share, 0.0);
        level.joints[4..].fill([0; 4]);
        let found = measure(&full, &level, &poses);
        assert_eq!(found.max_frame, 1);
        assert!((found.max_share - 0.5).abs() < 0.002 && (found.mean_share - 0.25).abs() < 0.001, "{found:?}");
    }

    #[test]
    #[should_panic(expected = "nothing pokes through")]
    fn swapped_sheets_are_not_passed_over() {
        let full = stack(&[sheet(0.0, 0.0), sheet(0.03, 0.03)]);
        let swapped = stack(&[sheet(0.03, 0.03), sheet(0.0, 0.0)]);
        let found = measure(&full, &swapped, &TestPoses::rest());
        assert_eq!(found.mean_share, 0.0, "nothing pokes through");
    }

    #[test]
    fn one_layer_and_nothing_measure_zero() {
        let ball = uv_sphere(8, 8);
        assert_eq!(measure(&ball, &uv_sphere(5, 4), &TestPoses::rest()), Interpenetration::default());
        let nothing = TestMesh::default();
        assert_eq!(measure(&nothing, &nothing, &TestPoses::rest()), Interpenetration::default());
    }

    #[test]
    fn layers_are_what_hangs_together_by_place() {
        let mut mesh = stack(&[sheet(0.0, 0.0), sheet(1.0, 1.0), sheet(0.0, 0.0)]);
        assert_eq!(find_layers(&mesh.positions, &mesh.triangles), [0, 0, 1, 1, 0, 0]);
        mesh.triangle([0, 5, 1]);
        assert_eq!(find_layers(&mesh.positions, &mesh.triangles), [0; 7]);
    }
}
