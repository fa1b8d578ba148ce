//! Values of words: read, or refused with what is allowed.

use super::PoseRates;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use crowd_stages::{Technique, View};

/// Reads a technique by its long or short name.
pub fn techniques() -> impl TypedValueParser<Value = Technique> {
    let value = |t: Technique| PossibleValue::new(t.name()).alias(t.short_name()).help(t.describe());
    PossibleValuesParser::new(Technique::ALL.map(value)).try_map(|name| name.parse::<Technique>())
}

/// Reads a view by its name.
pub(super) fn views() -> impl TypedValueParser<Value = View> {
    let named = |name: String| View::ALL.into_iter().find(|view| view.name() == name).unwrap_or_default();
    PossibleValuesParser::new(View::ALL.map(View::name)).map(named)
}

pub(super) fn finite(text: &str) -> Result<f32, String> {
    let value: f32 = text.trim().parse().map_err(|_| format!("found {text:?}, allowed a number"))?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(format!("found {text}, allowed a number of single precision, at most 3.4e38 either way"))
    }
}

pub(super) fn within(text: &str, least: f32, greatest: f32) -> Result<f32, String> {
    let value = finite(text)?;
    if (least..=greatest).contains(&value) {
        Ok(value)
    } else {
        Err(format!("found {value}, allowed {least} to {greatest}"))
    }
}

pub(super) fn positive(text: &str) -> Result<f32, String> {
    within(text, 0.01, 10_000.0)
}

pub(super) fn dots_px(text: &str) -> Result<f32, String> {
    within(text, 0.0, 64.0)
}

pub(super) fn pose_rates(text: &str) -> Result<PoseRates, String> {
    let text = text.trim();
    if text.eq_ignore_ascii_case("off") {
        return Ok(PoseRates::Off);
    }
    let known = match text.strip_suffix("px") {
        Some(px) => within(px, 0.01, 1000.0).map(PoseRates::Px),
        None => within(text, 0.1, 1e6).map(PoseRates::FarM),
    };
    known.map_err(|e| format!("{e}; or off, metres as in 60, pixels as in 1px"))
}

pub(super) fn fade(text: &str) -> Result<f32, String> {
    within(text, 0.0, crowd_scene::Gait::SHORTEST_S)
}

pub(super) fn not_negative(text: &str) -> Result<f32, String> {
    within(text, 0.0, 86_400.0)
}

pub(super) fn fog(text: &str) -> Result<f32, String> {
    if text.eq_ignore_ascii_case("off") {
        return Ok(0.0);
    }
    within(text, 1.0, 1e6).map_err(|e| format!("{e}; or off"))
}

pub(super) fn shadows(text: &str) -> Result<u32, String> {
    if text.eq_ignore_ascii_case("off") {
        return Ok(0);
    }
    let maps = text.parse().ok().filter(|maps| (1..=4).contains(maps));
    maps.ok_or_else(|| format!("found {text:?}, allowed off or 1 to 4"))
}

pub(super) fn rate(text: &str) -> Result<f32, String> {
    within(text, 0.001, 10_000.0)
}

pub(super) fn alpha(text: &str) -> Result<f32, String> {
    within(text, 1.0, 100.0)
}

pub(super) fn fov(text: &str) -> Result<f32, String> {
    within(text, 1.0, 160.0)
}

pub(super) fn samples(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "4" => Ok(4),
        _ => Err(format!("found {text}, allowed 1 or 4")),
    }
}

pub(super) fn triple(text: &str) -> Result<[f32; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, z] = parts[..] else {
        return Err(format!("found {} numbers, allowed three with commas between", parts.len()));
    };
    Ok([finite(x)?, finite(y)?, finite(z)?])
}

pub(super) fn depths(text: &str) -> Result<[f32; 2], String> {
    let (near, far) =
        text.split_once(',').ok_or_else(|| format!("found {text:?}, allowed two numbers with a comma"))?;
    let [near, far] = [within(near, 0.0, 1e6)?, within(far, 0.0, 1e6)?];
    if near <= far { Ok([near, far]) } else { Err(format!("found {near} before {far}, allowed rising depths")) }
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("found {text:?}, allowed WIDTHxHEIGHT, each 1 to 16384");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |t: &str| t.parse::<u32>().ok().filter(|v| (1..=16_384).contains(v)).ok_or_else(wrong);
    Ok([side(width)?, side(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_triples_are_read_or_refused_with_the_reason() {
        assert_eq!(size("640x360"), Ok([640, 360]));
        assert_eq!(triple("-1, 2,3.5"), Ok([-1.0, 2.0, 3.5]));
        for bad in ["640", "0x10", "x", "99999x1"] {
            assert!(size(bad).unwrap_err().contains(bad));
        }
        assert!(triple("1,2").unwrap_err().contains("found 2 numbers"));
        assert!(triple("1,2,nan").is_err());
        assert_eq!(pose_rates("60"), Ok(PoseRates::FarM(60.0)));
        assert_eq!([pose_rates("0.5px"), pose_rates("OFF")], [Ok(PoseRates::Px(0.5)), Ok(PoseRates::Off)]);
        assert_eq!([fog("OFF"), fog("120")], [Ok(0.0), Ok(120.0)]);
        assert!(["0", "-3", "nan", "thick"].iter().all(|bad| fog(bad).is_err_and(|e| e.contains("off"))));
        for bad in ["0", "px", "-1px", "nanpx", "inf", "1em"] {
            assert!(pose_rates(bad).is_err_and(|e| e.contains("1px")), "{bad}");
        }
    }
}
