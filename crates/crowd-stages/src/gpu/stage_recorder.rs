//! One compute pass a stage, each with a time stamp at its start.

/// Records stages into an encoder and remembers their names in the order of their time stamps.
pub(crate) struct StageRecorder<'a> {
    pub(crate) encoder: &'a mut wgpu::CommandEncoder,
    clock: Option<wgpu::QuerySet>,
    names: Vec<&'static str>,
    /// A name that everything goes by meanwhile.
    pub(crate) group: Option<&'static str>,
}

impl<'a> StageRecorder<'a> {
    pub(crate) fn new(encoder: &'a mut wgpu::CommandEncoder, clock: Option<wgpu::QuerySet>) -> Self {
        Self { encoder, clock, names: Vec::new(), group: None }
    }

    /// A pass of that name.
    pub(crate) fn stage(&mut self, name: &'static str, dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let number = self.number(name);
        let timestamp_writes = self.clock.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(number),
            end_of_pass_write_index: None,
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        dispatch(&mut self.encoder.begin_compute_pass(&descriptor));
    }

    /// Takes the name of a pass that draws: query set and number of the stamp at its start, and of the one at its end if it is
    /// the frame's last.
    pub(crate) fn draw_stamps(&mut self, name: &'static str, is_last: bool) -> Option<DrawStamps> {
        let number = self.number(name);
        self.clock.clone().map(|queries| (queries, number, is_last.then_some(number + 1)))
    }

    /// All names.
    pub(crate) fn into_names(self) -> Vec<&'static str> {
        self.names
    }

    fn number(&mut self, name: &'static str) -> u32 {
        self.names.push(self.group.unwrap_or(name));
        self.names.len() as u32 - 1
    }
}

/// Of a render pass.
pub(crate) type DrawStamps = (wgpu::QuerySet, u32, Option<u32>);
