//! Words for the window.

use clap::ValueHint;
use std::path::PathBuf;

/// Words that only a window knows.
#[derive(Debug, Clone, clap::Args)]
pub struct WindowWords {
    /// Seconds of the crowd a second of the clock, 0 to 100; 0: it stands still, until the overlay or the space bar says otherwise
    #[arg(long, default_value_t = 1.0, value_name = "X", value_parser = scale, conflicts_with = "headless", help_heading = "Window")]
    pub time_scale: f32,

    /// The window shows the crowd alone, without numbers and controls; F1 brings them back
    #[arg(long, conflicts_with = "headless", help_heading = "Window")]
    pub no_overlay: bool,

    /// PNG of the window at the last of --frames, or when it is closed before, numbers and controls and all
    #[arg(long, value_name = "PNG", value_hint = ValueHint::FilePath, requires = "frames", conflicts_with = "headless", help_heading = "Window")]
    pub screenshot: Option<PathBuf>,
}

fn scale(text: &str) -> Result<f32, String> {
    let value: f32 = text.trim().parse().map_err(|_| format!("found {text:?}, allowed a number"))?;
    if (0.0..=100.0).contains(&value) { Ok(value) } else { Err(format!("found {value}, allowed 0 to 100")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_forwards_or_stands_still() {
        assert_eq!([scale("0"), scale(" 2.5 ")], [Ok(0.0), Ok(2.5)]);
        for bad in ["-1", "101", "nan", "inf", "x", ""] {
            assert!(scale(bad).is_err_and(|e| e.contains("allowed")), "{bad}");
        }
    }
}
