//! Who throws a shadow into a cascade, and at which level.

use super::fill_budget::error_entry;
use crate::cascades::SUN_DIRECTION;
use crate::dispatch::{DOT_VERTICES, IMPOSTOR_VERTICES};
use crate::{
    BucketRecord, Buckets, Cascade, CascadeStep, CrowdData, FrameConfig, InstanceRecord, LodChoice, ShadowConfig,
};
use crowd_pack::LodRecord;
use glam::{Mat4, Vec3, Vec4};

/// Half texels at a map's rim that may not be read: those of the filter and of the offsets along normals.
const FINER_TEXELS: f32 = 16.0;

/// Height in texels below which somebody may be dots.
const DOTS_BELOW_TEXELS: f32 = 8.0;

/// Levels of those whose shadow may show in the cascade that `step` names; zeros for the others.
///
/// A caster's sphere meets the map's square, and the sphere drawn out along the sun's rays to the floor meets the camera's
/// frustum; and not all of it is in the next finer map, where whatever it shades looks first. Its level is the coarsest whose measured error is
/// at most two texels of the map, or dots where the camera may have some and it is less than eight texels high; never a finer one than the camera sees where `step.has_choices` says that `choices` has those, so that nobody is shaded by details they do not show.
/// Where levels morph, what the camera sees is on its way from the next coarser level to its own: none finer than that coarser one, whose
/// vertices all are at home.
///
/// `error_lods`: of [`crate::Buckets::error_lods`]. Returns one choice per instance.
///
/// Twin: `shaders/stages/select_casters.wgsl`. Equal unless a sphere touches a plane or the square's edge.
pub fn select_casters(
    data: &CrowdData,
    buckets: &Buckets,
    error_lods: &[LodRecord],
    instances: &[InstanceRecord],
    choices: &[LodChoice],
    shadow: &ShadowConfig,
    step: &CascadeStep,
    config: &FrameConfig,
) -> Vec<LodChoice> {
    let cascade = &shadow.cascades[step.cascade as usize];
    let clip_from_world = Mat4::from_cols_array_2d(&cascade.clip_from_world);
    let of = |(i, instance): (usize, &InstanceRecord)| {
        let (center, radius) = super::world_sphere(data, instance);
        let at = clip_from_world.transform_point3(center);
        let meets = instance.scale != 0.0 && at.truncate().abs().max_element() <= 1.0 + radius / cascade.half_m;
        if !meets
            || is_in_finer(shadow, step, center, radius)
            || !shadow_may_show(center, radius, shadow.floor_m, config)
        {
            return LodChoice::default();
        }
        let coarsest = error_lods[error_entry(instance.character, 0.0)];
        let LodRecord { vertex_count, triangle_count } = match dots_of(radius, cascade, &coarsest, config) {
            0 => error_lods[error_entry(instance.character, instance.scale * cascade.details_per_m)],
            dots => LodRecord { vertex_count: dots * DOT_VERTICES, triangle_count: dots },
        };
        let seen = match choices[i].vertex_count {
            // A picture throws the shadow of the coarsest mesh.
            IMPOSTOR_VERTICES if coarsest.vertex_count > IMPOSTOR_VERTICES => {
                LodChoice { vertex_count: coarsest.vertex_count, triangle_count: coarsest.triangle_count }
            }
            count if config.morph == 1 && count > coarsest.vertex_count => {
                coarser_than(buckets, instance.character, count)
            }
            _ => choices[i],
        };
        let sees_less = step.has_choices == 1 && seen.vertex_count > 0 && seen.vertex_count < vertex_count;
        if sees_less { seen } else { LodChoice { vertex_count, triangle_count } }
    };
    instances.iter().enumerate().map(of).collect()
}

/// The level next coarser than that of so many vertices, or the coarsest.
fn coarser_than(buckets: &Buckets, character: u32, vertex_count: u32) -> LodChoice {
    let coarser = buckets.level_of(character, vertex_count).saturating_sub(1);
    let BucketRecord { vertex_count, triangle_count, .. } = buckets.records[buckets.at(character, coarser) as usize];
    LodChoice { vertex_count, triangle_count }
}

/// Dots for somebody of a few texels, about one a texel of their height fewer vertices than the coarsest mesh and no more triangles; 0: the mesh.
fn dots_of(radius: f32, cascade: &Cascade, coarsest: &LodRecord, config: &FrameConfig) -> u32 {
    let height = radius / (0.55 * cascade.texel_m);
    let may_be = config.dot_area_px2 > 0.0 && height < DOTS_BELOW_TEXELS;
    if !may_be {
        return 0;
    }
    let mut dots = 1 << (height.max(1.0) as u32).ilog2();
    while dots > 0 && (dots * DOT_VERTICES >= coarsest.vertex_count || dots > coarsest.triangle_count.max(1)) {
        dots /= 2;
    }
    dots
}

/// Whether all that a sphere may shade finds its shadow in a finer map.
fn is_in_finer(shadow: &ShadowConfig, step: &CascadeStep, center: Vec3, radius: f32) -> bool {
    let Some(finer) = step.cascade.checked_sub(1).map(|finer| &shadow.cascades[finer as usize]) else { return false };
    let at = Mat4::from_cols_array_2d(&finer.clip_from_world).transform_point3(center);
    at.truncate().abs().max_element() + radius / finer.half_m <= 1.0 - FINER_TEXELS / shadow.side as f32
}

/// Whether a sphere and its shadow down to the floor meet the frustum.
fn shadow_may_show(center: Vec3, radius: f32, floor_m: f32, config: &FrameConfig) -> bool {
    let sun = Vec3::from(SUN_DIRECTION);
    let end = center - sun * ((center.y + radius - floor_m).max(0.0) / sun.y);
    config.planes.iter().all(|plane| {
        let plane = Vec4::from_array(*plane);
        plane.truncate().dot(center).max(plane.truncate().dot(end)) + plane.w >= -radius
    })
}
