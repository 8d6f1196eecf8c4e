//! The log density of a distribution.

use std::f64::consts::{LN_2, PI};

use super::distribution::{Distribution, zero_or_nan};
use super::scalar::Scalar;
use crate::gaussian::LN_2PI;

/// `density` where `depth` is at least 0, else −∞.
#[inline(always)]
fn inside<S: Scalar>(depth: S, density: S) -> S {
    (-depth).where_positive(S::from(f64::NEG_INFINITY), density)
}

/// `factor·log value`, and 0 for a factor of 0 whatever the logarithm is; NaN for a value below 0.
#[inline(always)]
fn times_log<S: Scalar>(factor: S, value: S) -> S {
    let zero = value.max(S::from(0.0)) - value;
    factor.abs().where_positive(factor * value.ln(), zero.where_positive(S::from(f64::NAN), S::from(0.0)))
}

/// `density` where `count` is 0, 1, 2, …, else −∞.
#[inline(always)]
fn at_count<S: Scalar>(count: S, density: S) -> S {
    let off = (count - count.floor()).abs();
    let density = off.where_positive(S::from(f64::NEG_INFINITY), density);
    inside(count, density)
}

/// Larger means of counts are taken for this one, which no sum overflows with.
const MOST_EXPECTED: f64 = 1e300;

impl<S: Scalar> Distribution<S> {
    /// `log p(x)`; −∞ outside the support, NaN where a parameter is out of range.
    #[inline(always)]
    pub fn log_density(&self, x: S) -> S {
        self.log_density_with(x, || (x + 1.0).ln_gamma())
    }

    /// `log p(x)` of a number that is the same for all, as a measurement.
    #[inline(always)]
    pub(crate) fn log_density_of_one(&self, x: f64) -> S {
        self.log_density_with(S::from(x), || S::from(Scalar::ln_gamma(x + 1.0)))
    }

    #[inline(always)]
    fn log_density_with(&self, x: S, log_factorial: impl FnOnce() -> S) -> S {
        match *self {
            Distribution::Normal { mean, sd } => {
                let z = (x - mean) / sd;
                z * z * -0.5 - sd.ln() - 0.5 * LN_2PI
            }
            Distribution::StudentT { df, location, scale } => {
                let z = (x - location) / scale;
                let half = (df + 1.0) * 0.5;
                half.ln_gamma()
                    - (df * 0.5).ln_gamma()
                    - (df * PI).ln() * 0.5
                    - scale.ln()
                    - half * (z * z / df + 1.0).ln()
            }
            Distribution::Laplace { location, scale } => -((x - location) / scale).abs() - scale.ln() - LN_2,
            Distribution::LogNormal { origin, sign, location, scale } => {
                let size = (x - origin) * sign;
                let log = size.ln();
                let z = (log - location) / scale;
                let density = z * z * -0.5 - scale.ln() - log - 0.5 * LN_2PI;
                // At its origin the density is 0, which the logarithm of 0 does not give.
                size.where_positive(density, S::from(f64::NEG_INFINITY)) + zero_or_nan(scale)
            }
            Distribution::Exponential { origin, mean } => {
                let z = (x - origin) / mean;
                inside(z, -z - mean.abs().ln())
            }
            Distribution::Gamma { origin, shape, scale } => {
                let z = (x - origin) / scale;
                let density = (shape - 1.0) * z.ln() - z - shape.ln_gamma() - scale.abs().ln();
                z.where_positive(density, S::from(f64::NEG_INFINITY)) + zero_or_nan(shape)
            }
            Distribution::Uniform { low, high } => {
                let depth = (x - low).min(high - x);
                inside(depth, -(high - low).ln())
            }
            // Where so many are expected that they are no number, any count is as unlikely as can be.
            Distribution::Poisson { mean } => {
                let mean = mean.min(S::from(MOST_EXPECTED));
                at_count(x, times_log(x, mean) - mean - log_factorial())
            }
            Distribution::NegativeBinomial { mean, size } => {
                let mean = mean.min(S::from(MOST_EXPECTED));
                let whole = mean + size;
                let density = (x + size).ln_gamma() - size.ln_gamma() - log_factorial()
                    + times_log(x, mean / whole)
                    + size * (size / whole).ln();
                at_count(x, density)
            }
            Distribution::Binomial { n, p } => {
                let failures = n - x;
                let choices = (n + 1.0).ln_gamma() - log_factorial() - (failures + 1.0).ln_gamma();
                let density = choices + times_log(x, p) + times_log(failures, -p + 1.0);
                let is_count = n - n.floor();
                let density = is_count.where_positive(S::from(f64::NAN), density);
                at_count(x, inside(failures, density))
            }
        }
    }
}
