//! The ways to draw a crowd, and what can be switched on them.

use std::fmt;
use std::str::FromStr;

/// How the crowd is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Technique {
    /// B0: one draw per instance at full detail, no culling: the baseline of Peng 2011 and Dong 2019.
    PseudoInstancing,
    /// B1: instances culled by the frustum, all at full detail, one instanced draw a character.
    Instanced,
    /// B2: three discrete levels by depth, culling by a widened frustum, one instanced draw a level and character
    /// (Park & Han 2009).
    Discrete,
    /// B3: per-frame triangle reformation into one index buffer, one indirect draw (Peng 2011 §5, Dong 2019 §5.3).
    Reform,
    /// B4: the triangles that [`Self::Bucketed`] would draw, placed beforehand: what drawing alone costs. Each frame is baked
    /// by [`crate::gpu::CrowdRenderer::bake_floor`] first.
    StaticFloor,
    /// P: far characters as points of one pixel from their surface, in four densities, near ones at full detail (the comparison of
    /// Dong 2019 §6.2).
    Points,
    /// Ours: instances sorted by character and quantised level, one indirect draw for each of those from index tables in
    /// cache order; nothing is written per triangle.
    #[default]
    Bucketed,
}

impl Technique {
    /// All, in the order of their short names, ours last.
    pub const ALL: [Self; 7] = [
        Self::PseudoInstancing,
        Self::Instanced,
        Self::Discrete,
        Self::Reform,
        Self::StaticFloor,
        Self::Points,
        Self::Bucketed,
    ];

    /// Place in [`Self::ALL`].
    pub(crate) fn number(self) -> usize {
        Self::ALL.iter().position(|technique| *technique == self).expect("ALL holds all")
    }

    /// The name, as in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::PseudoInstancing => "pseudo-instancing",
            Self::Instanced => "instanced",
            Self::Discrete => "discrete",
            Self::Reform => "reform",
            Self::StaticFloor => "static-floor",
            Self::Points => "points",
            Self::Bucketed => "bucketed",
        }
    }

    /// The short name, `b0` to `b4` and `p` for what others have published.
    pub fn short_name(self) -> &'static str {
        match self {
            Self::PseudoInstancing => "b0",
            Self::Instanced => "b1",
            Self::Discrete => "b2",
            Self::Reform => "b3",
            Self::StaticFloor => "b4",
            Self::Points => "p",
            Self::Bucketed => "bucketed",
        }
    }

    /// One line on what it does.
    pub fn describe(self) -> &'static str {
        match self {
            Self::PseudoInstancing => "One draw per instance at full detail, nothing culled (Peng 2011's baseline)",
            Self::Instanced => "Frustum culling, full detail, one instanced draw a character",
            Self::Discrete => "Three levels by depth, one instanced draw each a character (Park & Han 2009)",
            Self::Reform => "Continuous levels reformed into one index buffer each frame, one draw (Dong 2019)",
            Self::StaticFloor => "What bucketed draws, placed beforehand: what drawing alone costs",
            Self::Points => "Far characters as points of their surface (what Dong 2019 compares with)",
            Self::Bucketed => "Instances sorted by character and level, drawn from index tables in cache order",
        }
    }

    /// Whether the budget decides the levels.
    pub fn has_budget(self) -> bool {
        matches!(self, Self::Reform | Self::StaticFloor | Self::Bucketed)
    }
}

impl fmt::Display for Technique {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Technique {
    type Err = String;

    /// By [`Technique::name`] or [`Technique::short_name`]; case does not count.
    fn from_str(text: &str) -> Result<Self, String> {
        let fits = |t: &Self| text.eq_ignore_ascii_case(t.name()) || text.eq_ignore_ascii_case(t.short_name());
        let names = || Self::ALL.map(Self::name).join(", ");
        Self::ALL.into_iter().find(fits).ok_or_else(|| format!("found {text:?}, allowed {}", names()))
    }
}

/// Which levels an instance may get.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Levels {
    /// Every level of the LOD table.
    #[default]
    Continuous,
    /// Those with index tables: up to 64 a character.
    Quantized,
}

/// How the budget is split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Fit {
    /// Water filling ([`crate::cpu::fill_budget`]): all of N is used whenever more is wanted.
    #[default]
    Fill,
    /// Eq. 1 as printed, shrunk where clamping took it above N ([`crate::cpu::fit_budget`]).
    Plain,
}

/// Where [`Technique::Bucketed`] works out its vertices. The picture is the same, bit for bit, where nobody fades; who fades differs by rounding: in the
/// picture between [`Self::Vertex`] and the others, in shadow maps between [`Self::Compute`], which lends casters its vertices, and the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Skinning {
    /// Whichever takes this adapter the least time, measured over the first frames; [`Self::Palettes`], unmeasured, where somebody may fade.
    #[default]
    Auto,
    /// In the vertex shader, from two frames of the clip.
    Vertex,
    /// In the vertex shader, from palettes that a compute stage has blended.
    Palettes,
    /// By a compute stage: each vertex once, however many passes draw it.
    Compute,
}

impl Skinning {
    /// All that can draw a frame.
    pub const WAYS: [Self; 3] = [Self::Vertex, Self::Palettes, Self::Compute];

    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Vertex => "vertex",
            Self::Palettes => "palettes",
            Self::Compute => "compute",
        }
    }
}

