//! What "below", "independent", "steadier" and "close" mean, fixed before any result was seen.

use crate::metrics::median;

/// The verdict on a claim, or on a part of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Reproduced,
    NotReproduced,
    /// What it needs was not run, or not often enough to tell.
    NotRun,
}

impl Verdict {
    pub(super) fn of(holds: bool) -> Self {
        if holds { Verdict::Reproduced } else { Verdict::NotReproduced }
    }

    /// The verdict on "all of these": one that fails decides, and then one that is missing.
    pub(super) fn all(verdicts: impl IntoIterator<Item = Verdict>) -> Self {
        let mut all = None;
        for verdict in verdicts {
            all = Some(match (all, verdict) {
                (_, Verdict::NotReproduced) | (Some(Verdict::NotReproduced), _) => Verdict::NotReproduced,
                (_, Verdict::NotRun) | (Some(Verdict::NotRun), _) => Verdict::NotRun,
                _ => Verdict::Reproduced,
            });
        }
        all.unwrap_or(Verdict::NotRun)
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Verdict::Reproduced => "reproduced",
            Verdict::NotReproduced => "not reproduced",
            Verdict::NotRun => "not run",
        }
    }
}

/// The level of the sign test.
const LEVEL: f64 = 0.05;

/// Medians within this factor of each other are close.
pub(super) const CLOSE: f64 = 1.5;

/// Of the points, the share at which "in general" must hold.
pub(super) const IN_GENERAL: f64 = 0.8;

/// Slopes within this many standard errors of 0 are no slopes.
const STANDARD_ERRORS: f64 = 2.0;

/// One point of "below".
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Below {
    /// `exp` of the median log-ratio.
    pub(super) ratio: f64,
    /// The probability that as many of as many coins fall on one side.
    pub(super) p: f64,
    pub(super) verdict: Verdict,
}

/// Median log-ratio below 0, and a one-sided sign test that says so at 5%.
pub(super) fn below(log_ratios: &[f64]) -> Below {
    let n = log_ratios.len();
    let negative = log_ratios.iter().filter(|ratio| **ratio < 0.0).count();
    let (ratio, p) = (median(log_ratios.to_vec()), at_least(negative, n));
    let verdict = match ratio < 0.0 && p < LEVEL {
        true => Verdict::Reproduced,
        // Even if all were below, so few could not tell.
        false if ratio < 0.0 && at_least(n, n) >= LEVEL => Verdict::NotRun,
        false => Verdict::NotReproduced,
    };
    Below { ratio: ratio.exp(), p, verdict }
}

/// `P(X ≥ successes)` for `X ~ Bin(n, ½)`.
fn at_least(successes: usize, n: usize) -> f64 {
    let mut term = 0.5_f64.powi(n as i32);
    let mut sum = 0.0;
    for k in 0..=n {
        if k >= successes {
            sum += term;
        }
        term *= (n - k) as f64 / (k + 1) as f64;
    }
    sum.min(1.0)
}

/// A line through `(log x, log error)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slope {
    pub(super) slope: f64,
    pub(super) standard_error: f64,
}

impl Slope {
    /// Least squares; none of fewer than three points or of points above one another.
    pub(super) fn through(points: &[(f64, f64)]) -> Option<Slope> {
        let n = points.len() as f64;
        if points.len() < 3 {
            return None;
        }
        let mean = |pick: fn(&(f64, f64)) -> f64| points.iter().map(pick).sum::<f64>() / n;
        let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        if spread == 0.0 {
            return None;
        }
        let slope = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread;
        let residual: f64 = points.iter().map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2)).sum();
        Some(Slope { slope, standard_error: (residual / (n - 2.0) / spread).sqrt() })
    }

    pub(super) fn is_flat(self) -> bool {
        self.slope.abs() < STANDARD_ERRORS * self.standard_error
    }

    pub(super) fn falls(self) -> bool {
        self.slope < -STANDARD_ERRORS * self.standard_error
    }
}

/// The ratio of the largest to the smallest: how unsteady medians are.
pub(super) fn unsteadiness(medians: &[f64]) -> f64 {
    let (low, high) =
        medians.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), m| (low.min(*m), high.max(*m)));
    high / low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_test_by_hand() {
        assert_eq!(at_least(0, 5), 1.0);
        assert!((at_least(5, 5) - 1.0 / 32.0).abs() < 1e-15);
        assert!((at_least(15, 20) - 0.020694732666015625).abs() < 1e-12);
    }

    #[test]
    fn below_needs_the_median_and_the_test() {
        let of = |negative: usize, n: usize| {
            let ratios: Vec<f64> = (0..n).map(|i| if i < negative { -1.0 } else { 1.0 }).collect();
            below(&ratios).verdict
        };
        assert_eq!(of(20, 20), Verdict::Reproduced);
        assert_eq!(of(15, 20), Verdict::Reproduced);
        assert_eq!(of(14, 20), Verdict::NotReproduced);
        assert_eq!(of(0, 20), Verdict::NotReproduced);
        assert_eq!(of(3, 3), Verdict::NotRun);
        assert_eq!(of(1, 3), Verdict::NotReproduced);
    }

    #[test]
    fn a_line_is_found_with_its_uncertainty() {
        let exact: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), 3.0 - 2.0 * f64::from(i))).collect();
        let line = Slope::through(&exact).unwrap();
        assert!((line.slope + 2.0).abs() < 1e-12 && line.standard_error < 1e-12 && line.falls());
        let flat = [(0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (3.0, -1.0), (4.0, 1.0)];
        assert!(Slope::through(&flat).unwrap().is_flat());
        assert_eq!(Slope::through(&[(1.0, 0.0), (1.0, 1.0), (1.0, 2.0)]), None);
    }

    #[test]
    fn one_failure_decides_and_then_one_gap() {
        use Verdict::{NotReproduced, NotRun, Reproduced};
        assert_eq!(Verdict::all([Reproduced, NotRun, NotReproduced, NotRun]), NotReproduced);
        assert_eq!(Verdict::all([Reproduced, NotRun]), NotRun);
        assert_eq!(Verdict::all([Reproduced, Reproduced]), Reproduced);
        assert_eq!(Verdict::all([]), NotRun);
        assert_eq!(unsteadiness(&[2.0, 1.0, 3.0]), 3.0);
    }
}
