//! When to resample.

use serde::{Deserialize, Serialize};

use crate::error::FilterError;

/// The rule that decides whether a filter resamples after a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ResampleWhen {
    /// Never: sequential importance sampling.
    Never,
    /// After every step.
    Always,
    /// When the effective sample size is below this fraction of `K`, in (0, 1].
    EssBelow(f64),
}

impl ResampleWhen {
    /// The paper's rule: `K_eff < K/3`.
    pub const PAPER: ResampleWhen = ResampleWhen::EssBelow(1.0 / 3.0);

    /// Checks the fraction.
    ///
    /// # Errors
    /// [`FilterError::Setting`] unless it lies in (0, 1].
    pub fn check(self) -> Result<(), FilterError> {
        match self {
            ResampleWhen::EssBelow(fraction) if !(fraction > 0.0 && fraction <= 1.0) => {
                Err(FilterError::Setting {
                    name: "the fraction of particles below which to resample",
                    value: fraction.to_string(),
                    expected: "above 0 and at most 1",
                })
            }
            _ => Ok(()),
        }
    }

    /// Whether to resample `particles` particles of this effective sample size.
    pub fn is_due(self, effective_sample_size: f64, particles: usize) -> bool {
        match self {
            ResampleWhen::Never => false,
            ResampleWhen::Always => true,
            ResampleWhen::EssBelow(fraction) => effective_sample_size < fraction * particles as f64,
        }
    }
}
