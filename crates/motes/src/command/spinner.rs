//! A line on a terminal that says what is being done, for work whose end is not known beforehand.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

/// A line that changes.
pub(super) struct Spinner {
    bar: Option<ProgressBar>,
    said: Option<Instant>,
    /// When it first knew a share of the work that was done, and which.
    start: Option<(Instant, f64)>,
}

impl Spinner {
    pub(super) fn new(quiet: bool) -> Self {
        let is_shown = !quiet && std::io::stderr().is_terminal();
        let style = ProgressStyle::with_template("{spinner} {msg}  {elapsed}");
        let bar = || {
            ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
        };
        Spinner { bar: is_shown.then(bar), said: None, start: None }
    }

    /// Says what is being done, if it is time to say something new, and about how long it still takes where the share of the work is known: `text` may be some work.
    pub(super) fn say(&mut self, text: &dyn Fn() -> (String, Option<f64>)) {
        const PATIENCE: Duration = Duration::from_millis(500);
        let Some(bar) = &self.bar else { return };
        if self.said.is_some_and(|said| said.elapsed() < PATIENCE) {
            return;
        }
        let (text, share) = text();
        let now = Instant::now();
        let left = share.and_then(|share| {
            let (start, first) = *self.start.get_or_insert((now, share));
            time_left(now - start, [first, share])
        });
        let left = left.map_or(String::new(), |left| format!(", about {} left", HumanDuration(left)));
        bar.set_message(text + &left);
        bar.tick();
        self.said = Some(now);
    }

    /// Removes the line.
    pub(super) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// How long the rest of some work takes, of which a share was done at first, and another one after a while.
fn time_left(elapsed: Duration, [first, share]: [f64; 2]) -> Option<Duration> {
    let rest = (1.0 - share) / (share - first);
    (share > first && rest.is_finite() && rest >= 0.0).then(|| elapsed.mul_f64(rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_takes_as_long_as_what_was_done() {
        let elapsed = Duration::from_secs(6);
        assert_eq!(time_left(elapsed, [0.25, 0.5]), Some(Duration::from_secs(12)));
        assert_eq!(time_left(elapsed, [0.0, 1.0]), Some(Duration::ZERO));
        assert_eq!(time_left(elapsed, [0.5, 0.5]), None);
        assert_eq!(time_left(elapsed, [0.5, 0.4]), None);
        assert_eq!(time_left(elapsed, [0.1, 1.2]), None);
    }
}
