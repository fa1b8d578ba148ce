//! Casters of the shadow maps with the vertices that the crowd's own pass has skinned: each once, however many maps draw it.

use super::LendVertices;
use super::bucket_draws::{BucketDraws, Lists};
use super::draw_crowd::DrawCrowd;
use super::shadows::caster_bias;
use super::stage_recorder::StageRecorder;
use super::upload::{CrowdBuffers, FrameBuffers};

/// Vertices that a pass skins beforehand, and who has them.
#[derive(Clone, Copy)]
pub(crate) struct Lender<'a> {
    pub(crate) skinned: &'a wgpu::Buffer,
    pub(crate) lists: Lists<'a>,
}

/// Who lends what and who borrows it.
pub(crate) struct Lending {
    stage: LendVertices,
    lent: wgpu::Buffer,
    /// Of the casters' list.
    borrow: wgpu::BindGroup,
    /// Made when somebody first lends; does not depend on whom.
    meshes: Option<wgpu::RenderPipeline>,
    /// Somebody lends in this frame.
    is_lending: bool,
    /// Of who lent last: kept over frames in which nobody does, for frames of several ways may take turns.
    fitted: Option<Fitted>,
}

/// What depends on who lends.
struct Fitted {
    /// Whose it is bound to.
    skinned: wgpu::Buffer,
    lend: wgpu::BindGroup,
    /// One a map.
    bound: Vec<wgpu::BindGroup>,
}

impl Lending {
    /// `lent`: a word an instance; `casters`: of the maps.
    pub(crate) fn new(
        device: &wgpu::Device,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        lent: wgpu::Buffer,
        casters: Lists<'_>,
    ) -> Self {
        let stage = LendVertices::new(device);
        let Lists { sorted_keys, sorted, drawn, .. } = casters;
        let borrow = stage.bind(device, &f.config, &c.tables.bucket_counts, sorted_keys, sorted, drawn, &lent);
        Self { stage, lent, borrow, meshes: None, is_lending: false, fitted: None }
    }

    /// Binds what `lender` has, unless it is bound; `None`: nobody lends in this frame. `configs`: one a map, the frame as the sun sees it.
    pub(crate) fn fit<'a>(
        &mut self,
        device: &wgpu::Device,
        c: &CrowdBuffers,
        f: &FrameBuffers,
        draw: &DrawCrowd,
        configs: impl Iterator<Item = &'a wgpu::Buffer>,
        lender: Option<Lender<'_>>,
    ) {
        self.is_lending = lender.is_some();
        let Some(Lender { skinned, lists }) = lender else { return };
        if self.fitted.as_ref().is_some_and(|fitted| fitted.skinned == *skinned) {
            return;
        }
        let Lists { sorted_keys, sorted, drawn, .. } = lists;
        let counts = &c.tables.bucket_counts;
        let of_map = |config: &wgpu::Buffer| {
            let frame = FrameBuffers { config: config.clone(), ..f.clone() };
            draw.bind_skinned(c, &frame, &f.nothing, skinned)
        };
        self.meshes.get_or_insert_with(|| {
            let inputs = &BucketDraws::MORPHING_INPUTS;
            match c.has_cutouts {
                true => draw.caster_pipeline("borrowed_masked", Some("mask"), inputs, caster_bias()),
                false => draw.caster_pipeline("borrowed_caster", None, inputs, caster_bias()),
            }
        });
        self.fitted = Some(Fitted {
            skinned: skinned.clone(),
            lend: self.stage.bind(device, &f.config, counts, sorted_keys, sorted, drawn, &self.lent),
            bound: configs.map(of_map).collect(),
        });
    }

    /// Lets go of the buffers of who lent last: they are going.
    pub(crate) fn forget(&mut self) {
        (self.is_lending, self.fitted) = (false, None);
    }

    /// What is bound, where somebody lends in this frame.
    fn lending(&self) -> Option<&Fitted> {
        self.fitted.as_ref().filter(|_| self.is_lending)
    }

    /// After the crowd's own stages.
    pub(crate) fn record_lend(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        if let Some(fitted) = self.lending() {
            recorder.stage("lend_vertices", |pass| self.stage.record_lend(pass, &fitted.lend, count));
        }
    }

    /// After what vertices need to know of a map's casters.
    pub(crate) fn record_borrow(&self, recorder: &mut StageRecorder<'_>, count: u32) {
        if self.lending().is_some() {
            recorder.stage("lend_vertices", |pass| self.stage.record_borrow(pass, &self.borrow, count));
        }
    }

    /// Pipeline and bind group of that map, where somebody lends.
    pub(crate) fn draws_with(&self, map: usize) -> Option<(&wgpu::RenderPipeline, &wgpu::BindGroup)> {
        self.meshes.as_ref().zip(self.lending()).map(|(meshes, fitted)| (meshes, &fitted.bound[map]))
    }
}
