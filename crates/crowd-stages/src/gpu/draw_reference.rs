//! What a reference camera sees besides the crowd: culled instances as dots and the frustum's edges.

use super::draw_crowd::DEPTH;
use super::kernel::{Use, buffer_entry};
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::{CrowdBounds, DrawConfig, FrameConfig, FrustumCorners, Result};
use glam::{Mat4, Vec3};

const RECORDS: &str = include_str!("../../../../shaders/shared/records.wgsl");
const REFERENCE: &str = include_str!("../../../../shaders/draw/reference.wgsl");
/// Vertices of twelve edges.
const EDGE_VERTICES: u32 = 12 * 6;
/// How far a frustum is drawn where nobody said where the crowd is, metres.
const USUAL_FAR_M: f32 = 100.0;

/// The WGSL of the reference camera's marks as it is compiled.
pub fn reference_source() -> String {
    [RECORDS, REFERENCE].concat()
}

/// Pipelines and buffers of the marks.
pub(crate) struct DrawReference {
    dots: wgpu::RenderPipeline,
    edges: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    corners: wgpu::Buffer,
}

impl DrawReference {
    /// `light`: the layout of bind group 1, which the pass has set.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        crowd: &CrowdBuffers,
        frame: &FrameBuffers,
        color_format: wgpu::TextureFormat,
        sample_count: u32,
        light: &wgpu::BindGroupLayout,
    ) -> Result<Self> {
        let device = up.device;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let corners = up.empty::<FrustumCorners>("frustum corners", 1, usage, "draw no reference camera")?;
        let uses = [Use::Uniform, Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read];
        let entry = |(i, kind): (usize, &Use)| buffer_entry(i as u32, wgpu::ShaderStages::VERTEX, *kind, None);
        let entries: Vec<_> = uses.iter().enumerate().map(entry).collect();
        let label = Some("reference");
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let buffers = [&frame.config, &frame.draw_config, &corners, &frame.instances, &crowd.characters, &frame.culled];
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let bound = device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout: &layout, entries: &entries });
        let source = wgpu::ShaderSource::Wgsl(reference_source().into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout), Some(light)],
            immediate_size: 0,
        });
        let pipeline = |vertex: &str| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(vertex),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Less),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: wgpu::MultisampleState { count: sample_count, ..Default::default() },
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("mark"),
                    compilation_options: Default::default(),
                    targets: &[Some(color_format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Ok(Self { dots: pipeline("culled_dot"), edges: pipeline("edge"), bound, corners })
    }

    /// Whose frustum is drawn.
    pub(crate) fn look_at(&self, queue: &wgpu::Queue, seen: &FrameConfig, bounds: &CrowdBounds) {
        queue.write_buffer(&self.corners, 0, bytemuck::bytes_of(&frustum_corners(seen, bounds)));
    }

    /// Draws the marks: dots of those whom the frustum does not meet, if `has_culled`, and the frustum's edges.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, has_culled: bool, instance_count: u32) {
        pass.set_bind_group(0, &self.bound, &[]);
        if has_culled {
            pass.set_pipeline(&self.dots);
            pass.draw(0..3, 0..instance_count);
        }
        pass.set_pipeline(&self.edges);
        pass.draw(0..EDGE_VERTICES, 0..1);
    }
}

/// Corners of a view's frustum from near the eye to the far end of the crowd.
fn frustum_corners(seen: &FrameConfig, bounds: &CrowdBounds) -> FrustumCorners {
    let clip_from_world = Mat4::from_cols_array_2d(&seen.clip_from_world);
    let DrawConfig { ray_x, ray_y, ray_w, .. } = DrawConfig::new(&clip_from_world, 1, 1, 1);
    let (x, y, w) = (Vec3::from(ray_x), Vec3::from(ray_y), Vec3::from(ray_w));
    let eye = Vec3::from(seen.eye);
    let corner = |c: u32| {
        let pick = |axis: usize| if c & (1 << axis) != 0 { bounds.high[axis] } else { bounds.low[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let ahead = w.normalize_or_zero();
    let depths = (0..8).map(|c| (corner(c) - eye).dot(ahead));
    let last = depths.fold(0.0, f32::max);
    let far_m = if bounds.low.x > bounds.high.x || last <= 0.0 { USUAL_FAR_M } else { last };
    let near_m = 0.01 * far_m;
    let mut corners = [[0.0; 4]; 8];
    for (c, place) in corners.iter_mut().enumerate() {
        let side = |bit: usize| if c & bit != 0 { 1.0 } else { -1.0 };
        let depth_m = if c & 4 != 0 { far_m } else { near_m };
        *place = (eye + (x * side(1) + y * side(2) + w) * depth_m).extend(1.0).to_array();
    }
    FrustumCorners { corners }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FrameView, Weight};

    #[test]
    fn corners_lie_on_the_pictures_corners_from_near_the_eye_to_the_crowds_end() {
        let eye = Vec3::new(3.0, 2.0, 9.0);
        let view = glam::camera::rh::view::look_at_mat4(eye, Vec3::new(0.5, 1.0, -4.0), Vec3::Y);
        let clip_from_world = glam::camera::rh::proj::directx::perspective(0.9, 16.0 / 9.0, 0.1, 500.0) * view;
        let seen = FrameConfig::from_camera(&FrameView {
            clip_from_world,
            eye,
            fov_y_rad: 0.9,
            viewport_height_px: 360.0,
            time_s: 0.0,
            budget: 1,
            alpha: 3.0,
            weight: Weight::Area,
        });
        let mut bounds = CrowdBounds::default();
        bounds.add(Vec3::ZERO, 30.0);
        let FrustumCorners { corners } = frustum_corners(&seen, &bounds);
        for (c, corner) in corners.iter().enumerate() {
            let clip = clip_from_world * glam::Vec4::from_array(*corner);
            let side = |bit: usize| if c & bit != 0 { 1.0 } else { -1.0 };
            assert!((clip.x / clip.w - side(1)).abs() < 1e-3 && (clip.y / clip.w - side(2)).abs() < 1e-3, "{clip}");
        }
        let depth = |c: usize| (clip_from_world * glam::Vec4::from_array(corners[c])).w;
        assert!(depth(4) > 39.0 && depth(4) < 75.0 && depth(0) < 1.0, "{} {}", depth(4), depth(0));
        let unknown = frustum_corners(&seen, &CrowdBounds::default());
        assert!(((clip_from_world * glam::Vec4::from_array(unknown.corners[7])).w - USUAL_FAR_M).abs() < 0.1);
    }
}
