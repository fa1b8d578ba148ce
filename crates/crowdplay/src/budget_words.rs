//! Words for what a frame may come to and what the player may take.

use clap::ValueEnum;
use crowd_stages::BudgetIn;

/// `--steady` unless given: at least 99 % of the budget is used.
pub use crowd_stages::STEADY_PERCENT;

/// Words beside `--budget`.
#[derive(Debug, Clone, clap::Args)]
pub struct BudgetWords {
    /// What the budget counts: vertices, as the papers do, or triangles, which is what rasterisers are bound by (with --fit fill)
    #[arg(long, value_enum, default_value_t = BudgetInWord::Vertices, value_name = "WHAT", help_heading = "Level of detail")]
    pub budget_in: BudgetInWord,

    /// Percent of the budget that may be left over so that levels keep still: as long as what was chosen for the last frame comes to so
    /// much or more, and to no more than N, only the camera changes levels, not those who come and leave; 0: every frame uses all it
    /// can. The CPU keeps nothing from frame to frame [default: 0.9; 0 with --fit eq1]
    #[arg(long, value_name = "PERCENT", value_parser = percent, help_heading = "Level of detail")]
    pub steady: Option<f32>,

    /// Megabytes (of 1,048,576 bytes) of GPU memory that the crowd and its pictures may take. Without --budget, N becomes the largest
    /// that fits; what does not fit is refused with what takes how much. The screen itself and the driver's own needs are not counted
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = "Machine")]
    pub vram: Option<u32>,
}

/// `--budget-in`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BudgetInWord {
    /// As in the papers
    Vertices,
    /// As rasterisers count
    Triangles,
}

impl BudgetInWord {
    /// What it means.
    pub fn budget_in(self) -> BudgetIn {
        match self {
            Self::Vertices => BudgetIn::Vertices,
            Self::Triangles => BudgetIn::Triangles,
        }
    }
}

fn percent(text: &str) -> Result<f32, String> {
    let value: f32 = text.trim().parse().map_err(|_| format!("found {text:?}, allowed a number"))?;
    if (0.0..=50.0).contains(&value) { Ok(value) } else { Err(format!("found {value}, allowed 0 to 50")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percents_are_numbers_from_0_to_50() {
        assert_eq!([percent("0"), percent(" 1.5")], [Ok(0.0), Ok(1.5)]);
        for bad in ["-1", "51", "nan", "x", ""] {
            assert!(percent(bad).is_err_and(|e| e.contains("allowed")), "{bad}");
        }
    }
}
