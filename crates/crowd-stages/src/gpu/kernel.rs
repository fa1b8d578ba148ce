//! A compute shader with its entry points: what all stages' dispatches have in common.

use crate::dispatch::{BLOCK_SIZE, FOLD_COLUMNS, INSTANCE_GROUP_SIZE};
use std::num::NonZeroU64;

/// Text that stands before every stage's shader.
const RECORDS: &str = include_str!("../../../../shaders/shared/records.wgsl");

/// How a stage uses a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Use {
    /// A uniform.
    Uniform,
    /// Storage, only read.
    Read,
    /// Storage, read and written.
    Write,
    /// A texture of layers whose texels are only fetched.
    Frames,
    /// The same as a storage texture, see [`fetches_from_storage`].
    StoredFrames,
}

/// Whether frames are fetched from a storage texture: on software Vulkan that is code of a few loads within the shader, where a texture's fetch
/// is a call for which everything is put aside, and which looks for each lane's mip level. Cards have hardware for the latter.
pub(crate) fn fetches_from_storage(device: &wgpu::Device) -> bool {
    is_software(device) && device.limits().max_storage_textures_per_shader_stage > 0
}

/// Whether stages run on a processor (llvmpipe): what they cost there is what they touch.
pub(crate) fn is_software(device: &wgpu::Device) -> bool {
    let info = device.adapter_info();
    info.device_type == wgpu::DeviceType::Cpu && info.backend == wgpu::Backend::Vulkan
}

/// The same WGSL with frames in a storage texture, which has no levels to name.
pub(crate) fn with_stored_frames(source: &str) -> String {
    let [declared, fetched] = ["var animation: texture_2d_array<u32>", "textureLoad(animation, vec2u(x, y), layer, 0)"];
    assert!(source.contains(declared) && source.contains(fetched), "frames.wgsl fetches in other words");
    source
        .replace(declared, "var animation: texture_storage_2d_array<rgba32uint, read>")
        .replace(fetched, "textureLoad(animation, vec2u(x, y), layer)")
}

/// The same for the shadow maps.
pub(crate) fn with_stored_maps(source: &str) -> String {
    let [declared, fetched] = ["var shadow_map: texture_2d_array<f32>", ", map, 0).x"];
    assert!(source.contains(declared) && source.matches(fetched).count() == 3, "shadow.wgsl fetches in other words");
    source.replace(declared, "var shadow_map: texture_storage_2d_array<r32float, read>").replace(fetched, ", map).x")
}

/// A shader that looks at the shadow maps, as it is compiled for the device.
pub(crate) fn lit_source(device: &wgpu::Device, source: String) -> String {
    if fetches_from_storage(device) { with_stored_maps(&source) } else { source }
}

/// The WGSL a stage is compiled from.
pub(crate) fn stage_source(shared: &[&str], stage: &str) -> String {
    let mut source = String::from(RECORDS);
    for part in shared {
        source.push_str(part);
    }
    source.push_str(stage);
    source
}

/// A layout of buffers at bindings 0, 1, 2, ...
pub(crate) fn buffer_layout(
    device: &wgpu::Device,
    name: &str,
    visibility: wgpu::ShaderStages,
    uses: &[Use],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> =
        uses.iter().enumerate().map(|(i, kind)| buffer_entry(i as u32, visibility, *kind, None)).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries })
}

pub(crate) fn buffer_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    kind: Use,
    min_binding_size: Option<NonZeroU64>,
) -> wgpu::BindGroupLayoutEntry {
    let ty = match kind {
        Use::Frames => {
            let ty = wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            };
            return wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        }
        Use::StoredFrames => {
            let ty = wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::ReadOnly,
                format: wgpu::TextureFormat::Rgba32Uint,
                view_dimension: wgpu::TextureViewDimension::D2Array,
            };
            return wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        }
        Use::Uniform => wgpu::BufferBindingType::Uniform,
        Use::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Use::Write => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size },
        count: None,
    }
}

/// Arguments of dispatches that the GPU writes where there is something to do and leaves at zero elsewhere: what `recall_seen` calls `gate`.
pub(crate) type Gate<'a> = Option<&'a wgpu::Buffer>;

