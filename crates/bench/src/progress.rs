//! Progress for a person at a terminal, and for a log file.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use motes_cli::status;

/// How often a line is written where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(20);

/// Shows how far a run has come. Work is measured in estimated seconds, so that a long unit counts for more than a
/// short one.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    total: f64,
    done: f64,
    units: usize,
    units_done: usize,
    failed: usize,
    start: Instant,
    last_line: Instant,
}

impl Progress {
    /// Starts showing a run of `units` units that are estimated to take `total` seconds one after another.
    pub(crate) fn start(units: usize, total: f64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(1000).with_style(style);
            bar.enable_steady_tick(Duration::from_millis(500));
            bar
        });
        let now = Instant::now();
        Progress { bar, total, done: 0.0, units, units_done: 0, failed: 0, start: now, last_line: now }
    }

    /// A unit of that name has begun.
    pub(crate) fn started(&mut self, name: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{}  now {name}", self.summary()));
        }
    }

    /// A unit has ended whose estimate was `seconds`.
    pub(crate) fn ended(&mut self, name: &str, seconds: f64, failure: Option<&str>) {
        self.done += seconds;
        self.units_done += 1;
        if let Some(reason) = failure {
            self.failed += 1;
            self.print(&format!("failed: {name}: {reason}"));
        }
        let summary = self.summary();
        match &self.bar {
            Some(bar) => {
                bar.set_position((1000.0 * self.fraction()) as u64);
                bar.set_message(summary);
            }
            None if self.last_line.elapsed() >= LINE_EVERY || self.units_done == self.units => {
                self.last_line = Instant::now();
                status(&format!("{:3.0} %  {summary}, last {name}", 100.0 * self.fraction()));
            }
            None => {}
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }

    fn print(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None => status(line),
        }
    }

    fn fraction(&self) -> f64 {
        if self.total > 0.0 { (self.done / self.total).min(1.0) } else { 1.0 }
    }

    fn summary(&self) -> String {
        let elapsed = self.start.elapsed().as_secs_f64();
        let left = match self.fraction() {
            fraction if fraction > 0.0 => format!(", {} left", duration(elapsed * (1.0 / fraction - 1.0))),
            _ => String::new(),
        };
        let failed = if self.failed > 0 { format!(", {} failed", self.failed) } else { String::new() };
        format!("{}/{} units in {}{left}{failed}", self.units_done, self.units, duration(elapsed))
    }
}

/// Seconds as a person says them.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.1} days", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_read_well() {
        let said: Vec<String> = [0.4, 75.0, 600.0, 9000.0, 2e5].into_iter().map(duration).collect();
        assert_eq!(said, ["0.4 s", "75 s", "10 min", "2.5 h", "2.3 days"]);
    }
}
