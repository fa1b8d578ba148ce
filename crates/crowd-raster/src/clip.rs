//! Clips a triangle in clip space, before the division by w, so that triangles that pass the eye come out right.

use glam::{Vec3, Vec4};

/// Screen coordinates are clipped at this many half screens from the middle: fixed point never overflows, and triangles
/// that only stick out of the picture stay whole.
const GUARD: f32 = 8.0;
/// Smallest w kept: for matrices whose near plane lies in the eye.
const LEAST_W: f32 = 1e-6;
/// Three corners and one more a plane.
const MOST_CORNERS: usize = 3 + PLANES.len();

/// Signed distances to the planes, positive inside.
const PLANES: [fn(Vec4) -> f32; 6] = [
    |p| p.z,
    |p| p.w - LEAST_W,
    |p| GUARD * p.w - p.x,
    |p| GUARD * p.w + p.x,
    |p| GUARD * p.w - p.y,
    |p| GUARD * p.w + p.y,
];

/// A corner of what is left of a triangle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Corner {
    /// Clip space.
    pub(crate) position: Vec4,
    /// Shares of the triangle's own corners.
    pub(crate) barycentric: Vec3,
}

/// What clipping has to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Nothing of it can be seen (or a coordinate is not a number).
    Outside,
    /// It needs no clipping.
    Whole,
    /// It crosses the near plane or the guard band.
    Crossing,
}

/// Sorts a triangle by the frustum.
pub(crate) fn classify(corners: &[Vec4; 3]) -> Outcome {
    let all = |outside: fn(&Vec4) -> bool| corners.iter().all(outside);
    if !corners.iter().all(|p| p.is_finite())
        || all(|p| p.z < 0.0)
        || all(|p| p.z > p.w)
        || all(|p| p.x > p.w)
        || all(|p| p.x < -p.w)
        || all(|p| p.y > p.w)
        || all(|p| p.y < -p.w)
    {
        return Outcome::Outside;
    }
    if corners.iter().all(|&p| PLANES.iter().all(|plane| plane(p) >= 0.0)) { Outcome::Whole } else { Outcome::Crossing }
}

/// Sutherland and Hodgman: the polygon left of a triangle, up to nine corners, in the triangle's order.
pub(crate) struct Polygon {
    corners: [Corner; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    pub(crate) fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: Corner) {
        // A convex polygon gains at most one corner a plane; rounding could make it gain more, which are dropped.
        if self.count < MOST_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }
}

/// Clips by all planes.
pub(crate) fn clip_triangle(corners: &[Vec4; 3]) -> Polygon {
    let mut polygon = Polygon { corners: Default::default(), count: 0 };
    for (position, barycentric) in corners.iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
        polygon.push(Corner { position: *position, barycentric });
    }
    for plane in PLANES {
        let before = Polygon { ..polygon };
        polygon.count = 0;
        for (i, &here) in before.corners().iter().enumerate() {
            let next = before.corners()[(i + 1) % before.count];
            let (d_here, d_next) = (plane(here.position), plane(next.position));
            if d_here >= 0.0 {
                polygon.push(here);
            }
            if (d_here >= 0.0) != (d_next >= 0.0) {
                // Always from the inside out, so that neighbours cut their common edge at the same point.
                let (inside, outside, d_in, d_out) =
                    if d_here >= 0.0 { (here, next, d_here, d_next) } else { (next, here, d_next, d_here) };
                let t = d_in / (d_in - d_out);
                polygon.push(Corner {
                    position: inside.position + (outside.position - inside.position) * t,
                    barycentric: inside.barycentric + (outside.barycentric - inside.barycentric) * t,
                });
            }
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_in_view_is_whole_and_one_behind_is_outside() {
        let inside = [Vec4::new(0.0, 0.0, 0.5, 1.0), Vec4::new(0.5, 0.0, 0.5, 1.0), Vec4::new(0.0, 0.5, 0.5, 1.0)];
        assert_eq!(classify(&inside), Outcome::Whole);
        assert_eq!(classify(&inside.map(|p| p - Vec4::Z)), Outcome::Outside);
        assert_eq!(classify(&[inside[0], inside[1], Vec4::NAN]), Outcome::Outside);
    }

    #[test]
    fn a_corner_behind_the_eye_becomes_two_on_the_near_plane() {
        let corners = [Vec4::new(0.0, 0.0, 1.0, 2.0), Vec4::new(1.0, 0.0, 1.0, 2.0), Vec4::new(0.0, 1.0, -1.0, -0.5)];
        assert_eq!(classify(&corners), Outcome::Crossing);
        let polygon = clip_triangle(&corners);
        assert_eq!(polygon.corners().len(), 4);
        for corner in polygon.corners() {
            assert!(corner.position.z >= -1e-6 && corner.position.w > 0.0);
            assert!((corner.barycentric.element_sum() - 1.0).abs() < 1e-6);
            let rebuilt = corners[0] * corner.barycentric.x
                + corners[1] * corner.barycentric.y
                + corners[2] * corner.barycentric.z;
            assert!((rebuilt - corner.position).length() < 1e-5);
        }
    }
}
