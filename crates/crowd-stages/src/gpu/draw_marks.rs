//! What is shown besides the crowd: by a reference camera culled instances as dots and the frustum's edges, by views tags.

use super::kernel::{Use, buffer_entry};
use super::renderer::RendererOptions;
use super::targets::DepthWay;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::{CrowdBounds, DrawConfig, FrameConfig, MarkConfig, Result, View};
use glam::{Mat4, Vec3};

const RECORDS: &str = include_str!("../../../../shaders/shared/records.wgsl");
const MARKS: &str = include_str!("../../../../shaders/draw/marks.wgsl");
/// Vertices of twelve edges.
const EDGE_VERTICES: u32 = 12 * 6;
/// How far a frustum is drawn where nobody said where the crowd is, metres.
const USUAL_FAR_M: f32 = 100.0;

/// The WGSL of the marks as it is compiled.
pub fn marks_source() -> String {
    [RECORDS, MARKS].concat()
}

/// Pipelines and buffers of the marks.
pub(crate) struct DrawMarks {
    dots: wgpu::RenderPipeline,
    edges: wgpu::RenderPipeline,
    tags: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    config: wgpu::Buffer,
}

/// Vertices of a tag's two triangles.
const TAG_VERTICES: u32 = 6;

impl DrawMarks {
    /// `light`: the layout of bind group 1, which the pass has set.
    pub(crate) fn new(up: &mut Uploader<'_>, options: &RendererOptions, light: &wgpu::BindGroupLayout) -> Result<Self> {
        let RendererOptions { color_format, sample_count, .. } = *options;
        let depth = DepthWay::of(options);
        let device = up.device;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let config = up.empty::<MarkConfig>("marks", 1, usage, "draw no marks")?;
        let uses = [Use::Uniform, Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Read];
        let entry = |(i, kind): (usize, &Use)| buffer_entry(i as u32, wgpu::ShaderStages::VERTEX, *kind, None);
        let entries: Vec<_> = uses.iter().enumerate().map(entry).collect();
        let label = Some("marks");
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let source = wgpu::ShaderSource::Wgsl(marks_source().into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout), Some(light)],
            immediate_size: 0,
        });
        let constants = [("REVERSED", u8::from(depth.reversed).into())];
        let pipeline = |vertex: &str, fragment: &str, blend: Option<wgpu::BlendState>| {
            let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(vertex),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: options,
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: Some(depth.state(depth.nearer(), Default::default())),
                multisample: wgpu::MultisampleState { count: sample_count, ..Default::default() },
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState { blend, ..color_format.into() })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let tags = pipeline("tag", "shade_tag", Some(wgpu::BlendState::ALPHA_BLENDING));
        Ok(Self {
            dots: pipeline("culled_dot", "mark", None),
            edges: pipeline("edge", "mark", None),
            tags,
            layout,
            config,
        })
    }

    /// What the marks of the next frame show: `seen` is the frame, whose frustum a reference camera sees.
    pub(crate) fn write(
        &self,
        queue: &wgpu::Queue,
        seen: &FrameConfig,
        bounds: &CrowdBounds,
        view: View,
        has_choices: bool,
    ) {
        let corners = frustum_corners(seen, bounds);
        let config = MarkConfig { corners, view: view as u32, has_choices: has_choices.into(), ..Default::default() };
        queue.write_buffer(&self.config, 0, bytemuck::bytes_of(&config));
    }

    /// `sight`: of occlusion culling; without it anything that can be read.
    pub(crate) fn bind(
        &self,
        device: &wgpu::Device,
        crowd: &CrowdBuffers,
        frame: &FrameBuffers,
        sight: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let FrameBuffers { config, draw_config, instances, culled, choices, .. } = frame;
        let buffers = [config, draw_config, &self.config, instances, &crowd.characters, culled, choices, sight];
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let label = Some("marks");
        device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout: &self.layout, entries: &entries })
    }

    /// Draws what a reference camera sees: dots of those whom the frustum does not meet, if `has_culled`, and its edges.
    pub(crate) fn draw_reference(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bound: &wgpu::BindGroup,
        has_culled: bool,
        instance_count: u32,
    ) {
        pass.set_bind_group(0, bound, &[]);
        if has_culled {
            pass.set_pipeline(&self.dots);
            pass.draw(0..3, 0..instance_count);
        }
        pass.set_pipeline(&self.edges);
        pass.draw(0..EDGE_VERTICES, 0..1);
    }

    /// Draws a tag over everyone of whom the view says something.
    pub(crate) fn draw_tags(&self, pass: &mut wgpu::RenderPass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        pass.set_bind_group(0, bound, &[]);
        pass.set_pipeline(&self.tags);
        pass.draw(0..TAG_VERTICES, 0..instance_count);
    }
}

/// Corners of a view's frustum from near the eye to the far end of the crowd.
fn frustum_corners(seen: &FrameConfig, bounds: &CrowdBounds) -> [[f32; 4]; 8] {
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
    corners
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
        let corners = frustum_corners(&seen, &bounds);
        for (c, corner) in corners.iter().enumerate() {
            let clip = clip_from_world * glam::Vec4::from_array(*corner);
            let side = |bit: usize| if c & bit != 0 { 1.0 } else { -1.0 };
            assert!((clip.x / clip.w - side(1)).abs() < 1e-3 && (clip.y / clip.w - side(2)).abs() < 1e-3, "{clip}");
        }
        let depth = |c: usize| (clip_from_world * glam::Vec4::from_array(corners[c])).w;
        assert!(depth(4) > 39.0 && depth(4) < 75.0 && depth(0) < 1.0, "{} {}", depth(4), depth(0));
        let unknown = frustum_corners(&seen, &CrowdBounds::default());
        assert!(((clip_from_world * glam::Vec4::from_array(unknown[7])).w - USUAL_FAR_M).abs() < 0.1);
    }
}
