//! An estimate of a log-evidence, and whether it is to be believed.

use motes_inference::LogMean;

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

    /// That of a single filter: nobody knows how far it is off.
    pub(super) fn of_one(log_evidence: f64) -> Self {
        Estimated { log_evidence, error: f64::INFINITY }
    }

    /// Whether this one is to be believed rather than `other`: it is surer, and no mass is missing in it that the other has found.
    ///
    /// Filters that miss mass agree with each other, so that their standard error says nothing.
    pub(super) fn is_better_than(&self, other: &Estimated) -> bool {
        let lead = other.log_evidence - self.log_evidence;
        self.error < other.error && lead <= (2.0 * self.error.hypot(other.error)).min(MOST_LEAD)
    }
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
        let alone = Estimated::of_one(-10.0);
        assert!(Estimated { log_evidence: -10.9, error: 0.1 }.is_better_than(&alone));
        assert!(!Estimated { log_evidence: -11.2, error: 0.1 }.is_better_than(&alone));
    }
}
