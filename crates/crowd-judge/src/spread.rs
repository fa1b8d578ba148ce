//! Spreads points over a surface by area.

use glam::Vec3;

/// A point that stays on its triangle through all poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePoint {
    /// The triangle.
    pub triangle: u32,
    /// Shares of its corners.
    pub shares: [f32; 3],
}

impl SurfacePoint {
    /// The point's place, or any other value that its triangle's corners have.
    pub fn blend(&self, corners: [Vec3; 3]) -> Vec3 {
        corners[0] * self.shares[0] + corners[1] * self.shares[1] + corners[2] * self.shares[2]
    }
}

/// `count` points, evenly along the summed areas and low-discrepancy within the triangles: the same on every machine.
/// None where no triangle has an area.
pub(crate) fn spread_points(positions: &[Vec3], triangles: &[[u32; 3]], count: u32) -> Vec<SurfacePoint> {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
        (b - a).cross(c - a).length()
    };
    let areas: Vec<f64> = triangles.iter().map(area).collect();
    let total: f64 = areas.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let (mut triangle, mut passed) = (0, areas[0]);
    (0..count)
        .map(|i| {
            let mark = (f64::from(i) + 0.5) / f64::from(count) * total;
            while passed < mark && triangle + 1 < triangles.len() {
                triangle += 1;
                passed += areas[triangle];
            }
            // The R2 sequence: multiples of the plastic number's inverse powers.
            let unit = |step: f64| {
                let x = 0.5 + step * f64::from(i + 1);
                x - x.floor()
            };
            let (x, y) = (unit(0.754_877_666_246_692_7), unit(0.569_840_290_998_053_3));
            let (s, t) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            SurfacePoint { triangle: triangle as u32, shares: [s as f32, t as f32, (1.0 - s - t) as f32] }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_go_by_area() {
        let positions =
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [3.0, 0.0], [0.0, 3.0]].map(|[x, y]: [f32; 2]| Vec3::new(x, y, 0.0));
        let points = spread_points(&positions, &[[0, 1, 2], [0, 1, 1], [0, 3, 4]], 1000);
        let on = |triangle: u32| points.iter().filter(|point| point.triangle == triangle).count();
        assert_eq!((on(0), on(1), on(2)), (100, 0, 900));
        assert!(points.iter().all(|p| p.shares.iter().all(|&share| (-1e-6..=1.0).contains(&share))));
        assert_eq!(spread_points(&positions, &[[0, 1, 1]], 10), []);
        assert_eq!(spread_points(&[], &[], 10), []);
    }
}
