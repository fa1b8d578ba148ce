//! Draws batches: bins the triangles of some at a time, then draws the bands side by side.

use rayon::prelude::*;

use crate::bin::{BAND_ROWS, Bins, Size, Span, bin_triangles};
use crate::cover::draw_band;
use crate::{Batch, Target, View};

/// Triangles binned as one job.
const JOB_TRIANGLES: usize = 1 << 13;
/// Triangles binned before the bands are drawn: bounds what is kept in memory, about 150 MB.
const ROUND_TRIANGLES: usize = 1 << 21;
/// Largest draw that does not wake other threads.
const ALONE_TRIANGLES: usize = 1 << 11;

/// Draws a batch into the target.
pub fn draw(target: &mut Target, view: &View, batch: &Batch<'_>) {
    draw_many(target, view, std::slice::from_ref(batch));
}

/// Draws batches into the target, as if one after the other; much faster than that for crowds of small ones.
///
/// The picture depends neither on the number of threads nor on how triangles are shared out among batches.
/// Cost: each triangle is set up once, each pixel of a round of two million triangles shaded once.
pub fn draw_many(target: &mut Target, view: &View, batches: &[Batch<'_>]) {
    if target.width == 0 || target.height == 0 {
        return;
    }
    let mut jobs = JobList::default();
    for (batch, triangles) in batches.iter().map(|batch| batch.triangles.len()).enumerate() {
        let mut start = 0;
        while start < triangles {
            let end = triangles.min(start + JOB_TRIANGLES);
            jobs.push(Span { batch: batch as u32, triangles: start..end });
            if jobs.triangles >= ROUND_TRIANGLES {
                draw_round(target, view, batches, &std::mem::take(&mut jobs));
            }
            start = end;
        }
    }
    draw_round(target, view, batches, &jobs);
}

/// Jobs of about the same number of triangles, in drawing order.
#[derive(Default)]
struct JobList {
    jobs: Vec<Vec<Span>>,
    /// Of the last job.
    last: usize,
    /// Of all.
    triangles: usize,
}

impl JobList {
    fn push(&mut self, span: Span) {
        let count = span.triangles.len();
        match self.jobs.last_mut() {
            Some(job) if self.last + count <= JOB_TRIANGLES => {
                job.push(span);
                self.last += count;
            }
            _ => {
                self.jobs.push(vec![span]);
                self.last = count;
            }
        }
        self.triangles += count;
    }
}

fn draw_round(target: &mut Target, view: &View, batches: &[Batch<'_>], jobs: &JobList) {
    let size = Size { width: target.width, height: target.height };
    let in_band = (size.width * BAND_ROWS) as usize;
    let bin = |job: &Vec<Span>| bin_triangles(batches, job, view, size);
    if jobs.triangles <= ALONE_TRIANGLES {
        let bins: Vec<Bins> = jobs.jobs.iter().map(bin).collect();
        let bands = target.color.chunks_mut(in_band).zip(target.depth.chunks_mut(in_band)).enumerate();
        for (band, (colors, depths)) in bands {
            draw_band(batches, &bins, band as u32, size, colors, depths);
        }
    } else {
        let bins: Vec<Bins> = jobs.jobs.par_iter().map(bin).collect();
        let bands = target.color.par_chunks_mut(in_band).zip(target.depth.par_chunks_mut(in_band)).enumerate();
        bands.for_each(|(band, (colors, depths))| draw_band(batches, &bins, band as u32, size, colors, depths));
    }
}
