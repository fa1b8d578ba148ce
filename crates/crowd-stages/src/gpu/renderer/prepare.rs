//! What a frame needs set up before it is recorded, once or when sizes change: poses that are held, shadow maps, occlusion, skinning beforehand.

use super::super::HoldPoses;
use super::super::occlusion::Occlusion;
use super::super::shadows::Shadows;
use super::super::targets::DepthWay;
use super::super::techniques::Workshop;
use super::super::upload::Uploader;
use super::{CrowdRenderer, RendererOptions};
use crate::{BudgetIn, DrawOptions, FrameConfig, Result, Skinning, Technique};

impl CrowdRenderer {
    /// Sets up the stage that holds poses, unless it is.
    pub(super) fn prepare_holding(&mut self, device: &wgpu::Device) {
        if self.hold.is_some() {
            return;
        }
        let stage = HoldPoses::new(device);
        let (config, crowd) = (&self.frame.config, &self.crowd);
        let bound = stage.bind(device, config, &crowd.clips, &crowd.clip_speeds, &self.frame.instances);
        self.hold = Some((stage, bound));
    }

    /// Sets up shadow maps of that side, unless they are.
    pub(super) fn fit_shadows(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, side: u32) -> Result<()> {
        if self.shadows.as_ref().is_some_and(|shadows| shadows.side == side) {
            return Ok(());
        }
        (self.shadows, self.memory.shadows) = (None, 0);
        let mut up = Uploader { device, queue, bytes: 0 };
        let shadows = Shadows::new(&mut up, &self.crowd, &self.frame, &self.draw, &self.options, side)?;
        self.memory.shadows = shadows.bytes;
        self.shadows = Some(shadows);
        Ok(())
    }

    /// Lets the casters have the vertices that the crowd's own pass skins beforehand, where it does.
    pub(super) fn fit_lending(&mut self, device: &wgpu::Device, options: &DrawOptions, skinning: Skinning) {
        let painter = self.painters[options.technique.number()].as_ref().expect("prepared by the caller");
        let lender = painter.lender().filter(|_| skinning == Skinning::Compute);
        if let Some(shadows) = &mut self.shadows {
            shadows.fit_lending(device, &self.crowd, &self.frame, &self.draw, lender);
        }
    }

    /// Sets up occlusion culling for pictures of that size, unless it is.
    /// `depth`: of an engine; else the renderer's own.
    pub(super) fn fit_occlusion(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        depth: Option<&wgpu::TextureView>,
        size: (u32, u32),
    ) -> Result<()> {
        let mut up = Uploader { device, queue, bytes: 0 };
        let RendererOptions { max_instances, sample_count, .. } = self.options;
        if self.occlusion.is_none() {
            self.occlusion = Some(Occlusion::new(&mut up, &self.crowd, &self.frame, max_instances)?);
            self.memory.occlusion = up.bytes;
        }
        let occlusion = self.occlusion.as_mut().expect("set above");
        let size = (size.0.max(1), size.1.max(1));
        self.memory.occlusion -= occlusion.pyramid_bytes();
        let depth = depth.unwrap_or_else(|| self.draw.own_depth());
        let way = DepthWay::of(&self.options);
        let fitted = occlusion.fit(&mut up, &self.crowd, &self.frame, (depth, way), size, sample_count);
        self.memory.occlusion += occlusion.pyramid_bytes();
        fitted
    }

    /// Decides where this frame's vertices are worked out, and sets up what that needs.
    pub(super) fn prepare_skinning(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        config: &FrameConfig,
        options: &DrawOptions,
    ) -> Skinning {
        if options.technique != Technique::Bucketed {
            return Skinning::Vertex;
        }
        let arrived = self.read_back.collect(&self.meters);
        self.trial.took(arrived.frame, arrived.timings_ms.iter().map(|(_, ms)| ms).sum());
        self.trial.note_room(self.may_outgrow(config));
        let way = self.trial.way(options.skinning);
        // Once: whoever asks for another way by name afterwards keeps what that needs.
        let is_over = options.skinning == Skinning::Auto && self.trial.take_end();
        let mut up = Uploader { device, queue, bytes: 0 };
        let Self { crowd, frame, draw, options, painters, shadows, .. } = self;
        let painter = painters[Technique::Bucketed.number()].as_mut().expect("prepared by the caller");
        if way != Skinning::Vertex {
            let workshop = Workshop { up: &mut up, crowd, frame, draw, options };
            let prepared = painter.prepare_skinning(workshop);
            if let Err(error) = prepared {
                self.trial.refuse(&error);
                return Skinning::Vertex;
            }
            self.memory.skinning += up.bytes;
        } else if is_over {
            painter.forget_skinning();
            self.memory.skinning = 0;
            if let Some(shadows) = shadows {
                shadows.forget_lender();
            }
        }
        way
    }

    /// Whether N lets through more vertices than there is room for, and the crowd has them.
    fn may_outgrow(&self, config: &FrameConfig) -> bool {
        let is_known = self.instance_characters.len() >= self.instance_count as usize;
        let most = if is_known { self.full_detail_totals.vertex_count } else { u32::MAX };
        let in_vertices = config.budget_in == BudgetIn::Vertices as u32;
        in_vertices && config.budget.min(most) > self.options.max_vertices
    }

    /// Sets up what sharing poses needs, where it is asked for and fits: without it everyone is skinned by themselves.
    pub(super) fn prepare_sharing(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        options: &DrawOptions,
    ) -> bool {
        if !options.shares_poses() || self.trial.refuses_sharing() {
            return false;
        }
        let mut up = Uploader { device, queue, bytes: 0 };
        let Self { crowd, frame, draw, options, painters, .. } = self;
        let painter = painters[Technique::Bucketed.number()].as_mut().expect("prepared by the caller");
        let prepared = painter.prepare_sharing(Workshop { up: &mut up, crowd, frame, draw, options });
        if let Err(error) = &prepared {
            self.trial.refuse_sharing(error);
            return false;
        }
        self.memory.skinning += up.bytes;
        true
    }
}
