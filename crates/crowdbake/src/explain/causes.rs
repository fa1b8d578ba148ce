//! Why a position of the coarsest level stays, finer than the bake's four obstacles, and what would set it free.
//!
//! The obstacle is the bake's own word, stored in the pack. The cause is read off the coarsest level around the position:
//! an open border, a meeting of charts, a piece of four triangles.

use crate::unpack::Unpacked;
use crowd_pack::{LodRecord, obstacle, vertex_class};
use std::collections::BTreeMap;

/// Triangles of the smallest closed piece there is.
const SMALLEST_PIECE: u32 = 4;

/// Why a position stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// A triangle would turn over, on the surface in some pose or in the texture.
    Fold,
    /// Three or more charts of the texture meet.
    ChartCorner,
    /// A material ends.
    MaterialBorder,
    /// A seam without a partner along it.
    SeamEnd,
    /// A separate piece that is as small as a closed piece can be.
    SmallestPiece,
    /// The surface would be pinched off or two of its sides would touch.
    Pinch,
    /// Nothing of the character would be left.
    LastPiece,
    /// An open border.
    OpenBorder,
    /// An edge of more than two triangles.
    CrowdedEdge,
    /// Of class fixed, which never moves under `peng2011`.
    FixedClass,
    /// Fixed for another reason: more triangles meet there than a collapse may move.
    Hub,
}

/// What a cause is called and what can be done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Words {
    /// What is there, as in "48 places where ...".
    pub what: &'static str,
    /// What to change in the asset.
    pub remedy: &'static str,
}

impl Cause {
    /// All causes, in the order in which they are listed.
    pub const ALL: [Self; 11] = [
        Self::Fold,
        Self::ChartCorner,
        Self::MaterialBorder,
        Self::SeamEnd,
        Self::SmallestPiece,
        Self::Pinch,
        Self::LastPiece,
        Self::OpenBorder,
        Self::CrowdedEdge,
        Self::FixedClass,
        Self::Hub,
    ];

    /// Its name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::ChartCorner => "chart-corner",
            Self::MaterialBorder => "material-border",
            Self::SeamEnd => "seam-end",
            Self::SmallestPiece => "smallest-piece",
            Self::Pinch => "pinch",
            Self::LastPiece => "last-piece",
            Self::OpenBorder => "open-border",
            Self::CrowdedEdge => "crowded-edge",
            Self::FixedClass => "fixed-class",
            Self::Hub => "hub",
        }
    }

    /// The bake's word for it, one of [`crowd_pack::obstacle`].
    pub fn obstacle(self) -> u8 {
        match self {
            Self::Fold => obstacle::FLIP,
            Self::ChartCorner | Self::MaterialBorder | Self::SeamEnd => obstacle::SEAM,
            Self::SmallestPiece | Self::Pinch | Self::LastPiece => obstacle::TOPOLOGY,
            Self::OpenBorder | Self::CrowdedEdge | Self::FixedClass | Self::Hub => obstacle::FIXED,
        }
    }

    /// A flag of the bake that lifts the cause, for a pack baked with these criteria.
    pub fn flag(self, criteria: &str) -> Option<&'static str> {
        let stays = matches!(self, Self::OpenBorder | Self::LastPiece | Self::Hub);
        (criteria == "peng2011" && !stays).then_some("--criteria wedge")
    }

    /// Its words.
    pub fn words(self) -> Words {
        let (what, remedy) = match self {
            Self::Fold => (
                "a triangle would fold over, on the surface or in the texture",
                "straighten the outlines of the UV charts there and give the texture fewer, larger charts",
            ),
            Self::ChartCorner => (
                "three or more UV charts meet",
                "weld the seam: sew two of the charts together, or let the seams meet in fewer places",
            ),
            Self::MaterialBorder => (
                "two materials meet",
                "put both on one material with one texture; a border that stays a seam of one material can close",
            ),
            Self::SeamEnd => (
                "a seam has no partner to close with",
                "weld the seam, or lead it on so that both of its sides have the same points",
            ),
            Self::SmallestPiece => (
                "a separate piece is down to four triangles, the least a closed piece can have",
                "join the piece to the surface below it, paint it into the texture, or leave it out of far levels",
            ),
            Self::Pinch => (
                "the surface would be pinched off, as a limb of three sides is",
                "end limbs, fingers and straps in one point; join what only touches",
            ),
            Self::LastPiece => ("nothing of the character would be left", "nothing: this is the end"),
            Self::OpenBorder => {
                ("the surface is open", "close the hole, or weld the open border to the surface next to it")
            }
            Self::CrowdedEdge => {
                ("more than two triangles share an edge", "split the surfaces there, or delete the faces inside")
            }
            Self::FixedClass => {
                ("the rules of peng2011 hold the vertex for good", "use fewer seams and no open borders")
            }
            Self::Hub => ("more than 128 triangles meet in one point", "break the fan up with a ring of edges"),
        };
        Words { what, remedy }
    }
}

/// A position of the coarsest level that cannot move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stuck {
    /// Its first vertex.
    pub vertex: u32,
    /// The bake's word for what keeps it, one of [`crowd_pack::obstacle`].
    pub obstacle: u8,
    /// Why.
    pub cause: Cause,
}

