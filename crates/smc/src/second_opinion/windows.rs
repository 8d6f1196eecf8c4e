//! Differences of two log-evidences over the last 1, 2, 4, … steps.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::evidence::AncestryVariance;

/// The longest window, in steps.
const LONGEST: usize = 1024;

/// A difference below which there is no miss, whatever the errors, in nats: evidence off by a factor of 150.
const LEAST_DIFFERENCE: f64 = 5.0;

/// Standard errors below which there is none. Errors have longer tails than a Gaussian, and there are up to eleven windows at every step.
const LEAST_SCORE: f64 = 6.0;

/// What was known before a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Since {
    /// The step.
    pub(super) step: usize,
    /// The difference of the log-evidences of all steps before it.
    difference: f64,
    /// Variances of the filter's log-evidence and of the bootstrap's, before the block of steps that it belongs to.
    variances: [f64; 2],
}

/// The log-evidence of the bootstrap less that of the filter, of some steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Excess {
    /// In nats.
    pub(super) difference: f64,
    /// Variances of the filter's part and of the bootstrap's (nats²).
    variances: [f64; 2],
}

impl Excess {
    /// Its standard error (nats).
    pub(super) fn error(&self) -> f64 {
        (self.variances[0] + self.variances[1]).sqrt()
    }

    /// Whether the bootstrap is above by more than both errors allow, so that the filter missed mass.
    pub(super) fn is_miss_of_filter(&self) -> bool {
        self.is_above(self.difference, self.variances[0])
    }

    /// The same the other way round.
    pub(super) fn is_miss_of_bootstrap(&self) -> bool {
        self.is_above(-self.difference, self.variances[1])
    }

    /// Whether a difference is too large, the variance of what is below being this. Half of that is its bias: `E log Ẑ ≈ log Z − ½ Var log Ẑ`.
    fn is_above(&self, difference: f64, variance: f64) -> bool {
        difference - 0.5 * variance >= LEAST_DIFFERENCE.max(LEAST_SCORE * self.error())
    }
}

/// The last steps, and the sum of all.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Windows {
    /// Before each of the last steps that windows may begin with.
    begins: VecDeque<Since>,
    difference: f64,
}

impl Windows {
    /// Takes in a step that no window begins with.
    pub(super) fn skip(&mut self, difference: f64) {
        self.begins.clear();
        self.difference += difference;
    }

    /// Takes in a step, after which the errors of the filter and of the bootstrap are these.
    pub(super) fn step(&mut self, step: usize, difference: f64, errors: &[AncestryVariance; 2]) {
        if self.begins.len() == LONGEST {
            self.begins.pop_front();
        }
        let variances = [0, 1].map(|of| errors[of].variance_before_block());
        self.begins.push_back(Since { step, difference: self.difference, variances });
        self.difference += difference;
    }

    /// The difference of all steps so far.
    pub(super) fn difference(&self) -> f64 {
        self.difference
    }

    /// The windows that end with the last step, from the shortest on: their lengths, and what was known before them.
    pub(super) fn ending_now(&self) -> impl Iterator<Item = (usize, Since)> {
        let lengths = std::iter::successors(Some(1), |length| Some(2 * length));
        let lengths = lengths.take_while(|length| *length <= self.begins.len());
        lengths.map(|length| (length, self.begins[self.begins.len() - length]))
    }

    /// What the steps since then add up to. Errors are those of whole blocks of steps, no smaller than those of the window.
    pub(super) fn since(&self, since: &Since, errors: &[AncestryVariance; 2]) -> Excess {
        let variances = [0, 1].map(|of| errors[of].variance() - since.variances[of]);
        Excess { difference: self.difference - since.difference, variances }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_miss_is_beyond_both_errors_and_not_small() {
        let excess = |difference: f64, variances| Excess { difference, variances };
        assert!(excess(5.0, [0.0, 0.0]).is_miss_of_filter() && !excess(4.9, [0.0, 0.0]).is_miss_of_filter());
        // Six standard errors of 1 are 6; half of the filter's variance is its bias.
        assert!(
            excess(6.33, [0.64, 0.36]).is_miss_of_filter() && !excess(6.31, [0.64, 0.36]).is_miss_of_filter()
        );
        assert!(excess(-6.19, [0.64, 0.36]).is_miss_of_bootstrap());
        assert!(!excess(-6.17, [0.64, 0.36]).is_miss_of_bootstrap());
        assert!(
            !excess(-9.0, [0.1, 0.1]).is_miss_of_filter() && !excess(9.0, [0.1, 0.1]).is_miss_of_bootstrap()
        );
    }

    #[test]
    fn windows_are_sums_of_the_last_steps() {
        let (mut windows, errors) =
            (Windows::default(), [AncestryVariance::default(), AncestryVariance::default()]);
        windows.skip(100.0);
        (1..=3000).for_each(|step| windows.step(step, step as f64, &errors));
        let sum = |first: usize| (first..=3000).sum::<usize>() as f64;
        let found: Vec<usize> = windows
            .ending_now()
            .map(|(length, since)| {
                assert_eq!(since.step, 3001 - length);
                assert_eq!(windows.since(&since, &errors).difference, sum(since.step));
                length
            })
            .collect();
        assert_eq!(found, (0..=10).map(|power| 1 << power).collect::<Vec<usize>>());
        assert_eq!(windows.difference(), 100.0 + sum(1));
        windows.skip(1.0);
        assert_eq!(windows.ending_now().count(), 0, "no window reaches over a step that was skipped");
    }
}
