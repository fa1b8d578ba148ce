//! What a frame is drawn into: the renderer's own depth and samples, or an engine's.

use super::renderer::RendererOptions;
use crate::{Error, FrameConfig, Result};
use glam::{Mat4, Vec4};

/// An engine's own targets, for [`super::CrowdRenderer::encode_into`]. What is in them stays where the crowd is not before it, and the crowd is
/// in both afterwards.
#[derive(Debug, Clone, Copy)]
pub struct Targets<'a> {
    /// Colour: of [`RendererOptions::color_format`] and [`RendererOptions::sample_count`]. A view may be sRGB where its texture is not, and does
    /// not say so: that alone is left to wgpu's validation.
    pub color: &'a wgpu::TextureView,
    /// Where several samples are resolved to once the crowd is drawn. `None`: the engine goes on with `color` and does so itself.
    pub resolve: Option<&'a wgpu::TextureView>,
    /// Depth: of [`RendererOptions::depth_format`] and as many samples. With occlusion culling it is read as well:
    /// `TEXTURE_BINDING` is among its usages.
    pub depth: &'a wgpu::TextureView,
    /// Pixels of all of them.
    pub size: (u32, u32),
}

impl Targets<'_> {
    /// `reads_depth`: a stage will.
    pub(crate) fn check(&self, options: &RendererOptions, reads_depth: bool) -> Result<()> {
        let RendererOptions { color_format, depth_format, sample_count, .. } = *options;
        let remedy = "make the renderer with the engine's formats and samples (RendererOptions)";
        let color = Wanted { what: "colour target", format: color_format, sample_count, size: self.size, remedy };
        color.check(self.color)?;
        let depth = Wanted { what: "depth target", format: depth_format, ..color };
        depth.check(self.depth)?;
        if let Some(resolve) = self.resolve {
            let remedy = "resolve several samples into a texture of one, or into nothing (None)";
            Wanted { what: "resolve target", sample_count: 1, remedy, ..color }.check(resolve)?;
            if sample_count == 1 {
                let (found, allowed) = ("one beside a colour target of one sample a pixel".into(), "none".into());
                return Err(Error::Target { what: "resolve target", found, allowed, remedy });
            }
        }
        let texture = self.depth.texture();
        if reads_depth && !texture.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING) {
            return Err(Error::Target {
                what: "depth target",
                found: format!("usages {:?}", texture.usage()),
                allowed: "those with TEXTURE_BINDING".into(),
                remedy: "make the texture so, or draw without occlusion culling",
            });
        }
        // The part of it that can be read is a view made here.
        let parts = texture.depth_or_array_layers() * texture.mip_level_count();
        if reads_depth && depth_format.has_stencil_aspect() && parts > 1 {
            return Err(Error::Target {
                what: "depth target",
                found: "a layer or a mip level of a texture with a stencil".into(),
                allowed: "a texture of its own".into(),
                remedy: "draw into one, into a depth without a stencil, or without occlusion culling",
            });
        }
        Ok(())
    }
}

/// What a target must be.
#[derive(Clone, Copy)]
pub(crate) struct Wanted {
    pub(crate) what: &'static str,
    pub(crate) format: wgpu::TextureFormat,
    pub(crate) sample_count: u32,
    pub(crate) size: (u32, u32),
    pub(crate) remedy: &'static str,
}

