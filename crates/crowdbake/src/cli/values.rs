//! Values of options, read and kept within what is allowed.

use super::MOST_CLIP_WEIGHT;
use clap::builder::{PathBufValueParser, TypedValueParser};
use crowd_lod::AttributeWeights;
use std::path::PathBuf;

/// A file to write. `-` is not one: a file of that name surprises whoever expected standard output.
pub(super) fn output_parser() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let named = path.as_os_str() != "-";
        named.then_some(path).ok_or("standard output is not written to; give a file, `./-` for one of that name")
    })
}

/// A file to write, for PNG alone: pixels of one format under the ending of another open nowhere.
pub(super) fn png_parser() -> impl TypedValueParser<Value = PathBuf> {
    output_parser().try_map(|path: PathBuf| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        let other =
            matches!(ending.as_str(), "jpg" | "jpeg" | "webp" | "gif" | "bmp" | "tif" | "tiff" | "tga" | "svg" | "pdf");
        if other { Err(format!("found .{ending}, allowed .png: only PNG is written")) } else { Ok(path) }
    })
}

/// A file to write or a folder, for binary glTF alone.
pub(super) fn glb_parser() -> impl TypedValueParser<Value = PathBuf> {
    output_parser().try_map(|path: PathBuf| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "gltf" | "obj" if !path.is_dir() => {
                Err(format!("found .{ending}, allowed .glb: only binary glTF is written"))
            }
            _ => Ok(path),
        }
    })
}

pub(super) fn parse_jobs(text: &str) -> Result<usize, String> {
    let jobs: usize = text.parse().map_err(|_| "not a whole number, allowed 0 to 256".to_owned())?;
    if jobs <= 256 { Ok(jobs) } else { Err(format!("found {jobs}, allowed 0 to 256")) }
}

/// A day either way.
pub(super) fn parse_time(text: &str) -> Result<f32, String> {
    parse_between(text, 86_400.0)
}

pub(super) fn parse_turn(text: &str) -> Result<f32, String> {
    parse_between(text, 360.0)
}

pub(super) fn parse_between(text: &str, most: f32) -> Result<f32, String> {
    let number: f32 = text.trim().parse().map_err(|_| "not a number".to_owned())?;
    if (-most..=most).contains(&number) {
        Ok(number)
    } else {
        Err(format!("found {number}, allowed -{most} to {most}"))
    }
}

/// Times the file's size, or metres: from a millionth to a million.
pub(crate) fn parse_size_number(text: &str) -> Result<f32, String> {
    let number: f32 = text.trim().parse().map_err(|_| format!("found {text}, allowed a number"))?;
    if (1e-6..=1e6).contains(&number) { Ok(number) } else { Err(format!("found {text}, allowed 0.000001 to 1000000")) }
}

/// `CLIP=W`; the name may hold `=` itself.
pub(super) fn parse_clip_weight(text: &str) -> Result<(String, f32), String> {
    let (clip, weight) = text.rsplit_once('=').ok_or_else(|| format!("found {text}, allowed CLIP=W, as in Walk=2"))?;
    let weight: f32 = weight.trim().parse().map_err(|_| format!("found {weight}, allowed a number from 0 to 1000"))?;
    if clip.is_empty() || !(0.0..=MOST_CLIP_WEIGHT).contains(&weight) {
        return Err(format!("found {text}, allowed a clip and a number from 0 to 1000"));
    }
    Ok((clip.to_owned(), weight))
}

pub(super) fn parse_attribute_weight(text: &str) -> Result<(String, f32), String> {
    let allowed =
        || format!("found {text}, allowed uv, normal, color or layers, and a number from 0 to 1000, as in uv=2");
    let (name, weight) = text.split_once('=').ok_or_else(allowed)?;
    let weight: f32 = weight.trim().parse().map_err(|_| allowed())?;
    if !(0.0..=MOST_CLIP_WEIGHT).contains(&weight) || !weigh_attribute(&mut AttributeWeights::default(), name, weight) {
        return Err(allowed());
    }
    Ok((name.to_owned(), weight))
}

/// Sets the weight of an attribute by its name; `false` if there is none of that name.
pub(crate) fn weigh_attribute(weights: &mut AttributeWeights, name: &str, weight: f32) -> bool {
    match name {
        "uv" => weights.uv = weight,
        "normal" => weights.normal = weight,
        "color" => weights.color = weight,
        "layers" => weights.layers = weight,
        _ => return false,
    }
    true
}

/// A share of the triangles, the same for every command: `0.25` or `25%`.
pub(super) fn parse_share(text: &str) -> Result<f64, String> {
    let allowed = || format!("found {text}, allowed above 0 and up to 1, or up to 100%, as in 0.25 or 25%");
    let (number, whole) = match text.trim().strip_suffix('%') {
        Some(percent) => (percent.trim(), 100.0),
        None => (text.trim(), 1.0),
    };
    let number: f64 = number.parse().map_err(|_| allowed())?;
    if number > 0.0 && number <= whole { Ok(number / whole) } else { Err(allowed()) }
}

pub(super) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').ok_or("expected WIDTHxHEIGHT, as in 320x420")?;
    let side = |part: &str| part.parse::<u32>().ok().filter(|side| (16..=4096).contains(side));
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok([width, height]),
        _ => Err(format!("found {text}, allowed 16 to 4096 pixels a side")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_and_sizes_say_what_is_allowed() {
        assert_eq!([parse_share("10%"), parse_share(" 2.5 %"), parse_share("0.1")], [Ok(0.1), Ok(0.025), Ok(0.1)]);
        let allowed = "allowed above 0 and up to 1, or up to 100%, as in 0.25 or 25%";
        assert_eq!(parse_share("25").unwrap_err(), format!("found 25, {allowed}"));
        assert_eq!(parse_share("250%").unwrap_err(), format!("found 250%, {allowed}"));
        assert!(["%", "NaN%", "nan", "", "0", "-1%"].iter().all(|text| parse_share(text).is_err()));
        assert_eq!(parse_size("64x32"), Ok([64, 32]));
        assert!(parse_size("64").is_err() && parse_size("1x99999").is_err());
        use crate::sample::FrameRate;
        assert!(FrameRate::parse("0").is_err() && FrameRate::parse("NaN").is_err());
        assert_eq!(
            (FrameRate::parse("auto"), FrameRate::parse("12.5")),
            (Ok(FrameRate::Auto), Ok(FrameRate::Fixed(12.5)))
        );
        assert_eq!(parse_clip_weight("a=b=0.5"), Ok(("a=b".to_owned(), 0.5)));
        assert_eq!(parse_attribute_weight("uv=2"), Ok(("uv".to_owned(), 2.0)));
        assert!(["colour=1", "uv", "uv=-1", "uv=nan", "=1"].iter().all(|t| parse_attribute_weight(t).is_err()));
        assert!(
            ["Walk", "=1", "Walk=", "Walk=-1", "Walk=nan", "Walk=1001"].iter().all(|t| parse_clip_weight(t).is_err())
        );
        assert_eq!(parse_turn("-360"), Ok(-360.0));
        assert_eq!(parse_turn("361").unwrap_err(), "found 361, allowed -360 to 360");
        assert!(parse_turn("NaN").is_err() && parse_time("inf").is_err() && parse_time("1e30").is_err());
        assert_eq!((parse_jobs("256"), parse_jobs("257").is_err()), (Ok(256), true));
    }
}
