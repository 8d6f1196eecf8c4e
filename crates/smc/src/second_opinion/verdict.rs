//! What a second opinion says.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a second opinion says of all steps so far.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Verdict {
    /// All steps could be judged, and none of them speaks against the filter.
    Agrees,
    /// Some steps could not be judged, and the others do not speak against the filter. Either the bootstrap is too poor for this, or the filter itself is, which its own effective sample size says.
    NoOpinion {
        /// The first step that could not be judged.
        first_step: usize,
        /// Steps that could not.
        unjudged: usize,
        /// All steps.
        steps: usize,
    },
    /// The bootstrap found mass that the filter misses: evidence and estimates of the filter are not to be trusted.
    Warns {
        /// The first step from which on it shows.
        first_step: usize,
        /// How far the filter's log-evidence of the steps from there on was below the bootstrap's at its worst (nats).
        difference: f64,
        /// The Monte Carlo standard error of this (nats).
        error: f64,
    },
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Verdict::Agrees => write!(f, "a bootstrap filter agrees"),
            Verdict::NoOpinion { first_step, unjudged, steps } => write!(
                f,
                "no second opinion: {unjudged} of {steps} steps, from step {first_step} on, are too hard for a bootstrap filter, or for \
                 this one by its own effective sample size"
            ),
            Verdict::Warns { first_step, difference, error } => write!(
                f,
                "from step {first_step} on the filter misses mass: a bootstrap filter has a log-evidence that is {difference:.1} ± {error:.1} \
                 larger"
            ),
        }
    }
}
