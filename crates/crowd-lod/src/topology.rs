//! The triangles alive at the moment, and which of them meet at a position.
//!
//! Arrays only: a triangle names its three variants, a position lists its triangles. Dead triangles leave short lists at once and
//! stay in long ones until they are half of one, so that a collapse costs what its surroundings cost, at a hub too.

use crate::split_seams::SplitMesh;

/// Lists up to this length are rid of dead triangles at once.
const SHORT_LIST: usize = 32;

/// Triangles of the mesh as collapsed so far.
#[derive(Debug)]
pub(crate) struct Topology {
    /// Corners as variants. Those of dead triangles stay as they died.
    pub triangles: Vec<[u32; 3]>,
    /// Corners as positions.
    pub triangle_positions: Vec<[u32; 3]>,
    /// Whether a triangle still counts.
    pub alive: Vec<bool>,
    /// Living triangles.
    pub alive_count: u32,
    incident: Vec<Vec<u32>>,
    dead_counts: Vec<u32>,
}

/// An edge seen from one of its ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spoke {
    /// The other end.
    pub to: u32,
    /// Living triangles on the edge.
    pub triangle_count: u32,
    /// The first two of them.
    pub triangles: [u32; 2],
}

impl Topology {
    /// All triangles alive.
    pub fn new(split: &SplitMesh) -> Self {
        let triangle_positions: Vec<[u32; 3]> =
            split.triangles.iter().map(|t| t.map(|v| split.position_of(v))).collect();
        let mut incident = vec![Vec::new(); split.position_source.len()];
        for (t, corners) in triangle_positions.iter().enumerate() {
            for &p in corners {
                incident[p as usize].push(t as u32);
            }
        }
        Self {
            triangles: split.triangles.clone(),
            alive: vec![true; triangle_positions.len()],
            alive_count: triangle_positions.len() as u32,
            triangle_positions,
            dead_counts: vec![0; incident.len()],
            incident,
        }
    }

    /// Living triangles at a position.
    pub fn around(&self, p: u32) -> impl Iterator<Item = u32> + '_ {
        let all_alive = self.dead_counts[p as usize] == 0;
        self.incident[p as usize].iter().copied().filter(move |&t| all_alive || self.alive[t as usize])
    }

    /// Number of living triangles at a position.
    pub fn valence(&self, p: u32) -> usize {
        self.incident[p as usize].len() - self.dead_counts[p as usize] as usize
    }

    /// Corner of a triangle at a position.
    pub fn corner_at(&self, t: u32, p: u32) -> usize {
        self.triangle_positions[t as usize].iter().position(|&q| q == p).expect("the triangle lies at the position")
    }

    /// Whether a triangle has a corner at a position.
    pub fn touches(&self, t: u32, p: u32) -> bool {
        self.triangle_positions[t as usize].contains(&p)
    }

    /// The corner of a triangle that is neither `a` nor `b`, two of its corners.
    pub fn third(&self, t: u32, a: u32, b: u32) -> u32 {
        let corners = self.triangle_positions[t as usize];
        corners.into_iter().find(|&p| p != a && p != b).expect("a living triangle has three positions")
    }

    /// Number of living triangles on the edge between two positions; scans the end with fewer.
    pub fn edge_triangle_count(&self, a: u32, b: u32) -> u32 {
        let (few, other) = if self.valence(a) <= self.valence(b) { (a, b) } else { (b, a) };
        self.around(few).filter(|&t| self.touches(t, other)).count() as u32
    }

    /// Kills a triangle.
    pub fn remove(&mut self, t: u32) {
        debug_assert!(self.alive[t as usize]);
        self.alive[t as usize] = false;
        self.alive_count -= 1;
        for p in self.triangle_positions[t as usize] {
            self.dead_counts[p as usize] += 1;
            let list = &mut self.incident[p as usize];
            if list.len() <= SHORT_LIST || self.dead_counts[p as usize] as usize * 2 > list.len() {
                list.retain(|&t| self.alive[t as usize]);
                self.dead_counts[p as usize] = 0;
            }
        }
    }

    /// Moves the living triangles in `moved`, all at `from`, to `to`. `from` is left without any.
    pub fn move_triangles(&mut self, from: u32, to: u32, moved: &[u32]) {
        for &t in moved {
            let corner = self.corner_at(t, from);
            self.triangle_positions[t as usize][corner] = to;
        }
        self.incident[to as usize].extend_from_slice(moved);
        self.incident[from as usize] = Vec::new();
        self.dead_counts[from as usize] = 0;
    }
}
