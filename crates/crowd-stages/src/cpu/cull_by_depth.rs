//! Which of three discrete levels an instance is drawn at, if any.

use super::world_from_local;
use crate::{Buckets, CrowdData, DiscreteConfig, FrameConfig, InstanceRecord};
use glam::{Mat4, Vec3, Vec4};

/// Keys of the instances: the bucket of one of three levels by depth, or [`Buckets::nobody`] when culled.
///
/// An instance is reduced to the centre of its character's box. It is culled when that lies outside the frustum widened by half
/// the diagonal of the largest character's box (times the instance's scale); its depth, the w of clip space in metres, is
/// compared with `config.lod_depths_m`. `levels`: of [`Buckets::discrete_levels`], three a character, the finest first.
///
/// Paper: Park & Han 2009 §3.1. Departs: one stage writes what their geometry shader streams out; depth is that before the
/// division by w, which they do not say.
/// Twin: `shaders/stages/cull_by_depth.wgsl`. Equal unless a centre lies within [`super::PLANE_BOUND_M`] of a widened plane or
/// a depth within that of a threshold.
pub fn cull_by_depth(
    data: &CrowdData,
    buckets: &Buckets,
    levels: &[u32],
    discrete: &DiscreteConfig,
    instances: &[InstanceRecord],
    config: &FrameConfig,
) -> Vec<u32> {
    let clip_from_world = Mat4::from_cols_array_2d(&config.clip_from_world);
    let key = |instance: &InstanceRecord| {
        let center = box_center(data, instance);
        let reach = discrete.half_diagonal_m * instance.scale;
        let is_inside = |plane: &[f32; 4]| {
            let plane = Vec4::from_array(*plane);
            plane.truncate().dot(center) + plane.w >= -reach
        };
        if instance.scale == 0.0 || !config.planes.iter().all(is_inside) {
            return buckets.nobody();
        }
        let depth_m = (clip_from_world * center.extend(1.0)).w;
        let level = config.lod_depths_m.iter().filter(|threshold| depth_m > **threshold).count();
        levels[instance.character as usize * 3 + level]
    };
    instances.iter().map(key).collect()
}

/// The centre of the instance's box in the world.
pub fn box_center(data: &CrowdData, instance: &InstanceRecord) -> Vec3 {
    let character = &data.characters[instance.character as usize];
    let (min, max) = (Vec3::from_array(character.box_min), Vec3::from_array(character.box_max));
    world_from_local(instance, (min + max) * 0.5)
}
