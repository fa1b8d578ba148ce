//! Sums what was found in each pose up to a verdict.

use crate::Verdict;
use glam::Vec3;

/// What one pose showed, both ways.
#[derive(Debug, Default)]
pub(crate) struct PoseFindings {
    /// Metres, one per point.
    pub distances: Vec<f32>,
    angle_sum_deg: f64,
    angles: u64,
    color_sum: f64,
    colors: u64,
    /// Texels, one per point that has a texture; at rest only.
    pub drifts: Vec<f32>,
}

impl PoseFindings {
    /// Two normals at points that belong together, any length; one without length says nothing.
    pub fn add_normals(&mut self, a: Vec3, b: Vec3) {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        if a.length_squared() > 0.0 && b.length_squared() > 0.0 {
            // atan2 is exact for small angles, where acos is not.
            self.angle_sum_deg += libm::atan2(a.cross(b).length(), a.dot(b)).to_degrees();
            self.angles += 1;
        }
    }

    /// Two base colours, sRGB 0 to 1.
    pub fn add_colors(&mut self, a: Vec3, b: Vec3) {
        self.color_sum += (a - b).as_dvec3().length_squared() / 3.0;
        self.colors += 1;
    }
}

/// Sums up: the pose at rest first, then those in motion.
pub(crate) fn sum_up(findings: &[PoseFindings], diagonal_m: f64) -> Verdict {
    let percent = |metres: f64| if diagonal_m > 0.0 { 100.0 * metres / diagonal_m } else { 0.0 };
    let (rest, moving) = findings.split_at(1.min(findings.len()));
    let judged = if moving.is_empty() { rest } else { moving };
    let mut distances: Vec<f32> = judged.iter().flat_map(|pose| pose.distances.iter().copied()).collect();
    let (mut max, mut max_pose) = (0.0_f32, None);
    for (i, pose) in moving.iter().enumerate() {
        for &distance in &pose.distances {
            if distance > max {
                (max, max_pose) = (distance, Some(i as u32));
            }
        }
    }
    if moving.is_empty() {
        max = distances.iter().copied().fold(0.0, f32::max);
    }
    let mut drifts: Vec<f32> = rest.iter().flat_map(|pose| pose.drifts.iter().copied()).collect();
    let drift_squares: f64 = drifts.iter().map(|&drift| f64::from(drift) * f64::from(drift)).sum();
    let mean = distances.iter().copied().map(f64::from).sum::<f64>() / (distances.len().max(1) as f64);
    let share = |sum: f64, count: u64| if count > 0 { sum / count as f64 } else { 0.0 };
    let total = |of: fn(&PoseFindings) -> (f64, u64)| {
        findings.iter().map(of).fold((0.0, 0), |(sum, count), (s, c)| (sum + s, count + c))
    };
    let (angle_sum, angles) = total(|pose| (pose.angle_sum_deg, pose.angles));
    let (color_sum, colors) = total(|pose| (pose.color_sum, pose.colors));
    Verdict {
        triangles: 0,
        animated_rms: percent(root_mean_square(judged)),
        rest_rms: percent(root_mean_square(rest)),
        mean: percent(mean),
        p99: percent(f64::from(percentile(&mut distances, 0.99))),
        max: percent(f64::from(max)),
        max_pose,
        normal_deg: share(angle_sum, angles),
        color_rms: share(color_sum, colors).sqrt(),
        uv_p95_texels: (!drifts.is_empty()).then(|| f64::from(percentile(&mut drifts, 0.95))),
        uv_rms_texels: (!drifts.is_empty()).then_some((drift_squares / drifts.len() as f64).sqrt()),
        image_rmse: None,
        silhouette_xor: None,
        silhouette_missed: None,
        limbs_missed: None,
    }
}

fn root_mean_square(poses: &[PoseFindings]) -> f64 {
    let squares = poses.iter().flat_map(|pose| &pose.distances).map(|&d| f64::from(d) * f64::from(d));
    let count: usize = poses.iter().map(|pose| pose.distances.len()).sum();
    (squares.sum::<f64>() / count.max(1) as f64).sqrt()
}

/// The smallest value that `share` of all values are not larger than; 0 for none.
pub(crate) fn percentile(values: &mut [f32], share: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let place = ((values.len() as f64 * share).ceil() as usize).clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(place, f32::total_cmp).1
}
