//! A bar on a terminal for what takes more than two seconds.

use std::io::IsTerminal;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// What may become a bar.
pub(super) struct Progress {
    total: usize,
    start: Instant,
    is_shown: bool,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    /// That of `total` pieces of work.
    pub(super) fn new(total: usize, quiet: bool) -> Self {
        let is_shown = !quiet && std::io::stderr().is_terminal();
        Progress { total, start: Instant::now(), is_shown, bar: OnceLock::new() }
    }

    /// So many are done; any thread may say so.
    pub(super) fn done(&self, count: usize) {
        const PATIENCE: Duration = Duration::from_secs(2);
        if !self.is_shown || self.start.elapsed() <= PATIENCE {
            return;
        }
        let new = || {
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {eta} left");
            let bar = ProgressBar::new(self.total as u64);
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        };
        self.bar.get_or_init(new).set_position(count as u64);
    }

    /// Removes the bar.
    pub(super) fn finish(self) {
        if let Some(bar) = self.bar.into_inner() {
            bar.finish_and_clear();
        }
    }
}
