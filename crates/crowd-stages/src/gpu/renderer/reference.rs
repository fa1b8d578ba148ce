//! The newest frame as a reference camera sees it.

use super::super::draw_crowd::Part;
use super::super::draw_marks::DrawMarks;
use super::super::stage_recorder::StageRecorder;
use super::super::techniques::FrameContext;
use super::super::upload::Uploader;
use super::CrowdRenderer;
use crate::{DrawOptions, Error, FrameConfig, Result, Skinning, Technique, View};

impl CrowdRenderer {
    /// Draws the newest frame of `options.technique` once more as another camera sees it: who was drawn, at the levels chosen for
    /// `seen`; those whom the frustum of `seen` does not meet as dots, and its edges. Without shadows; totals and times stay those
    /// of the frame. Dong & Peng 2019 show their culling so.
    ///
    /// `seen`: of the frame; `reference`: the other camera. Submit the frame before, as with every two frames. Techniques that cull by
    /// other rules than `cull_instances` (pseudo-instancing, discrete) show no dots.
    ///
    /// # Errors
    /// [`Error::NoFrame`] where the technique has not drawn the present instances, or with occlusion culling, which keeps no frame;
    /// those of [`Self::encode`].
    pub fn encode_reference(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        color: &wgpu::TextureView,
        size: (u32, u32),
        [seen, reference]: [&FrameConfig; 2],
        options: impl Into<DrawOptions>,
    ) -> Result<()> {
        let options = DrawOptions { frozen: true, shadows: 0, ..options.into() };
        let technique = options.technique;
        if !self.holds_frame[technique.number()] {
            return Err(Error::NoFrame { technique });
        }
        let skinning = self.prepare_skinning(device, queue, seen, &options);
        self.draw.fit_targets(device, size, false)?;
        self.check_own(color, size, reference)?;
        self.prepare_marks(device, queue)?;
        let marks = self.marks.as_ref().expect("prepared above");
        marks.write(queue, seen, &self.bounds, View::Shaded, false);
        let marks_bound = marks.bind(device, &self.crowd, &self.frame, &self.frame.choices);
        let (config, _) = self.write_uniforms(queue, size, reference, &options);
        let painter = self.painters[technique.number()].as_ref().expect("it has drawn a frame");
        let context = self.context(&config, options, skinning);
        let mut recorder = StageRecorder::new(encoder, None);
        if let Some(feed) = &self.feed {
            feed.record_count(recorder.encoder, &self.frame.config);
        }
        painter.record_frozen(&mut recorder, &context);
        let into = self.draw.own_attachments(color);
        let mut pass = self.draw.begin(recorder.encoder, &into, None, Part::Only, self.unshaded.bound(), false);
        if let Some(scenery) = &self.scenery {
            scenery.draw(&mut pass, false);
        }
        painter.draw(&mut pass, &context);
        let has_culled = !matches!(technique, Technique::PseudoInstancing | Technique::Discrete);
        marks.draw_reference(&mut pass, &marks_bound, has_culled, self.instance_count);
        Ok(())
    }

    /// Sets up what views and a reference camera show besides the crowd, unless it is. Both do so themselves; beforehand [`Self::memory`] has it.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] where the device has no room.
    pub fn prepare_marks(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<()> {
        if self.marks.is_none() {
            let mut up = Uploader { device, queue, bytes: 0 };
            self.marks = Some(DrawMarks::new(&mut up, &self.options, self.draw.light_layout())?);
            self.memory.others += up.bytes;
        }
        Ok(())
    }

    fn context<'a>(&'a self, config: &'a FrameConfig, options: DrawOptions, skinning: Skinning) -> FrameContext<'a> {
        FrameContext {
            crowd: &self.crowd,
            selection: &self.selection,
            occlusion: self.occlusion.as_ref().filter(|_| options.occludes()),
            config,
            options,
            skinning,
            characters: &self.instance_characters,
            full_detail_totals: &self.full_detail_totals,
        }
    }
}
