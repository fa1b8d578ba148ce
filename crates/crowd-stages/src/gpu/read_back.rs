//! Totals and timestamps on their way back, a few frames late, without stopping anyone.

use super::allocate::buffer_or_error;
use super::poll_device::poll_device;
use super::stage_recorder::{Bounds, Stamps};
use crate::{Error, FrameTotals, Result};
use std::mem::size_of;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Duration;

const TOTALS_BYTES: u64 = size_of::<FrameTotals>() as u64;
/// Draws of a frame that are counted.
const MOST_DRAWS: u32 = 2;
const RUNS_BYTES: u64 = MOST_DRAWS as u64 * size_of::<u64>() as u64;
/// Frames under way that are remembered; older ones are forgotten.
const MAX_SLOTS: usize = 4;

const FREE: u8 = 0;
const UNDER_WAY: u8 = 1;
const ARRIVED: u8 = 2;
const LOST: u8 = 3;

struct Slot {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
    frame: u64,
    /// Totals known beforehand (nothing was selected on the GPU).
    known_totals: Option<FrameTotals>,
    stages: Vec<&'static str>,
    /// Draws whose runs were counted.
    draws: u32,
}

/// Time stamps between stages.
pub(crate) struct StageClock {
    pub(crate) stamps: Stamps,
    resolved: wgpu::Buffer,
    nanoseconds_per_tick: f32,
}

impl StageClock {
    /// `None` where the device has no timestamps.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, max_stages: u32) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let bounds = Bounds::of(device);
        let count = bounds.stamp_count(max_stages);
        let label = Some("stage clock");
        let queries =
            device.create_query_set(&wgpu::QuerySetDescriptor { label, ty: wgpu::QueryType::Timestamp, count });
        Some(Self {
            stamps: Stamps { queries, bounds },
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label,
                size: u64::from(count) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            nanoseconds_per_tick: queue.get_timestamp_period(),
        })
    }
}

/// Counts the vertex shader's runs of the crowd's draws, as the adapter does: what reuse of vertices is left over is in it.
pub(crate) struct RunCounter {
    pub(crate) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl RunCounter {
    /// `None` where the device has no pipeline statistics.
    pub(crate) fn new(device: &wgpu::Device) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_STATISTICS_QUERY) {
            return None;
        }
        let label = Some("vertex shader runs");
        let ty = wgpu::QueryType::PipelineStatistics(wgpu::PipelineStatisticsTypes::VERTEX_SHADER_INVOCATIONS);
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count: MOST_DRAWS }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label,
                size: RUNS_BYTES,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        })
    }
}

/// What measures a frame, as far as the device offers it.
#[derive(Default)]
pub(crate) struct Meters {
    pub(crate) clock: Option<StageClock>,
    pub(crate) runs: Option<RunCounter>,
}

impl Meters {
    /// Bytes of its buffers, and of as many copies on their way back as there can be.
    pub(crate) fn bytes(&self) -> u64 {
        let runs = self.runs.as_ref().map_or(0, |runs| runs.resolved.size());
        let slot = TOTALS_BYTES + self.stamp_bytes() + RUNS_BYTES;
        self.stamp_bytes() + runs + MAX_SLOTS as u64 * slot
    }

    fn stamp_bytes(&self) -> u64 {
        self.clock.as_ref().map_or(0, |clock| clock.resolved.size())
    }
}

