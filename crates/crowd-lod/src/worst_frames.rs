//! Finds the frames in which levels lie farthest from full detail, without measuring all of them.
//!
//! A vertex that a level lacks is not farther from the level than from any one of its triangles: the one closest at rest
//! gives a distance from above in every frame for the price of one triangle.

use crate::closest::{ClosestTriangles, triangle_distance_squared};
use crate::quadrics::pose_position;
use crate::{LodPoses, Surface};
use rayon::prelude::*;

/// Vertices looked at for each level, spread over those it lacks.
const VERTICES: usize = 300;
/// Frames looked at, spread over all.
const FRAMES: usize = 512;

/// A vertex of full detail and the corners of the triangle it is held against, as places in a list of vertices to pose.
type Pair = [u32; 4];

/// For each level the frame in which it is worst; rising, each once, without those in `known`.
///
/// `levels`: triangles over the vertices of `full`. Of long motions some frames are left out. The frames are those that seem worst by an estimate from above: whoever
/// wants the distance measures them.
pub fn worst_frames(full: &Surface<'_>, levels: &[&[[u32; 3]]], poses: &LodPoses<'_>, known: &[u32]) -> Vec<u32> {
    let frame_count = poses.palettes.len() / poses.joint_count.max(1);
    let mut posed = PosedSome { place: vec![u32::MAX; full.positions.len()], vertices: Vec::new() };
    let pairs: Vec<Vec<Pair>> = levels.iter().map(|level| pair_up(full, level, &mut posed)).collect();
    let step = frame_count.div_ceil(FRAMES).max(1);
    let looked_at: Vec<usize> = (0..frame_count).step_by(step).collect();
    let scores: Vec<Vec<f32>> = looked_at
        .par_iter()
        .map(|&frame| {
            let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
            let pose = |&v: &u32| {
                let v = v as usize;
                pose_position(full.positions[v], full.joints[v], full.weights[v], palette)
            };
            let places: Vec<[f32; 3]> = posed.vertices.iter().map(pose).collect();
            let far = |[v, a, b, c]: &Pair| {
                triangle_distance_squared(places[*v as usize], [*a, *b, *c].map(|corner| places[corner as usize]))
            };
            pairs.iter().map(|level| level.iter().map(far).fold(0.0, f32::max)).collect()
        })
        .collect();
    let mut chosen: Vec<u32> = Vec::new();
    for level in 0..levels.len() {
        let free = |&at: &usize| {
            let frame = looked_at[at] as u32;
            !known.contains(&frame) && !chosen.contains(&frame)
        };
        let rank = |&a: &usize, &b: &usize| scores[a][level].total_cmp(&scores[b][level]).then(b.cmp(&a));
        let worst = (0..looked_at.len()).filter(free).max_by(rank).filter(|&at| scores[at][level] > 0.0);
        chosen.extend(worst.map(|at| looked_at[at] as u32));
    }
    chosen.sort_unstable();
    chosen
}

/// The vertices that need a pose, each once.
struct PosedSome {
    place: Vec<u32>,
    vertices: Vec<u32>,
}

impl PosedSome {
    fn add(&mut self, vertex: u32) -> u32 {
        let place = &mut self.place[vertex as usize];
        if *place == u32::MAX {
            *place = self.vertices.len() as u32;
            self.vertices.push(vertex);
        }
        *place
    }
}

/// Some of the vertices that a level lacks, each with the level's triangle that is closest at rest.
fn pair_up(full: &Surface<'_>, level: &[[u32; 3]], posed: &mut PosedSome) -> Vec<Pair> {
    let mut kept = vec![false; full.positions.len()];
    level.as_flattened().iter().for_each(|&v| kept[v as usize] = true);
    let mut lost: Vec<u32> = full.triangles.as_flattened().iter().copied().filter(|&v| !kept[v as usize]).collect();
    lost.sort_unstable();
    lost.dedup();
    let mut tree = ClosestTriangles::new(full.positions, level);
    tree.refit(full.positions, level);
    let step = lost.len().div_ceil(VERTICES).max(1);
    let pair = |&v: &u32| {
        let (triangle, _) = tree.closest(full.positions[v as usize], full.positions, level, u32::MAX)?;
        let [a, b, c] = level[triangle as usize];
        Some([v, a, b, c].map(|vertex| posed.add(vertex)))
    };
    lost.iter().step_by(step).filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{REST, TestPoses, grid};

    #[test]
    fn the_frame_that_stretches_most_is_worst() {
        let mesh = grid(2, 2, |x, y| if x == 1 && y == 1 { 1.0 } else { 0.0 }, |_, _| false);
        let corner = |x: f32, y: f32| {
            mesh.positions.iter().position(|p| p[0] == x && p[1] == y).expect("a corner of the grid") as u32
        };
        let (a, b, c, d) = (corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 2.0), corner(0.0, 2.0));
        let flat = [[a, b, c], [a, c, d]];
        let tall = |by: f32| [REST[0], REST[1], REST[2].map(|c| c * by)];
        let poses = TestPoses::even(vec![REST, tall(2.0), tall(5.0), tall(3.0)], 1);
        let full = mesh.surface();
        assert_eq!(worst_frames(&full, &[&flat], &poses.poses(), &[]), [2]);
        // Known frames are not named again, and two levels name two frames.
        assert_eq!(worst_frames(&full, &[&flat], &poses.poses(), &[2]), [3]);
        assert_eq!(worst_frames(&full, &[&flat, &flat], &poses.poses(), &[]), [2, 3]);
        // Full detail lacks nothing.
        assert!(worst_frames(&full, &[&mesh.triangles], &poses.poses(), &[]).is_empty());
    }
}
