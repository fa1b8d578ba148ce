//! What a discrete level is asked to be: words in, words out.

use crowd_lod::{Coarsest, SurfaceError};
use crowd_pack::ManifestTarget;

/// Which distance to full detail a target limits (decision 0074).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distance {
    /// What no point exceeds in any frame: the measured bound.
    EveryPoint,
    /// Root mean square over the surface and the frames.
    Rms,
}

impl Distance {
    /// As measured of a level, metres.
    pub fn of(self, error: &SurfaceError) -> f32 {
        match self {
            Self::EveryPoint => error.bound_m,
            Self::Rms => error.rms_m,
        }
    }

    /// `5mm:max`: every point; `5mm:rms`; without a word `usual`.
    fn split(text: &str, usual: Self) -> Result<(&str, Self), String> {
        match text.trim().rsplit_once(':') {
            None => Ok((text, usual)),
            Some((number, word)) => match word.trim() {
                "max" => Ok((number, Self::EveryPoint)),
                "rms" => Ok((number, Self::Rms)),
                _ => Err(format!("found {text}, allowed after the colon max (every point in every frame) or rms")),
            },
        }
    }
}

/// A target as people write it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LodTarget(pub ManifestTarget);

impl LodTarget {
    /// `0.25` or `25%`: a share of the triangles.
    ///
    /// # Errors
    /// What was found and what is allowed.
    pub fn parse_ratio(text: &str) -> Result<Self, String> {
        let (number, unit) = number_and_unit(text)?;
        let share = match unit {
            "" => number,
            "%" => number / 100.0,
            _ => return Err(format!("found {text}, allowed a share as in 0.25 or 25%")),
        };
        if share > 0.0 && share <= 1.0 {
            return Ok(Self(ManifestTarget::Ratio(share as f32)));
        }
        Err(format!("found {text}, allowed above 0 and up to 1, or up to 100%"))
    }

    /// `0.005`, `5mm`, `0.5cm`, `0.005m`: a distance that no point exceeds. `0.5%`: a share of the height. `5mm:rms`: root mean square.
    ///
    /// # Errors
    /// What was found and what is allowed.
    pub fn parse_error(text: &str) -> Result<Self, String> {
        let (text, distance) = Distance::split(text, Distance::EveryPoint)?;
        let (number, unit) = number_and_unit(text)?;
        let metres = match unit {
            "" | "m" => number,
            "cm" => number / 100.0,
            "mm" => number / 1000.0,
            "%" if number > 0.0 && number <= 100.0 => {
                let share = (number / 100.0) as f32;
                return Ok(Self(match distance {
                    Distance::EveryPoint => ManifestTarget::ErrorHeight(share),
                    Distance::Rms => ManifestTarget::RmsHeight(share),
                }));
            }
            _ => {
                return Err(format!(
                    "found {text}, allowed a distance as in 5mm, 0.5cm or 0.005, or a share of the height as in 0.5%"
                ));
            }
        };
        if (1e-9..=1e6).contains(&metres) {
            let metres = metres as f32;
            return Ok(Self(match distance {
                Distance::EveryPoint => ManifestTarget::ErrorM(metres),
                Distance::Rms => ManifestTarget::RmsM(metres),
            }));
        }
        Err(format!("found {text}, allowed above 0"))
    }

    /// `1@120`: one pixel RMS where the character is 120 pixels high; `1` alone means at 720. `1@120:max`: no point is off by more.
    ///
    /// # Errors
    /// What was found and what is allowed.
    pub fn parse_pixels(text: &str) -> Result<Self, String> {
        let allowed = || format!("found {text}, allowed PIXELS@HEIGHT, as in 1@120 or 1@120:max");
        let (number, distance) = Distance::split(text, Distance::Rms)?;
        let (pixels, height) = number.trim().split_once('@').unwrap_or((number.trim(), "720"));
        let number = |part: &str| part.trim().trim_end_matches("px").parse::<f32>().map_err(|_| allowed());
        let (pixels, height) = (number(pixels)?, number(height)?);
        if (1e-3..=1e5).contains(&pixels) && (1.0..=1e5).contains(&height) {
            return Ok(Self(match distance {
                Distance::EveryPoint => ManifestTarget::Pixels(pixels, height),
                Distance::Rms => ManifestTarget::RmsPixels(pixels, height),
            }));
        }
        Err(allowed())
    }

