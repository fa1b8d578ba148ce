//! The modeller's clay: shared positions, polygons whose corners carry chart coordinates, tubes and caps.
//! Painting, skinning and files are left to others.

use glam::{Vec2, Vec3};

/// What a corner of a face knows besides its position.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Index into [`Shape::positions`].
    pub position: u32,
    /// Place inside the face's chart, 0..1 in both directions.
    pub chart_uv: Vec2,
    /// Metres along the part (height on a torso, distance along a limb): the painter's first pattern coordinate.
    pub along: f32,
    /// Turns around the part, 0..1: the painter's second pattern coordinate.
    pub around: f32,
}

/// A triangle or quad, counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub struct Face {
    /// Three or four corners.
    pub corners: Vec<Corner>,
    /// The chart (atlas rectangle) it is unwrapped into.
    pub chart: u16,
    /// The body part, for the painter.
    pub part: u8,
    /// This face re-uses the texels that its mirror image has painted.
    pub mirrored: bool,
}

/// A surface under construction. Positions are shared between charts; wedges are made when it is written.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Bind-pose positions in metres.
    pub positions: Vec<Vec3>,
    /// For each position, the tag its skin weights are computed from (see the rig).
    pub tags: Vec<u16>,
    /// All polygons.
    pub faces: Vec<Face>,
}

/// How a grid of rings is unwrapped: which chart, and where each column and row falls in it.
#[derive(Clone, Debug)]
pub struct GridChart {
    /// Chart index.
    pub chart: u16,
    /// Part index for the painter.
    pub part: u8,
    /// Re-uses painted texels of its mirror image.
    pub mirrored: bool,
    /// Swap u and v: long limbs lie down in the atlas.
    pub lying: bool,
}

impl Shape {
    /// Adds one position and returns its index.
    pub fn add(&mut self, p: Vec3, tag: u16) -> u32 {
        self.positions.push(p);
        self.tags.push(tag);
        self.positions.len() as u32 - 1
    }

    /// Adds a ring of positions and returns their indices.
    pub fn add_ring(&mut self, ring: &[Vec3], tag: u16) -> Vec<u32> {
        ring.iter().map(|&p| self.add(p, tag)).collect()
    }

    /// Joins a stack of rings (`rings[row][column]`) over the columns `cols` and leaves out the quads named by `skip`.
    ///
    /// `u(row, k)`: chart coordinate of the k-th of `cols`; `around[k]`: turns at that column; `v[row]`,
    /// `along[row]`: chart coordinate and metres of each row. `flip` turns the grid inside out.
    pub fn add_grid(
        &mut self,
        rings: &[Vec<u32>],
        cols: &[usize],
        u: &dyn Fn(usize, usize) -> f32,
        around: &[f32],
        v: &[f32],
        along: &[f32],
        chart: &GridChart,
        flip: bool,
        skip: &dyn Fn(usize, usize) -> bool,
    ) {
        for row in 0..rings.len() - 1 {
            for k in 0..cols.len() - 1 {
                if skip(row, k) {
                    continue;
                }
                let corner = |r: usize, k: usize| {
                    let (a, b) = (u(r, k), v[r]);
                    Corner {
                        position: rings[r][cols[k] % rings[r].len()],
                        chart_uv: if chart.lying { Vec2::new(b, a) } else { Vec2::new(a, b) },
                        along: along[r],
                        around: around[k],
                    }
                };
                let corners = vec![corner(row, k), corner(row, k + 1), corner(row + 1, k + 1), corner(row + 1, k)];
                self.add_face(corners, chart, flip);
            }
        }
    }

    /// Adds one polygon, dropping corners that repeat their neighbour's position.
    pub fn add_face(&mut self, mut corners: Vec<Corner>, chart: &GridChart, flip: bool) {
        corners.dedup_by(|a, b| a.position == b.position);
        if corners.len() > 1 && corners[0].position == corners[corners.len() - 1].position {
            corners.pop();
        }
        if corners.len() < 3 {
            return;
        }
        if flip {
            corners.reverse();
        }
        self.faces.push(Face { corners, chart: chart.chart, part: chart.part, mirrored: chart.mirrored });
    }

