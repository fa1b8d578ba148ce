//! Talk to people: lines on stderr, and progress with the time left where stderr is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Display;
use std::io::Write;
use std::sync::Mutex;

/// How much is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Loudness {
    /// Errors.
    Quiet,
    /// Errors, warnings and results.
    Normal,
    /// Each step too.
    Verbose,
}

/// The mouth of a run; threads share it.
pub(crate) struct Talk<'a> {
    err: Mutex<&'a mut (dyn Write + Send)>,
    loudness: Loudness,
    terminal: bool,
    bar: ProgressBar,
}

/// Units of one character on the progress bar.
const UNITS: f32 = 1000.0;

impl<'a> Talk<'a> {
    pub(crate) fn new(err: &'a mut (dyn Write + Send), loudness: Loudness, terminal: bool) -> Self {
        Self { err: Mutex::new(err), loudness, terminal, bar: ProgressBar::hidden() }
    }

    /// Shows a bar for `count` characters from now on, on a terminal only.
    pub(crate) fn start_progress(&mut self, count: usize) {
        if !self.terminal || self.loudness == Loudness::Quiet {
            return;
        }
        let bar =
            ProgressBar::with_draw_target(Some(count as u64 * UNITS as u64), ProgressDrawTarget::stderr_with_hz(10));
        let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {elapsed} gone, {eta} left  {wide_msg}");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.enable_steady_tick(std::time::Duration::from_millis(250));
        self.bar = bar;
    }

    /// Moves the bar by a share of one character.
    pub(crate) fn advance(&self, share: f32, name: &str, step: &str) {
        self.bar.inc((share * UNITS) as u64);
        self.bar.set_message(format!("{name}: {step}"));
    }

    pub(crate) fn end_progress(&self) {
        self.bar.finish_and_clear();
    }

    pub(crate) fn error(&self, what: impl Display) {
        self.say(Loudness::Quiet, format!("error: {what}"));
    }

    pub(crate) fn warn(&self, what: impl Display) {
        self.say(Loudness::Normal, format!("warning: {what}"));
    }

    pub(crate) fn note(&self, what: impl Display) {
        self.say(Loudness::Normal, what.to_string());
    }

    pub(crate) fn detail(&self, what: impl Display) {
        self.say(Loudness::Verbose, what.to_string());
    }

    fn say(&self, from: Loudness, line: String) {
        if self.loudness < from {
            return;
        }
        let mut err = self.err.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // Nobody is left to tell when stderr itself is gone.
        self.bar.suspend(|| {
            let _ = writeln!(err, "{}", printable(&line));
        });
    }
}

/// The line without control characters, line separators and marks that turn the direction of text: names come from files,
/// and a terminal obeys what it is shown.
pub(crate) fn printable(line: &str) -> String {
    let steers = |c: char| {
        c.is_control()
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    line.chars().map(|c| if steers(c) { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quiet_keeps_errors_and_nothing_else() {
        let mut err = Vec::new();
        let talk = Talk::new(&mut err, Loudness::Quiet, false);
        talk.note("baked");
        talk.warn("odd");
        talk.error("bad\u{1b}[2J\u{202e}");
        drop(talk);
        assert_eq!(String::from_utf8(err).unwrap(), "error: bad\u{fffd}[2J\u{fffd}\n");
    }
}
