//! Ground and walls around the crowd: one indexed draw after the backdrop.

use super::kernel::{Use, buffer_entry, lit_source};
use super::lit::{Lit, has_shadows};
use super::renderer::RendererOptions;
use super::shadows::caster_bias;
use super::targets::DepthWay;
use super::upload::Uploader;
use crate::{Error, Result, SceneryVertex};
use std::mem::size_of;

const RECORDS: &str = include_str!("../../../../shaders/shared/records.wgsl");
const LIGHT: &str = include_str!("../../../../shaders/shared/light.wgsl");
const SHADOW: &str = include_str!("../../../../shaders/shared/shadow.wgsl");
const SCENERY: &str = include_str!("../../../../shaders/draw/scenery.wgsl");

/// The WGSL of the scenery's draw as it is compiled.
pub fn scenery_source() -> String {
    [RECORDS, LIGHT, SHADOW, SCENERY].concat()
}

/// Pipeline and buffers of the scenery.
pub(crate) struct DrawScenery {
    pipeline: Lit,
    caster: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    bound: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl DrawScenery {
    /// Uploads. `config`: the frame's uniform; `light`: the layout of bind group 1.
    ///
    /// # Errors
    /// [`Error::Instance`] for a triangle whose corner is not there, [`Error::Limit`] or [`Error::OutOfMemory`] where it does
    /// not fit the device.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        config: &wgpu::Buffer,
        vertices: &[SceneryVertex],
        triangles: &[[u32; 3]],
        options: &RendererOptions,
        light: &wgpu::BindGroupLayout,
    ) -> Result<Self> {
        let allowed = vertices.len() as u32;
        if let Some((index, &found)) =
            triangles.as_flattened().iter().enumerate().find(|(_, corner)| **corner >= allowed)
        {
            return Err(Error::Instance { index, what: "corner of the scenery", found, allowed });
        }
        let remedy = "draw a simpler scenery";
        let layout = up.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("scenery"),
            entries: &[buffer_entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, Use::Uniform, None)],
        });
        let (device, of, light) = (up.device.clone(), layout.clone(), light.clone());
        let options = *options;
        let lit = move |shows| pipeline(&device, &of, Some((&options, &light, shows)));
        Ok(Self {
            pipeline: Lit::new(lit),
            caster: pipeline(up.device, &layout, None),
            bound: bind(up.device, &layout, config),
            layout,
            vertices: up.filled("scenery vertices", vertices, wgpu::BufferUsages::VERTEX, remedy)?,
            indices: up.filled("scenery indices", triangles.as_flattened(), wgpu::BufferUsages::INDEX, remedy)?,
            index_count: 3 * triangles.len() as u32,
        })
    }

    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, shows_shadows: bool) {
        self.draw_with(pass, self.pipeline.of(shows_shadows), &self.bound);
    }

    /// Draws depth alone as `config` has the camera.
    pub(crate) fn cast(&self, device: &wgpu::Device, pass: &mut wgpu::RenderPass<'_>, config: &wgpu::Buffer) {
        self.draw_with(pass, &self.caster, &bind(device, &self.layout, config));
    }

    fn draw_with(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline, bound: &wgpu::BindGroup) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bound, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.index_count, 0, 0..1);
    }
}

fn bind(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, config: &wgpu::Buffer) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scenery"),
        layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: config.as_entire_binding() }],
    })
}

/// `lit`: what the targets are, the layout of the light and whether that has maps; `None` draws depth alone, of both sides.
fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    lit: Option<(&RendererOptions, &wgpu::BindGroupLayout, bool)>,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("scenery"),
        source: wgpu::ShaderSource::Wgsl(lit_source(device, scenery_source()).into()),
    });
    let light = lit.map(|(_, light, _)| light);
    let constants = [has_shadows(lit.is_some_and(|(.., shows)| shows))];
    let bind_group_layouts: Vec<_> = [Some(layout), light].into_iter().filter(Option::is_some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("scenery"),
        bind_group_layouts: &bind_group_layouts,
        immediate_size: 0,
    });
    let targets = lit.map(|(options, ..)| [Some(options.color_format.into())]);
    let depth = lit.map_or(DepthWay::OF_MAPS, |(options, ..)| DepthWay::of(options));
    let bias = if lit.is_some() { Default::default() } else { caster_bias() };
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4, 2 => Float32x3];
    let corners = wgpu::VertexBufferLayout {
        array_stride: size_of::<SceneryVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("scenery"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place"),
            compilation_options: Default::default(),
            buffers: &[Some(corners)],
        },
        primitive: wgpu::PrimitiveState { cull_mode: lit.map(|_| wgpu::Face::Back), ..Default::default() },
        depth_stencil: Some(depth.state(depth.nearer(), bias)),
        multisample: wgpu::MultisampleState {
            count: lit.map_or(1, |(options, ..)| options.sample_count),
            ..Default::default()
        },
        fragment: targets.as_ref().map(|targets| wgpu::FragmentState {
            module: &module,
            entry_point: Some("shade"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