impl Wanted {
    pub(crate) fn check(&self, view: &wgpu::TextureView) -> Result<()> {
        let Self { what, remedy, .. } = *self;
        let texture = view.texture();
        let refused = |found: String, allowed: String| Err(Error::Target { what, found, allowed, remedy });
        // A view does not say whether it is sRGB where its texture is not.
        if texture.format().remove_srgb_suffix() != self.format.remove_srgb_suffix() {
            return refused(format!("{:?}", texture.format()), format!("{:?}", self.format));
        }
        if texture.sample_count() != self.sample_count {
            return refused(format!("{} samples a pixel", texture.sample_count()), format!("{}", self.sample_count));
        }
        // Nor which of its levels it is.
        let sizes = |level: u32| ((texture.width() >> level).max(1), (texture.height() >> level).max(1));
        if !(0..texture.mip_level_count()).any(|level| sizes(level) == self.size) {
            let words = |(width, height)| format!("{width} x {height} pixels");
            return refused(words(sizes(0)), words(self.size));
        }
        if !texture.usage().contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
            return refused(format!("usages {:?}", texture.usage()), "those with RENDER_ATTACHMENT".into());
        }
        Ok(())
    }
}

/// Refuses formats of colour that shaders cannot write colours into: whole numbers, depth, and what the device does not draw into.
///
/// # Errors
/// [`Error::Target`].
pub(crate) fn check_color_format(format: wgpu::TextureFormat, device: &wgpu::Device) -> Result<()> {
    let features = device.features();
    let is_float = matches!(format.sample_type(None, Some(features)), Some(wgpu::TextureSampleType::Float { .. }));
    let usages = format.guaranteed_format_features(features).allowed_usages;
    if is_float && !format.is_multi_planar_format() && usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
        return Ok(());
    }
    Err(Error::Target {
        what: "RendererOptions::color_format",
        found: format!("{format:?}"),
        allowed: "a format of colours, as floats or parts of one, that the device draws into".into(),
        remedy: "use Rgba8UnormSrgb, or the engine's",
    })
}

/// What a pass is begun with.
pub(crate) struct Attachments<'a> {
    pub(crate) color: &'a wgpu::TextureView,
    pub(crate) resolve: Option<&'a wgpu::TextureView>,
    pub(crate) depth: &'a wgpu::TextureView,
    /// An engine's: what is in them stays, and no backdrop is drawn.
    pub(crate) are_hosts: bool,
}

/// How depth is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DepthWay {
    pub(crate) format: wgpu::TextureFormat,
    /// 1 near, 0 far.
    pub(crate) reversed: bool,
}

impl DepthWay {
    /// Of the shadow maps.
    pub(crate) const OF_MAPS: Self = Self { format: super::draw_crowd::DEPTH, reversed: false };

    pub(crate) fn of(options: &RendererOptions) -> Self {
        Self { format: options.depth_format, reversed: options.reverse_z }
    }

    /// What is drawn over something else.
    pub(crate) fn nearer(self) -> wgpu::CompareFunction {
        if self.reversed { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Less }
    }

    /// Where nothing is.
    pub(crate) fn farthest(self) -> f32 {
        if self.reversed { 0.0 } else { 1.0 }
    }

    pub(crate) fn state(self, compare: wgpu::CompareFunction, bias: wgpu::DepthBiasState) -> wgpu::DepthStencilState {
        wgpu::DepthStencilState {
            format: self.format,
            depth_write_enabled: Some(true),
            depth_compare: Some(compare),
            stencil: Default::default(),
            bias,
        }
    }

    /// The part of a depth texture that stages read: all there is, or all but its stencil.
    pub(crate) fn readable(self, depth: &wgpu::TextureView) -> wgpu::TextureView {
        if !self.format.has_stencil_aspect() {
            return depth.clone();
        }
        depth.texture().create_view(&wgpu::TextureViewDescriptor {
            label: Some("depth without its stencil"),
            aspect: wgpu::TextureAspect::DepthOnly,
            ..Default::default()
        })
    }

    /// Bytes of a sample; what a driver makes of them is its own affair.
    pub(crate) fn bytes(self) -> u64 {
        match self.format {
            wgpu::TextureFormat::Depth32FloatStencil8 => 8,
            _ => 4,
        }
    }

