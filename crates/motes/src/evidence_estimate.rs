//! An estimate of a log-evidence, and whether it is to be believed.

use motes_inference::LogMean;

/// The most nats by which other filters may have more evidence, however unsure they are: evidence that is unbiased is rarely far too large.
const MOST_LEAD: f64 = 1.0;

/// A standard error above which the mean of some runs is that of one of them, and the most nats by which it may then have more evidence than a surer one. The evidence of a run is e⁷ times too
/// large at most once in a thousand.
const ROUGH: f64 = 0.5;
const MOST_LUCK: f64 = 7.0;

/// An estimate, and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EvidenceEstimate {
    pub(crate) log_evidence: f64,
    pub(crate) error: f64,
}

impl EvidenceEstimate {
    /// That of the average evidence of some filters.
    pub(crate) fn of(logarithms: &[f64]) -> Self {
        let mean = LogMean::of(logarithms);
        EvidenceEstimate { log_evidence: mean.log(), error: mean.standard_error().unwrap_or(f64::NAN) }
    }

    /// That of a single filter: nobody knows how far it is off.
    pub(crate) fn of_one(log_evidence: f64) -> Self {
        EvidenceEstimate { log_evidence, error: f64::INFINITY }
    }

    /// Whether this one is to be believed rather than `other`: it is surer, and no mass is missing in it that the other has found.
    ///
    /// Filters that miss mass agree with each other, so that their standard error says nothing.
    pub(crate) fn is_better_than(&self, other: &EvidenceEstimate) -> bool {
        self.error < other.error && !self.misses(other, 2.0)
    }

    /// Whether mass is missing that `other` has found, which has more evidence than so many standard errors explain.
    fn misses(&self, other: &EvidenceEstimate, standard_errors: f64) -> bool {
        let lead = other.log_evidence - self.log_evidence;
        lead.is_nan() || lead > (standard_errors * self.error.hypot(other.error)).min(MOST_LEAD)
    }

    /// The surest of some estimates of the same evidence among those that miss nothing that another has found; the largest, if there is none. None of none.
    pub(crate) fn surest(all: &[EvidenceEstimate]) -> Option<EvidenceEstimate> {
        // Where one run is most of a mean, its error is unknown, and the mean may be too large by luck.
        let misses = |one: &EvidenceEstimate, other: &EvidenceEstimate| match other.error <= ROUGH {
            // Several are compared, of each of many sequences.
            true => one.misses(other, 4.0),
            false => other.log_evidence - one.log_evidence > MOST_LUCK,
        };
        let whole = all.iter().filter(|one| !all.iter().any(|other| misses(one, other)));
        let surest = whole.min_by(|a, b| a.error.total_cmp(&b.error));
        surest.or_else(|| all.iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surer_estimate_is_believed_unless_it_misses_mass() {
        let plain = EvidenceEstimate { log_evidence: -10.0, error: 0.4 };
        let is_better = |log_evidence, error| EvidenceEstimate { log_evidence, error }.is_better_than(&plain);
        assert!(is_better(-10.5, 0.1));
        assert!(is_better(3.0, 0.1));
        assert!(!is_better(-11.5, 0.1));
        assert!(!is_better(-10.0, 0.5));
        assert!(!is_better(-10.0, f64::NAN));
        // Of filters that all collapsed nothing is known.
        let none = EvidenceEstimate { log_evidence: f64::NEG_INFINITY, error: f64::NAN };
        assert!(!EvidenceEstimate { log_evidence: -10.0, error: 0.1 }.is_better_than(&none));
        let unsure = EvidenceEstimate { log_evidence: -10.0, error: 0.99 };
        assert!(!EvidenceEstimate { log_evidence: -11.2, error: 0.1 }.is_better_than(&unsure));
        assert_eq!(EvidenceEstimate::surest(&[]), None);
        let sure = EvidenceEstimate { log_evidence: -10.2, error: 0.1 };
        let lost = EvidenceEstimate { log_evidence: -300.0, error: 1e-3 };
        assert_eq!(EvidenceEstimate::surest(&[lost, plain, sure, none]), Some(sure));
        assert_eq!(EvidenceEstimate::surest(&[lost, plain]), Some(plain));
        // One run of many that was lucky.
        let lucky = EvidenceEstimate { log_evidence: -6.0, error: 0.998 };
        assert_eq!(EvidenceEstimate::surest(&[lucky, sure]), Some(sure));
        let found = EvidenceEstimate { log_evidence: -1.0, ..lucky };
        assert_eq!(EvidenceEstimate::surest(&[found, sure]), Some(found));
        let alone = EvidenceEstimate::of_one(-10.0);
        assert!(EvidenceEstimate { log_evidence: -10.9, error: 0.1 }.is_better_than(&alone));
        assert!(!EvidenceEstimate { log_evidence: -11.2, error: 0.1 }.is_better_than(&alone));
    }
}
