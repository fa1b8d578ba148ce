//! Refuses parameters that the steps could not work with. After this, every index is in range and every number finite.

use crate::{Error, LodMesh, LodPoses, Result};

/// Triangles or vertices a mesh may have: keeps corner counts and sort keys within 32 bits.
pub(crate) const MAX_ELEMENT_COUNT: usize = 1 << 28;
/// How far from the origin a pose may take a vertex along each axis, metres: four times as far as one may lie in bind pose, so
/// that turning is free. The quadrics' fourth powers of it, summed over a million triangles, stay within the numbers' range.
const MAX_POSED_M: f32 = 4.0e6;

/// Bytes that the quadrics hold for a position in a frame.
const FRAME_BYTES: usize = 48;
/// Memory that all frames may take together. A hundred thousand triangles in 500 frames take 1.2 GB.
const MAX_FRAME_MEMORY_BYTES: usize = 8 << 30;

/// Checks lengths, indices and numbers of a mesh.
pub(crate) fn validate_mesh(mesh: &LodMesh<'_>) -> Result<()> {
    let vertex_count = mesh.positions.len();
    at_most("vertex count", vertex_count, MAX_ELEMENT_COUNT)?;
    at_most("triangle count", mesh.triangles.len(), MAX_ELEMENT_COUNT)?;
    same_length("normals", mesh.normals.len(), vertex_count)?;
    same_length("uvs", mesh.uvs.len(), vertex_count)?;
    same_length("colors", mesh.colors.len(), vertex_count)?;
    same_length("joints", mesh.joints.len(), vertex_count)?;
    same_length("weights", mesh.weights.len(), vertex_count)?;
    same_length("triangle_materials", mesh.triangle_materials.len(), mesh.triangles.len())?;
    let shown = mesh.appearance.shown_colors;
    let contrast = mesh.appearance.triangle_contrast;
    if !shown.is_empty() {
        same_length("appearance.shown_colors", shown.len(), vertex_count)?;
        all_finite("appearance.shown_colors", shown.as_flattened(), 3)?;
    }
    if !contrast.is_empty() {
        same_length("appearance.triangle_contrast", contrast.len(), mesh.triangles.len())?;
        all_finite("appearance.triangle_contrast", contrast, 1)?;
    }
    all_finite("positions", mesh.positions.as_flattened(), 3)?;
    all_finite("normals", mesh.normals.as_flattened(), 3)?;
    all_finite("uvs", mesh.uvs.as_flattened(), 2)?;
    all_finite("weights", mesh.weights.as_flattened(), 4)?;
    if let Some(i) = mesh.weights.iter().position(|w| w.iter().any(|&w| !(0.0..=1.001).contains(&w))) {
        return Err(parameter(format!("weights[{i}]"), format!("{:?}", mesh.weights[i]), "0..=1".into()));
    }
    let sum = |w: &[f32; 4]| w.iter().map(|&w| f64::from(w)).sum::<f64>();
    if let Some(i) = mesh.weights.iter().position(|w| !(0.99..=1.01).contains(&sum(w))) {
        return Err(parameter(format!("sum of weights[{i}]"), sum(&mesh.weights[i]).to_string(), "1".into()));
    }
    // The quadrics hold fourth powers of lengths; beyond this they would overflow.
    if let Some(i) = mesh.positions.iter().position(|p| p.iter().any(|c| c.abs() > 1.0e6)) {
        return Err(parameter(format!("positions[{i}]"), format!("{:?}", mesh.positions[i]), "within 1e6 m".into()));
    }
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        if let Some(&v) = triangle.iter().find(|&&v| v as usize >= vertex_count) {
            return Err(parameter(format!("triangles[{i}]"), v.to_string(), format!("below {vertex_count}")));
        }
    }
    Ok(())
}

