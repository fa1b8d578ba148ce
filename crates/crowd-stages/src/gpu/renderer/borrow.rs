//! Instances that a simulator has, in the place of the CPU's.

use super::super::feed::{BoundFeed, InstanceFeed};
use super::super::upload::Uploader;
use super::CrowdRenderer;
use crate::{Error, FrameTotals, Result};

impl CrowdRenderer {
    /// Draws a simulator's instances from its own buffer until [`Self::set_instances`] is called: every frame takes what is in it
    /// then, checks it on the GPU and refuses what could not be drawn ([`FrameTotals::refused_count`]). The CPU's work does not
    /// grow with their number.
    ///
    /// # Errors
    /// [`Error::Limit`] for more than `max_instances` or a buffer that is too small for `most`, [`Error::Feed`] for one that is not
    /// for storage, or a number of characters that is not `most`, [`Error::Instance`] for a character that is not there.
    pub fn borrow_instances(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        feed: &InstanceFeed<'_>,
    ) -> Result<()> {
        let (most, allowed) = (feed.most, self.options.max_instances);
        if most > allowed {
            let remedy = "make the renderer with a larger max_instances";
            return Err(Error::Limit { what: "instances", needed: most.into(), allowed: allowed.into(), remedy });
        }
        if !feed.characters.is_empty() && feed.characters.len() != most as usize {
            return Err(Error::Feed { what: "characters of instances", problem: "another number than `most`" });
        }
        let count = self.characters.len() as u32;
        if let Some(index) = feed.characters.iter().position(|character| *character >= count) {
            return Err(Error::Instance { index, what: "character", found: feed.characters[index], allowed: count });
        }
        let mut up = Uploader { device, queue, bytes: 0 };
        let bound = BoundFeed::new(&mut up, feed, &self.crowd, &self.frame, count)?;
        self.return_instances(queue);
        self.end_motion();
        self.memory.feed = bound.bytes;
        self.feed = Some(bound);
        self.trial.note_fades(true);
        self.bounds = feed.bounds;
        self.note_instances(most, feed.characters.to_vec());
        Ok(())
    }

    /// Forgets a simulator's instances.
    pub(super) fn return_instances(&mut self, queue: &wgpu::Queue) {
        if self.feed.take().is_some() {
            self.memory.feed = 0;
            self.holds_frame = Default::default();
            queue.write_buffer(&self.frame.totals, 0, bytemuck::bytes_of(&FrameTotals::default()));
        }
    }
}