/// What a picture shows. All but [`Self::Shaded`] lay a coloured tag over everyone drawn; not [`Technique::PseudoInstancing`],
/// [`Technique::Discrete`] and [`Technique::Points`], whose levels are not those of the shared selection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum View {
    /// People as they look.
    #[default]
    Shaded = 0,
    /// Their levels' vertices between a character's coarsest mesh (blue) and full detail (red), by logarithms.
    Levels = 1,
    /// Triangles of their levels a pixel of their bounding spheres: from a hundredth (blue) to one and more (red).
    Density = 2,
    /// Full detail red, meshes between green, coarsest meshes blue, dots purple.
    Representation = 3,
    /// With occlusion culling: in sight green, drawn but then found hidden orange, hidden and left out red.
    Occlusion = 4,
}

impl View {
    /// All.
    pub const ALL: [Self; 5] = [Self::Shaded, Self::Levels, Self::Density, Self::Representation, Self::Occlusion];

    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaded => "shaded",
            Self::Levels => "levels",
            Self::Density => "density",
            Self::Representation => "representation",
            Self::Occlusion => "occlusion",
        }
    }
}

/// A technique with its switches: what [`crate::gpu::CrowdRenderer::encode`] is told beside the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct DrawOptions {
    /// How the crowd is drawn.
    pub technique: Technique,
    /// Levels of [`Technique::Reform`]; [`Technique::Bucketed`] draws quantised ones whatever stands here.
    pub levels: Levels,
    /// How the budget is split.
    pub fit: Fit,
    /// Vertices of [`Technique::Bucketed`] stay at their level's places, so that levels change at once.
    pub no_morph: bool,
    /// [`Technique::Bucketed`] draws nobody as their impostor, whatever the frame's `impostor_area_px2` says.
    pub no_impostors: bool,
    /// [`Technique::Bucketed`] leaves out whom others hide: two-phase occlusion culling, see [`Self::occludes`].
    pub occlusion: bool,
    /// Where [`Technique::Bucketed`] works out its vertices.
    pub skinning: Skinning,
    /// Shadow maps of the sun, 0 to 4; none without.
    pub shadows: u32,
    /// Poses of far ones are held for a while: see [`crate::cpu::hold_poses`]; how long, the frame's `hold_far_m` and `hold_px` say.
    pub holds_poses: bool,
    /// [`Technique::Bucketed`] skins each pose that is held once, for all who are in it: see [`Self::shares_poses`].
    pub share_poses: bool,
    /// What the picture shows, as far as the other switches allow ([`Self::shown_view`]).
    pub view: View,
    /// Who is drawn and at which levels stays as in the technique's last frame; camera and poses go on. A frame that comes first,
    /// or after other instances, is a frame like any other; hidden ones are not left out.
    pub frozen: bool,
}

impl DrawOptions {
    /// The levels that will be chosen from.
    pub fn levels(&self) -> Levels {
        match self.technique {
            Technique::Bucketed | Technique::StaticFloor => Levels::Quantized,
            _ => self.levels,
        }
    }
}

impl DrawOptions {
    /// Whether vertices move between levels: only where tables are drawn whose levels follow the water's height.
    pub fn morphs(&self) -> bool {
        let moves = matches!(self.technique, Technique::Bucketed | Technique::StaticFloor);
        moves && self.fit == Fit::Fill && !self.no_morph
    }
}

impl DrawOptions {
    /// Whether hidden instances are left out: where buckets are drawn by levels that follow the water's height, which says at
    /// which levels newly seen ones come.
    pub fn occludes(&self) -> bool {
        self.technique == Technique::Bucketed && self.fit == Fit::Fill && self.occlusion && !self.frozen
    }

    /// Whether instances share poses: where they are held and worked out before the draw. Frozen frames have lists of another time.
    pub fn shares_poses(&self) -> bool {
        let has_palettes = matches!(self.skinning, Skinning::Palettes | Skinning::Compute);
        self.technique == Technique::Bucketed && has_palettes && self.holds_poses && self.share_poses && !self.frozen
    }

    /// The view that is shown: shaded where the one asked for has nothing to say. Occlusion culling overwrites the levels of its first
    /// phase, and without it nobody is hidden.
    pub fn shown_view(&self) -> View {
        let has_levels =
            !matches!(self.technique, Technique::PseudoInstancing | Technique::Discrete | Technique::Points);
        match self.view {
            View::Occlusion if !self.occludes() => View::Shaded,
            View::Levels | View::Density | View::Representation if self.occludes() || !has_levels => View::Shaded,
            view => view,
        }
    }

    /// Whether characters a few pixels high may be dots, or impostors where the crowd has them.
    pub fn has_dots(&self) -> bool {
        self.technique == Technique::Bucketed && self.fit == Fit::Fill
    }
}

impl From<Technique> for DrawOptions {
    fn from(technique: Technique) -> Self {
        Self { technique, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for technique in Technique::ALL {
            assert_eq!(technique.to_string().parse(), Ok(technique));
            assert_eq!(technique.short_name().to_uppercase().parse(), Ok(technique));
            assert_eq!(Technique::ALL[technique.number()], technique);
        }
        let error = "b9".parse::<Technique>().expect_err("there is no such");
        assert!(error.contains("b9") && error.contains("bucketed"), "{error}");
    }

    #[test]
    fn bucketed_knows_quantised_levels_only() {
        let both = [Technique::Reform, Technique::Bucketed].map(|t| DrawOptions::from(t).levels());
        assert_eq!(both, [Levels::Continuous, Levels::Quantized]);
    }
}
