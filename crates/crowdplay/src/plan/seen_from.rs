//! From where the crowd is seen, as the words say.

use super::{CameraPlan, CameraWay};
use crate::cli::Args;
use crate::{Error, Result};

/// The camera that the words ask for.
pub(super) fn camera(args: &Args) -> Result<CameraPlan> {
    let fov_y_rad = args.fov.to_radians();
    if let Some(word) = &args.camera_path {
        let way = match word.to_str() {
            Some("orbit") => CameraWay::Orbit,
            Some("line") => CameraWay::Straight,
            Some("walkthrough") => CameraWay::Walkthrough,
            _ => return Ok(CameraPlan::Path { path: word.clone() }),
        };
        return Ok(CameraPlan::Way { way, fov_y_rad });
    }
    if let (Some(eye), Some(target)) = (args.eye, args.target) {
        if eye == target {
            return Err(Error::Parameter {
                option: "--target",
                found: "the same point as --eye".to_owned(),
                allowed: "another point".to_owned(),
            });
        }
        return Ok(CameraPlan::Fixed { eye, target, fov_y_rad });
    }
    if let Some([azimuth, elevation, distance_m]) = args.orbit {
        if !(0.01..=1e6).contains(&distance_m) || !(-89.0..=89.0).contains(&elevation) {
            return Err(Error::Parameter {
                option: "--orbit",
                found: format!("elevation {elevation}, distance {distance_m}"),
                allowed: "elevation -89 to 89, distance 0.01 to 1000000".to_owned(),
            });
        }
        return Ok(CameraPlan::Orbit {
            azimuth_rad: azimuth.to_radians(),
            elevation_rad: elevation.to_radians(),
            distance_m,
            target: args.target,
            fov_y_rad,
        });
    }
    if args.target.is_some() {
        return Err(Error::Parameter {
            option: "--target",
            found: "alone".to_owned(),
            allowed: "with --eye or --orbit".to_owned(),
        });
    }
    Ok(CameraPlan::Framed { fov_y_rad })
}
