//! Which way of skinning takes this adapter the least time: tried in turn over the first frames.

use crate::{Error, Skinning};

/// Frames of each way that count, after one that compiles its shaders.
const ROUNDS: usize = 3;
/// Frames after which a trial whose times do not come back is over.
const MOST_FRAMES: u32 = 60;
/// Share of the vertex shader's time below which another way is worth its memory.
const WORTH: f32 = 0.98;

/// How vertices are skinned, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinningChoice {
    /// The way of the newest frame.
    pub way: Skinning,
    /// Whether it stays: asked for, refused, measured to its end, or all there is to choose where somebody may fade.
    pub is_settled: bool,
    /// Somebody may fade, or did once, so [`Skinning::Auto`] takes palettes and measures nothing.
    pub fades: bool,
    /// GPU milliseconds a frame, medians of [`Skinning::WAYS`], once measured.
    pub measured_ms: Option<[f32; 3]>,
    /// Why it is not what was asked for.
    pub refused: Option<String>,
    /// Why poses are not shared though that was asked for.
    pub sharing_refused: Option<String>,
}

/// The trial of one renderer.
#[derive(Debug, Default)]
pub(crate) struct SkinningTrial {
    frames: u32,
    /// Frames under way.
    awaited: Vec<(u64, Skinning)>,
    times_ms: [Vec<f32>; 3],
    outcome: Option<(Skinning, Option<[f32; 3]>)>,
    refused: Option<String>,
    sharing_refused: Option<String>,
    newest: Option<Skinning>,
    end_is_known: bool,
    /// Somebody may fade, or did once.
    fades: bool,
    /// The frame may have more vertices than the renderer has room for.
    outgrows: bool,
}

impl SkinningTrial {
    /// The way that the next frame is drawn, when `asked` was asked for.
    pub(crate) fn way(&self, asked: Skinning) -> Skinning {
        match asked {
            _ if self.refused.is_some() => Skinning::Vertex,
            Skinning::Auto if self.fades || self.outgrows => Skinning::Palettes,
            Skinning::Auto => match self.outcome {
                Some((way, _)) => way,
                None => Skinning::WAYS[self.frames as usize % Skinning::WAYS.len()],
            },
            way => way,
        }
    }

    /// Takes note that somebody may fade. Ways add up a fade's numbers in two orders, in the picture or in shadow maps, and a picture must not depend on
    /// what was measured: from now on it is palettes, which mix a joint's two clips once for all vertices on it.
    pub(crate) fn note_fades(&mut self, fades: bool) {
        self.fades |= fades;
    }

    /// Takes note whether the next frame may have more vertices than there is room for: those skinned beforehand would be missing, and their absence
    /// taken for speed. It is palettes then, which need no room for vertices.
    pub(crate) fn note_room(&mut self, outgrows: bool) {
        self.outgrows = outgrows;
    }

    /// What a way needs does not fit: the vertex shader does it from now on.
    pub(crate) fn refuse(&mut self, error: &Error) {
        self.refused = Some(error.to_string());
    }

    /// What sharing poses needs does not fit: everyone is skinned by themselves from now on, in whatever way.
    pub(crate) fn refuse_sharing(&mut self, error: &Error) {
        self.sharing_refused = Some(error.to_string());
    }

    /// Whether that does not fit.
    pub(crate) fn refuses_sharing(&self) -> bool {
        self.sharing_refused.is_some()
    }

    /// Frame `number` was recorded in that way. `can_measure`: its times will come back.
    pub(crate) fn drawn(&mut self, number: u64, asked: Skinning, way: Skinning, can_measure: bool) {
        self.newest = Some(way);
        if asked != Skinning::Auto || self.fades || self.outgrows || self.outcome.is_some() {
            return;
        }
        self.frames += 1;
        self.awaited.push((number, way));
        if !can_measure || self.frames > MOST_FRAMES {
            self.outcome = Some((Skinning::Vertex, None));
        }
    }

    /// Frame `number` took so long on the GPU.
    pub(crate) fn took(&mut self, number: u64, ms: f32) {
        let Some(place) = self.awaited.iter().position(|(awaited, _)| *awaited == number) else { return };
        let (_, way) = self.awaited[place];
        // Frames before it that have not come by now never will.
        self.awaited.drain(..=place);
        let Some(index) = Skinning::WAYS.iter().position(|w| *w == way) else { return };
        self.times_ms[index].push(ms);
        if self.outcome.is_none() && self.times_ms.iter().all(|times| times.len() > ROUNDS) {
            let medians = [0, 1, 2].map(|w| median(&self.times_ms[w][1..]));
            self.outcome = Some((Skinning::WAYS[fastest(&medians)], Some(medians)));
        }
    }

    /// Whether the trial has ended since this was asked last.
    pub(crate) fn take_end(&mut self) -> bool {
        let has_ended = self.outcome.is_some() && !self.end_is_known;
        self.end_is_known |= has_ended;
        has_ended
    }

