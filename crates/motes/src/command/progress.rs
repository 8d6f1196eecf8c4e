//! A bar on a terminal for what takes more than two seconds.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// What may become a bar.
pub(super) struct Progress {
    total: usize,
    start: Instant,
    is_shown: bool,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// That of `total` pieces of work.
    pub(super) fn new(total: usize, quiet: bool) -> Self {
        let is_shown = !quiet && std::io::stderr().is_terminal();
        Progress { total, start: Instant::now(), is_shown, bar: None }
    }

    /// So many are done.
    pub(super) fn done(&mut self, count: usize) {
        const PATIENCE: Duration = Duration::from_secs(2);
        if !self.is_shown {
            return;
        }
        if self.bar.is_none() && self.start.elapsed() > PATIENCE {
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {eta} left");
            let bar = ProgressBar::new(self.total as u64);
            self.bar = Some(bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(count as u64);
        }
    }

    /// Removes the bar.
    pub(super) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
