//! What a frame needs seen to before it is drawn: motion, memory, what the budget counts and how large it is.

use super::running::{Painter, Running};
use crate::Result;
use crate::crowd::Crowd;
use crate::governor::Governor;
use crate::gpu_backend::renderer_options;
use crate::overlay::Knobs;
use crate::schedules::Schedules;
use crowd_stages::Technique;

impl Running {
    /// What people on their places do by now: the GPU looks it up itself, unless it is told that everyone keeps their clip.
    pub(super) fn play_motion(&mut self, crowd: &mut Crowd) -> Result<()> {
        let poses_here =
            matches!(self.painter, Painter::Cpu(..)) || self.knobs.draw.technique == Technique::StaticFloor;
        if self.knobs.motion == Some(true) && poses_here {
            crowd.play(self.readings.time_s);
        }
        if std::mem::replace(&mut self.motion, self.knobs.motion) == self.knobs.motion {
            return Ok(());
        }
        crowd.instances.iter_mut().for_each(|instance| instance.leaving_share = 0.0);
        if let Painter::Gpu(renderer) = &mut self.painter {
            let plan = crowd.schedules.as_ref().filter(|_| self.knobs.motion == Some(true)).map(Schedules::plan);
            renderer.set_motion(&self.gpu.device, &self.gpu.queue, plan)?;
            renderer.set_instances(&self.gpu.queue, &crowd.instances)?;
        }
        Ok(())
    }

    /// What does not fit the memory that may be taken is not drawn: the frame is as the one before, and the overlay says so.
    pub(super) fn keep_within_memory(&mut self) {
        if let (Some(room), Painter::Gpu(renderer)) = (&mut self.room, &self.painter)
            && self.knobs.draw != self.drawn
            && !room.admit(&self.gpu, renderer, self.screen.size(), self.knobs.largest_budget, self.knobs.draw)
        {
            self.knobs.draw = self.drawn;
            self.readings.message = Some("that does not fit the memory that may be taken (--vram)".to_owned());
        }
        self.drawn = self.knobs.draw;
        let size = self.screen.size();
        if let (Some(room), Painter::Gpu(renderer)) = (&self.room, &self.painter)
            && std::mem::replace(&mut self.drawn_size, size) != size
            && !room.holds_size(&self.gpu, renderer, size, self.knobs.largest_budget)
        {
            let message = "a window of this size takes more than the memory that may be taken (--vram)";
            self.readings.message = Some(message.to_owned());
        }
    }

    /// Makes other room where the budget counts something else than in the frame before.
    pub(super) fn recount(&mut self, crowd: &Crowd) {
        if std::mem::replace(&mut self.counted_in, self.knobs.counts()) == self.knobs.counts() {
            return;
        }
        if let Painter::Gpu(renderer) = &mut self.painter {
            let (format, budget) = (self.screen.scene_format(), self.knobs.largest_budget);
            let of = renderer_options(&self.gpu.device, crowd, format, self.samples, budget, self.knobs.counts());
            renderer.make_room(of.max_vertices, of.max_triangles);
        }
    }

    /// Moves the budget towards the time that a frame may take, if there is one. A budget changed by hand is where it goes on from.
    pub(super) fn govern(&mut self, frame_ms: f32) {
        let Knobs { budget, largest_budget, target_ms: Some(target_ms), .. } = self.knobs else {
            self.governor = None;
            return;
        };
        let kept = self.governor.take().filter(|(_, last)| *last == budget);
        let mut governor =
            kept.map_or_else(|| Governor::new(target_ms, budget, largest_budget), |(governor, _)| governor);
        governor.aim_at(target_ms);
        let work_ms: f32 = self.readings.stages_ms.iter().map(|(_, ms)| ms).sum();
        self.knobs.budget = governor.next(if work_ms > 0.0 { work_ms } else { frame_ms });
        self.governor = Some((governor, self.knobs.budget));
    }
}
