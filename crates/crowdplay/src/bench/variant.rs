//! What takes part in a bench: a technique, with switches after plus signs.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use crowd_stages::{DrawOptions, Technique};
use std::fmt;
use std::str::FromStr;

/// A technique and what is switched on for it alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// How the crowd is drawn.
    pub technique: Technique,
    /// Whom others hide is left out.
    pub occlusion: bool,
}

impl Variant {
    /// The switches of its frames: its own over those of the whole bench.
    pub fn options(self, draw: DrawOptions) -> DrawOptions {
        DrawOptions { technique: self.technique, occlusion: self.occlusion || draw.occlusion, ..draw }
    }
}

impl From<Technique> for Variant {
    fn from(technique: Technique) -> Self {
        Self { technique, occlusion: false }
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let occlusion = if self.occlusion { "+occlusion" } else { "" };
        f.pad(&format!("{}{occlusion}", self.technique))
    }
}

impl FromStr for Variant {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split('+');
        let mut variant = Self::from(parts.next().unwrap_or_default().trim().parse::<Technique>()?);
        for part in parts {
            match part.trim() {
                "occlusion" if variant.technique == Technique::Bucketed => variant.occlusion = true,
                _ => return Err(format!("found {text:?}, allowed bucketed+occlusion")),
            }
        }
        Ok(variant)
    }
}

/// Reads a variant; the help lists all.
pub fn variants() -> impl TypedValueParser<Value = Variant> {
    let value = |t: Technique| PossibleValue::new(t.name()).alias(t.short_name()).help(t.describe());
    let occlusion = PossibleValue::new("bucketed+occlusion").help("The same without those whom others hide");
    PossibleValuesParser::new(Technique::ALL.map(value).into_iter().chain([occlusion]))
        .try_map(|name| name.parse::<Variant>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_read_back_and_nonsense_is_refused() {
        for name in ["bucketed", "reform", "bucketed+occlusion"] {
            assert_eq!(name.parse::<Variant>().unwrap().to_string(), name);
        }
        let draw = DrawOptions::default();
        assert!("bucketed+occlusion".parse::<Variant>().unwrap().options(draw).occludes());
        assert!(!"bucketed".parse::<Variant>().unwrap().options(draw).occludes());
        for name in ["", "b9", "reform+occlusion", "bucketed+speed", "bucketed+"] {
            assert!(name.parse::<Variant>().is_err(), "{name}");
        }
    }
}
