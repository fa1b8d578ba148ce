//! Faces of any number of corners as triangles.

use glam::DVec3;

/// Beyond this many corners a face is cut as a fan: ear cutting takes cubic time.
const EAR_CORNERS: usize = 256;

/// Cuts a face into triangles, corner order kept. Triangles and convex quads as a fan from the first corner; a concave
/// quad along its inner diagonal; other faces by cutting ears off. Triangles that use a vertex twice are left out.
pub(super) fn triangulate_polygon(positions: &[[f32; 3]], face: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let mut push = |t: [u32; 3]| {
        if t[0] != t[1] && t[1] != t[2] && t[0] != t[2] {
            triangles.push(t);
        }
    };
    let corner = |v: u32| DVec3::from_array(positions[v as usize].map(f64::from));
    let mut ring = face.to_vec();
    let up = newell_normal(ring.iter().map(|v| corner(*v)));
    while ring.len() > 3 && ring.len() <= EAR_CORNERS {
        let Some(ear) = find_ear(&ring, &corner, up) else { break };
        let count = ring.len();
        push([ring[(ear + count - 1) % count], ring[ear], ring[(ear + 1) % count]]);
        ring.remove(ear);
    }
    for i in 1..ring.len().saturating_sub(1) {
        push([ring[0], ring[i], ring[i + 1]]);
    }
}

/// Twice the area vector of a face that need not be flat.
fn newell_normal(corners: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(a, b)| a.cross(b)).sum()
}

/// The ear to cut next. For a convex ring that is corner 1, 2, ... in turn, which makes the fan from corner 0.
fn find_ear(ring: &[u32], corner: &impl Fn(u32) -> DVec3, up: DVec3) -> Option<usize> {
    let count = ring.len();
    (1..=count).map(|i| i % count).find(|&i| {
        let (before, after) = ((i + count - 1) % count, (i + 1) % count);
        let [a, b, c] = [ring[before], ring[i], ring[after]].map(corner);
        if (b - a).cross(c - b).dot(up) <= 0.0 {
            return false;
        }
        let inside =
            |p: DVec3| [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(p - *from).dot(up) >= 0.0);
        let others = (0..count).filter(|o| ![before, i, after].contains(o)).map(|o| corner(ring[o]));
        !others.filter(|p| *p != a && *p != b && *p != c).any(inside)
    })
}
