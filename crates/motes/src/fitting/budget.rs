//! How long a fit may take.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use motes_inference::Stage;

use crate::error::MotesError;

/// Seconds from now on, beside what else may say to stop.
pub(super) struct Budget<'a> {
    seconds: Option<f64>,
    start: Instant,
    proceed: &'a (dyn Fn() -> ControlFlow<()> + Sync),
    /// Whether work was stopped because they are spent.
    is_over: AtomicBool,
    /// Whether what is left to do is done however long it takes.
    is_lifted: AtomicBool,
}

impl<'a> Budget<'a> {
    pub(super) fn new(seconds: Option<f64>, proceed: &'a (dyn Fn() -> ControlFlow<()> + Sync)) -> Self {
        let [is_over, is_lifted] = [(); 2].map(|()| AtomicBool::new(false));
        Budget { seconds, start: Instant::now(), proceed, is_over, is_lifted }
    }

    /// Whether work is to go on; asked from any thread.
    pub(super) fn check(&self) -> ControlFlow<()> {
        (self.proceed)()?;
        if self.is_lifted.load(Ordering::Relaxed) || !self.is_spent() {
            return ControlFlow::Continue(());
        }
        self.is_over.store(true, Ordering::Relaxed);
        ControlFlow::Break(())
    }

    /// Whether the seconds are over.
    pub(super) fn is_spent(&self) -> bool {
        self.seconds.is_some_and(|seconds| self.start.elapsed().as_secs_f64() >= seconds)
    }

    /// Whether it was they that stopped work.
    pub(super) fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }

    /// Lets what is left be done: summaries of draws.
    pub(super) fn lift(&self) {
        self.is_lifted.store(true, Ordering::Relaxed);
    }

    /// Why there is no maximum.
    pub(super) fn too_short_to_search(&self) -> MotesError {
        let seconds = self.seconds.unwrap_or_default();
        MotesError::Setting(format!(
            "--budget: {seconds} seconds ended it before the first search had ended; take more seconds, or fewer passes"
        ))
    }

    /// Why there are no draws.
    pub(super) fn too_short(&self, stage: Stage) -> MotesError {
        let seconds = self.seconds.unwrap_or_default();
        let place = match stage {
            Stage::Starting => "while starts were sought",
            Stage::WarmUp => "in the warm-up",
            Stage::Sampling | Stage::Done => "at the first draws",
        };
        MotesError::Setting(format!(
            "--budget: {seconds} seconds ended {place}, before there were draws to keep; take more seconds"
        ))
    }
}
