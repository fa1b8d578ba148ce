//! Who takes part in a comparison.

use clap::ValueEnum;

/// A way to make levels. The words of `--ours` and `--peers`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Contender {
    /// Ours: the default order.
    Wedge,
    /// Ours: levels of `wedge` with their vertices moved.
    Refit,
    /// Ours: the default order from the pose at rest alone.
    Bind,
    /// Ours: the criteria of Peng 2011 to the letter.
    Peng2011,
    /// meshoptimizer, `simplify_with_attributes`, every primitive by the same share.
    MeshoptAttr,
    /// meshoptimizer, `simplify_with_update`, every primitive by the same share.
    MeshoptUpdate,
    /// meshoptimizer, `simplify_with_attributes` over the whole character.
    MeshoptGlobal,
    /// meshoptimizer, `simplify_with_update` over the whole character.
    MeshoptBest,
    /// gltfpack with `-si R -se 1`.
    GltfpackSe1,
    /// gltfpack with `-sv -sp`: every mesh stops at one relative error.
    GltfpackBest,
}

impl Contender {
    /// All of ours.
    pub const OURS: [Self; 4] = [Self::Wedge, Self::Refit, Self::Bind, Self::Peng2011];

    /// All others.
    pub const PEERS: [Self; 6] = [
        Self::MeshoptAttr,
        Self::MeshoptUpdate,
        Self::MeshoptGlobal,
        Self::MeshoptBest,
        Self::GltfpackSe1,
        Self::GltfpackBest,
    ];

    /// True for what this program makes.
    pub fn is_ours(self) -> bool {
        Self::OURS.contains(&self)
    }

    /// True for what the program gltfpack makes.
    pub fn is_gltfpack(self) -> bool {
        matches!(self, Self::GltfpackSe1 | Self::GltfpackBest)
    }

    /// Its name in tables and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wedge => "wedge",
            Self::Refit => "refit",
            Self::Bind => "bind",
            Self::Peng2011 => "peng2011",
            Self::MeshoptAttr => "meshopt-attr",
            Self::MeshoptUpdate => "meshopt-update",
            Self::MeshoptGlobal => "meshopt-global",
            Self::MeshoptBest => "meshopt-best",
            Self::GltfpackSe1 => "gltfpack-se1",
            Self::GltfpackBest => "gltfpack-best",
        }
    }
}
