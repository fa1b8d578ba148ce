//! Dispatches of the depth pyramid: the two finest levels from the depth texture, then one dispatch a large level and one for the others.

use super::kernel::{Use, blocks, buffer_entry, stage_source};
use crate::{PyramidConfig, PyramidStep};
use wgpu::util::DeviceExt;

/// Numbers of a level that one group makes in a few turns.
const SMALL: u32 = 4096;

/// Shader: `shaders/stages/build_pyramid.wgsl`. Twin: [`crate::cpu::build_pyramid`].
pub struct BuildPyramid {
    /// From one sample a pixel, and from several.
    read: [(wgpu::ComputePipeline, wgpu::BindGroupLayout); 2],
    halve: (wgpu::ComputePipeline, wgpu::BindGroupLayout),
    finish: (wgpu::ComputePipeline, wgpu::BindGroupLayout),
    /// Gathers four depths at a time; beyond the rim it has the rim's.
    nearest: wgpu::Sampler,
}

/// The buffers and the depth of one size, bound.
pub struct BoundPyramid {
    config: PyramidConfig,
    read: wgpu::BindGroup,
    /// Of each large level but the two finest.
    halve: Vec<wgpu::BindGroup>,
    /// Of all others, if there are any.
    finish: Option<wgpu::BindGroup>,
}

impl BuildPyramid {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/build_pyramid.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("build_pyramid"),
            source: wgpu::ShaderSource::Wgsl(Self::source().into()),
        });
        let compute = wgpu::ShaderStages::COMPUTE;
        let buffer = |binding, kind| buffer_entry(binding, compute, kind, None);
        let depth = |binding, multisampled| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: compute,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Depth,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled,
            },
            count: None,
        };
        let entry_point = |name: &'static str, entries: &[wgpu::BindGroupLayoutEntry]| {
            let layout =
                device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            });
            (pipeline, layout)
        };
        let config = buffer(0, Use::Uniform);
        let farthest = buffer(2, Use::Write);
        let sampler = wgpu::BindGroupLayoutEntry {
            binding: 5,
            visibility: compute,
            ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
            count: None,
        };
        Self {
            read: [
                entry_point("read_depth", &[config, farthest, depth(3, false), sampler]),
                entry_point("read_samples", &[config, farthest, depth(4, true)]),
            ],
            halve: entry_point("halve", &[config, buffer(1, Use::Uniform), farthest]),
            finish: entry_point("finish", &[config, buffer(1, Use::Uniform), farthest]),
            nearest: device.create_sampler(&wgpu::SamplerDescriptor { label: Some("nearest"), ..Default::default() }),
        }
    }

    /// Binds a pyramid: its shape as a value and in its buffer, room for its numbers, and a view of the depth texture of that
    /// size and number of samples.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: PyramidConfig,
        pyramid: &wgpu::Buffer,
        farthest: &wgpu::Buffer,
        depth: &wgpu::TextureView,
    ) -> BoundPyramid {
        let read = self.bind_depth(device, config, pyramid, farthest, depth);
        let of_level = |level: u32, layout: &wgpu::BindGroupLayout| {
            let step = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("pyramid step"),
                contents: bytemuck::bytes_of(&PyramidStep { level, ..Default::default() }),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("halve"),
                layout,
                entries: &[
                    entry(0, pyramid.as_entire_binding()),
                    entry(1, step.as_entire_binding()),
                    entry(2, farthest.as_entire_binding()),
                ],
            })
        };
        let is_large = |level: &u32| {
            let level = &config.levels[*level as usize];
            level.width * level.height > SMALL
        };
        let small = (2..config.level_count).find(|level| !is_large(level)).unwrap_or(config.level_count);
        let halve = (2..small).map(|level| of_level(level, &self.halve.1)).collect();
        let finish = (small < config.level_count).then(|| of_level(small, &self.finish.1));
        BoundPyramid { config, read, halve, finish }
    }

    fn bind_depth(
        &self,
        device: &wgpu::Device,
        config: PyramidConfig,
        pyramid: &wgpu::Buffer,
        farthest: &wgpu::Buffer,
        depth: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let several = usize::from(config.sample_count > 1);
        let mut entries = vec![
            entry(0, pyramid.as_entire_binding()),
            entry(2, farthest.as_entire_binding()),
            entry(3 + several as u32, wgpu::BindingResource::TextureView(depth)),
        ];
        if several == 0 {
            entries.push(entry(5, wgpu::BindingResource::Sampler(&self.nearest)));
        }
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("read_depth"),
            layout: &self.read[several].1,
            entries: &entries,
        })
    }

    /// Binds another `depth` of the same kind and size.
    pub(crate) fn rebind_depth(
        &self,
        device: &wgpu::Device,
        bound: &mut BoundPyramid,
        pyramid: &wgpu::Buffer,
        farthest: &wgpu::Buffer,
        depth: &wgpu::TextureView,
    ) {
        bound.read = self.bind_depth(device, bound.config, pyramid, farthest, depth);
    }

    /// Records the dispatches, one a large level and one for all small ones.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &BoundPyramid) {
        let groups_of = |level: usize| {
            let level = &bound.config.levels[level];
            blocks(level.width * level.height)
        };
        let finest = &bound.config.levels[0];
        let fours = blocks(finest.width.div_ceil(2) * finest.height.div_ceil(2));
        let mut dispatch = |pipeline: &wgpu::ComputePipeline, group: &wgpu::BindGroup, groups: u32| {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(
                groups.min(crate::dispatch::FOLD_COLUMNS),
                groups.div_ceil(crate::dispatch::FOLD_COLUMNS),
                1,
            );
        };
        dispatch(&self.read[usize::from(bound.config.sample_count > 1)].0, &bound.read, fours);
        for (before, group) in bound.halve.iter().enumerate() {
            dispatch(&self.halve.0, group, groups_of(before + 2));
        }
        if let Some(group) = &bound.finish {
            dispatch(&self.finish.0, group, 1);
        }
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}
