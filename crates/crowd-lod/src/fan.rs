//! The triangles around a position, gathered once for all edges along which it might move.
//!
//! A look around tries a handful of edges, and each asks the same of every triangle: its corners, how it lies in the tested poses, its side
//! in the texture. Here they lie together.

use crate::criteria::{POSES, Places, Rules, normals, product, uv_side};
use crate::split_seams::SplitMesh;
use crate::topology::{Spoke, Topology};
use fearless_simd::dispatch;

/// One triangle of a fan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Blade {
    pub triangle: u32,
    /// Corners as variants, that at the centre first.
    pub variants: [u32; 3],
    /// The positions of the other two.
    pub others: [u32; 2],
}

impl Blade {
    /// Whether the triangle has a corner at a position other than the centre.
    pub fn touches(&self, p: u32) -> bool {
        self.others.contains(&p)
    }
}

/// How a triangle lies before the centre moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lie {
    /// Normals in the tested poses, twice the area long.
    pub normals: Places,
    /// Their squared lengths.
    pub squared: [f32; POSES],
    /// Twice the signed area in the texture; `None` for a dot or a thread there.
    pub uv_side: Option<f64>,
}

/// The living triangles around a position.
#[derive(Debug, Default)]
pub(crate) struct Fan {
    pub center: u32,
    /// In the order in which the position lists them.
    pub blades: Vec<Blade>,
    /// The variants at the centre, each once, ascending.
    pub variants: Vec<u32>,
    /// How each blade lies; empty until [`Self::measure`].
    pub lies: Vec<Lie>,
}

impl Fan {
    /// Gathers the triangles around `center`.
    pub fn gather(&mut self, topology: &Topology, center: u32) {
        self.center = center;
        self.blades.clear();
        self.variants.clear();
        self.lies.clear();
        for triangle in topology.around(center) {
            let positions = topology.triangle_positions[triangle as usize];
            let [a, b, c] = topology.triangles[triangle as usize];
            let (variants, others) = if positions[0] == center {
                ([a, b, c], [positions[1], positions[2]])
            } else if positions[1] == center {
                ([b, c, a], [positions[2], positions[0]])
            } else {
                ([c, a, b], [positions[0], positions[1]])
            };
            self.blades.push(Blade { triangle, variants, others });
            if !self.variants.contains(&variants[0]) {
                self.variants.push(variants[0]);
            }
        }
        self.variants.sort_unstable();
    }

    /// Looks how the triangles lie, if that was not done yet.
    pub fn measure(&mut self, rules: &Rules, split: &SplitMesh) {
        if !self.lies.is_empty() {
            return;
        }
        let Self { center, blades, lies, .. } = self;
        let center = rules.places(*center);
        dispatch!(rules.vectors(), _ => {
            for blade in blades.iter() {
                let [a, b] = blade.others.map(|p| rules.places(p));
                let normals = normals(center, a, b);
                let uvs = blade.variants.map(|v| split.variant_uv[v as usize].map(f64::from));
                lies.push(Lie { normals, squared: product(&normals, &normals), uv_side: uv_side(uvs) });
            }
        });
    }

    /// Writes the edges at the centre to `spokes`, in the order in which the triangles list them.
    pub fn spokes(&self, spokes: &mut Vec<Spoke>) {
        spokes.clear();
        for blade in &self.blades {
            for to in blade.others {
                match spokes.iter_mut().find(|s| s.to == to) {
                    None => spokes.push(Spoke { to, triangle_count: 1, triangles: [blade.triangle; 2] }),
                    Some(spoke) => {
                        if spoke.triangle_count == 1 {
                            spoke.triangles[1] = blade.triangle;
                        }
                        spoke.triangle_count += 1;
                    }
                }
            }
        }
    }

    /// Writes the triangles on the edge to `t` to `on_edge`.
    pub fn find_on_edge(&self, t: u32, on_edge: &mut Vec<u32>) {
        on_edge.clear();
        on_edge.extend(self.blades.iter().filter(|blade| blade.touches(t)).map(|blade| blade.triangle));
    }

    /// Of each triangle on the edge to `t`, its variants at the centre and there.
    pub fn variants_on_edge(&self, t: u32) -> impl Iterator<Item = (u32, u32)> {
        self.blades.iter().filter_map(move |blade| {
            let at = blade.others.iter().position(|&p| p == t)?;
            Some((blade.variants[0], blade.variants[at + 1]))
        })
    }

    /// The blades that stay when the centre moves to `t`, and how they lie; only once measured.
    pub fn staying(&self, t: u32) -> impl Iterator<Item = (&Blade, &Lie)> {
        self.blades.iter().zip(&self.lies).filter(move |(blade, _)| !blade.touches(t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Criteria;
    use crate::classify::classify_wedges;
    use crate::split_seams::split_seams;
    use crate::test_meshes::{TestPoses, grid, uv_sphere};

    /// Every fan of a mesh with a seam says what the triangles say one by one.
    #[test]
    fn a_fan_is_what_its_triangles_say() {
        let mesh = uv_sphere(9, 7);
        let split = split_seams(&mesh.mesh());
        let topology = Topology::new(&split);
        let (mut fan, mut spokes, mut on_edge) = (Fan::default(), Vec::new(), Vec::new());
        for p in 0..split.position_source.len() as u32 {
            fan.gather(&topology, p);
            assert_eq!(fan.blades.len(), topology.valence(p));
            for blade in &fan.blades {
                let corners = blade.variants.map(|v| split.position_of(v));
                assert_eq!(corners, [p, blade.others[0], blade.others[1]]);
                let turned = (0..3).any(|by| {
                    [0, 1, 2].map(|i| topology.triangles[blade.triangle as usize][(i + by) % 3]) == blade.variants
                });
                assert!(turned, "the front stays the front");
            }
            assert!(fan.variants.is_sorted_by(|a, b| a < b));
            fan.spokes(&mut spokes);
            for spoke in &spokes {
                assert_eq!(spoke.triangle_count, topology.edge_triangle_count(p, spoke.to));
                fan.find_on_edge(spoke.to, &mut on_edge);
                assert_eq!(on_edge, spoke.triangles, "two triangles on each edge of a closed surface");
            }
        }
    }

    #[test]
    fn a_gathered_fan_forgets_how_the_last_one_lay() {
        let mesh = grid(4, 4, |x, _| 0.3 * x as f32, |_, _| false);
        let poses = TestPoses::rest();
        let split = split_seams(&mesh.mesh());
        let classes = classify_wedges(&split);
        let class = &classes.wedge_class;
        let rules = Rules::new(&mesh.mesh(), &poses.poses(), &split, Criteria::Wedge, &classes.non_manifold, class);
        let topology = Topology::new(&split);
        let mut fan = Fan::default();
        for p in [6, 12, 7] {
            fan.gather(&topology, p);
            assert!(fan.lies.is_empty());
            fan.measure(&rules, &split);
            for (blade, lie) in fan.blades.iter().zip(&fan.lies) {
                let [a, b] = blade.others.map(|q| rules.places(q));
                let expected = normals(rules.places(p), a, b);
                assert_eq!((lie.normals, lie.squared), (expected, product(&expected, &expected)));
                assert!(lie.uv_side.is_some_and(|area| area > 0.0), "texture as in the plane");
            }
            let to = fan.blades[0].others[0];
            assert!(fan.staying(to).count() < fan.blades.len());
            assert!(fan.staying(to).all(|(blade, _)| !blade.touches(to)));
        }
    }
}
