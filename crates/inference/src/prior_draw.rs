//! A draw from the prior that can be drawn once more.

use motes_models::{Seed, fill_standard_normal};

use crate::likelihood::Estimator;

/// A draw from the prior, with the estimate of the likelihood there: who asks once more, with the same estimator and the same random numbers, finds the same.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorDraw {
    /// Its position (`D`).
    pub v: Vec<f64>,
    /// The estimator of the likelihood.
    pub estimator: Estimator,
    /// What the estimate took its random numbers from.
    pub seed: Seed,
}

/// Where a draw from the prior is, for what is written down: its number, and its estimator.
pub(crate) type DrawNumber = (u64, Estimator);

impl PriorDraw {
    /// The draw of that number from the prior of `d` parameters.
    pub(crate) fn of(d: usize, (number, estimator): DrawNumber, seed: &Seed) -> Self {
        let seed = seed.child("prior").nth(number);
        let mut v = vec![0.0; d];
        fill_standard_normal(&mut seed.stream(), &mut v);
        PriorDraw { v, estimator, seed: seed.child("likelihood") }
    }
}
