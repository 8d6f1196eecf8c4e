//! Over how many steps a filter's estimate of its own error can be trusted.

use serde::{Deserialize, Serialize};

use crate::evidence::AncestryVariance;
use crate::weights::LogWeights;

/// Effective particles from which on an estimate of error is trusted.
const LEAST_EFFECTIVE: f64 = 20.0;

/// The same as a fraction of all particles.
const LEAST_FRACTION: f64 = 0.02;

/// The variance of the log-evidence of a block of steps up to which an estimate is trusted: beyond it a logarithm is far from Gaussian.
const MOST_VARIANCE: f64 = 0.5;

/// Steps for which a filter that could not be trusted is not trusted either: its particles may be in a wrong place with weights that look fine.
const RECOVERY: usize = 20;

/// Steps, up to the present one, at which a filter had weights that can be trusted.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Trust {
    steps: usize,
    /// Whether there was a step at which it had not.
    was_lost: bool,
}

impl Trust {
    /// Takes in a step, after which the filter has these weights and this error.
    pub(super) fn step(&mut self, weights: &LogWeights, error: &AncestryVariance) {
        let least = LEAST_EFFECTIVE.max(LEAST_FRACTION * weights.len() as f64);
        if weights.effective_sample_size() >= least && error.variance_of_block() <= MOST_VARIANCE {
            self.steps += 1;
        } else {
            *self = Trust { steps: 0, was_lost: true };
        }
    }

    /// How many steps in a row up to now it had such weights.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// The same without those of its recovery.
    pub(super) fn recovered_steps(&self) -> usize {
        if self.was_lost { self.steps.saturating_sub(RECOVERY) } else { self.steps }
    }
}
