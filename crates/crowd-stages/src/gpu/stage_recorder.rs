//! One compute pass a stage, each with a time stamp at its start.

/// Records stages into an encoder and remembers their names in the order of their time stamps.
pub(crate) struct StageRecorder<'a> {
    pub(crate) encoder: &'a mut wgpu::CommandEncoder,
    clock: Option<wgpu::QuerySet>,
    names: Vec<&'static str>,
}

impl<'a> StageRecorder<'a> {
    pub(crate) fn new(encoder: &'a mut wgpu::CommandEncoder, clock: Option<wgpu::QuerySet>) -> Self {
        Self { encoder, clock, names: Vec::new() }
    }

    /// A pass of that name.
    pub(crate) fn stage(&mut self, name: &'static str, dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let number = self.names.len() as u32;
        self.names.push(name);
        let timestamp_writes = self.clock.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(number),
            end_of_pass_write_index: None,
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        dispatch(&mut self.encoder.begin_compute_pass(&descriptor));
    }

    /// Takes the last name, that of the draw: the stamps of its pass, and all names.
    pub(crate) fn finish(mut self, name: &'static str) -> (Option<(wgpu::QuerySet, u32, u32)>, Vec<&'static str>) {
        let number = self.names.len() as u32;
        self.names.push(name);
        (self.clock.map(|queries| (queries, number, number + 1)), self.names)
    }
}