/// Which of a gate's three entries says how many groups there are; its number.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Groups {
    /// A block of instances each.
    Blocks = 0,
    /// One.
    One = 1,
    /// Of the sort in one pass.
    Runs = 2,
}

/// A stage's pipelines, one an entry point, over one layout.
pub(crate) struct Kernel {
    name: &'static str,
    layout: wgpu::BindGroupLayout,
    pipelines: Vec<wgpu::ComputePipeline>,
}

impl Kernel {
    pub(crate) fn new(
        device: &wgpu::Device,
        name: &'static str,
        source: String,
        entry_points: &[&'static str],
        uses: &[Use],
    ) -> Self {
        Self::with_constants(device, name, source, entry_points, uses, &[])
    }

    /// The same with constants of the shader.
    pub(crate) fn with_constants(
        device: &wgpu::Device,
        name: &'static str,
        source: String,
        entry_points: &[&'static str],
        uses: &[Use],
        constants: &[(&str, f64)],
    ) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = buffer_layout(device, name, wgpu::ShaderStages::COMPUTE, uses);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |entry_point: &&'static str| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                // Stages write what a group shares before they read it; clearing it beforehand is dear on software
                // Vulkan: `write_bucket_args` takes a sixth of its time without.
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    zero_initialize_workgroup_memory: false,
                },
                cache: None,
            })
        };
        let pipelines = entry_points.iter().map(pipeline).collect();
        Self { name, layout, pipelines }
    }

    /// Buffers in the order of the shader's bindings.
    pub(crate) fn bind(&self, device: &wgpu::Device, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        self.bind_resources(device, buffers.iter().map(|buffer| buffer.as_entire_binding()))
    }

    /// The same of other things than buffers, too.
    pub(crate) fn bind_resources<'b>(
        &self,
        device: &wgpu::Device,
        resources: impl IntoIterator<Item = wgpu::BindingResource<'b>>,
    ) -> wgpu::BindGroup {
        let entries: Vec<_> =
            (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.name),
            layout: &self.layout,
            entries: &entries,
        })
    }

    /// Dispatches entry point number `entry` with that many groups, folded into rows; none for zero groups.
    pub(crate) fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        entry: usize,
        bound: &wgpu::BindGroup,
        groups: u32,
    ) {
        if groups == 0 {
            return;
        }
        pass.set_pipeline(&self.pipelines[entry]);
        pass.set_bind_group(0, bound, &[]);
        pass.dispatch_workgroups(groups.min(FOLD_COLUMNS), groups.div_ceil(FOLD_COLUMNS), 1);
    }

    /// The same, or where there is a gate as many groups as that lets through.
    pub(crate) fn dispatch_gated(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        entry: usize,
        bound: &wgpu::BindGroup,
        groups: (Groups, u32),
        gate: Gate<'_>,
    ) {
        let Some(gate) = gate else {
            self.dispatch(pass, entry, bound, groups.1);
            return;
        };
        pass.set_pipeline(&self.pipelines[entry]);
        pass.set_bind_group(0, bound, &[]);
        pass.dispatch_workgroups_indirect(gate, groups.0 as u64 * size_of::<[u32; 3]>() as u64);
    }

    /// Dispatches as many groups as a buffer says.
    pub(crate) fn dispatch_indirect(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        entry: usize,
        bound: &wgpu::BindGroup,
        groups: &wgpu::Buffer,
    ) {
        pass.set_pipeline(&self.pipelines[entry]);
        pass.set_bind_group(0, bound, &[]);
        pass.dispatch_workgroups_indirect(groups, 0);
    }
}

/// Groups when each thread works on one element.
pub(crate) fn blocks(count: u32) -> u32 {
    count.div_ceil(BLOCK_SIZE)
}

/// Groups when each group works on one instance.
pub(crate) fn instance_groups(count: u32) -> u32 {
    const { assert!(INSTANCE_GROUP_SIZE <= 256, "default limits allow 256 threads a group") };
    count
}
