//! All nodes at one time: local transforms, world matrices, palettes.

use crate::check_input::{check_clip, check_skeleton};
use crate::evaluate_track::{LocalPose, apply_track, unit_or_identity};
use crate::{ClipView, Joint, Mat3x4, Result, Skeleton};
use glam::{DMat4, DVec4};

/// The palette `world(node) * inverse_bind` of one time, one matrix per joint.
///
/// `time_s`: seconds, any number; before a track's first key and after its last their values hold.
///
/// # Errors
/// [`crate::Error::Parameter`] when an index points outside, keys and values do not fit or a number is not finite.
pub fn pose_at(skeleton: &Skeleton, joints: &[Joint], clip: &ClipView<'_>, time_s: f32) -> Result<Vec<Mat3x4>> {
    check_skeleton(skeleton, joints)?;
    check_clip(skeleton, clip)?;
    let worlds = world_matrices(skeleton, clip, f64::from(time_s));
    Ok(joints.iter().map(|joint| palette_matrix(&worlds, joint)).collect())
}

/// `world(node)` of every node. The input was checked.
pub(crate) fn world_matrices(skeleton: &Skeleton, clip: &ClipView<'_>, time_s: f64) -> Vec<DMat4> {
    let mut locals: Vec<LocalPose> = skeleton
        .rest
        .iter()
        .map(|rest| LocalPose {
            translation: rest.translation.as_dvec3(),
            rotation: unit_or_identity(DVec4::from(rest.rotation.as_dquat())),
            scale: rest.scale.as_dvec3(),
        })
        .collect();
    for track in &clip.tracks {
        apply_track(track, time_s, &mut locals[track.node as usize]);
    }
    let mut worlds: Vec<DMat4> = Vec::with_capacity(locals.len());
    for (local, parent) in locals.iter().zip(&skeleton.parents) {
        let matrix = DMat4::from_scale_rotation_translation(local.scale, local.rotation, local.translation);
        // Parents come first, so the parent's world matrix is there already.
        worlds.push(parent.map_or(matrix, |parent| worlds[parent as usize] * matrix));
    }
    worlds
}

/// What a vertex in bind space is multiplied with.
pub(crate) fn palette_matrix(worlds: &[DMat4], joint: &Joint) -> Mat3x4 {
    let rows = to_rows(worlds[joint.node as usize] * joint.inverse_bind.as_dmat4());
    [rows[0], rows[1], rows[2]]
}

/// Rows of a matrix, rounded to `f32`.
pub(crate) fn to_rows(matrix: DMat4) -> [[f32; 4]; 4] {
    matrix.transpose().to_cols_array_2d().map(|row| row.map(|value| value as f32))
}
