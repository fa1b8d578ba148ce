//! From the camera plan to the camera of a moment, and from a camera to the frame's numbers.

use crate::cli::PoseRates;
use crate::crowd::{Bounds, Crowd};
use crate::plan::{CameraPlan, CameraWay, DetailPlan};
use crate::{Error, Result};
use crowd_scene::{Camera, CameraPath};
use crowd_stages::{FrameConfig, FrameView, dot_area_px2 as area_of_height};
use glam::Vec3;
use std::path::Path;

/// Bytes of a camera path file: far more than its most keys need.
const PATH_BYTES: u64 = 64 << 20;

/// At the end of sight a twentieth of a colour is left.
const FOG_AT_SIGHT: f32 = 3.0;

/// Where the camera is at a time.
#[derive(Debug, Clone)]
pub enum Viewer {
    /// Stands still.
    Still(Camera),
    /// Follows a path; planes of the camera beside it.
    Path(CameraPath, Camera),
}

impl Viewer {
    /// Opens the camera plan: frames the crowd, or reads the path.
    ///
    /// # Errors
    /// [`Error::Scene`] for a camera path that was refused.
    pub fn open(plan: &CameraPlan, crowd: &Crowd) -> Result<Self> {
        let far_m = crowd.framed.far_m;
        Ok(match plan {
            CameraPlan::Framed { fov_y_rad } => Self::Still(Camera { fov_y_rad: *fov_y_rad, ..crowd.framed }),
            CameraPlan::Fixed { eye, target, fov_y_rad } => {
                let (eye, target) = (Vec3::from_array(*eye), Vec3::from_array(*target));
                let around = Camera::orbit(target, eye.distance(target), 0.0, 0.0);
                Self::Still(Camera { eye, fov_y_rad: *fov_y_rad, far_m: around.far_m.max(far_m), ..around })
            }
            CameraPlan::Orbit { azimuth_rad, elevation_rad, distance_m, target, fov_y_rad } => {
                let target = target.map_or_else(|| crowd.bounds.middle(), Vec3::from_array);
                let camera = Camera::orbit(target, *distance_m, *azimuth_rad, *elevation_rad);
                Self::Still(Camera { fov_y_rad: *fov_y_rad, far_m: camera.far_m.max(far_m), ..camera })
            }
            CameraPlan::Way { way, fov_y_rad } => Self::Path(made_for(*way, crowd, *fov_y_rad), crowd.framed),
            CameraPlan::Path { path } => {
                let text = read_text(path, PATH_BYTES)?;
                let refused = |e: crowd_scene::Error| Error::Scene { path: path.clone(), problem: e.to_string() };
                Self::Path(CameraPath::parse(&text).map_err(refused)?, crowd.framed)
            }
        })
    }

    /// When a path ends, seconds; `None` for a camera that stands still.
    pub fn end_s(&self) -> Option<f32> {
        match self {
            Self::Still(_) => None,
            Self::Path(path, _) => Some(path.end_s()),
        }
    }

    /// The camera at `time_s`.
    pub fn at(&self, time_s: f32) -> Camera {
        match self {
            Self::Still(camera) => *camera,
            Self::Path(path, planes) => path.at(time_s, planes),
        }
    }
}

/// A camera path through or around this crowd.
fn made_for(way: CameraWay, crowd: &Crowd, fov_y_rad: f32) -> CameraPath {
    let Bounds { min, max, height_m } = crowd.bounds;
    let eye_m = 0.94 * height_m;
    match way {
        CameraWay::Orbit => {
            let arm = crowd.framed.eye - crowd.bounds.middle();
            let from = libm::atan2f(arm.x, arm.z);
            let across = libm::sqrtf(arm.x * arm.x + arm.z * arm.z);
            let around = [from, from + std::f32::consts::TAU];
            CameraPath::orbit(crowd.bounds.middle(), arm.length(), libm::atan2f(arm.y, across), around, 20.0, fov_y_rad)
        }
        CameraWay::Straight => CameraPath::straight(min, max, 2.5 * height_m, 20.0, fov_y_rad),
        CameraWay::Walkthrough => CameraPath::walkthrough(min, max, eye_m, 999.0 / 30.0, fov_y_rad),
    }
}

/// A camera that has all of the crowd and another camera in view.
pub fn reference_camera(crowd: &Crowd, seen: &Camera, aspect: f32) -> Camera {
    let Bounds { min, max, .. } = crowd.bounds;
    let whole = crowd_scene::overlook(min.min(seen.eye), max.max(seen.eye), aspect);
    // In a corner every pixel counts: less air around them.
    Camera { eye: whole.target + (whole.eye - whole.target) * 0.75, ..whole }
}

/// Adds a camera to a recording that may have to begin.
pub fn record(recording: &mut Option<CameraPath>, time_s: f32, camera: &Camera) {
    match recording {
        Some(path) => path.record(time_s, camera),
        None => *recording = Some(CameraPath::starting(time_s, camera)),
    }
}

/// A text file of at most `most_bytes`.
pub fn read_text(path: &Path, most_bytes: u64) -> Result<String> {
    let refused = |problem: String| Error::Scene { path: path.to_owned(), problem };
    String::from_utf8(read_bytes(path, most_bytes)?).map_err(|_| refused("is not UTF-8 text".to_owned()))
}

/// A file of at most `most_bytes`.
pub fn read_bytes(path: &Path, most_bytes: u64) -> Result<Vec<u8>> {
    use std::io::Read;
    let refused = |problem: String| Error::Scene { path: path.to_owned(), problem };
    let file = std::fs::File::open(path).map_err(|e| refused(e.to_string()))?;
    let mut bytes = Vec::new();
    let read = file.take(most_bytes + 1).read_to_end(&mut bytes).map_err(|e| refused(e.to_string()))?;
    if read as u64 > most_bytes {
        return Err(refused(format!("found more than {most_bytes} bytes, allowed {most_bytes}")));
    }
    Ok(bytes)
}

/// The uniform of a frame.
pub fn frame_config(camera: &Camera, size: [u32; 2], time_s: f32, detail: &DetailPlan, budget: u32) -> FrameConfig {
    let config = FrameConfig::from_camera(&FrameView {
        clip_from_world: camera.clip_from_world(size[0] as f32 / size[1].max(1) as f32),
        eye: camera.eye,
        fov_y_rad: camera.fov_y_rad,
        viewport_height_px: size[1] as f32,
        time_s,
        budget,
        alpha: detail.alpha,
        weight: detail.weight,
    });
    let lod_depths_m = detail.lod_depths_m.unwrap_or(config.lod_depths_m);
    let (hold_far_m, hold_px) = match detail.pose_rates {
        // Whoever holds poses without saying how long keeps them within a pixel.
        PoseRates::Off => (0.0, 1.0),
        PoseRates::FarM(metres) => (metres, 0.0),
        PoseRates::Px(px) => (0.0, px),
    };
    let dot_area_px2 = area_of_height(detail.dots_px);
    let slack = (f64::from(budget) * f64::from(detail.slack_share)) as u32;
    let budget_in = detail.budget_in as u32;
    let impostor_area_px2 = area_of_height(detail.impostors_px);
    let fog_per_m = if detail.sight_m > 0.0 { FOG_AT_SIGHT / detail.sight_m } else { 0.0 };
    let config = FrameConfig { lod_depths_m, dot_area_px2, impostor_area_px2, hold_far_m, hold_px, ..config };
    FrameConfig { budget_in, slack, fog_per_m, ..config }
}
