//! Finds the nearest point of a posed surface: a box tree sorted once and fitted to each pose.

use glam::Vec3;

/// Triangles in a leaf at most.
const LEAF_SIZE: usize = 4;

#[derive(Debug, Clone, Copy)]
struct Branch {
    /// Triangles below, in the tree's sequence.
    start: u32,
    end: u32,
    /// Second child; the first one follows the branch. 0 in a leaf.
    second: u32,
}

/// The tree's shape, for all poses.
#[derive(Debug, Clone, Default)]
pub(crate) struct TreeShape {
    sequence: Vec<u32>,
    branches: Vec<Branch>,
}

/// The surface in one pose.
#[derive(Debug)]
pub(crate) struct PosedSurface<'a> {
    shape: &'a TreeShape,
    boxes: Vec<(Vec3, Vec3)>,
    /// Corners of each triangle.
    corners: Vec<[Vec3; 3]>,
    /// Where each triangle looks, any length; zero for one without area.
    facing: Vec<Vec3>,
}

/// The nearest point found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Its triangle.
    pub triangle: u32,
    /// Shares of the triangle's corners.
    pub shares: [f32; 3],
    /// Distance, squared.
    pub distance_squared: f32,
}

impl TreeShape {
    /// Sorts triangles by their place in one pose; any other pose will do for it too, less quickly.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let centre = |t: &[u32; 3]| t.iter().map(|&v| positions[v as usize]).sum::<Vec3>();
        let centres: Vec<Vec3> = triangles.iter().map(centre).collect();
        let mut shape = Self { sequence: (0..triangles.len() as u32).collect(), branches: Vec::new() };
        if !triangles.is_empty() {
            shape.split(&centres, 0, triangles.len());
        }
        shape
    }

    fn split(&mut self, centres: &[Vec3], start: usize, end: usize) {
        let branch = self.branches.len();
        self.branches.push(Branch { start: start as u32, end: end as u32, second: 0 });
        if end - start <= LEAF_SIZE {
            return;
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &t in &self.sequence[start..end] {
            low = low.min(centres[t as usize]);
            high = high.max(centres[t as usize]);
        }
        let extent = high - low;
        let axis = if extent.x >= extent.y && extent.x >= extent.z { 0 } else { 1 + usize::from(extent.z > extent.y) };
        let middle = (end - start) / 2;
        self.sequence[start..end].select_nth_unstable_by(middle, |&a, &b| {
            centres[a as usize][axis].total_cmp(&centres[b as usize][axis]).then(a.cmp(&b))
        });
        self.split(centres, start, start + middle);
        self.branches[branch].second = self.branches.len() as u32;
        self.split(centres, start + middle, end);
    }
}

impl<'a> PosedSurface<'a> {
    /// Fits the tree to a pose.
    pub fn new(shape: &'a TreeShape, positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let corners: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect();
        let facing = corners.iter().map(|[a, b, c]| (b - a).cross(c - a)).collect();
        let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); shape.branches.len()];
        for i in (0..boxes.len()).rev() {
            let branch = shape.branches[i];
            let (mut low, mut high) = boxes[i];
            if branch.second == 0 {
                for &t in &shape.sequence[branch.start as usize..branch.end as usize] {
                    for &corner in &corners[t as usize] {
                        low = low.min(corner);
                        high = high.max(corner);
                    }
                }
            } else {
                for child in [i + 1, branch.second as usize] {
                    low = low.min(boxes[child].0);
                    high = high.max(boxes[child].1);
                }
            }
            boxes[i] = (low, high);
        }
        Self { shape, boxes, corners, facing }
    }

    /// Corners of a triangle in this pose.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.corners[triangle as usize]
    }

    /// Where a triangle looks, any length.
    pub fn facing(&self, triangle: u32) -> Vec3 {
        self.facing[triangle as usize]
    }

    /// The nearest point among the triangles; with `facing` among those that look the same way (less than a right angle
    /// apart). `guess`: a triangle that may be near; it changes the time, and which of equally near ones is found.
    pub fn nearest(&self, point: Vec3, facing: Option<Vec3>, guess: Option<u32>) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        let mut least = f32::INFINITY;
        let mut look_at = |t: u32, least: &mut f32| {
            if facing.is_some_and(|facing| facing.dot(self.facing[t as usize]) <= 0.0) {
                return;
            }
            let (shares, distance_squared) = nearest_on_triangle(point, self.corners[t as usize]);
            if distance_squared < *least {
                *least = distance_squared;
                best = Some(Nearest { triangle: t, shares, distance_squared });
            }
        };
        if let Some(t) = guess {
            look_at(t, &mut least);
        }
        if self.boxes.is_empty() {
            return None;
        }
        // Halving splits of fewer than 2^32 triangles: the stack never holds more than one branch a level.
        let mut stack = [(0_u32, 0.0_f32); 64];
        let mut depth = 1;
        stack[0] = (0, self.box_distance(0, point));
        while depth > 0 {
            depth -= 1;
            let (at, distance) = stack[depth];
            if distance >= least {
                continue;
            }
            let branch = &self.shape.branches[at as usize];
            if branch.second == 0 {
                for &t in &self.shape.sequence[branch.start as usize..branch.end as usize] {
                    look_at(t, &mut least);
                }
                continue;
            }
            let (a, b) = (at + 1, branch.second);
            let (to_a, to_b) = (self.box_distance(a, point), self.box_distance(b, point));
            let (near, far) = if to_a <= to_b { ((a, to_a), (b, to_b)) } else { ((b, to_b), (a, to_a)) };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
        best
    }

    /// Visits the triangles within a distance (squared) that look the same way, with the shares of their nearest point.
    pub fn within(&self, point: Vec3, facing: Vec3, distance_squared: f32, visit: &mut dyn FnMut(u32, [f32; 3])) {
        let mut stack: Vec<u32> = if self.boxes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(at) = stack.pop() {
            if self.box_distance(at, point) > distance_squared {
                continue;
            }
            let branch = &self.shape.branches[at as usize];
            if branch.second != 0 {
                stack.extend([branch.second, at + 1]);
                continue;
            }
            for &t in &self.shape.sequence[branch.start as usize..branch.end as usize] {
                if facing.dot(self.facing[t as usize]) > 0.0 {
                    let (shares, found) = nearest_on_triangle(point, self.corners[t as usize]);
                    if found <= distance_squared {
                        visit(t, shares);
                    }
                }
            }
        }
    }

    fn box_distance(&self, branch: u32, point: Vec3) -> f32 {
        let (low, high) = self.boxes[branch as usize];
        (low - point).max(point - high).max(Vec3::ZERO).length_squared()
    }
}

