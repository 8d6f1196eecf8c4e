//! What a Gaussian approximation needs of a distribution: its moments, and what an observation of it says of its location.

use super::distribution::Distribution;
use super::scalar::Scalar;

/// What an observation says of a distribution's location `θ`: the mean of counts and of positive numbers, the mean of the logarithm where that
/// is normal, the centre elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score<S> {
    /// `θ`, up to a constant that no state changes.
    pub location: S,
    /// `∂ log p(y | θ) / ∂θ`.
    pub slope: S,
    /// The Fisher information of `θ`; the inverse variance where the end of the range moves with `θ`, and it has none.
    pub information: S,
}

impl<S: Scalar> Distribution<S> {
    /// Mean and variance; location and squared scale where the variance is infinite.
    #[inline(always)]
    pub fn moments(&self) -> [S; 2] {
        match *self {
            Distribution::Normal { mean, sd } => [mean, sd * sd],
            Distribution::StudentT { df, location, scale } => {
                let square = scale * scale;
                let beyond = df - 2.0;
                [location, beyond.where_positive(square * df / beyond, square)]
            }
            Distribution::Laplace { location, scale } => [location, scale * scale * 2.0],
            Distribution::LogNormal { origin, sign, location, scale } => {
                let square = scale * scale;
                let mean = (location + square * 0.5).exp();
                [origin + sign * mean, (square.exp() - 1.0) * mean * mean]
            }
            Distribution::Exponential { origin, mean } => [origin + mean, mean * mean],
            Distribution::Gamma { origin, shape, scale } => [origin + shape * scale, shape * scale * scale],
            Distribution::Uniform { low, high } => {
                let width = high - low;
                [(low + high) * 0.5, width * width / 12.0]
            }
            Distribution::Poisson { mean } => [mean, mean],
            Distribution::NegativeBinomial { mean, size } => [mean, mean + mean * mean / size],
            Distribution::Binomial { n, p } => [n * p, n * p * (-p + 1.0)],
        }
    }

    /// What the observation `y` says of the location.
    #[inline(always)]
    pub fn score(&self, y: S) -> Score<S> {
        let one = S::from(1.0);
        match *self {
            Distribution::StudentT { df, location, scale } => {
                let (rest, square) = (y - location, scale * scale);
                Score {
                    location,
                    slope: (df + 1.0) * rest / (df * square + rest * rest),
                    information: (df + 1.0) / ((df + 3.0) * square),
                }
            }
            Distribution::Laplace { location, scale } => {
                let rest = y - location;
                let sign = rest.where_positive(one, (-rest).where_positive(-one, S::from(0.0)));
                Score { location, slope: sign / scale, information: one / (scale * scale) }
            }
            Distribution::LogNormal { origin, sign, location, scale } => {
                let information = one / (scale * scale);
                let location = location - ((y - origin) * sign).ln();
                Score { location, slope: -location * information, information }
            }
            Distribution::Normal { .. }
            | Distribution::Exponential { .. }
            | Distribution::Gamma { .. }
            | Distribution::Uniform { .. }
            | Distribution::Poisson { .. }
            | Distribution::NegativeBinomial { .. }
            | Distribution::Binomial { .. } => {
                let [mean, variance] = self.moments();
                let information = one / variance;
                Score { location: mean, slope: (y - mean) * information, information }
            }
        }
    }
}
