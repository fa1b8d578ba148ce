//! What takes part in a bench: a technique, with switches after plus signs.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use crowd_stages::{DrawOptions, FrameConfig, Skinning, Technique};
use std::fmt;
use std::str::FromStr;

/// A technique and what is switched on for it alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// How the crowd is drawn.
    pub technique: Technique,
    /// Whom others hide is left out.
    pub occlusion: bool,
    /// Where its vertices are worked out; `None`: as in the whole bench.
    pub skinning: Option<Skinning>,
    /// With four shadow maps.
    pub shadows: bool,
    /// Levels change at once.
    pub jumps: bool,
    /// Every frame uses all it can of the budget, however levels move for it.
    pub eager: bool,
    /// Everyone is halfway from one clip to another, in every frame.
    pub fades: bool,
    /// Small ones are impostors, where the pack has them; without, nobody is.
    pub impostors: bool,
    /// Poses of far ones are held.
    pub rates: bool,
    /// The same, and those in one pose share it.
    pub shares: bool,
}

/// Shadow maps of a variant with shadows.
const SHADOW_MAPS: u32 = 4;

impl Variant {
    /// The switches of its frames: its own over those of the whole bench.
    pub fn options(self, draw: DrawOptions) -> DrawOptions {
        DrawOptions {
            technique: self.technique,
            occlusion: self.occlusion || draw.occlusion,
            skinning: self.skinning.unwrap_or(draw.skinning),
            shadows: if self.shadows { SHADOW_MAPS } else { draw.shadows },
            no_morph: self.jumps || draw.no_morph,
            no_impostors: !self.impostors,
            holds_poses: self.rates || self.shares || draw.holds_poses,
            share_poses: self.shares || draw.share_poses,
            ..draw
        }
    }

    /// The frame as it has it.
    pub fn config(self, config: FrameConfig) -> FrameConfig {
        let slack = if self.eager { 0 } else { config.slack };
        FrameConfig { slack, ..config }
    }
}

impl From<Technique> for Variant {
    fn from(technique: Technique) -> Self {
        Self {
            technique,
            occlusion: false,
            jumps: false,
            eager: false,
            impostors: false,
            skinning: None,
            shadows: false,
            fades: false,
            rates: false,
            shares: false,
        }
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let occlusion = if self.occlusion { "+occlusion" } else { "" };
        let jumps = if self.jumps { "+jumps" } else { "" };
        let eager = if self.eager { "+eager" } else { "" };
        let impostors = if self.impostors { "+impostors" } else { "" };
        let skinning = self.skinning.map(|way| format!("+{}", way.name())).unwrap_or_default();
        let shadows = if self.shadows { "+shadows" } else { "" };
        let fades = if self.fades { "+fades" } else { "" };
        let rates = if self.rates { "+rates" } else { "" };
        let shares = if self.shares { "+share" } else { "" };
        f.pad(&format!(
            "{}{occlusion}{jumps}{impostors}{eager}{skinning}{shadows}{fades}{rates}{shares}",
            self.technique
        ))
    }
}

impl FromStr for Variant {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split('+');
        let mut variant = Self::from(parts.next().unwrap_or_default().trim().parse::<Technique>()?);
        let is_bucketed = variant.technique == Technique::Bucketed;
        let has_water = variant.technique.has_budget();
        for part in parts.map(str::trim) {
            let way = Skinning::WAYS.into_iter().find(|way| way.name() == part);
            match way {
                Some(_) if is_bucketed && variant.skinning.is_none() => variant.skinning = way,
                None if is_bucketed && part == "occlusion" => variant.occlusion = true,
                None if is_bucketed && part == "jumps" => variant.jumps = true,
                None if has_water && part == "eager" => variant.eager = true,
                None if is_bucketed && part == "impostors" => variant.impostors = true,
                None if part == "shadows" => variant.shadows = true,
                None if part == "fades" => variant.fades = true,
                None if part == "rates" => variant.rates = true,
                None if is_bucketed && part == "share" => variant.shares = true,
                _ => {
                    let ways = Skinning::WAYS.map(Skinning::name).join(", ");
                    return Err(format!(
                        "found {text:?}, allowed after bucketed+: occlusion, jumps, impostors, eager, shadows, fades, rates, share and one of {ways}; after others +shadows, +fades and +rates, after those with a budget +eager"
                    ));
                }
            }
        }
        if variant.technique == Technique::StaticFloor && variant.rates {
            return Err(format!(
                "found {text:?}, allowed +rates after others: the floor is baked anew for each frame, with everyone's pose of that time"
            ));
        }
        if variant.shares && !matches!(variant.skinning, Some(Skinning::Palettes | Skinning::Compute)) {
            return Err(format!("found {text:?}, allowed +share after bucketed+compute or bucketed+palettes"));
        }
        Ok(variant)
    }
}

