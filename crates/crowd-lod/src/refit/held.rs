//! Which places of a level stay: where it already lies on full detail there is little to win and much to lose.
//!
//! Least squares spreads an error: what lay exactly would come off a little, with its normals, its seams and the shell just under it. Places at rest
//! stay; the weights of a held vertex are fitted like all others, so in the frames it may move.

use super::pairs::Pair;
use super::shape::Shape;
use crate::quadrics::dot;

/// A place stays where the level around it lies closer than this share of its whole root mean square distance.
const HELD_SHARE: f64 = 0.4;

/// Whether each place stays. `mean_squared`: distance of the whole level, both ways, before the fit.
pub(crate) fn find_held(shape: &Shape, pairs: &[Pair], mean_squared: f64) -> Vec<bool> {
    let mut around = vec![(0.0_f64, 0.0_f64); shape.places.len()];
    for pair in pairs {
        let squared = f64::from(pair.share) * f64::from(dot(pair.offset, pair.offset));
        for p in shape.corner_places(pair.triangle as usize) {
            around[p].0 += squared;
            around[p].1 += f64::from(pair.share);
        }
    }
    let limit = HELD_SHARE * HELD_SHARE * mean_squared;
    around.iter().map(|&(sum, share)| share > 0.0 && sum <= limit * share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refit::fit_places::solve_places;
    use crate::refit::full_detail::FullDetail;
    use crate::refit::pairs::Probes;
    use crate::test_meshes::{TestPoses, grid, quick};
    use crate::{level_mesh, simplify};

    #[test]
    fn all_of_an_exact_level_stays() {
        let mesh = grid(2, 2, |_, _| 0.0, |_, _| false);
        let (lod_mesh, poses) = (mesh.mesh(), TestPoses::rest());
        let order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        let level = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        let full = FullDetail::new(&lod_mesh, &poses.poses(), &order, 1);
        let shape = Shape::new(&level);
        let (mut pairs, _) = Probes::new(&full, &shape, 400).pair(&full, &shape, &shape.blend(&full.frames), false);
        let mut held = |error: f32| {
            pairs.iter_mut().for_each(|pair| pair.offset = [0.0, 0.0, error]);
            find_held(&shape, &pairs, f64::from(error * error))
        };
        assert!(held(0.0).into_iter().all(|held| held), "nothing is left to win");
        assert!(!held(0.1).into_iter().any(|held| held), "as far off as all");
    }

    #[test]
    fn where_a_level_is_off_it_moves_and_elsewhere_it_stays() {
        let mesh = grid(8, 4, |_, _| 0.0, |_, _| false);
        let (lod_mesh, poses) = (mesh.mesh(), TestPoses::rest());
        let order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        let mut level = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        level.positions.iter_mut().filter(|place| place[0] > 5.5).for_each(|place| place[2] += 0.3);
        let full = FullDetail::new(&lod_mesh, &poses.poses(), &order, 1);
        let shape = Shape::new(&level);
        let matrices = shape.blend(&full.frames);
        let (pairs, error) = Probes::new(&full, &shape, 4000).pair(&full, &shape, &matrices, false);
        let held = find_held(&shape, &pairs, error);
        let uvs: Vec<_> = level.triangles.iter().map(|t| t.map(|v| level.uvs[v as usize])).collect();
        let moves = solve_places(&full, &shape, &uvs, &matrices, (&pairs, &[]), &held);
        for ((step, held), place) in moves.iter().zip(held).zip(&shape.places) {
            match place[0] {
                x if x < 4.5 => assert!(held && *step == [0.0; 3], "{place:?}: {step:?}"),
                x if x > 5.5 => assert!(!held && step[2] < -0.1, "{place:?}: {step:?}"),
                _ => {}
            }
        }
    }
}
