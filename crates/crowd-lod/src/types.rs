//! What goes in and what comes out.

/// Rows of an affine matrix: `out[r] = m[r][0]*x + m[r][1]*y + m[r][2]*z + m[r][3]`.
pub type Mat3x4 = [[f32; 4]; 3];

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why nothing was simplified.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The caller is wrong.
    #[error("{what}: found {found}, allowed {allowed}")]
    Parameter {
        /// Which value.
        what: String,
        /// Found.
        found: String,
        /// Allowed.
        allowed: String,
    },
}

/// The mesh to simplify. Per-vertex slices have one entry per vertex, per-triangle ones one per triangle.
#[derive(Debug, Clone, Copy)]
pub struct LodMesh<'a> {
    /// Bind-space positions, metres.
    pub positions: &'a [[f32; 3]],
    /// Unit normals.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates.
    pub uvs: &'a [[f32; 2]],
    /// Linear RGBA8 colours.
    pub colors: &'a [[u8; 4]],
    /// Joint indices, below the poses' `joint_count`.
    pub joints: &'a [[u16; 4]],
    /// Weights, summing to 1.
    pub weights: &'a [[f32; 4]],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// Material of each triangle; a border between two materials is a seam.
    pub triangle_materials: &'a [u16],
    /// What the textures show, as far as it is known.
    pub appearance: Appearance<'a>,
}

/// What the textures of a mesh show. Empty slices where nobody looked: then a slide of the texture costs by its length alone, and
/// colours are those of the vertices.
#[derive(Debug, Clone, Copy, Default)]
pub struct Appearance<'a> {
    /// For each vertex, the colour seen there: texture times factor times vertex colour, sRGB, 0..=1.
    pub shown_colors: &'a [[f32; 3]],
    /// For each triangle, how fast the texture's colours change in it: RMS of the RGB difference for a small step, per unit of
    /// texture coordinate.
    pub triangle_contrast: &'a [f32],
    /// The textures themselves.
    pub textures: Option<&'a dyn ShownColors>,
    /// For each material, whether it is shaded by the faces' own normals.
    pub flat_materials: &'a [bool],
}

/// Looks colours up where no vertex is.
pub trait ShownColors: std::fmt::Debug + Sync {
    /// The colour of a material at a texture coordinate, sRGB, 0..=1. `tint`: the vertex colour there, linear.
    fn color(&self, material: u16, uv: [f32; 2], tint: [f32; 3]) -> [f32; 3];

    /// Whether two materials (or one with itself) have no texture and look alike but for their colours: triangles of one may then get the
    /// other.
    fn differ_in_color_alone(&self, _a: u16, _b: u16) -> bool {
        false
    }

    /// Whether a material is seen everywhere, whatever the alpha of its texture and vertices: only then a triangle gets other colours.
    fn is_opaque(&self, _material: u16) -> bool {
        true
    }
}

/// The poses that count.
#[derive(Debug, Clone, Copy)]
pub struct LodPoses<'a> {
    /// Whole frames of `joint_count` premultiplied matrices, frame by frame. At least one frame.
    pub palettes: &'a [Mat3x4],
    /// Matrices a frame.
    pub joint_count: usize,
    /// Weight of each frame in the mean cost, summing to 1 (clips weigh equally, so a frame weighs
    /// `1 / (clips * frames of its clip)`).
    pub frame_weights: &'a [f32],
}

/// Which collapses are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Criteria {
    /// Everything has a price (default): wedges move in pairs along their seam where they can, and keep what they show where they
    /// have no image; lost parts and turned triangles are charged.
    #[default]
    Wedge,
    /// Peng 2011 §4.2 to the letter: classes are fixed once; fixed vertices never move.
    Peng2011,
}

/// How much the cost of a collapse minds what a surface shows, next to its shape. 1 is the default, 0 does not mind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttributeWeights {
    /// Textures that slide.
    pub uv: f32,
    /// Normals.
    pub normal: f32,
    /// Vertex colours, and the colours of parts that vanish.
    pub color: f32,
    /// Layers that come through each other; see `layer_gaps`.
    pub layers: f32,
}

impl Default for AttributeWeights {
    fn default() -> Self {
        Self { uv: 1.0, normal: 1.0, color: 1.0, layers: 1.0 }
    }
}

