//! What the vertex shader of points computes, point by point.

use super::pose_instance::{blend_palette, skin_matrix};
use super::{turn, world_from_local};
use crate::{CrowdData, InstanceRecord, PointRecord};
use crowd_pack::decode_normal;
use glam::{Vec3, Vec4};

/// A point in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosedPoint {
    /// World, metres.
    pub position: Vec3,
    /// World, unit.
    pub normal: Vec3,
    /// Linear base colour.
    pub color: Vec3,
    /// Light does not change it.
    pub is_unlit: bool,
    /// The back is seen, too.
    pub is_double_sided: bool,
}

/// The points of an instance at `time_s`. `points`: the first ones of its character's, as many as are drawn.
///
/// Paper: Dong 2019 Eq. 2, for points in the place of vertices. Twin: `shaders/draw/points.wgsl`.
pub fn pose_points(
    data: &CrowdData,
    points: &[PointRecord],
    instance: &InstanceRecord,
    time_s: f32,
) -> Vec<PosedPoint> {
    let palette = blend_palette(data, instance, time_s);
    let pose = |point: &PointRecord| {
        let rows = skin_matrix(&palette, point.joints, point.weights);
        let apply = |v: Vec4| Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
        let normal = apply(Vec3::from_array(decode_normal(point.normal_oct)).extend(0.0));
        let [r, g, b, lit] = point.color;
        let root = Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0;
        PosedPoint {
            position: world_from_local(instance, apply(Vec3::from_array(point.position).extend(1.0))),
            normal: turn(instance.yaw_rad, normal).normalize_or(Vec3::Y),
            color: root * root,
            is_unlit: lit < 128,
            is_double_sided: point.is_double_sided != 0,
        }
    };
    points.iter().map(pose).collect()
}