/// Each position of the coarsest level that cannot move, in the order of its vertices. Empty for a pack that does not say; those that could
/// move, had the bake not ended there, are left out.
pub fn stuck_positions(character: &Unpacked<'_>) -> Vec<Stuck> {
    let record = character.record;
    let level = LodRecord { vertex_count: record.min_vertex_count, triangle_count: record.min_triangle_count };
    let around = Surroundings::of(character, level);
    let peng = character.manifest.criteria == "peng2011";
    let mut seen = vec![false; around.position_of.len()];
    let mut stuck = Vec::new();
    for (vertex, &obstacle) in character.manifest.obstacles.iter().enumerate() {
        let position = around.position_of[vertex] as usize;
        if !std::mem::replace(&mut seen[position], true) && obstacle != obstacle::ENDED {
            let fixed_class = peng && character.vertices[vertex].class() == vertex_class::FIXED;
            let cause = around.cause(position, obstacle, peng, fixed_class);
            stuck.push(Stuck { vertex: vertex as u32, obstacle, cause });
        }
    }
    stuck
}

/// What lies around each position of a level.
struct Surroundings {
    /// Position of each vertex of the level.
    position_of: Vec<u32>,
    open: Vec<bool>,
    crowded: Vec<bool>,
    /// Distinct texture coordinates and materials.
    charts: Vec<u32>,
    materials: Vec<u32>,
    /// Triangles of the connected piece.
    piece_triangles: Vec<u32>,
}

impl Surroundings {
    fn of(character: &Unpacked<'_>, level: LodRecord) -> Self {
        let vertices = &character.vertices[..level.vertex_count as usize];
        let mut known = BTreeMap::new();
        let position_of: Vec<u32> = vertices
            .iter()
            .map(|vertex| {
                let next = known.len() as u32;
                *known.entry((vertex.position.map(f32::to_bits), vertex.joints, vertex.weights)).or_insert(next)
            })
            .collect();
        let position_count = known.len();
        let triangles = character.level_triangles(level);
        let mut edges: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut pieces = Pieces::new(position_count);
        for corners in &triangles {
            let corners = corners.map(|v| position_of[v as usize]);
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (corners[from], corners[to]);
                *edges.entry((a.min(b), a.max(b))).or_default() += 1;
                pieces.join(a, b);
            }
        }
        let mut around = Self {
            open: vec![false; position_count],
            crowded: vec![false; position_count],
            charts: distinct(&position_of, vertices, position_count, |v| (v.uv.map(f32::to_bits), v.material())),
            materials: distinct(&position_of, vertices, position_count, |v| ([0; 2], v.material())),
            piece_triangles: vec![0; position_count],
            position_of,
        };
        for (&(a, b), &count) in &edges {
            for end in [a as usize, b as usize] {
                around.open[end] |= count == 1;
                around.crowded[end] |= count > 2;
            }
        }
        let mut of_piece = vec![0_u32; position_count];
        for corners in &triangles {
            of_piece[pieces.root(around.position_of[corners[0] as usize]) as usize] += 1;
        }
        for position in 0..position_count {
            around.piece_triangles[position] = of_piece[pieces.root(position as u32) as usize];
        }
        around
    }

    fn cause(&self, position: usize, obstacle: u8, peng: bool, fixed_class: bool) -> Cause {
        match obstacle {
            obstacle::SEAM if self.charts[position] > 2 => Cause::ChartCorner,
            obstacle::SEAM if self.materials[position] > 1 => Cause::MaterialBorder,
            obstacle::SEAM => Cause::SeamEnd,
            // The default criteria let pieces vanish and the surface change its topology; only the last piece stays.
            obstacle::TOPOLOGY if !peng => Cause::LastPiece,
            obstacle::TOPOLOGY if self.piece_triangles[position] <= SMALLEST_PIECE => Cause::SmallestPiece,
            obstacle::TOPOLOGY => Cause::Pinch,
            obstacle::FLIP => Cause::Fold,
            _ if self.crowded[position] => Cause::CrowdedEdge,
            _ if self.open[position] => Cause::OpenBorder,
            _ if fixed_class => Cause::FixedClass,
            _ => Cause::Hub,
        }
    }
}

/// Number of different keys among the vertices of each position.
fn distinct<K: Ord>(
    position_of: &[u32],
    vertices: &[crowd_pack::VertexRecord],
    position_count: usize,
    key: impl Fn(&crowd_pack::VertexRecord) -> K,
) -> Vec<u32> {
    let mut keys: Vec<(u32, K)> = position_of.iter().copied().zip(vertices.iter().map(key)).collect();
    keys.sort_unstable();
    keys.dedup();
    let mut counts = vec![0; position_count];
    for (position, _) in keys {
        counts[position as usize] += 1;
    }
    counts
}

/// Connected pieces: a forest in which each position knows one nearer to its root.
struct Pieces {
    parents: Vec<u32>,
}

impl Pieces {
    fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    fn root(&mut self, mut position: u32) -> u32 {
        while self.parents[position as usize] != position {
            let next = self.parents[position as usize];
            self.parents[position as usize] = self.parents[next as usize];
            position = self.parents[position as usize];
        }
        position
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_joined_over_shared_positions() {
        let mut pieces = Pieces::new(6);
        for (a, b) in [(0, 1), (1, 2), (4, 5)] {
            pieces.join(a, b);
        }
        let roots: Vec<u32> = (0..6).map(|p| pieces.root(p)).collect();
        assert_eq!(roots, [0, 0, 0, 3, 4, 4]);
    }

    #[test]
    fn every_cause_has_words_and_a_remedy() {
        for cause in Cause::ALL {
            let words = cause.words();
            assert!(words.what.len() > 10 && words.remedy.len() > 10, "{cause:?}");
            assert_eq!(serde_json::to_value(cause).unwrap(), cause.name());
        }
    }
}
