//! The log-evidence of a sequence by twisted filters, which look ahead.

use motes_inference::LogMean;
use motes_models::{PartialMeasurements, Seed};
use motes_smc::{FilterError, Twisting};

use super::options::{CompareOptions, MOST_REFERENCE_FILTERS};
use super::sequence::Sequence;
use crate::model::{Kind, Model};

/// Particles of a twisted filter. They are enough to learn quadratics of up to 48 coordinates.
pub(super) const TWISTED_PARTICLES: usize = 5000;

/// The fewest twisted filters that are averaged.
const FEWEST_FILTERS: usize = 8;

/// The most nats by which other filters may have more evidence, however unsure they are: evidence that is unbiased is rarely far too large.
const MOST_LEAD: f64 = 1.0;

/// An estimate, and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimated {
    pub(super) log_evidence: f64,
    pub(super) error: f64,
}

impl Estimated {
    /// That of the average evidence of some filters.
    pub(super) fn of(logarithms: &[f64]) -> Self {
        let mean = LogMean::of(logarithms);
        Estimated { log_evidence: mean.log(), error: mean.standard_error().unwrap_or(f64::NAN) }
    }

    /// Whether this one is to be believed rather than `other`: it is surer, and no mass is missing in it that the other has found.
    ///
    /// Filters that miss mass agree with each other, so that their standard error says nothing.
    pub(super) fn is_better_than(&self, other: &Estimated) -> bool {
        let lead = other.log_evidence - self.log_evidence;
        self.error < other.error && lead <= (2.0 * self.error.hypot(other.error)).min(MOST_LEAD)
    }
}

/// The estimate of so many filters as it takes for the standard error that is `wanted`; `None` where the model has no such filters, they are not as sure, or the first
/// of them do not know it better than `plain`.
pub(super) fn by_twisted_filters(
    model: &Model,
    sequence: &Sequence,
    options: &CompareOptions,
    wanted: f64,
    plain: &Estimated,
    seed: &Seed,
) -> Option<Estimated> {
    let Kind::Learnable(learnable) = model.kind() else { return None };
    if !learnable.has_gradients() {
        return None;
    }
    let rows = sequence.measurements.concat();
    let measurements = PartialMeasurements::new(model.measurements().len(), rows).ok()?;
    let (first, seed_of_learning) = (options.reference_particles, seed.child("learn"));
    let twisting =
        Twisting::learn(learnable, &measurements, first, TWISTED_PARTICLES, &seed_of_learning).ok()?;
    let filter = |number: usize| {
        match twisting.log_evidence(learnable, TWISTED_PARTICLES, seed.nth(number as u64).stream()) {
            Ok(found) => Some(found),
            // It has estimated an evidence of 0.
            Err(FilterError::Collapse { .. }) => Some(f64::NEG_INFINITY),
            Err(_) => None,
        }
    };
    let mut found = (0..FEWEST_FILTERS).map(filter).collect::<Option<Vec<f64>>>()?;
    while Estimated::of(&found).is_better_than(plain) {
        let twisted = Estimated::of(&found);
        if twisted.error <= wanted {
            return Some(twisted);
        }
        if found.len() == MOST_REFERENCE_FILTERS {
            return None;
        }
        found.push(filter(found.len())?);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surer_estimate_is_believed_unless_it_misses_mass() {
        let plain = Estimated { log_evidence: -10.0, error: 0.4 };
        let is_better = |log_evidence, error| Estimated { log_evidence, error }.is_better_than(&plain);
        assert!(is_better(-10.5, 0.1));
        assert!(is_better(3.0, 0.1));
        assert!(!is_better(-11.5, 0.1));
        assert!(!is_better(-10.0, 0.5));
        assert!(!is_better(-10.0, f64::NAN));
        // Of filters that all collapsed nothing is known.
        let none = Estimated { log_evidence: f64::NEG_INFINITY, error: f64::NAN };
        assert!(!Estimated { log_evidence: -10.0, error: 0.1 }.is_better_than(&none));
        let unsure = Estimated { log_evidence: -10.0, error: 0.99 };
        assert!(!Estimated { log_evidence: -11.2, error: 0.1 }.is_better_than(&unsure));
    }
}
