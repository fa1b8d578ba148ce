//! Finds the frame in which a level with vertices of its own lies farther from full detail than was measured.
//!
//! Moved vertices are worst elsewhere than those of the order, one alone perhaps, in one frame. So all of them are looked at: a point is
//! not farther from a surface than from the triangle that is closest to it at rest, and only where that is too far it is searched.

use crate::closest::{ClosestTriangles, corners_of, distances_squared};
use crate::measure_surfaces::pose_surface;
use crate::{LodPoses, Surface};
use rayon::prelude::*;

/// Frames looked at, spread over all.
const FRAMES: usize = 512;
/// Points looked at on each side, spread over vertices and middles of triangles: more than a character has, so that hostile ones end.
const POINTS: usize = 200_000;
/// Points looked at together.
const LANES: usize = 8;

/// For each level the frame in which a vertex or the middle of a triangle, of it or of full detail, lies farther from the other surface than
/// anywhere else; none where no frame looked at has one farther than `beyond_m`.
///
/// `levels`: meshes of their own, each with its `beyond_m`. `known`: frames that were measured, of which none is named. Of long motions some
/// frames are left out.
pub fn worse_frames(
    full: &Surface<'_>,
    levels: &[(Surface<'_>, f32)],
    poses: &LodPoses<'_>,
    known: &[u32],
) -> Vec<Option<u32>> {
    let frame_count = poses.palettes.len() / poses.joint_count.max(1);
    let sides: Vec<[OneSide; 2]> =
        levels.iter().map(|(level, _)| [OneSide::new(full, level), OneSide::new(level, full)]).collect();
    let frames: Vec<usize> = (0..frame_count)
        .step_by(frame_count.div_ceil(FRAMES).max(1))
        .filter(|&frame| !known.contains(&(frame as u32)))
        .collect();
    let in_frame = |&frame: &usize| -> Vec<f32> {
        let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
        let original = pose_surface(full, palette);
        let farthest = |((level, beyond_m), [there, back]): (&(Surface<'_>, f32), &[OneSide; 2])| {
            let moved = pose_surface(level, palette);
            let far = there.farthest(beyond_m * beyond_m, &original, &moved, level.triangles);
            back.farthest(far, &moved, &original, full.triangles)
        };
        levels.iter().zip(&sides).map(farthest).collect()
    };
    let far: Vec<Vec<f32>> = frames.par_iter().map(in_frame).collect();
    let worst = |(at, (_, beyond_m)): (usize, &(Surface<'_>, f32))| {
        let rank = |&a: &usize, &b: &usize| far[a][at].total_cmp(&far[b][at]).then(b.cmp(&a));
        let worst = (0..frames.len()).max_by(rank).filter(|&frame| far[frame][at] > beyond_m * beyond_m);
        worst.map(|frame| frames[frame] as u32)
    };
    levels.iter().enumerate().map(worst).collect()
}

/// Points of one surface, against another.
struct OneSide {
    /// Three vertices, of which it is the middle; thrice the same for a vertex.
    points: Vec<[u32; 3]>,
    /// The triangle closest to each at rest.
    closest: Vec<u32>,
    tree: ClosestTriangles,
}

impl OneSide {
    fn new(from: &Surface<'_>, to: &Surface<'_>) -> Self {
        let mut vertices: Vec<u32> = from.triangles.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let all: Vec<[u32; 3]> = vertices.into_iter().map(|v| [v; 3]).chain(from.triangles.iter().copied()).collect();
        let mut tree = ClosestTriangles::new(to.positions, to.triangles);
        tree.refit(to.positions, to.triangles);
        let step = all.len().div_ceil(POINTS).max(1);
        let nearest = |point: [u32; 3]| {
            let (closest, _) = tree.closest(middle(point, from.positions), to.positions, to.triangles, u32::MAX)?;
            Some((point, closest))
        };
        let (points, closest) = all.into_iter().step_by(step).filter_map(nearest).unzip();
        Self { points, closest, tree }
    }

    /// The largest squared distance of the points, or `far` where none is farther.
    fn farthest(&self, mut far: f32, from: &[[f32; 3]], to: &[[f32; 3]], triangles: &[[u32; 3]]) -> f32 {
        let mut tree: Option<ClosestTriangles> = None;
        for (points, closest) in self.points.chunks(LANES).zip(self.closest.chunks(LANES)) {
            let mut places = [[0.0; 3]; LANES];
            let mut corners = [[[0.0; 3]; 3]; LANES];
            for lane in 0..LANES {
                let at = lane.min(points.len() - 1);
                places[lane] = middle(points[at], from);
                corners[lane] = corners_of(triangles[closest[at] as usize], to);
            }
            let above = distances_squared(&places, &corners);
            for lane in 0..points.len() {
                if above[lane] > far {
                    let tree = tree.get_or_insert_with(|| {
                        let mut tree = self.tree.clone();
                        tree.refit(to, triangles);
                        tree
                    });
                    let found = tree.close_enough(places[lane], to, triangles, closest[lane], far);
                    far = far.max(found.map_or(0.0, |(_, squared)| squared));
                }
            }
        }
        far
    }
}

fn middle([a, b, c]: [u32; 3], places: &[[f32; 3]]) -> [f32; 3] {
    let [a, b, c] = corners_of([a, b, c], places);
    [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{REST, TestMesh, TestPoses, grid};

    /// A square in two triangles with its corners on those of a finer grid, one of which moves with a joint of its own in the level alone.
    fn square_with_a_corner_astray() -> (TestMesh, TestMesh) {
        let full = grid(4, 4, |_, _| 0.0, |_, _| false);
        let mut level = grid(1, 1, |_, _| 0.0, |_, _| false);
        level.positions.iter_mut().for_each(|p| *p = p.map(|c| c * 4.0));
        level.joints[0] = [1, 0, 0, 0];
        (full, level)
    }

    #[test]
    fn the_one_frame_in_which_one_vertex_goes_astray_is_found() {
        let (full, level) = square_with_a_corner_astray();
        let lifted = |by: f32| [REST[0], REST[1], [0.0, 0.0, 1.0, by]];
        let palettes = [0.0, 0.1, 0.0, 0.5, 0.3].map(|by| [REST, lifted(by)]).concat();
        let poses = TestPoses::even(palettes, 2);
        let worse = |beyond_m: f32, known: &[u32]| {
            worse_frames(&full.surface(), &[(level.surface(), beyond_m)], &poses.poses(), known)[0]
        };
        assert_eq!(worse(0.0, &[]), Some(3));
        assert_eq!(worse(0.2, &[3]), Some(4));
        assert_eq!(worse(0.49, &[]), Some(3));
        assert_eq!(worse(0.51, &[]), None);
        assert_eq!(worse(0.31, &[0, 3]), None);
        // Both go along: nothing is farther than before.
        let stiff = TestPoses::even(vec![lifted(2.0); 4], 2);
        assert_eq!(worse_frames(&full.surface(), &[(level.surface(), 1.0e-4)], &stiff.poses(), &[]), [None]);
    }

    #[test]
    fn a_point_nearer_to_another_triangle_than_at_rest_is_not_far() {
        // The grid slides along by one: each of its vertices lies on another triangle then.
        let full = grid(4, 1, |_, _| 0.0, |_, _| false);
        let mut level = full.clone();
        level.joints.fill([1, 0, 0, 0]);
        let slid = |by: f32| [[1.0, 0.0, 0.0, by], REST[1], REST[2]];
        let poses = TestPoses::even([[REST, slid(1.0)], [REST, slid(2.0)]].concat(), 2);
        let worse =
            |beyond_m: f32| worse_frames(&full.surface(), &[(level.surface(), beyond_m)], &poses.poses(), &[])[0];
        assert_eq!(worse(2.5), None);
        assert_eq!(worse(1.5), Some(1));
        assert_eq!(worse(0.5), Some(1));
    }

    #[test]
    fn nothing_is_worse_than_nothing() {
        let (full, level) = square_with_a_corner_astray();
        let none = TestMesh::default();
        let rest = TestPoses::even(vec![REST, REST], 2);
        for (a, b) in [(&full, &none), (&none, &level), (&none, &none)] {
            assert_eq!(worse_frames(&a.surface(), &[(b.surface(), 0.0)], &rest.poses(), &[]), [None]);
        }
        let still = TestPoses::even(Vec::new(), 2);
        assert_eq!(worse_frames(&full.surface(), &[(level.surface(), 0.0)], &still.poses(), &[]), [None]);
        assert!(worse_frames(&full.surface(), &[], &rest.poses(), &[]).is_empty());
    }
}
