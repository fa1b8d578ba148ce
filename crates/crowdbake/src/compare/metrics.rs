//! What is measured, in the order of the tables.

use crowd_judge::Verdict;

/// One figure of a verdict; smaller is better for all of them.
pub struct Metric {
    /// Its key in JSON, with the unit.
    pub key: &'static str,
    /// Its heading in tables.
    pub heading: &'static str,
    /// Decimals shown.
    pub decimals: usize,
    /// Takes it out of a verdict; `None` where it was not measured.
    pub of: fn(&Verdict) -> Option<f64>,
}

const fn metric(key: &'static str, heading: &'static str, decimals: usize, of: fn(&Verdict) -> Option<f64>) -> Metric {
    Metric { key, heading, decimals, of }
}

/// Root mean square distance in motion.
pub const ANIMATED_RMS: Metric = metric("animated_rms_percent", "anim RMS %", 4, |v| Some(v.animated_rms));
/// Root mean square distance at rest.
pub const REST_RMS: Metric = metric("rest_rms_percent", "rest RMS %", 4, |v| Some(v.rest_rms));
/// Largest distance in motion.
pub const MAX: Metric = metric("max_percent", "max %", 3, |v| Some(v.max));
/// Mean angle between normals.
pub const NORMAL: Metric = metric("normal_deg", "normal deg", 2, |v| Some(v.normal_deg));
/// Base colour.
pub const COLOR: Metric = metric("color_rms", "colour", 4, |v| Some(v.color_rms));
/// Slide of the texture.
pub const UV: Metric = metric("uv_p95_texels", "UV p95 px", 1, |v| v.uv_p95_texels);
/// Pictures.
pub const IMAGE: Metric = metric("image_rmse", "image", 4, |v| v.image_rmse);

/// All of them.
pub const METRICS: [Metric; 13] = [
    ANIMATED_RMS,
    REST_RMS,
    metric("mean_percent", "mean %", 4, |v| Some(v.mean)),
    metric("p99_percent", "p99 %", 3, |v| Some(v.p99)),
    MAX,
    NORMAL,
    COLOR,
    UV,
    metric("uv_rms_texels", "UV RMS px", 1, |v| v.uv_rms_texels),
    IMAGE,
    metric("silhouette_xor_percent", "XOR %", 2, |v| v.silhouette_xor),
    metric("silhouette_missed_percent", "missed %", 2, |v| v.silhouette_missed),
    metric("limbs_missed_percent", "limbs missed %", 2, |v| v.limbs_missed),
];