    pub(crate) fn choice(&self, asked: Skinning) -> SkinningChoice {
        SkinningChoice {
            way: self.newest.unwrap_or(self.way(asked)),
            is_settled: asked != Skinning::Auto
                || self.refused.is_some()
                || self.fades
                || self.outgrows
                || self.outcome.is_some(),
            fades: self.fades,
            measured_ms: self.outcome.filter(|_| !self.fades).and_then(|(_, ms)| ms),
            refused: self.refused.clone(),
            sharing_refused: self.sharing_refused.clone(),
        }
    }
}

/// The number of the least, the first unless another is worth its memory.
fn fastest(medians: &[f32]) -> usize {
    let mut best = (0, medians[0] * WORTH);
    for (number, ms) in medians.iter().enumerate().skip(1) {
        if *ms < best.1 {
            best = (number, *ms);
        }
    }
    best.0
}

fn median(times: &[f32]) -> f32 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames whose times come back one frame late, `of` milliseconds by way; the first of each is slow.
    fn tried(of: [f32; 3]) -> SkinningTrial {
        let mut trial = SkinningTrial::default();
        for number in 0..20 {
            let way = trial.way(Skinning::Auto);
            trial.drawn(number, Skinning::Auto, way, true);
            if number > 0 {
                let before = Skinning::WAYS[(number as usize - 1) % 3] as usize - 1;
                trial.took(number - 1, if number < 4 { 1000.0 } else { of[before] });
            }
        }
        trial
    }

    #[test]
    fn the_fastest_way_stays_and_ties_go_to_the_vertex_shader() {
        let way = |of| tried(of).choice(Skinning::Auto);
        assert_eq!(way([3.0, 2.0, 1.0]).way, Skinning::Compute);
        assert_eq!(way([3.0, 2.0, 2.5]).way, Skinning::Palettes);
        assert_eq!(way([3.0, 2.99, 2.98]).way, Skinning::Vertex);
        assert_eq!(way([1.0, 2.0, 3.0]).measured_ms, Some([1.0, 2.0, 3.0]));
        assert!(way([1.0, 2.0, 3.0]).is_settled);
    }

    #[test]
    fn where_somebody_may_fade_it_is_palettes_whatever_was_measured() {
        let mut trial = SkinningTrial::default();
        trial.note_fades(true);
        for number in 0..20 {
            assert_eq!(trial.way(Skinning::Auto), Skinning::Palettes);
            trial.drawn(number, Skinning::Auto, Skinning::Palettes, number < 10);
            trial.took(number, 1.0);
        }
        let choice = trial.choice(Skinning::Auto);
        assert_eq!((choice.way, choice.is_settled, choice.measured_ms), (Skinning::Palettes, true, None));
        assert_eq!(trial.way(Skinning::Vertex), Skinning::Vertex, "whoever asks for it has it");
        // Settled before anybody faded, and under way.
        for mut trial in [tried([1.0, 3.0, 2.0]), SkinningTrial::default()] {
            assert_eq!(trial.way(Skinning::Auto), Skinning::Vertex);
            trial.note_fades(true);
            trial.note_fades(false);
            assert_eq!(trial.way(Skinning::Auto), Skinning::Palettes);
        }
        // Where palettes do not fit.
        let mut trial = SkinningTrial::default();
        trial.note_fades(true);
        trial.refuse(&Error::NoFloor);
        assert_eq!(trial.way(Skinning::Auto), Skinning::Vertex);
    }

    #[test]
    fn what_was_asked_for_is_done_unless_it_does_not_fit() {
        let mut trial = SkinningTrial::default();
        assert_eq!(trial.way(Skinning::Compute), Skinning::Compute);
        assert!(trial.choice(Skinning::Compute).is_settled && !trial.choice(Skinning::Auto).is_settled);
        trial.refuse(&Error::NoFloor);
        assert_eq!(trial.way(Skinning::Compute), Skinning::Vertex);
        assert!(trial.choice(Skinning::Auto).is_settled && trial.choice(Skinning::Auto).refused.is_some());
        // Poses that cannot be shared leave the way as it is.
        let mut trial = SkinningTrial::default();
        trial.refuse_sharing(&Error::NoFloor);
        assert_eq!(trial.way(Skinning::Compute), Skinning::Compute);
        assert!(trial.refuses_sharing() && trial.choice(Skinning::Compute).sharing_refused.is_some());
    }

    #[test]
    fn without_times_the_vertex_shader_does_it() {
        let mut trial = SkinningTrial::default();
        trial.drawn(0, Skinning::Auto, Skinning::Vertex, false);
        assert_eq!(trial.way(Skinning::Auto), Skinning::Vertex);
        assert!(trial.choice(Skinning::Auto).is_settled);
        // Times that never come back end it, too.
        let mut trial = SkinningTrial::default();
        (0..100).for_each(|number| trial.drawn(number, Skinning::Auto, Skinning::Palettes, true));
        assert_eq!(trial.way(Skinning::Auto), Skinning::Vertex);
    }
}
