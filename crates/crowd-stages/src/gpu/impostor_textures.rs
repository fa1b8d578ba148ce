//! Impostors on the GPU: their tiles as layers of two textures, and the vertices they are drawn from.

use super::allocate::texture_or_error;
use super::kernel::{Use, buffer_entry};
use super::upload::{Uploader, array_layers, array_view};
use crate::{CrowdData, Error, ImpostorSheet, Result};
use wgpu::BufferUsages as Usage;

/// Texels that a layer is high at most, unless one pose needs more.
const LAYER_HEIGHT: u32 = 2048;
const REMEDY: &str = "bake fewer characters into one pack, or smaller impostors";

/// What drawing impostors needs.
pub(crate) struct ImpostorTextures {
    /// Of [`crate::Impostors::vertices`].
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) bound: wgpu::BindGroup,
}

impl ImpostorTextures {
    /// `None` where the crowd has no impostors.
    pub(crate) fn new(up: &mut Uploader<'_>, data: &CrowdData) -> Result<Option<Self>> {
        let Some(impostors) = &data.impostors else { return Ok(None) };
        let pose_height = impostors.tile_px * impostors.elevation_count;
        let pose_count = impostors.characters.iter().map(|c| c.pose_count * c.clip_count).sum::<u32>().max(1);
        let poses_a_layer = (LAYER_HEIGHT / pose_height).clamp(1, pose_count);
        let (width, height) = (impostors.width() as u32, poses_a_layer * pose_height);
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: array_layers(pose_count.div_ceil(poses_a_layer), width == height),
        };
        expect_room(&up.device.limits(), size)?;
        let mips = impostors.mips();
        let color_texels = mips.iter().map(|mip| mip.color.as_slice());
        let color = fill_texture(up, "colours of impostors", wgpu::TextureFormat::Rgba8UnormSrgb, size, color_texels)?;
        let normal_texels = mips.iter().map(|mip| mip.normal.as_slice());
        let normal = fill_texture(up, "normals of impostors", wgpu::TextureFormat::Rgba8Unorm, size, normal_texels)?;
        let sheet = ImpostorSheet {
            tile_px: impostors.tile_px,
            azimuth_count: impostors.azimuth_count,
            elevation_count: impostors.elevation_count,
            poses_a_layer,
        };
        let sheet = up.filled("sheet of impostors", &[sheet], Usage::UNIFORM, REMEDY)?;
        let vertices = up.filled("vertices of impostors", &impostors.vertices(data), Usage::VERTEX, REMEDY)?;
        let sampler = up.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("impostors"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let layout = layout(up.device);
        let bound = up.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("impostors"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: sheet.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&color) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&normal) },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::Sampler(&sampler) },
            ],
        });
        Ok(Some(Self { vertices, layout, bound }))
    }
}

fn expect_room(limits: &wgpu::Limits, size: wgpu::Extent3d) -> Result<()> {
    let sides = (size.width.max(size.height), limits.max_texture_dimension_2d);
    let layers = (size.depth_or_array_layers, limits.max_texture_array_layers);
    for (what, (needed, allowed)) in [("side of a layer of impostors", sides), ("layers of impostors", layers)] {
        if needed > allowed {
            return Err(Error::Limit { what, needed: needed.into(), allowed: allowed.into(), remedy: REMEDY });
        }
    }
    Ok(())
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
    let texture = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: fragment,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        },
        count: None,
    };
    let sampler = wgpu::BindGroupLayoutEntry {
        binding: 3,
        visibility: fragment,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    };
    let entries = [buffer_entry(0, vertex | fragment, Use::Uniform, None), texture(1), texture(2), sampler];
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("impostors"), entries: &entries })
}

/// `mips`: levels of all rows below each other, which go on from layer to layer.
fn fill_texture<'a>(
    up: &mut Uploader<'_>,
    label: &'static str,
    format: wgpu::TextureFormat,
    size: wgpu::Extent3d,
    mips: impl ExactSizeIterator<Item = &'a [[u8; 4]]>,
) -> Result<wgpu::TextureView> {
    let descriptor = wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: mips.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let texels = u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers);
    let bytes = texels * 4 * 4 / 3;
    let texture = texture_or_error(up.device, label, bytes, REMEDY, &descriptor)?;
    up.bytes += bytes;
    for (mip_level, texels) in (0..).zip(mips) {
        let (width, height) = (size.width >> mip_level, size.height >> mip_level);
        for (z, layer) in (0..).zip(texels.chunks(width as usize * height as usize)) {
            up.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level,
                    origin: wgpu::Origin3d { x: 0, y: 0, z },
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(layer),
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: None },
                wgpu::Extent3d { width, height: layer.len() as u32 / width, depth_or_array_layers: 1 },
            );
        }
    }
    Ok(texture.create_view(&array_view(label)))
}
