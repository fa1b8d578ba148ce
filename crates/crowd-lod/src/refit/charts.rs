//! Charts of full detail: parts of the surface over which texture coordinates run on without a cut, and where they end.

use crate::LodMesh;
use crate::closest::ClosestTriangles;
use crate::split_seams::zero_signless_bits;

/// Two edges of a rim run on straight when the cosine between their directions away from their end is below this.
const STRAIGHT_COS: f32 = -0.7;

/// Charts of full detail's triangles.
pub(crate) struct Charts {
    /// Chart of each triangle.
    pub of_triangle: Vec<u32>,
    /// Rim of each chart.
    rims: Vec<Rim>,
}

/// Where a chart ends, in the texture: edges as triangles of no width.
#[derive(Default)]
struct Rim {
    ends: Vec<[f32; 3]>,
    edges: Vec<[u32; 3]>,
    tree: Option<ClosestTriangles>,
    /// Ends where the rim turns, rising.
    corners: Vec<[u32; 2]>,
}

impl Charts {
    /// Joins triangles across edges that have the same places, texture coordinates and material on both sides.
    pub fn new(mesh: &LodMesh<'_>, triangles: &[[u32; 3]], materials: &[u16]) -> Self {
        // Edges by what they have at both ends, the lower end first.
        type End = ([u32; 3], [u32; 2]);
        let end = |v: u32| -> End {
            (mesh.positions[v as usize].map(zero_signless_bits), mesh.uvs[v as usize].map(zero_signless_bits))
        };
        let mut edges: Vec<(End, End, u16, u32)> = Vec::with_capacity(triangles.len() * 3);
        for (t, corners) in triangles.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (end(corners[i]), end(corners[(i + 1) % 3]));
                edges.push((a.min(b), a.max(b), materials[t], (t * 3 + i) as u32));
            }
        }
        edges.sort_unstable();
        let mut parents: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut rim_corners = Vec::new();
        for group in edges.chunk_by(|x, y| (x.0, x.1, x.2) == (y.0, y.1, y.2)) {
            for pair in group.windows(2) {
                let (a, b) = (root(&mut parents, pair[0].3 / 3), root(&mut parents, pair[1].3 / 3));
                parents[a.max(b) as usize] = a.min(b);
            }
            if group.len() == 1 {
                rim_corners.push(group[0].3);
            }
        }
        let mut of_triangle = vec![0_u32; triangles.len()];
        let mut count = 0;
        for t in 0..triangles.len() {
            let first = root(&mut parents, t as u32) as usize;
            if first == t {
                of_triangle[t] = count;
                count += 1;
            } else {
                of_triangle[t] = of_triangle[first];
            }
        }
        rim_corners.sort_unstable();
        let mut rims: Vec<Rim> = Vec::new();
        rims.resize_with(count as usize, Rim::default);
        for corner in rim_corners {
            let (t, i) = (corner as usize / 3, corner as usize % 3);
            let rim = &mut rims[of_triangle[t] as usize];
            let at = rim.ends.len() as u32;
            let ends = [triangles[t][i], triangles[t][(i + 1) % 3]];
            for v in ends {
                let [u, v] = mesh.uvs[v as usize];
                rim.ends.push([u, v, 0.0]);
            }
            rim.edges.push([at, at + 1, at + 1]);
        }
        for rim in &mut rims {
            let mut tree = ClosestTriangles::new(&rim.ends, &rim.edges);
            tree.refit(&rim.ends, &rim.edges);
            rim.tree = Some(tree);
            rim.corners = rim_corners_of(&rim.ends);
        }
        Self { of_triangle, rims }
    }

    /// Whether the rim of a chart turns at `uv`, one of its vertices.
    pub fn is_corner(&self, chart: u32, uv: [f32; 2]) -> bool {
        self.rims[chart as usize].corners.binary_search(&uv.map(zero_signless_bits)).is_ok()
    }

    /// The point on the rim of a chart that is closest to `uv`, and how far it is.
    pub fn to_rim(&self, chart: u32, uv: [f32; 2]) -> Option<([f32; 2], f32)> {
        let rim = &self.rims[chart as usize];
        let hit = rim.tree.as_ref()?.closest_point([uv[0], uv[1], 0.0], &rim.ends, &rim.edges, None, None)?;
        let corners = rim.edges[hit.triangle as usize].map(|v| rim.ends[v as usize]);
        let at = super::pairs::mix(corners, hit.weights);
        Some(([at[0], at[1]], hit.distance_squared.sqrt()))
    }
}

/// Ends of a rim where it does not run straight on: `ends` two by two, one pair for each edge.
fn rim_corners_of(ends: &[[f32; 3]]) -> Vec<[u32; 2]> {
    let mut leaving: Vec<([u32; 2], [f32; 2])> = Vec::with_capacity(ends.len());
    for edge in ends.chunks_exact(2) {
        for [from, to] in [[edge[0], edge[1]], [edge[1], edge[0]]] {
            let key = [from[0], from[1]].map(zero_signless_bits);
            leaving.push((key, [to[0] - from[0], to[1] - from[1]]));
        }
    }
    leaving.sort_by_key(|l| l.0);
    let straight = |group: &[([u32; 2], [f32; 2])]| {
        let [a, b] = [group[0].1, group[group.len() - 1].1];
        let lengths = ((a[0] * a[0] + a[1] * a[1]) * (b[0] * b[0] + b[1] * b[1])).sqrt();
        group.len() == 2 && a[0] * b[0] + a[1] * b[1] < STRAIGHT_COS * lengths
    };
    leaving.chunk_by(|a, b| a.0 == b.0).filter(|group| !straight(group)).map(|group| group[0].0).collect()
}

fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        parents[at as usize] = parents[parents[at as usize] as usize];
        at = parents[at as usize];
    }
    at
}