/// Reads a variant; the help lists all.
pub fn variants() -> impl TypedValueParser<Value = Variant> {
    let value = |t: Technique| PossibleValue::new(t.name()).alias(t.short_name()).help(t.describe());
    let bucketed = |name: &'static str, help: &'static str| PossibleValue::new(name).help(help);
    let of_bucketed = [
        bucketed("bucketed+occlusion", "The same without those whom others hide"),
        bucketed("bucketed+shadows", "The same with four shadow maps of the sun"),
        bucketed("bucketed+occlusion+shadows", "Both"),
        bucketed("bucketed+vertex+shadows", "Shadow maps, everything skinned by the vertex shader"),
        bucketed("bucketed+palettes+shadows", "Shadow maps, the camera's people skinned from palettes"),
        bucketed("bucketed+compute+shadows", "Shadow maps of vertices that a compute stage has skinned for the camera"),
        bucketed("bucketed+jumps", "The same with levels that change at once"),
        bucketed("bucketed+impostors", "The same with small ones as pictures, where the pack has them (--impostors)"),
        bucketed("bucketed+eager", "The same where every frame uses all it can of the budget, as with no slack"),
        bucketed(
            "bucketed+rates",
            "The same with poses of far ones held for a while (--pose-rates, or within a pixel)",
        ),
        bucketed(
            "bucketed+compute+share",
            "Skinned by a compute stage, each pose that is held once for all who are in it",
        ),
        bucketed("bucketed+palettes+share", "The same of palettes"),
        bucketed("bucketed+compute+rates", "Skinned by a compute stage, poses of far ones held"),
        bucketed("bucketed+fades", "The same with everyone halfway from one clip to another"),
        bucketed("bucketed+vertex+fades", "The same, skinned by the vertex shader"),
        bucketed("bucketed+palettes+fades", "The same, skinned from palettes"),
        bucketed("bucketed+compute+fades", "The same, skinned by a compute stage"),
        bucketed("bucketed+vertex", "Skinned by the vertex shader from two frames"),
        bucketed("bucketed+palettes", "Skinned by the vertex shader from palettes blended beforehand"),
        bucketed("bucketed+compute", "Skinned by a compute stage"),
    ];
    PossibleValuesParser::new(Technique::ALL.map(value).into_iter().chain(of_bucketed))
        .try_map(|name| name.parse::<Variant>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_read_back_and_nonsense_is_refused() {
        for name in [
            "bucketed",
            "reform",
            "bucketed+occlusion",
            "bucketed+compute",
            "bucketed+occlusion+vertex+shadows",
            "bucketed+jumps",
            "bucketed+eager",
            "reform+eager",
            "bucketed+impostors",
            "bucketed+palettes+fades",
            "reform+fades",
            "bucketed+compute+rates",
            "bucketed+compute+share",
            "bucketed+compute+shadows",
        ] {
            assert_eq!(name.parse::<Variant>().unwrap().to_string(), name);
        }
        let draw = DrawOptions::default();
        assert!("bucketed+occlusion".parse::<Variant>().unwrap().options(draw).occludes());
        let way = |name: &str| name.parse::<Variant>().unwrap().options(draw).skinning;
        assert_eq!([way("bucketed"), way("bucketed+palettes")], [Skinning::Auto, Skinning::Palettes]);
        let impostors = |name: &str| !name.parse::<Variant>().unwrap().options(draw).no_impostors;
        assert_eq!([impostors("bucketed"), impostors("bucketed+impostors")], [false, true]);
        assert!(!"bucketed+jumps".parse::<Variant>().unwrap().options(draw).morphs());
        assert!(!"bucketed".parse::<Variant>().unwrap().options(draw).occludes());
        for name in [
            "",
            "b9",
            "bucketed+share",
            "reform+share",
            "reform+occlusion",
            "bucketed+speed",
            "bucketed+",
            "b3+compute",
            "bucketed+vertex+compute",
            "static-floor+rates",
            "instanced+eager",
        ] {
            assert!(name.parse::<Variant>().is_err(), "{name}");
        }
    }
}
