//! One compute pass a stage, each with time stamps.

use super::kernel::is_software;

/// Records stages into an encoder and remembers their names in the order of their time stamps.
pub(crate) struct StageRecorder<'a> {
    pub(crate) encoder: &'a mut wgpu::CommandEncoder,
    clock: Option<Stamps>,
    names: Vec<&'static str>,
    /// A name that everything goes by meanwhile.
    pub(crate) group: Option<&'static str>,
}

/// Where time stamps go, and which ones bound a stage.
#[derive(Clone)]
pub(crate) struct Stamps {
    pub(crate) queries: wgpu::QuerySet,
    pub(crate) bounds: Bounds,
}

/// Which stamps bound a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bounds {
    /// From its pass's start to the next one's: cards have done by then what was recorded before.
    Starts,
    /// From the end of the pass before to its own end, the first from the end of an empty one. Software Vulkan (llvmpipe) takes a stamp
    /// when it is next told to finish what was drawn, which is at the next stamp, and works off dispatches at once: a stamp at a stage's start is
    /// taken after that stage. One at its end is taken by the stamp at the next one's start, which nobody reads.
    Ends,
}

impl Bounds {
    /// Those that are true on this device.
    pub(crate) fn of(device: &wgpu::Device) -> Self {
        if is_software(device) { Self::Ends } else { Self::Starts }
    }

    /// How many stamps so many stages have.
    pub(crate) fn stamp_count(self, stages: u32) -> u32 {
        match self {
            Self::Starts => stages + 1,
            Self::Ends => 2 * (stages + 1),
        }
    }

    /// The stamps between which the stages lie.
    pub(crate) fn pick(self, stamps: &[u64]) -> Vec<u64> {
        match self {
            Self::Starts => stamps.to_vec(),
            Self::Ends => stamps.iter().skip(1).step_by(2).copied().collect(),
        }
    }
}

impl<'a> StageRecorder<'a> {
    /// Begins a frame.
    pub(crate) fn new(encoder: &'a mut wgpu::CommandEncoder, clock: Option<Stamps>) -> Self {
        if let Some(Stamps { queries, bounds: Bounds::Ends }) = &clock {
            let timestamp_writes = Some(wgpu::ComputePassTimestampWrites {
                query_set: queries,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            });
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("frame"), timestamp_writes });
        }
        Self { encoder, clock, names: Vec::new(), group: None }
    }

    /// A pass of that name.
    pub(crate) fn stage(&mut self, name: &'static str, dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let stamps = self.stamps(name, false);
        let timestamp_writes = stamps.as_ref().map(|(query_set, start, end)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(*start),
            end_of_pass_write_index: *end,
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        dispatch(&mut self.encoder.begin_compute_pass(&descriptor));
    }

    /// Takes the name of a pass that draws: query set and number of the stamp at its start, and of the one at its end where that is
    /// looked at, as it is if it is the frame's last.
    pub(crate) fn draw_stamps(&mut self, name: &'static str, is_last: bool) -> Option<DrawStamps> {
        self.stamps(name, is_last)
    }

    /// All names.
    pub(crate) fn into_names(self) -> Vec<&'static str> {
        self.names
    }

    fn stamps(&mut self, name: &'static str, is_last: bool) -> Option<DrawStamps> {
        self.names.push(self.group.unwrap_or(name));
        let count = self.names.len() as u32;
        let Stamps { queries, bounds } = self.clock.clone()?;
        Some(match bounds {
            Bounds::Starts => (queries, count - 1, is_last.then_some(count)),
            Bounds::Ends => (queries, 2 * count, Some(2 * count + 1)),
        })
    }
}

/// Of a render pass.
pub(crate) type DrawStamps = (wgpu::QuerySet, u32, Option<u32>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_leave_out_the_starts() {
        let stamps = [10, 20, 21, 50, 51, 60];
        assert_eq!(stamps.len() as u32, Bounds::Ends.stamp_count(2));
        assert_eq!(Bounds::Ends.pick(&stamps), [20, 50, 60]);
        assert_eq!(Bounds::Starts.pick(&stamps[..3]), [10, 20, 21]);
    }
}