/// What came back of the newest finished frame.
#[derive(Debug, Clone, Default)]
pub(crate) struct Arrived {
    /// Its number, from 1.
    pub(crate) frame: u64,
    pub(crate) totals: Option<FrameTotals>,
    pub(crate) timings_ms: Vec<(&'static str, f32)>,
    /// Runs of the vertex shader over the crowd.
    pub(crate) vertex_runs: Option<u64>,
}

#[derive(Default)]
pub(crate) struct ReadBack {
    slots: Vec<Slot>,
    next_frame: u64,
    newest: u64,
    arrived: Arrived,
}

impl ReadBack {
    /// Records the copies of a frame; they are mapped when the encoder is submitted.
    ///
    /// `stages`: names in the order of the time stamps. `draws`: how many had their runs counted.
    pub(crate) fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        totals: &wgpu::Buffer,
        known_totals: Option<FrameTotals>,
        meters: &Meters,
        stages: Vec<&'static str>,
        draws: u32,
    ) {
        let mut slot = self.take_slot(device, meters);
        let clock = meters.clock.as_ref();
        encoder.copy_buffer_to_buffer(totals, 0, &slot.buffer, 0, TOTALS_BYTES);
        if let Some(clock) = clock {
            let stamps = clock.stamps.bounds.stamp_count(stages.len() as u32);
            encoder.resolve_query_set(&clock.stamps.queries, 0..stamps, &clock.resolved, 0);
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &slot.buffer, TOTALS_BYTES, u64::from(stamps) * 8);
        }
        if let Some(runs) = &meters.runs {
            encoder.resolve_query_set(&runs.queries, 0..draws, &runs.resolved, 0);
            let end = TOTALS_BYTES + meters.stamp_bytes();
            encoder.copy_buffer_to_buffer(&runs.resolved, 0, &slot.buffer, end, RUNS_BYTES);
        }
        self.next_frame += 1;
        slot.frame = self.next_frame;
        slot.known_totals = known_totals;
        slot.draws = draws;
        slot.stages = if clock.is_some() { stages } else { Vec::new() };
        slot.state.store(UNDER_WAY, Ordering::Release);
        let state = slot.state.clone();
        encoder.map_buffer_on_submit(&slot.buffer, wgpu::MapMode::Read, .., move |result| {
            state.store(if result.is_ok() { ARRIVED } else { LOST }, Ordering::Release);
        });
        self.slots.push(slot);
    }

    /// A free slot, or a new one; a slot whose frame was never submitted is forgotten in time.
    fn take_slot(&mut self, device: &wgpu::Device, meters: &Meters) -> Slot {
        if let Some(free) = self.slots.iter().position(|slot| slot.state.load(Ordering::Acquire) == FREE) {
            return self.slots.remove(free);
        }
        if self.slots.len() >= MAX_SLOTS {
            self.slots.remove(0);
        }
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: TOTALS_BYTES + meters.stamp_bytes() + RUNS_BYTES,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let state = Arc::new(AtomicU8::new(FREE));
        Slot { buffer, state, frame: 0, known_totals: None, stages: Vec::new(), draws: 0 }
    }

    /// Number of the frame recorded last, from 1.
    pub(crate) fn last_frame(&self) -> u64 {
        self.next_frame
    }

    /// Whether the newest recorded frame has not come back yet.
    pub(crate) fn is_under_way(&self) -> bool {
        let newest = self.slots.iter().max_by_key(|slot| slot.frame);
        newest.is_some_and(|slot| slot.state.load(Ordering::Acquire) == UNDER_WAY)
    }

    /// Takes in what has arrived and gives the newest.
    pub(crate) fn collect(&mut self, meters: &Meters) -> &Arrived {
        for slot in &mut self.slots {
            match slot.state.load(Ordering::Acquire) {
                ARRIVED => {}
                LOST => {
                    slot.state.store(FREE, Ordering::Release);
                    continue;
                }
                _ => continue,
            }
            if slot.frame > self.newest
                && let Ok(bytes) = slot.buffer.get_mapped_range(..)
            {
                self.newest = slot.frame;
                self.arrived.frame = slot.frame;
                let (totals, rest) = bytes.split_at(TOTALS_BYTES as usize);
                let (stamps, runs) = rest.split_at(meters.stamp_bytes() as usize);
                let read: FrameTotals = bytemuck::pod_read_unaligned(totals);
                let known = slot.known_totals.map(|known| FrameTotals { refused_count: read.refused_count, ..known });
                self.arrived.totals = Some(known.unwrap_or(read));
                let tick_ms = meters.clock.as_ref().map_or(0.0, |clock| f64::from(clock.nanoseconds_per_tick) * 1e-6);
                let stamps: Vec<u64> = stamps.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
                let bounds = meters.clock.as_ref().map_or(Bounds::Starts, |clock| clock.stamps.bounds);
                self.arrived.timings_ms = spans(&slot.stages, &bounds.pick(&stamps), tick_ms);
                let counted = runs.chunks_exact(8).take(slot.draws as usize).map(bytemuck::pod_read_unaligned::<u64>);
                self.arrived.vertex_runs = meters.runs.as_ref().map(|_| counted.sum());
            }
            slot.buffer.unmap();
            slot.state.store(FREE, Ordering::Release);
        }
        &self.arrived
    }
}

/// The first `count` elements of a buffer after `encoder` is done. Waits.
///
/// # Errors
/// [`Error::OutOfMemory`] when there is no room for the copy, [`Error::DeviceLost`] when the device is lost.
pub(crate) fn read_now<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut encoder: wgpu::CommandEncoder,
    buffer: &wgpu::Buffer,
    count: usize,
) -> Result<Vec<T>> {
    let size = (count * size_of::<T>()) as u64;
    if size == 0 {
        return Ok(Vec::new());
    }
    let (what, remedy) = ("bytes read back", "draw fewer instances");
    let descriptor = wgpu::BufferDescriptor {
        label: Some(what),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    };
    let back = buffer_or_error(device, what, remedy, &descriptor)?;
    encoder.copy_buffer_to_buffer(buffer, 0, &back, 0, size);
    queue.submit([encoder.finish()]);
    let (sender, mapped) = std::sync::mpsc::channel();
    // The receiver is gone only when the wait below has failed.
    back.map_async(wgpu::MapMode::Read, .., move |result| {
        let _ = sender.send(result.is_ok());
    });
    poll_device(device, wgpu::PollType::wait_indefinitely())?;
    let lost = || Error::DeviceLost(format!("{what} do not come back"));
    // Another thread that polls the same device may still be about to tell us; of a lost one nobody tells anything.
    match mapped.recv_timeout(Duration::from_secs(10)) {
        Ok(true) => Ok(bytemuck::pod_collect_to_vec(&back.get_mapped_range(..).map_err(|_| lost())?)),
        _ => Err(lost()),
    }
}

/// Milliseconds from each stamp to the next; of stages that ran twice, both together in the place of the first.
fn spans(stages: &[&'static str], ticks: &[u64], tick_ms: f64) -> Vec<(&'static str, f32)> {
    let mut spans: Vec<(&'static str, f32)> = Vec::new();
    for (name, pair) in stages.iter().zip(ticks.windows(2)) {
        let ms = (pair[1].saturating_sub(pair[0]) as f64 * tick_ms) as f32;
        match spans.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += ms,
            None => spans.push((name, ms)),
        }
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_runs_twice_is_told_once() {
        let found = spans(&["sort", "draw", "sort", "draw"], &[10, 30, 60, 65, 75], 1.0);
        assert_eq!(found, [("sort", 25.0), ("draw", 40.0)]);
    }
}