/// Which frames the cost of a collapse is averaged over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameChoice {
    /// Frames that stand for all others, up to 64, checked on all afterwards (default).
    #[default]
    Auto,
    /// Every frame. Memory grows with positions times frames.
    All,
    /// The bind pose alone, as tools do that know no clips: to see what the frames are worth.
    Bind,
}

/// Knobs of [`crate::simplify`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LodOptions {
    /// Which collapses are allowed.
    pub criteria: Criteria,
    /// What the cost minds beside shape; [`Criteria::Peng2011`] minds shape alone.
    pub attribute_weights: AttributeWeights,
    /// Which frames count.
    pub frames: FrameChoice,
    /// Factors on the weights of the frames in the costs, one a frame, 0 or more, not all 0; empty for none.
    pub frame_factors: Vec<f32>,
    /// Where the order ends.
    pub coarsest: Coarsest,
}

/// Where an order ends: once a level has at most so many triangles, or earlier, where nothing may collapse any more.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Coarsest {
    /// Where nothing may collapse any more (default).
    #[default]
    Last,
    /// A level that still shows a character far away: half a percent of the triangles, and not below 16 of them or 2 %, whichever is less.
    Useful,
    /// So many triangles.
    Triangles(u32),
    /// This share of the triangles, 0..=1.
    Share(f32),
}

impl Coarsest {
    /// Triangles at which the order of a mesh of `full` triangles may end.
    pub fn triangles(self, full: u32) -> u32 {
        // A tenth of 10 triangles is 1, although 0.1 is a little more than a tenth in binary.
        let share = |share: f64| (f64::from(full) * share + 1.0e-6) as u32;
        match self {
            Self::Last => 0,
            Self::Useful => share(USEFUL_SHARE).max(USEFUL_TRIANGLES.min(share(SMALL_MESH_SHARE))),
            Self::Triangles(count) => count,
            Self::Share(of_all) => share(f64::from(of_all)),
        }
    }
}

/// Share of the triangles below which real characters err by a tenth of their height: see `docs/decisions/0016-where-orders-end.md`.
const USEFUL_SHARE: f64 = 0.005;
/// Triangles below which no character is told from another.
const USEFUL_TRIANGLES: u32 = 16;
/// A share that is always within reach, for meshes of few triangles.
const SMALL_MESH_SHARE: f64 = 0.02;

/// Peng 2011 §4.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VertexClass {
    /// On an open border, or split more than in two.
    Fixed,
    /// Split in two along a seam: moves only together with its companion.
    Companion,
    /// Not split.
    Regular,
}

/// Seams and classes of a mesh at full detail.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeamReport {
    /// Distinct positions (with distinct skinning).
    pub position_count: u32,
    /// Vertices after splitting: distinct position, UV, colour, material and normal.
    pub vertex_count: u32,
    /// Vertices counted by UV and material alone: the paper's universal index.
    pub wedge_count: u32,
    /// Positions with two or more wedges.
    pub seam_position_count: u32,
    /// Wedges of class fixed.
    pub fixed_count: u32,
    /// Of these, on an open border.
    pub border_count: u32,
    /// Wedges of class companioned.
    pub companion_count: u32,
    /// Wedges of class regular.
    pub regular_count: u32,
    /// Triangles dropped because two corners share a position.
    pub degenerate_triangle_count: u32,
    /// Triangles dropped because another one has the same corners, attributes and front.
    pub duplicate_triangle_count: u32,
    /// Triangles kept that share all three places with another one: turned round, or with other attributes.
    pub coincident_triangle_count: u32,
    /// Edges with more than two triangles.
    pub non_manifold_edge_count: u32,
    /// Positions where the surface is no (half-)disc: on such an edge, or where several fans meet in a point.
    pub non_manifold_position_count: u32,
    /// Collapses onto places with more than 1,024 triangles that were not compared with others once more, so that time is bounded; 0 before simplifying.
    pub hurried_collapse_count: u32,
}