/// Checks the poses against the mesh that they move.
pub(crate) fn validate_poses(mesh: &LodMesh<'_>, poses: &LodPoses<'_>) -> Result<()> {
    let frame_count = poses.frame_weights.len();
    if frame_count == 0 {
        return Err(parameter("frame_weights".into(), "no frame".into(), "at least one".into()));
    }
    if poses.joint_count == 0 || poses.joint_count > 1 << 16 {
        return Err(parameter("joint_count".into(), poses.joint_count.to_string(), "1..=65536".into()));
    }
    let expected = frame_count.checked_mul(poses.joint_count);
    if expected != Some(poses.palettes.len()) {
        let allowed = format!("{frame_count} frames of {} matrices", poses.joint_count);
        return Err(parameter("palettes".into(), poses.palettes.len().to_string(), allowed));
    }
    all_finite("palettes", poses.palettes.as_flattened().as_flattened(), 12)?;
    all_finite("frame_weights", poses.frame_weights, 1)?;
    if let Some(i) = poses.frame_weights.iter().position(|&w| w < 0.0) {
        let found = poses.frame_weights[i].to_string();
        return Err(parameter(format!("frame_weights[{i}]"), found, "not negative".into()));
    }
    let sum: f64 = poses.frame_weights.iter().map(|&w| f64::from(w)).sum();
    if !(0.99..=1.01).contains(&sum) {
        return Err(parameter("sum of frame_weights".into(), sum.to_string(), "1".into()));
    }
    if let Some(i) = poses.palettes.iter().position(|m| m.as_flattened().iter().any(|c| c.abs() > 1.0e6)) {
        return Err(parameter(format!("palettes[{i}]"), format!("{:?}", poses.palettes[i]), "within 1e6".into()));
    }
    let joint_limit = poses.joint_count;
    for (i, joints) in mesh.joints.iter().enumerate() {
        if let Some(&j) = joints.iter().find(|&&j| j as usize >= joint_limit) {
            return Err(parameter(format!("joints[{i}]"), j.to_string(), format!("below {joint_limit}")));
        }
    }
    keep_poses_near(mesh, poses)
}

/// Refuses a matrix that takes what follows it out of reach: by the box around the vertices of its joint.
fn keep_poses_near(mesh: &LodMesh<'_>, poses: &LodPoses<'_>) -> Result<()> {
    let mut extents = vec![[0.0_f32; 3]; poses.joint_count];
    let mut is_used = vec![false; poses.joint_count];
    for (v, position) in mesh.positions.iter().enumerate() {
        for slot in (0..4).filter(|&slot| mesh.weights[v][slot] > 0.0) {
            let joint = mesh.joints[v][slot] as usize;
            is_used[joint] = true;
            extents[joint] = [0, 1, 2].map(|i| extents[joint][i].max(position[i].abs()));
        }
    }
    for (i, matrix) in poses.palettes.iter().enumerate() {
        let joint = i % poses.joint_count;
        let reach = |row: &[f32; 4]| (0..3).map(|k| row[k].abs() * extents[joint][k]).sum::<f32>() + row[3].abs();
        let furthest = matrix.iter().map(reach).fold(0.0, f32::max);
        if is_used[joint] && furthest > MAX_POSED_M {
            let found = format!("takes vertices of joint {joint} {furthest} m away");
            return Err(parameter(format!("palettes[{i}]"), found, format!("up to {MAX_POSED_M} m")));
        }
    }
    Ok(())
}

/// Checks that positions times frames do not outgrow memory.
pub(crate) fn validate_frame_memory(position_count: usize, frame_count: usize) -> Result<()> {
    let bytes = (position_count * FRAME_BYTES).saturating_mul(frame_count);
    if bytes <= MAX_FRAME_MEMORY_BYTES {
        return Ok(());
    }
    let found = format!("{} MB for {position_count} positions in {frame_count} frames", bytes >> 20);
    Err(parameter("memory of the frames that count".into(), found, format!("{} MB", MAX_FRAME_MEMORY_BYTES >> 20)))
}

fn same_length(what: &str, found: usize, expected: usize) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(parameter(format!("length of {what}"), found.to_string(), expected.to_string()))
}

fn at_most(what: &str, found: usize, limit: usize) -> Result<()> {
    if found <= limit {
        return Ok(());
    }
    Err(parameter(what.into(), found.to_string(), format!("at most {limit}")))
}

fn all_finite(what: &str, numbers: &[f32], width: usize) -> Result<()> {
    match numbers.iter().position(|n| !n.is_finite()) {
        None => Ok(()),
        Some(i) => Err(parameter(format!("{what}[{}]", i / width), numbers[i].to_string(), "a finite number".into())),
    }
}

pub(crate) fn parameter(what: String, found: String, allowed: String) -> Error {
    Error::Parameter { what, found, allowed }
}
