//! A line on a terminal that says what is being done, for work whose end is not known beforehand.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// A line that changes.
pub(super) struct Spinner {
    bar: Option<ProgressBar>,
    said: Option<Instant>,
}

impl Spinner {
    pub(super) fn new(quiet: bool) -> Self {
        let is_shown = !quiet && std::io::stderr().is_terminal();
        let style = ProgressStyle::with_template("{spinner} {msg}  {elapsed}");
        let bar = || {
            ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
        };
        Spinner { bar: is_shown.then(bar), said: None }
    }

    /// Says what is being done, if it is time to say something new: `text` may be some work.
    pub(super) fn say(&mut self, text: &dyn Fn() -> String) {
        const PATIENCE: Duration = Duration::from_millis(500);
        let Some(bar) = &self.bar else { return };
        if self.said.is_none_or(|said| said.elapsed() >= PATIENCE) {
            bar.set_message(text());
            bar.tick();
            self.said = Some(Instant::now());
        }
    }

    /// Removes the line.
    pub(super) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