    /// A tube with a closed tip, unwrapped as a disc: the first ring is the rim, the tip the middle. No seam inside.
    ///
    /// `rings`: rows of indices from the open end to the last ring; `tip`: the closing position's index.
    pub fn add_disc(&mut self, rings: &[Vec<u32>], tip: u32, along: &[f32], chart: &GridChart, flip: bool) {
        let n = rings[0].len();
        let rows = rings.len();
        let uv = |j: usize, row: usize| {
            let (s, c) = libm::sincosf(core::f32::consts::TAU * j as f32 / n as f32);
            Vec2::new(0.5, 0.5) + Vec2::new(s, c) * (0.5 * (rows - row) as f32 / rows as f32)
        };
        let corner = |j: usize, row: usize| Corner {
            position: if row == rows { tip } else { rings[row][j % n] },
            chart_uv: if row == rows { Vec2::splat(0.5) } else { uv(j, row) },
            along: along[row.min(along.len() - 1)],
            around: j as f32 / n as f32,
        };
        for row in 0..rows {
            for j in 0..n {
                let corners = if row + 1 == rows {
                    vec![corner(j, row), corner(j + 1, row), corner(j, rows)]
                } else {
                    vec![corner(j, row), corner(j + 1, row), corner(j + 1, row + 1), corner(j, row + 1)]
                };
                self.add_face(corners, chart, flip);
            }
        }
    }

    /// Moves the marked positions towards the mean of their neighbours, `rounds` times; `amount[i]` 0..1 per position.
    pub fn relax(&mut self, amount: &[f32], rounds: usize) {
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); self.positions.len()];
        for f in &self.faces {
            let n = f.corners.len();
            for i in 0..n {
                let (a, b) = (f.corners[i].position, f.corners[(i + 1) % n].position);
                neighbours[a as usize].push(b);
                neighbours[b as usize].push(a);
            }
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        for _ in 0..rounds {
            let old = self.positions.clone();
            for (i, list) in neighbours.iter().enumerate() {
                if amount[i] <= 0.0 || list.is_empty() {
                    continue;
                }
                let mean = list.iter().map(|&j| old[j as usize]).sum::<Vec3>() / list.len() as f32;
                self.positions[i] = old[i].lerp(mean, amount[i]);
            }
        }
    }

    /// All faces as triangles: quads are cut along their shorter diagonal.
    pub fn triangles(&self) -> Vec<(usize, [Corner; 3])> {
        let mut out = Vec::new();
        for (i, f) in self.faces.iter().enumerate() {
            let c = &f.corners;
            if c.len() == 3 {
                out.push((i, [c[0], c[1], c[2]]));
                continue;
            }
            let p = |k: usize| self.positions[c[k].position as usize];
            if p(0).distance_squared(p(2)) <= p(1).distance_squared(p(3)) * 1.0001 {
                out.push((i, [c[0], c[1], c[2]]));
                out.push((i, [c[0], c[2], c[3]]));
            } else {
                out.push((i, [c[0], c[1], c[3]]));
                out.push((i, [c[1], c[2], c[3]]));
            }
        }
        out
    }

    /// One smooth unit normal per position: face normals weighted by area and corner angle.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for (_, t) in self.triangles() {
            let p = t.map(|c| self.positions[c.position as usize]);
            let n = (p[1] - p[0]).cross(p[2] - p[0]);
            for k in 0..3 {
                let (a, b) = ((p[(k + 1) % 3] - p[k]).normalize_or_zero(), (p[(k + 2) % 3] - p[k]).normalize_or_zero());
                sums[t[k].position as usize] += n.normalize_or_zero() * libm::acosf(a.dot(b).clamp(-1.0, 1.0));
            }
        }
        sums.into_iter().map(|n| n.try_normalize().unwrap_or(Vec3::Y)).collect()
    }
}

/// Running sums of `lengths`, scaled to end at 1; one more entry than lengths.
pub fn running_share(lengths: &[f32]) -> Vec<f32> {
    let total: f32 = lengths.iter().sum();
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for l in lengths {
        sum += l;
        out.push(sum / total);
    }
    let last = out.len() - 1;
    out[last] = 1.0;
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strip_faces_outwards() {
        // A ring of four seen from above, +z first, then +x: quads must look outwards.
        let ring = |y: f32| [Vec3::new(0., y, 1.), Vec3::new(1., y, 0.), Vec3::new(0., y, -1.), Vec3::new(-1., y, 0.)];
        let mut s = Shape::default();
        let (a, b) = (s.add_ring(&ring(0.0), 0), s.add_ring(&ring(1.0), 0));
        let chart = GridChart { chart: 0, part: 0, mirrored: false, lying: false };
        let u = [0.0, 0.25, 0.5, 0.75, 1.0];
        let (cols, rows) = ([0, 1, 2, 3, 4], [0.0, 1.0]);
        s.add_grid(&[a, b], &cols, &|_, k| u[k], &u, &rows, &rows, &chart, false, &|_, _| false);
        assert_eq!(s.faces.len(), 4);
        for (_, t) in s.triangles() {
            let p = t.map(|c| s.positions[c.position as usize]);
            let n = (p[1] - p[0]).cross(p[2] - p[0]);
            let mid = (p[0] + p[1] + p[2]) / 3.0 - Vec3::new(0.0, 0.5, 0.0);
            assert!(n.dot(mid) > 0.0);
        }
    }
}