    /// Which distance may be how large, metres; `None` for a share of the triangles.
    pub fn limit_m(self, height_m: f32) -> Option<(Distance, f32)> {
        match self.0 {
            ManifestTarget::Ratio(_) => None,
            ManifestTarget::ErrorM(distance) => Some((Distance::EveryPoint, distance)),
            ManifestTarget::RmsM(distance) => Some((Distance::Rms, distance)),
            ManifestTarget::ErrorHeight(share) => Some((Distance::EveryPoint, share * height_m)),
            ManifestTarget::RmsHeight(share) => Some((Distance::Rms, share * height_m)),
            ManifestTarget::Pixels(pixels, height_px) => Some((Distance::EveryPoint, pixels / height_px * height_m)),
            ManifestTarget::RmsPixels(pixels, height_px) => Some((Distance::Rms, pixels / height_px * height_m)),
        }
    }
}

/// As `parse` reads it back.
impl std::fmt::Display for LodTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = |share: f32| short(f64::from(share) * 100.0);
        match self.0 {
            ManifestTarget::Ratio(share) | ManifestTarget::ErrorHeight(share) => write!(f, "{}%", percent(share)),
            ManifestTarget::RmsHeight(share) => write!(f, "{}%:rms", percent(share)),
            ManifestTarget::ErrorM(metres) => write!(f, "{}mm", short(f64::from(metres) * 1000.0)),
            ManifestTarget::RmsM(metres) => write!(f, "{}mm:rms", short(f64::from(metres) * 1000.0)),
            ManifestTarget::Pixels(pixels, height) => write!(f, "{pixels}@{height}:max"),
            ManifestTarget::RmsPixels(pixels, height) => write!(f, "{pixels}@{height}"),
        }
    }
}

impl LodTarget {
    /// In a sentence.
    pub fn words(self) -> String {
        let number = self.to_string();
        let number = number.split(':').next().unwrap_or_default();
        match self.0 {
            ManifestTarget::Ratio(_) => format!("{number} of the triangles"),
            ManifestTarget::ErrorM(_) => format!("every point within {number}"),
            ManifestTarget::RmsM(_) => format!("within {number} RMS"),
            ManifestTarget::ErrorHeight(_) => format!("every point within {number} of the height"),
            ManifestTarget::RmsHeight(_) => format!("within {number} of the height RMS"),
            ManifestTarget::Pixels(pixels, height) => format!("every point within {pixels} px at {height} px"),
            ManifestTarget::RmsPixels(pixels, height) => format!("within {pixels} px RMS at {height} px"),
        }
    }
}

/// `40`: triangles. `0.5%` or `0.005`: a share of them. `last`: where nothing may collapse any more.
///
/// # Errors
/// What was found and what is allowed.
pub fn parse_coarsest(text: &str) -> Result<Coarsest, String> {
    let text = text.trim();
    if text == "last" {
        return Ok(Coarsest::Last);
    }
    if let Ok(triangles) = text.parse::<u32>()
        && triangles > 0
    {
        return Ok(Coarsest::Triangles(triangles));
    }
    match LodTarget::parse_ratio(text) {
        Ok(LodTarget(ManifestTarget::Ratio(share))) => Ok(Coarsest::Share(share)),
        _ => Err(format!("found {text}, allowed triangles as in 40, a share of them as in 0.5%, or last")),
    }
}

/// As [`parse_coarsest`] reads it back.
pub fn coarsest_words(coarsest: Coarsest) -> String {
    match coarsest {
        Coarsest::Last => "last".to_owned(),
        Coarsest::Useful => "useful".to_owned(),
        Coarsest::Triangles(count) => count.to_string(),
        Coarsest::Share(share) => LodTarget(ManifestTarget::Ratio(share)).to_string(),
    }
}

/// Without the dust that a percent leaves in binary: six digits.
fn short(number: f64) -> f64 {
    let digits = 6 - libm::ceil(libm::log10(number.max(1e-12))) as i32;
    let scale = libm::pow(10.0, f64::from(digits));
    (number * scale).round() / scale
}

