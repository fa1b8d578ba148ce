//! Which instances can be seen, and how much each weighs.

use crate::{CrowdData, CullRecord, FrameConfig, InstanceRecord, Weight};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Tests every instance's bounding sphere against the frustum and weighs it.
///
/// The sphere is that of the clip playing, scaled, turned and moved by the instance. An instance is visible when the
/// sphere reaches the inner side of all six planes, so spheres outside a corner may pass: nothing visible is ever dropped.
/// The projected area is `pi * (focal_px * radius / distance)²`, with the distance at least the radius. Returns one
/// [`CullRecord`] per instance; weight and area are 0 when culled. An instance of scale 0 is nobody, a place that is free.
///
/// Paper: Peng 2011 §5.1 (bounding spheres against the frustum, `A^(1/alpha)`) and Dong 2019 §4.1 ([`Weight::AreaDistance`]).
/// Departs: the papers use one sphere per character; ours follows the clip. The papers leave a camera inside a sphere open.
///
/// Twin: `shaders/stages/cull_instances.wgsl`. Visibility equal unless a sphere touches a plane within [`PLANE_BOUND_M`]
/// metres a metre; floats within [`FLOAT_BOUND`].
pub fn cull_instances(data: &CrowdData, instances: &[InstanceRecord], config: &FrameConfig) -> Vec<CullRecord> {
    instances.par_iter().with_min_len(1024).map(|instance| cull(data, instance, config)).collect()
}

/// How far GPU and CPU may differ in a sphere's distance to a plane, as a share of the coordinates' size: a few roundings
/// of dot products, and a sine that WGSL lets be off by 2^-11 of the sphere's offset.
pub const PLANE_BOUND_M: f32 = 1e-5;

/// How far GPU and CPU may differ in weight, area and distance, as a share of the value. WGSL allows `pow` the errors of
/// `exp2(y * log2(x))`: 3 ulp of log2 at values up to 30 before exp2, then `3 + 2 * |x|` ulp; about 60 ulp in all.
pub const FLOAT_BOUND: f32 = 1e-5;

/// The instance's bounding sphere in the world: centre and radius, metres.
///
/// Of someone who fades it lies between the spheres of both clips, as every vertex does: a point of one sphere and a point of the
/// other, mixed by a share, are no farther from the mixed centres than the mixed radii.
pub fn world_sphere(data: &CrowdData, instance: &InstanceRecord) -> (Vec3, f32) {
    let of = |clip: u32| Vec4::from_array(data.clips[clip as usize].sphere);
    let own = of(instance.clip);
    let sphere = own + (of(instance.left_clip()) - own) * instance.leaving_share;
    (super::world_from_local(instance, sphere.truncate()), sphere.w * instance.scale)
}

fn cull(data: &CrowdData, instance: &InstanceRecord, config: &FrameConfig) -> CullRecord {
    let (center, radius) = world_sphere(data, instance);
    let distance_m = center.distance(Vec3::from_array(config.eye));
    let is_inside = config.planes.iter().all(|plane| {
        let plane = Vec4::from_array(*plane);
        plane.truncate().dot(center) + plane.w >= -radius
    });
    // Of no size: nobody.
    if !is_inside || instance.scale == 0.0 {
        return CullRecord { visible: 0, weight: 0.0, area_px2: 0.0, distance_m };
    }

    // Inside the sphere the projection has no meaning: the sphere fills the picture, no more.
    let nearest = distance_m.max(radius).max(1e-6);
    let radius_px = config.focal_px * radius / nearest;
    let area_px2 = std::f32::consts::PI * radius_px * radius_px;
    let weight = if config.weight == Weight::AreaDistance as u32 {
        let detail = data.characters[instance.character as usize].vertex_count as f32;
        libm::powf((area_px2 / nearest).max(1e-12), config.inverse_alpha)
            * libm::powf(detail.max(1.0), 1.0 - config.inverse_alpha)
    } else if config.weight == Weight::Error as u32 {
        config.focal_px * instance.scale / nearest
    } else {
        libm::powf(area_px2.max(1e-12), config.inverse_alpha)
    };
    CullRecord { visible: instance.character + 1, weight, area_px2, distance_m }
}
