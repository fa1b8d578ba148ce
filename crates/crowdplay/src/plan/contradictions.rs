//! Words that contradict each other, refused before anything is opened.

use crate::budget_words::BudgetInWord;
use crate::cli::{Args, BackendWord, FitWord, MetricWord, PoseRates, SimulatorWord, SkinningWord, Switch};
use crate::{Error, Result};
use crowd_stages::{Technique, View};

/// Eq. 1 as printed shares vertices, and memory is a GPU's.
pub(super) fn check_budget(args: &Args) -> Result<()> {
    let refused = |option, found: &str, allowed: &str| {
        Err(Error::Parameter { option, found: found.to_owned(), allowed: allowed.to_owned() })
    };
    let in_triangles = args.room.budget_in == BudgetInWord::Triangles;
    if in_triangles && args.fit == FitWord::Eq1 && args.lod_metric == MetricWord::Size {
        return refused("--budget-in", "triangles with --fit eq1", "triangles with --fit fill");
    }
    if args.room.steady.is_some_and(|percent| percent > 0.0)
        && args.fit == FitWord::Eq1
        && args.lod_metric == MetricWord::Size
    {
        return refused("--steady", "with --fit eq1", "with --fit fill");
    }
    if args.room.vram.is_some() && args.backend == BackendWord::Cpu {
        return refused("--vram", "with --backend cpu", "with a GPU");
    }
    Ok(())
}

/// Words of how a budget is spent where nothing has one; in a window technique and metric can be switched. --budget itself may stand there: the same
/// words with another technique are a comparison.
pub(super) fn check_unheeded(args: &Args) -> Result<()> {
    if !args.headless {
        return Ok(());
    }
    let refused = |option, found: String, allowed: String| Err(Error::Parameter { option, found, allowed });
    if let Some(px) = args.max_px.filter(|_| args.lod_metric == MetricWord::Size) {
        let found = format!("{px} with --lod-metric size, which knows no pixels of error");
        return refused("--max-px", found, "with --lod-metric error".to_owned());
    }
    let Some(technique) = args.technique.filter(|technique| !technique.has_budget()) else { return Ok(()) };
    let given = [
        ("--target-ms", args.target_ms.is_some()),
        ("--fit", args.fit == FitWord::Eq1),
        ("--lod-metric", args.lod_metric == MetricWord::Error),
        ("--steady", args.room.steady.is_some_and(|percent| percent > 0.0)),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            let with: Vec<&str> = Technique::ALL.iter().filter(|one| one.has_budget()).map(|one| one.name()).collect();
            let found = format!("given with --technique {technique}, which has no budget");
            refused(option, found, format!("with --technique {}", with.join(", ")))
        }
        None => Ok(()),
    }
}

/// In a window the clock decides how long a frame is.
pub(super) fn check_window(args: &Args) -> Result<()> {
    match args.dt {
        Some(dt_s) if !args.headless => Err(Error::Parameter {
            option: "--dt",
            found: format!("{dt_s} in a window, where the clock decides"),
            allowed: "with --headless; a window has --time-scale".to_owned(),
        }),
        _ => Ok(()),
    }
}

/// Who may be an impostor is said by size, to the technique that has buckets for them.
pub(super) fn check_impostors(args: &Args) -> Result<()> {
    let Some(px) = args.impostors.filter(|px| *px > 0.0) else { return Ok(()) };
    let refused = |with: String, allowed: &str| {
        Err(Error::Parameter { option: "--impostors", found: format!("{px} with {with}"), allowed: allowed.to_owned() })
    };
    match args.technique {
        Some(other) if other != Technique::Bucketed => {
            refused(format!("--technique {other}"), "with --technique bucketed")
        }
        _ if args.fit == FitWord::Eq1 => refused("--fit eq1".to_owned(), "with --fit fill"),
        _ if args.lod_metric == MetricWord::Error => {
            refused("--lod-metric error".to_owned(), "with --lod-metric size, since impostors have no measured error")
        }
        _ if args.backend == BackendWord::Cpu => refused("--backend cpu".to_owned(), "with a GPU"),
        _ => Ok(()),
    }
}

/// Only the bucketed technique has more than one way to skin, and the CPU has its own.
pub(super) fn check_skinning(args: &Args) -> Result<()> {
    let refused = |found: String, allowed: &str| {
        Err(Error::Parameter { option: "--skinning", found, allowed: allowed.to_owned() })
    };
    let word = args.skinning.skinning().name();
    match args.technique {
        _ if args.skinning == SkinningWord::Auto => Ok(()),
        Some(other) if other != Technique::Bucketed => {
            refused(format!("{word} with --technique {other}"), "with --technique bucketed")
        }
        _ if args.backend == BackendWord::Cpu => refused(format!("{word} with --backend cpu"), "with a GPU"),
        _ => Ok(()),
    }
}

