//! What "below", "independent", "steadier" and "close" mean, fixed before any result was seen.

use super::numbers::ratio;
use crate::statistics::{mean, median, standard_deviation};

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
    /// Repetitions.
    pub(super) n: usize,
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
    Below { ratio: ratio.exp(), p, n, verdict }
}

/// `P(X ≥ successes)` for `X ~ Bin(n, ½)`.
fn at_least(successes: usize, n: usize) -> f64 {
    // Binomial coefficients, by numbers so large that they stay finite.
    let (mut coefficient, mut tail, mut whole) = (1.0_f64, 0.0_f64, 0.0_f64);
    for k in 0..=n {
        if k >= successes {
            tail += coefficient;
        }
        whole += coefficient;
        coefficient *= (n - k) as f64 / (k + 1) as f64;
        if coefficient > LARGE {
            [&mut coefficient, &mut tail, &mut whole].into_iter().for_each(|number| *number /= LARGE);
        }
    }
    tail / whole
}

/// What binomial coefficients are divided by where they become larger.
const LARGE: f64 = 1e250;

/// The slope of log error on log x, over repetitions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slope {
    pub(super) slope: f64,
    pub(super) standard_error: f64,
}

impl Slope {
    /// The mean, with its standard error, of one slope for each repetition: each has a system of its own, whose difficulty
    /// moves a whole curve and not its slope. None of fewer than three repetitions.
    pub(super) fn over(curves: &[Vec<(f64, f64)>]) -> Option<Slope> {
        let slopes: Vec<f64> = curves.iter().filter_map(|points| least_squares(points)).collect();
        if slopes.len() < 3 {
            return None;
        }
        let standard_error = standard_deviation(&slopes) / (slopes.len() as f64).sqrt();
        Some(Slope { slope: mean(&slopes), standard_error })
    }

    pub(super) fn is_flat(self) -> bool {
        self.slope.abs() < STANDARD_ERRORS * self.standard_error
    }

    pub(super) fn falls(self) -> bool {
        self.slope < -STANDARD_ERRORS * self.standard_error
    }
}

/// The slope of the line through some points; none if they stand above one another.
fn least_squares(points: &[(f64, f64)]) -> Option<f64> {
    let (xs, ys): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    let (mean_x, mean_y) = (mean(&xs), mean(&ys));
    let spread: f64 = xs.iter().map(|x| (x - mean_x).powi(2)).sum();
    let product: f64 = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    (spread > 0.0).then(|| product / spread)
}

/// The ratio of the largest to the smallest: how unsteady medians are. Infinite if one of them is.
pub(super) fn unsteadiness(medians: &[f64]) -> f64 {
    let (low, high) =
        medians.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), m| (low.min(*m), high.max(*m)));
    ratio(high, low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_test_by_hand() {
        assert_eq!(at_least(0, 5), 1.0);
        assert!((at_least(5, 5) - 1.0 / 32.0).abs() < 1e-15);
        assert!((at_least(15, 20) - 0.020694732666015625).abs() < 1e-12);
        assert!((at_least(551, 1100) - 0.488).abs() < 1e-3);
        assert!(at_least(9000, 10_000) < 1e-300);
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
        let curve = |height: f64, slope: f64| -> Vec<(f64, f64)> {
            (0..5).map(|i| (f64::from(i), height + slope * f64::from(i))).collect()
        };
        // Far apart in height, and all falling: pooled, their heights would drown the slope.
        let falling: Vec<_> = (0..20).map(|r| curve(f64::from(r), -0.5 + 0.01 * f64::from(r % 3))).collect();
        let line = Slope::over(&falling).unwrap();
        assert!((line.slope + 0.49).abs() < 0.01 && line.falls() && !line.is_flat());
        let flat: Vec<_> = (0..20).map(|r| curve(0.0, if r % 2 == 0 { 0.3 } else { -0.3 })).collect();
        assert!(Slope::over(&flat).unwrap().is_flat());
        assert_eq!(Slope::over(&[curve(0.0, 1.0), curve(0.0, 1.0)]), None);
        assert_eq!(Slope::over(&vec![vec![(1.0, 0.0), (1.0, 1.0)]; 5]), None);
    }

    #[test]
    fn one_failure_decides_and_then_one_gap() {
        use Verdict::{NotReproduced, NotRun, Reproduced};
        assert_eq!(Verdict::all([Reproduced, NotRun, NotReproduced, NotRun]), NotReproduced);
        assert_eq!(Verdict::all([Reproduced, NotRun]), NotRun);
        assert_eq!(Verdict::all([Reproduced, Reproduced]), Reproduced);
        assert_eq!(Verdict::all([]), NotRun);
        assert_eq!(unsteadiness(&[2.0, 1.0, 3.0]), 3.0);
        assert_eq!(unsteadiness(&[f64::INFINITY; 3]), f64::INFINITY);
    }
}
