//! Into an engine's own targets.

use super::super::targets::{DepthWay, Targets, Wanted};
use super::{CrowdRenderer, Onto, RendererOptions};
use crate::{DrawOptions, FrameConfig, Result};

impl CrowdRenderer {
    /// Records one frame as [`Self::encode`] does, into an engine's own colour and depth: what the engine has drawn hides the crowd and is
    /// hidden by it, and what it draws afterwards is hidden by the crowd. There is no sky and no ground, scenery only where
    /// [`Self::set_scenery`] was given any, and fog only where `config.fog_per_m` says so.
    ///
    /// With occlusion culling people behind what the engine has drawn are left out, too. The engine's own objects throw no shadows on the
    /// crowd, and the crowd's maps shade the crowd alone. The whole of the targets is drawn into: there is no viewport.
    ///
    /// # Errors
    /// Those of [`Self::encode`]; [`crate::Error::Target`] for a target of another format, size or number of samples than the
    /// renderer was made for, and for a depth that occlusion culling cannot read.
    pub fn encode_into(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets<'_>,
        config: &FrameConfig,
        options: impl Into<DrawOptions>,
    ) -> Result<()> {
        let options = options.into();
        targets.check(&self.options, options.occludes())?;
        DepthWay::of(&self.options).check_camera(config)?;
        self.encode_onto(device, queue, encoder, Onto::Host(targets), config, options)
    }

    /// Refuses what [`Self::encode`] cannot draw: a colour view of another kind, a camera whose depth goes the other way. After targets of that
    /// size were made: a picture too large is one, whatever the view.
    pub(super) fn check_own(&self, color: &wgpu::TextureView, size: (u32, u32), config: &FrameConfig) -> Result<()> {
        let RendererOptions { color_format, .. } = self.options;
        let size = (size.0.max(1), size.1.max(1));
        let remedy = "make the renderer with that format, and say the view's size";
        let wanted = Wanted { what: "colour target", format: color_format, sample_count: 1, size, remedy };
        wanted.check(color)?;
        DepthWay::of(&self.options).check_camera(config)
    }
}