/// The nearest point of a triangle, as shares of its corners, and its distance squared (Ericson 2005, §5.1.5).
fn nearest_on_triangle(point: Vec3, [a, b, c]: [Vec3; 3]) -> ([f32; 3], f32) {
    let mut shares = shares_of_nearest(point, a, b, c);
    if !shares.iter().all(|share| share.is_finite()) {
        shares = shares_on_edges(point, a, b, c);
    }
    let place = a * shares[0] + b * shares[1] + c * shares[2];
    (shares, point.distance_squared(place))
}

fn shares_of_nearest(point: Vec3, a: Vec3, b: Vec3, c: Vec3) -> [f32; 3] {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let whole = 1.0 / (va + vb + vc);
    [va * whole, vb * whole, vc * whole]
}

/// The nearest point on the edges: for triangles without area, where the shares above divide by zero.
fn shares_on_edges(point: Vec3, a: Vec3, b: Vec3, c: Vec3) -> [f32; 3] {
    let along = |from: Vec3, to: Vec3| {
        let edge = to - from;
        let length_squared = edge.length_squared();
        if length_squared > 0.0 { ((point - from).dot(edge) / length_squared).clamp(0.0, 1.0) } else { 0.0 }
    };
    let (on_ab, on_bc, on_ca) = (along(a, b), along(b, c), along(c, a));
    let candidates = [[1.0 - on_ab, on_ab, 0.0], [0.0, 1.0 - on_bc, on_bc], [on_ca, 0.0, 1.0 - on_ca]];
    let distance = |s: &[f32; 3]| point.distance_squared(a * s[0] + b * s[1] + c * s[2]);
    candidates.into_iter().min_by(|s, t| distance(s).total_cmp(&distance(t))).unwrap_or([1.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = [f32; 3]> {
        [-4.0_f32..4.0, -4.0_f32..4.0, -4.0_f32..4.0]
    }

    proptest! {
        #[test]
        fn tree_finds_what_trying_all_finds(
            built in prop::collection::vec([place(), place(), place()], 1..80),
            moved in prop::collection::vec([place(), place(), place()], 80),
            point in place(),
            look in place(),
            guess in 0_u32..80,
        ) {
            let triangles: Vec<[u32; 3]> = (0..built.len() as u32).map(|i| [i * 3, i * 3 + 1, i * 3 + 2]).collect();
            let vectors = |places: &[[[f32; 3]; 3]]| places.as_flattened().iter().map(|&p| Vec3::from(p)).collect();
            let (built, moved): (Vec<Vec3>, Vec<Vec3>) = (vectors(&built), vectors(&moved[..built.len()]));
            let shape = TreeShape::new(&built, &triangles);
            let (point, look) = (Vec3::from(point), Vec3::from(look));
            for positions in [&built, &moved] {
                let surface = PosedSurface::new(&shape, positions, &triangles);
                for facing in [None, Some(look)] {
                    let fits = |t: &u32| facing.is_none_or(|f: Vec3| f.dot(surface.facing(*t)) > 0.0);
                    let all = (0..triangles.len() as u32).filter(fits);
                    let least = all.map(|t| nearest_on_triangle(point, surface.corners(t)).1).reduce(f32::min);
                    for guess in [None, Some(guess % triangles.len() as u32)] {
                        let found = surface.nearest(point, facing, guess);
                        let found = found.map(|found| found.distance_squared);
                        prop_assert_eq!(found.is_some(), least.is_some());
                        let (found, least) = (found.unwrap_or(0.0), least.unwrap_or(0.0));
                        prop_assert!((found - least).abs() <= 1.0e-5 * least, "{} {}", found, least);
                    }
                }
            }
        }
    }

    #[test]
    fn distance_to_a_triangle_by_hand() {
        let triangle = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
        for (point, squared) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([2.0, -2.0, 0.0], 4.0),
            ([4.0, 4.0, 0.0], 8.0),
            ([6.0, 0.0, 1.0], 5.0),
        ] {
            let (_, found) = nearest_on_triangle(Vec3::from(point), triangle);
            assert!((found - squared).abs() < 1.0e-5, "{point:?}: {found}");
        }
        let thread = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        assert_eq!(nearest_on_triangle(Vec3::new(1.5, 2.0, 0.0), thread).1, 4.0);
        assert_eq!(nearest_on_triangle(Vec3::new(0.0, 2.0, 0.0), [Vec3::ZERO; 3]).1, 4.0);
    }

    #[test]
    fn no_triangle_is_no_point() {
        let shape = TreeShape::new(&[], &[]);
        assert_eq!(PosedSurface::new(&shape, &[], &[]).nearest(Vec3::ZERO, None, None), None);
    }
}