fn number_and_unit(text: &str) -> Result<(f64, &str), String> {
    let text = text.trim();
    let end = text.find(|c: char| !(c.is_ascii_digit() || ".+-".contains(c))).unwrap_or(text.len());
    // An exponent belongs to the number.
    let end = match text[end..].strip_prefix(['e', 'E']) {
        Some(rest) => {
            let digits = rest.find(|c: char| !(c.is_ascii_digit() || "+-".contains(c))).unwrap_or(rest.len());
            end + 1 + digits
        }
        None => end,
    };
    let number = text[..end].parse::<f64>().map_err(|_| format!("found {text}, allowed a number"))?;
    Ok((number, text[end..].trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(text: &str) -> Result<ManifestTarget, String> {
        LodTarget::parse_ratio(text).map(|target| target.0)
    }

    fn error(text: &str) -> Result<ManifestTarget, String> {
        LodTarget::parse_error(text).map(|target| target.0)
    }

    #[test]
    fn shares_distances_and_pixels_are_read() {
        assert_eq!([ratio("0.25"), ratio(" 25 %"), ratio("25%")], [0.25; 3].map(|r| Ok(ManifestTarget::Ratio(r))));
        assert_eq!(ratio("25").unwrap_err(), "found 25, allowed above 0 and up to 1, or up to 100%");
        for text in ["0.005", "5mm", "0.5cm", "0.005m", "5e-3", "5e0mm"] {
            assert_eq!(error(text), Ok(ManifestTarget::ErrorM(0.005)), "{text}");
        }
        assert_eq!(error("0.5%"), Ok(ManifestTarget::ErrorHeight(0.005)));
        let pixels = |text| LodTarget::parse_pixels(text).map(|target| target.0);
        assert_eq!(pixels("1@120"), Ok(ManifestTarget::RmsPixels(1.0, 120.0)));
        assert_eq!(pixels("1.5px@720px:rms"), Ok(ManifestTarget::RmsPixels(1.5, 720.0)));
        assert_eq!(pixels("2"), Ok(ManifestTarget::RmsPixels(2.0, 720.0)));
        assert_eq!(pixels("1@120:max"), Ok(ManifestTarget::Pixels(1.0, 120.0)));
        assert_eq!(pixels("1 : max"), Ok(ManifestTarget::Pixels(1.0, 720.0)));
        assert_eq!(error("5mm:max"), Ok(ManifestTarget::ErrorM(0.005)));
        assert_eq!(error("5mm:rms"), Ok(ManifestTarget::RmsM(0.005)));
        assert_eq!(error("0.5%: rms"), Ok(ManifestTarget::RmsHeight(0.005)));
    }

    #[test]
    fn nonsense_is_refused_in_words() {
        for text in ["", "0", "-1", "nan", "inf", "1e999", "5 feet", "101%", "0%", "%", "e5", "1e"] {
            assert!(ratio(text).unwrap_err().contains("allowed"), "{text}");
            assert!(error(text).unwrap_err().contains("allowed") || text == "5 feet", "{text}");
        }
        for text in ["5mm:mean", "5mm:", "0.5%:max:rms"] {
            assert!(error(text).unwrap_err().contains("allowed"), "{text}");
        }
        assert!(LodTarget::parse_pixels("1@120:mean").unwrap_err().contains("max (every point in every frame) or rms"));
        for text in ["@", "1@", "@720", "1@0", "0@720", "nan@720", "1@inf", "1@2@3"] {
            assert!(LodTarget::parse_pixels(text).unwrap_err().contains("PIXELS@HEIGHT"), "{text}");
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        for text in ["0.25", "33.3%", "2%"] {
            let target = LodTarget::parse_ratio(text).unwrap();
            assert_eq!(LodTarget::parse_ratio(&target.to_string()), Ok(target));
        }
        for text in ["5mm", "0.123cm", "0.5%", "12.5%", "5mm:rms", "0.5%:rms"] {
            let target = LodTarget::parse_error(text).unwrap();
            assert_eq!(LodTarget::parse_error(&target.to_string()), Ok(target));
        }
        for text in ["1.5@96", "1.5@96:max"] {
            let target = LodTarget::parse_pixels(text).unwrap();
            assert_eq!(LodTarget::parse_pixels(&target.to_string()), Ok(target));
        }
        assert_eq!(LodTarget::parse_ratio("25%").unwrap().words(), "25% of the triangles");
    }

    #[test]
    fn an_end_is_triangles_a_share_or_the_last_level() {
        assert_eq!(parse_coarsest("40"), Ok(Coarsest::Triangles(40)));
        assert_eq!(parse_coarsest("1"), Ok(Coarsest::Triangles(1)));
        assert_eq!(parse_coarsest("0.5%"), Ok(Coarsest::Share(0.005)));
        assert_eq!(parse_coarsest(" last "), Ok(Coarsest::Last));
        for text in ["", "0", "-3", "first", "101%", "nan", "4294967296"] {
            assert!(parse_coarsest(text).unwrap_err().contains("or last"), "{text}");
        }
        for coarsest in [Coarsest::Last, Coarsest::Triangles(7), Coarsest::Share(0.25)] {
            assert_eq!(parse_coarsest(&coarsest_words(coarsest)), Ok(coarsest));
        }
    }

    #[test]
    fn pixels_are_distances_of_a_height() {
        let pixel = LodTarget::parse_pixels("1@180").unwrap();
        assert_eq!(pixel.limit_m(1.8), Some((Distance::Rms, 0.01)));
        let most = LodTarget::parse_pixels("1@180:max").unwrap();
        assert_eq!(most.limit_m(1.8), Some((Distance::EveryPoint, 0.01)));
        assert_eq!(LodTarget::parse_ratio("1").unwrap().limit_m(1.8), None);
    }
}