/// A view that has nothing to show is refused rather than shown shaded.
pub(super) fn check_view(args: &Args) -> Result<()> {
    let word = args.view.name();
    let refused =
        |found: String, allowed: &str| Err(Error::Parameter { option: "--view", found, allowed: allowed.to_owned() });
    match (args.view, args.technique) {
        (View::Shaded, _) => Ok(()),
        _ if args.backend == BackendWord::Cpu => refused(format!("{word} with --backend cpu"), "shaded, or with a GPU"),
        (View::Occlusion, _) if args.occlusion == Switch::Off => {
            refused(format!("{word} with --occlusion off"), "occlusion with --occlusion on")
        }
        (View::Occlusion, _) => Ok(()),
        _ if args.occlusion == Switch::On => {
            refused(format!("{word} with --occlusion on"), "shaded, occlusion, or with --occlusion off")
        }
        (_, Some(other @ (Technique::PseudoInstancing | Technique::Discrete | Technique::Points))) => {
            refused(format!("{word} with --technique {other}"), "with instanced, reform, static-floor or bucketed")
        }
        _ => Ok(()),
    }
}

/// What a second camera shows is kept by the techniques that cull by spheres, and not by occlusion culling.
pub(super) fn check_reference(args: &Args) -> Result<()> {
    let refused = |found: String, allowed: &str| {
        Err(Error::Parameter { option: "--reference-camera", found, allowed: allowed.to_owned() })
    };
    match args.technique {
        _ if !args.reference_camera => Ok(()),
        Some(other @ (Technique::PseudoInstancing | Technique::Discrete)) => {
            refused(format!("with --technique {other}"), "with instanced, reform, static-floor, points or bucketed")
        }
        _ if args.occlusion == Switch::On => refused("with --occlusion on".to_owned(), "with --occlusion off"),
        _ if args.backend == BackendWord::Cpu => refused("with --backend cpu".to_owned(), "with a GPU"),
        _ => Ok(()),
    }
}

/// Only a flock is simulated here, and on the GPU only where that draws.
pub(super) fn check_simulator(args: &Args) -> Result<()> {
    let refused = |found: String, allowed: &str| {
        Err(Error::Parameter { option: "--simulate", found, allowed: allowed.to_owned() })
    };
    match args.simulate {
        SimulatorWord::Auto => Ok(()),
        _ if args.flock.is_none() => refused("without --flock".to_owned(), "with --flock"),
        SimulatorWord::Gpu if args.backend == BackendWord::Cpu => {
            refused("gpu with --backend cpu".to_owned(), "with a GPU")
        }
        SimulatorWord::Gpu | SimulatorWord::Cpu => Ok(()),
    }
}

/// Only the bucketed technique leaves hidden ones out, and its newcomers' levels come from the water's height.
pub(super) fn check_occlusion(args: &Args) -> Result<()> {
    let refused = |found: String, allowed: &str| {
        Err(Error::Parameter { option: "--occlusion", found, allowed: allowed.to_owned() })
    };
    match args.technique {
        _ if args.occlusion == Switch::Off => Ok(()),
        Some(other) if other != Technique::Bucketed => {
            refused(format!("on with --technique {other}"), "on with --technique bucketed")
        }
        _ if args.fit == FitWord::Eq1 => refused("on with --fit eq1".to_owned(), "on with --fit fill"),
        _ => Ok(()),
    }
}

/// Only poses that are held and worked out before the draw can be shared.
pub(super) fn check_sharing(args: &Args) -> Result<()> {
    let refused = |found: &str, allowed: &str| {
        Err(Error::Parameter { option: "--share-poses", found: found.to_owned(), allowed: allowed.to_owned() })
    };
    if args.share_poses == Switch::Off {
        return Ok(());
    }
    if args.pose_rates == PoseRates::Off {
        return refused("on without --pose-rates", "on with --pose-rates, as in --pose-rates 1px");
    }
    match args.skinning {
        SkinningWord::Palettes | SkinningWord::Compute => Ok(()),
        SkinningWord::Auto | SkinningWord::Vertex => {
            refused("on without poses worked out beforehand", "on with --skinning compute or palettes")
        }
    }
}
