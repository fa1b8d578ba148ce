//! Colours full detail by its distance to a level.
//!
//! For pictures only: the distance is to the triangles around the vertex that a vertex collapsed to, so it may be too
//! large, never too small. Numbers come from `crowd_lod::measure_level`.

use glam::Vec3;

/// Linear RGBA8 of each vertex: blue where the level fits, green, yellow, red from `red_at_m` on.
///
/// `posed`: positions of full detail. `level_triangles`: indices below `vertex_count`.
pub(crate) fn paint_error(
    posed: &[[f32; 3]],
    collapse_map: &[u32],
    level_triangles: &[[u32; 3]],
    vertex_count: u32,
    red_at_m: f32,
) -> Vec<[u8; 4]> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); vertex_count as usize];
    for (index, triangle) in level_triangles.iter().enumerate() {
        for &corner in triangle {
            around[corner as usize].push(index as u32);
        }
    }
    let paint = |vertex: usize| {
        let mut kept = vertex as u32;
        while kept >= vertex_count {
            kept = collapse_map[kept as usize];
        }
        let p = Vec3::from(posed[vertex]);
        let mut nearest = p.distance_squared(Vec3::from(posed[kept as usize]));
        for &triangle in &around[kept as usize] {
            for &corner in &level_triangles[triangle as usize] {
                for &near in &around[corner as usize] {
                    let [a, b, c] = level_triangles[near as usize].map(|v| Vec3::from(posed[v as usize]));
                    nearest = nearest.min(p.distance_squared(closest_point(p, a, b, c)));
                }
            }
        }
        heat(nearest.sqrt() / red_at_m)
    };
    (0..posed.len()).map(paint).collect()
}

fn heat(share: f32) -> [u8; 4] {
    const STOPS: [[f32; 3]; 4] = [[20.0, 50.0, 160.0], [20.0, 150.0, 60.0], [230.0, 190.0, 20.0], [200.0, 10.0, 10.0]];
    let place = share.clamp(0.0, 1.0) * 3.0;
    let low = (place as usize).min(2);
    let t = place - low as f32;
    let channel = |c: usize| (STOPS[low][c] + (STOPS[low + 1][c] - STOPS[low][c]) * t) as u8;
    [channel(0), channel(1), channel(2), 255]
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
fn closest_point(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_did_not_move_is_blue_and_what_did_is_red() {
        // Vertex 3 stands above the triangle and collapsed into vertex 2.
        let posed = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, 0.5]];
        let colors = paint_error(&posed, &[0, 1, 2, 2], &[[0, 1, 2]], 3, 0.1);
        assert_eq!(colors[0], heat(0.0));
        assert_eq!(colors[3], heat(1.0));
    }

    #[test]
    fn the_closest_point_lies_inside_on_edges_and_at_corners() {
        let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
        assert_eq!(closest_point(Vec3::new(0.25, 0.25, 3.0), a, b, c), Vec3::new(0.25, 0.25, 0.0));
        assert_eq!(closest_point(Vec3::new(0.5, -2.0, 0.0), a, b, c), Vec3::new(0.5, 0.0, 0.0));
        assert_eq!(closest_point(Vec3::new(9.0, -1.0, 0.0), a, b, c), b);
    }
}