/// The result: vertices and triangles in collapse order, coarse first.
///
/// A level is a prefix: the first `vertex_count` vertices and the first `triangle_count` triangles, indices looked up in
/// `collapse_map` until they fall below `vertex_count`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CollapseOrder {
    /// For each vertex of the order, the input vertex whose place and skinning it has.
    pub vertex_source: Vec<u32>,
    /// For each vertex of the order, the input vertex whose texture coordinate and colour it has: mostly the same.
    /// A wedge that moves to a place where its chart is unknown keeps its own attributes there, as a vertex that only
    /// coarser levels use: a stand-in.
    pub attribute_source: Vec<u32>,
    /// For each vertex of the order, the input vertex whose normal it has: mostly the same.
    pub normal_source: Vec<u32>,
    /// For each vertex of the order, its material.
    pub vertex_materials: Vec<u16>,
    /// For each vertex of the order, its class at full detail.
    pub vertex_classes: Vec<VertexClass>,
    /// Full-detail triangles in the order's vertex indices; the last is the first to vanish.
    pub triangles: Vec<[u32; 3]>,
    /// For each input triangle kept, where it came from: input triangle of each triangle of the order.
    pub triangle_source: Vec<u32>,
    /// Target of each vertex, smaller than the vertex itself; a vertex that never collapses maps to itself.
    pub collapse_map: Vec<u32>,
    /// All levels, coarsest first; the last is full detail. Between two entries no vertex count is a level: companions
    /// go together.
    pub levels: Vec<Level>,
    /// Seams and classes.
    pub seams: SeamReport,
    /// Why the coarsest level goes no further.
    pub blocked: Blocked,
    /// For each vertex of the coarsest level, what keeps its position there: of its edges, the one that came furthest.
    pub obstacles: Vec<Obstacle>,
    /// Which frames counted.
    pub frames: FrameReport,
}

/// Which frames the costs were averaged over, and whether they stood for all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameReport {
    /// Frames given.
    pub given: u32,
    /// Frames that counted; 0 for the bind pose alone.
    pub used: u32,
    /// Times the order was made anew with more frames because the check failed.
    pub rerun_count: u32,
    /// The last check; `None` where every frame counted, and for the bind pose.
    pub check: Option<FrameCheck>,
}

/// How well chosen frames stand for all, measured on levels of a quarter and a twentieth of the triangles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameCheck {
    /// How far the RMS error over the chosen frames, by their weights, lies off that over all frames, as a share of it.
    pub deviation: f32,
    /// RMS error of the worst of all frames over that of the worst chosen one, 1 or more.
    pub worst_ratio: f32,
    /// Whether both lie within what is allowed: 3 % and 1.1.
    pub holds: bool,
}

/// One level of the continuous order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Level {
    /// Vertices: the paper's k.
    pub vertex_count: u32,
    /// Triangles: the paper's q(k).
    pub triangle_count: u32,
    /// Root of the largest mean squared distance paid by any collapse so far, metres: an estimate, not a bound.
    ///
    /// The mean is over the area concerned and over frames, with 0.2 of the worst frame added under [`Criteria::Wedge`].
    /// Distances are those to the planes of full detail; of what vanished, to what shows in its place, with the difference in
    /// colour counted as a distance.
    pub error_m: f32,
}

/// Two-sided closest-point distance over frames.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeasuredError {
    /// Root mean square, metres.
    pub rms_m: f32,
    /// Largest, metres.
    pub max_m: f32,
    /// Frame of the largest, an index into the poses given.
    pub max_frame: u32,
}

/// What keeps a position from moving; later members were reached only by passing the earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Obstacle {
    /// The position may not move at all, or only along its border.
    Fixed,
    /// A wedge has no image, or several.
    Seam,
    /// The surface would not stay a surface.
    Topology,
    /// A triangle would flip in space or in the texture.
    Flip,
    /// Nothing: the order was ended here, see [`Coarsest`].
    Ended,
}

/// Counts of positions at the coarsest level, by what keeps them there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Blocked {
    /// On an open border, or locked by class.
    pub fixed: u32,
    /// A seam whose wedges find no partner.
    pub seam: u32,
    /// Would change the topology (link condition).
    pub topology: u32,
    /// Would flip a triangle in some pose or in the texture.
    pub flip: u32,
    /// Could still move: the order was ended before.
    pub ended: u32,
}
