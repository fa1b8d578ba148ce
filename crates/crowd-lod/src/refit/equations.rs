//! The normal equations of one triangle of the level: how its pairs pull at its corners.

use super::full_detail::FullDetail;
use super::pairs::{Contact, Pair};
use super::pulls::{mean_square, slide, tilt_heed, tilts};
use super::rims::RimPair;
use super::shape::Shape;
use crate::Mat3x4;

/// Share of the pull that also holds along the surface, where the distance alone says nothing.
pub(crate) const SLIDE_SHARE: f64 = 0.05;
/// Pull back to where a place is, relative to the mean pull on its neighbours.
const DAMPING: f64 = 1.0e-3;

/// The normal equations of a triangle: 3 x 3 blocks of 3 x 3, and the right side.
#[derive(Clone)]
pub(crate) struct Local {
    pub matrix: [[f64; 9]; 9],
    pub right: [f64; 9],
}

impl Local {
    /// Leaves nothing that pulls at these corners.
    pub fn hold(&mut self, corners: [bool; 3]) {
        for i in (0..9).filter(|i| corners[i / 3]) {
            self.right[i] = 0.0;
            self.matrix[i] = [0.0; 9];
            self.matrix.iter_mut().for_each(|row| row[i] = 0.0);
        }
    }
}

/// How the pairs of one triangle pull at the places of its corners. `uvs`: the corners' texture coordinates.
pub(crate) fn local_equations(
    full: &FullDetail<'_>,
    shape: &Shape,
    triangle: usize,
    uvs: &[[f32; 2]; 3],
    matrices: &[Vec<Mat3x4>],
    pairs: &[&Pair],
) -> Local {
    let corners = shape.triangles[triangle];
    let places = shape.corner_places(triangle).map(|p| shape.places[p]);
    let mut local = Local { matrix: [[0.0; 9]; 9], right: [0.0; 9] };
    for pair in pairs {
        let slide = slide(full, uvs, pair);
        let slide_share = if slide.is_some() { full.slide_shares[pair.full_triangle as usize] } else { SLIDE_SHARE };
        let stiff = stiffness(pair.contact, slide_share);
        let share = f64::from(pair.share);
        // Force on the point: towards its contact, and along the surface to where its texture belongs.
        let offset = pair.offset.map(f64::from);
        let mut force = [0, 1, 2].map(|i| (0..3).map(|j| stiff[i][j] * offset[j]).sum::<f64>());
        if let Some(slide) = slide {
            for i in 0..3 {
                force[i] -= slide_share * f64::from(slide[i]);
            }
        }
        // Derivative of the point by each corner's place, and the same times the stiffness.
        let slopes = [0, 1, 2].map(|k| {
            let m = &matrices[pair.frame as usize][corners[k] as usize];
            let weight = f64::from(pair.weights[k]);
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| weight * f64::from(m[row][column])))
        });
        let pulled = slopes.map(|s| multiply(&stiff, &s));
        add_tilt(&mut local, full, shape, pair, (corners, places), matrices);
        for k in 0..3 {
            for i in 0..3 {
                let pull: f64 = (0..3).map(|row| slopes[k][row][i] * force[row]).sum();
                local.right[k * 3 + i] -= share * pull;
                for l in 0..3 {
                    for j in 0..3 {
                        let product: f64 = (0..3).map(|row| slopes[k][row][i] * pulled[l][row][j]).sum();
                        local.matrix[k * 3 + i][l * 3 + j] += share * product;
                    }
                }
            }
        }
    }
    local
}

/// How much an offset counts, by direction.
pub(crate) fn stiffness(contact: Contact, slide_share: f64) -> [[f64; 3]; 3] {
    let along = |v: [f32; 3], on: f64, off: f64| {
        let v = v.map(f64::from);
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| (on - off) * v[i] * v[j] + if i == j { off } else { 0.0 }))
    };
    match contact {
        Contact::Face(normal) => along(normal, 1.0, slide_share),
        Contact::Edge(direction) => along(direction, slide_share, 1.0),
        Contact::Corner => along([0.0; 3], 1.0, 1.0),
    }
}

/// Pulls a rim towards full detail's, in bind space.
pub(crate) fn add_rim(local: &mut Local, pair: &RimPair) {
    let stiff = stiffness(pair.contact, SLIDE_SHARE);
    let share = f64::from(pair.share);
    let force = [0, 1, 2].map(|i| (0..3).map(|j| stiff[i][j] * f64::from(pair.offset[j])).sum::<f64>());
    for k in 0..3 {
        for i in 0..3 {
            local.right[k * 3 + i] -= share * f64::from(pair.weights[k]) * force[i];
            for l in 0..3 {
                let weight = share * f64::from(pair.weights[k] * pair.weights[l]);
                for j in 0..3 {
                    local.matrix[k * 3 + i][l * 3 + j] += weight * stiff[i][j];
                }
            }
        }
    }
}

/// Pulls the edges of a triangle into the plane of full detail.
fn add_tilt(
    local: &mut Local,
    full: &FullDetail<'_>,
    shape: &Shape,
    pair: &Pair,
    (corners, places): ([u32; 3], [[f32; 3]; 3]),
    matrices: &[Vec<Mat3x4>],
) {
    let Some((n, rises)) = tilts(full, pair, corners, places, matrices) else { return };
    let heed = tilt_heed(full, shape, pair, mean_square(rises));
    let share = f64::from(pair.share) * full.tilt_shares[pair.full_triangle as usize] * heed / 3.0;
    // How each corner's height over the plane changes with its place.
    let slopes = [0, 1, 2].map(|k| {
        let m = &matrices[pair.frame as usize][corners[k] as usize];
        [0, 1, 2].map(|i| f64::from(n[0] * m[0][i] + n[1] * m[1][i] + n[2] * m[2][i]))
    });
    for k in 0..3 {
        let ends = [((k + 1) % 3, 1.0), (k, -1.0)];
        for (a, sign_a) in ends {
            for i in 0..3 {
                local.right[a * 3 + i] -= share * sign_a * slopes[a][i] * rises[k];
                for (b, sign_b) in ends {
                    for j in 0..3 {
                        local.matrix[a * 3 + i][b * 3 + j] += share * sign_a * sign_b * slopes[a][i] * slopes[b][j];
                    }
                }
            }
        }
    }
}

fn multiply(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Holds every corner a little where it is, so that places without pairs stay and thin ones do not run.
pub(crate) fn add_damping(locals: &mut [Local]) {
    let trace: f64 = locals.iter().map(|l| (0..9).map(|i| l.matrix[i][i]).sum::<f64>()).sum();
    let mean = trace / (9 * locals.len().max(1)) as f64;
    for local in locals {
        for i in 0..9 {
            local.matrix[i][i] += DAMPING * mean;
        }
    }
}

/// Pairs of each triangle, in the order given.
pub(crate) fn sort_by_triangle(triangle_count: usize, pairs: &[Pair]) -> Vec<Vec<&Pair>> {
    let mut sorted = vec![Vec::new(); triangle_count];
    for pair in pairs {
        sorted[pair.triangle as usize].push(pair);
    }
    sorted
}