    /// Refuses formats that are not of depth or too coarse for occlusion culling's slack, or that the device does not have.
    pub(crate) fn check(self, device: &wgpu::Device) -> Result<()> {
        let refused = |allowed: &str, remedy| {
            let (found, allowed) = (format!("{:?}", self.format), allowed.into());
            Err(Error::Target { what: "RendererOptions::depth_format", found, allowed, remedy })
        };
        if !self.format.has_depth_aspect() || self.format == wgpu::TextureFormat::Depth16Unorm {
            return refused("a format of depth with 24 bits or more", "use Depth32Float, or the engine's");
        }
        if !device.features().contains(self.format.required_features()) {
            return refused("what the device was made with", "ask for the format's feature when you make the device");
        }
        Ok(())
    }

    /// Refuses cameras whose depth goes the other way.
    ///
    /// # Errors
    /// [`Error::DepthRange`].
    pub(crate) fn check_camera(self, config: &FrameConfig) -> Result<()> {
        let words = |reversed: bool| if reversed { "1 near and 0 far" } else { "0 near and 1 far" };
        match is_reversed(&Mat4::from_cols_array_2d(&config.clip_from_world)) {
            Some(found) if found != self.reversed => {
                Err(Error::DepthRange { found: words(found), allowed: words(self.reversed) })
            }
            _ => Ok(()),
        }
    }
}

/// Whether depth falls with the distance; `None` where that cannot be told: without perspective, or lost in rounding.
///
/// z in clip space is `slope * w + offset`, so depth is `slope + offset / w`, where the near plane faces the eye.
fn is_reversed(clip_from_world: &Mat4) -> Option<bool> {
    let split = |row: Vec4| (row.truncate().as_dvec3(), f64::from(row.w));
    let (z, z_at_origin) = split(clip_from_world.row(2));
    let (w, w_at_origin) = split(clip_from_world.row(3));
    let slope = z.dot(w) / w.length_squared();
    // An oblique near plane (mirrors, water) turns z's row away from w's: then depth has no one direction.
    if (z - slope * w).length() > 1e-3 * z.length() && z.length() > 1e-6 * w.length() {
        return None;
    }
    let offset = z_at_origin - slope * w_at_origin;
    let rounding = 1e-6 * (z_at_origin.abs() + (slope * w_at_origin).abs());
    // Neither where something is not finite.
    if offset > rounding {
        Some(true)
    } else if offset < -rounding {
        Some(false)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use glam::camera::rh::{proj::directx, view::look_at_mat4};

    #[test]
    fn reversed_cameras_are_known_wherever_they_stand() {
        let flipped = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::new(0.0, 0.0, -1.0, 0.0), Vec4::new(0.0, 0.0, 1.0, 1.0));
        for eye in [Vec3::ZERO, Vec3::new(3.0, 2.0, 9.0), Vec3::new(-4e3, 50.0, 9e3)] {
            let view = look_at_mat4(eye, eye + Vec3::new(0.3, -0.1, -4.0), Vec3::Y);
            for projection in [directx::perspective(0.9, 1.5, 0.1, 50.0), directx::perspective_infinite(0.9, 1.5, 0.1)]
            {
                assert_eq!(is_reversed(&(projection * view)), Some(false), "{eye}");
                assert_eq!(is_reversed(&(flipped * projection * view)), Some(true), "{eye}");
            }
            let infinite = directx::perspective_infinite_reverse(0.9, 1.5, 0.1);
            assert_eq!(is_reversed(&(infinite * view)), Some(true), "{eye}");
        }
    }

    #[test]
    fn where_nothing_can_be_told_nothing_is_refused() {
        let flat = directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 50.0);
        for matrix in [Mat4::ZERO, Mat4::NAN, flat] {
            assert_eq!(is_reversed(&matrix), None, "{matrix}");
        }
        // Ten thousand kilometres from the origin a matrix has lost its near plane.
        let view = look_at_mat4(Vec3::splat(1e7), Vec3::splat(1e7) + Vec3::X * 10.0, Vec3::Y);
        assert_eq!(is_reversed(&(directx::perspective(0.9, 1.5, 0.1, 50.0) * view)), None);
    }
}
