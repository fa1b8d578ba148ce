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
        let center = rules.places(self.center);
        let lie = |blade: &Blade| {
            let [a, b] = blade.others.map(|p| rules.places(p));
            let (normals, squared) = dispatch!(rules.level(), _ => {
                let normals = normals(center, a, b);
                (normals, product(&normals, &normals))
            });
            let uvs = blade.variants.map(|v| split.variant_uv[v as usize].map(f64::from));
            Lie { normals, squared, uv_side: uv_side(uvs) }
        };
        self.lies.extend(self.blades.iter().map(lie));
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

    /// The blades that stay when the centre moves to `t`, and how they lie; only once measured.
    pub fn staying(&self, t: u32) -> impl Iterator<Item = (&Blade, &Lie)> {
        self.blades.iter().zip(&self.lies).filter(move |(blade, _)| !blade.touches(t))
    }
}
