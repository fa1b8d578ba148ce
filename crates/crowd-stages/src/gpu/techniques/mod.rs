//! What each technique adds to the shared selection: buffers of its own, stages, draw calls.

mod bucketed;
mod discrete;
mod instanced;
mod points;
mod pseudo_instancing;
mod reform;
mod static_floor;

pub(crate) use reform::windows;
pub(crate) use static_floor::Floor;

use super::draw_crowd::DrawCrowd;
use super::lending::Lender;
use super::occlusion::Occlusion;
use super::renderer::RendererOptions;
use super::selection::Selection;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers, Uploader};
use crate::{DrawOptions, Error, FrameConfig, FrameTotals, Result, Skinning, Technique};

/// What there is when a technique is set up.
pub(crate) struct Workshop<'a, 'd> {
    pub(crate) up: &'a mut Uploader<'d>,
    pub(crate) crowd: &'a CrowdBuffers,
    pub(crate) frame: &'a FrameBuffers,
    pub(crate) draw: &'a DrawCrowd,
    pub(crate) options: &'a RendererOptions,
}

/// What a frame is made of besides the technique.
pub(crate) struct FrameContext<'a> {
    pub(crate) crowd: &'a CrowdBuffers,
    pub(crate) selection: &'a Selection,
    /// Where hidden instances are left out.
    pub(crate) occlusion: Option<&'a Occlusion>,
    pub(crate) config: &'a FrameConfig,
    pub(crate) options: DrawOptions,
    /// Where vertices are worked out; never [`Skinning::Auto`].
    pub(crate) skinning: Skinning,
    /// Character of each instance.
    pub(crate) characters: &'a [u32],
    /// What drawing all instances at full detail comes to.
    pub(crate) full_detail_totals: &'a FrameTotals,
}

/// A technique that is set up.
pub(crate) trait Painter: Send + Sync {
    /// Records the compute stages. The last of them writes the frame's totals, unless [`Self::known_totals`] has them.
    fn record_stages(&self, recorder: &mut StageRecorder<'_>, context: &FrameContext<'_>);

    /// Records the stages after the levels once more, for instances that were chosen after the first draw.
    fn record_again(&self, _recorder: &mut StageRecorder<'_>, _context: &FrameContext<'_>) {}

    /// Whether [`Self::record_again`] does nothing, and takes no time for it, where nobody was chosen.
    fn can_be_gated(&self, _context: &FrameContext<'_>) -> bool {
        false
    }

    /// Sets up what works out vertices before the draw, unless it is.
    fn prepare_skinning(&mut self, _workshop: Workshop<'_, '_>) -> Result<()> {
        Ok(())
    }

    /// Sets up what shares poses, unless it is; after [`Self::prepare_skinning`].
    fn prepare_sharing(&mut self, _workshop: Workshop<'_, '_>) -> Result<()> {
        Ok(())
    }

    /// Gives back what that took.
    fn forget_skinning(&mut self) {}

    /// Records what a frame needs whose instances and levels are those of the last one.
    fn record_frozen(&self, _recorder: &mut StageRecorder<'_>, _context: &FrameContext<'_>) {}

    /// Draws the crowd into a pass that has the backdrop in it.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>);

    /// Totals known without the GPU.
    fn known_totals(&self, _context: &FrameContext<'_>) -> Option<FrameTotals> {
        None
    }

    /// Whether it can draw a frame now.
    fn is_ready(&self) -> bool {
        true
    }

    /// Takes a frame that was baked.
    fn lay_floor(&mut self, _floor: Floor) {}

    /// The vertices that it skins beforehand, where it is set up for that.
    fn lender(&self) -> Option<Lender<'_>> {
        None
    }

    /// A buffer that its stages wrote, by the name in the shader.
    fn buffer(&self, _name: &str) -> Option<&wgpu::Buffer> {
        None
    }
}

/// Whether a device has what a technique cannot do without.
pub fn supports(device: &wgpu::Device, technique: Technique) -> bool {
    let features = device.features();
    match technique {
        Technique::PseudoInstancing | Technique::Reform | Technique::StaticFloor => true,
        Technique::Instanced | Technique::Discrete | Technique::Points | Technique::Bucketed => {
            features.contains(wgpu::Features::INDIRECT_FIRST_INSTANCE)
        }
    }
}

/// Sets a technique up.
pub(crate) fn set_up(technique: Technique, workshop: Workshop<'_, '_>) -> Result<Box<dyn Painter>> {
    if !supports(workshop.up.device, technique) {
        let remedy = "make it with gpu::wanted_features() of what the adapter offers; where that is not among it, draw with \
                      Technique::Reform";
        return Err(Error::Feature { technique, feature: "INDIRECT_FIRST_INSTANCE", remedy });
    }
    Ok(match technique {
        Technique::PseudoInstancing => Box::new(pseudo_instancing::PseudoInstancing::new(workshop)),
        Technique::Instanced => Box::new(instanced::Instanced::new(workshop)?),
        Technique::Discrete => Box::new(discrete::Discrete::new(workshop)?),
        Technique::StaticFloor => Box::new(static_floor::StaticFloor::new(workshop)),
        Technique::Points => Box::new(points::Points::new(workshop)?),
        Technique::Reform => Box::new(reform::Reform::new(workshop)?),
        Technique::Bucketed => Box::new(bucketed::Bucketed::new(workshop)?),
    })
}
