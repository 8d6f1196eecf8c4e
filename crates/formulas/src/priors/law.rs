//! The distributions of priors.

use motes_models::equations::{Distribution, Scalar, gamma, normal_quantile};

/// A distribution of one number, or of several that add up to 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Law {
    Of(Distribution<f64>),
    /// That of 1/x.
    Inverse(Distribution<f64>),
    /// What lies between two numbers of another one.
    Truncated(Box<Truncated>),
    /// A dirichlet distribution with these weights.
    Dirichlet(Vec<f64>),
}

/// What lies between two numbers of a distribution.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Truncated {
    law: Law,
    ends: [f64; 2],
    /// The probabilities of a standard normal number below those that the ends are made of; below their negatives where that is more accurate.
    below: [f64; 2],
    is_mirrored: bool,
}

impl Truncated {
    /// None where nothing lies there.
    pub(crate) fn new(law: Law, ends: [f64; 2]) -> Option<Self> {
        let [low, high] = ends.map(|end| law.to_normal(end));
        let is_mirrored = low > 0.0;
        let [low, high] = if is_mirrored { [-high, -low] } else { [low, high] };
        let below = [low, high].map(Scalar::normal_cdf);
        (below[1] > below[0]).then_some(Truncated { law, ends, below, is_mirrored })
    }

    /// What a standard normal number is turned into.
    fn at(&self, v: f64) -> f64 {
        let v = if self.is_mirrored { -v } else { v };
        let [low, high] = self.below;
        let p = low + (high - low) * Scalar::normal_cdf(v);
        // Rounding can lead past the end; what is no number stays none.
        let v = normal_quantile(if p > 1.0 { 1.0 } else { p });
        let x = self.law.at_one(if self.is_mirrored { -v } else { v });
        x.clamp(self.ends[0], self.ends[1])
    }

    /// The standard normal number that a value is made of.
    fn to_normal(&self, x: f64) -> f64 {
        let v = self.law.to_normal(x.clamp(self.ends[0], self.ends[1]));
        let [low, high] = self.below;
        let below = Scalar::normal_cdf(if self.is_mirrored { -v } else { v });
        let v = normal_quantile(((below - low) / (high - low)).clamp(0.0, 1.0));
        if self.is_mirrored { -v } else { v }
    }

    fn log_density(&self, x: f64) -> f64 {
        match x >= self.ends[0] && x <= self.ends[1] {
            true => self.law.log_density(&[x]) - (self.below[1] - self.below[0]).ln(),
            false => f64::NEG_INFINITY,
        }
    }
}

impl Law {
    /// `log p(x)`.
    pub(crate) fn log_density(&self, values: &[f64]) -> f64 {
        let x = values.first().copied().unwrap_or(f64::NAN);
        match self {
            Law::Of(distribution) => distribution.log_density(x),
            Law::Inverse(distribution) if x > 0.0 => distribution.log_density(1.0 / x) - 2.0 * x.ln(),
            Law::Inverse(_) => f64::NEG_INFINITY,
            Law::Truncated(truncated) => truncated.log_density(x),
            Law::Dirichlet(weights) => log_dirichlet(weights, values),
        }
    }

    /// Writes values with this distribution, made of as many standard normal numbers.
    pub(crate) fn write(&self, noise: &[f64], values: &mut [f64]) {
        let Law::Dirichlet(weights) = self else {
            return values.iter_mut().zip(noise).for_each(|(value, v)| *value = self.at_one(*v));
        };
        for ((value, weight), v) in values.iter_mut().zip(weights).zip(noise) {
            *value = gamma(*weight, 1.0).from_normal(*v);
        }
        let sum: f64 = values.iter().sum();
        values.iter_mut().for_each(|value| *value /= sum);
    }

    /// The value that a standard normal number is turned into.
    fn at_one(&self, v: f64) -> f64 {
        match self {
            Law::Of(distribution) => distribution.from_normal(v),
            Law::Inverse(distribution) => 1.0 / distribution.from_normal(-v),
            Law::Truncated(truncated) => truncated.at(v),
            Law::Dirichlet(_) => f64::NAN,
        }
    }

    /// The standard normal number that a value is made of, where it is one of a density.
    fn to_normal(&self, x: f64) -> f64 {
        match self {
            _ if x.is_infinite() => x,
            Law::Of(distribution) => distribution.to_normal(x),
            Law::Inverse(distribution) if x > 0.0 => -distribution.to_normal(1.0 / x),
            Law::Inverse(_) => f64::NEG_INFINITY,
            Law::Truncated(truncated) => truncated.to_normal(x),
            Law::Dirichlet(_) => f64::NAN,
        }
    }

    /// The median to twelve digits, or of a dirichlet the mean.
    pub(crate) fn centre(&self) -> Vec<f64> {
        match self {
            Law::Dirichlet(weights) => {
                let sum: f64 = weights.iter().sum();
                weights.iter().map(|weight| weight / sum).collect()
            }
            one => {
                let (median, [low, high]) = (one.at_one(0.0), one.ends());
                // That of uniform(0.1, 0.7) is 0.4, not 0.39999999999999997.
                let short = format!("{median:.11e}").parse().ok();
                vec![short.filter(|short| (low..=high).contains(short)).unwrap_or(median)]
            }
        }
    }

    /// Whether it gives whole numbers.
    pub(crate) fn is_discrete(&self) -> bool {
        matches!(self, Law::Of(distribution) if distribution.is_discrete())
    }

    /// The ends of where a value can lie, infinite ones too.
    pub(crate) fn ends(&self) -> [f64; 2] {
        match self {
            Law::Of(distribution) => distribution.ends(),
            Law::Inverse(_) => [0.0, f64::INFINITY],
            Law::Truncated(truncated) => {
                let [[low, high], [least, most]] = [truncated.ends, truncated.law.ends()];
                [low.max(least), high.min(most)]
            }
            Law::Dirichlet(_) => [0.0, 1.0],
        }
    }
}

/// How far the sum of shares may be from 1.
const ROUNDED: f64 = 1e-9;

fn log_dirichlet(weights: &[f64], shares: &[f64]) -> f64 {
    if shares.iter().any(|share| *share < 0.0) || (shares.iter().sum::<f64>() - 1.0).abs() > ROUNDED {
        return f64::NEG_INFINITY;
    }
    let of_share = |(weight, share): (&f64, &f64)| {
        // 0·log 0 is 0.
        let power = if *weight == 1.0 { 0.0 } else { (weight - 1.0) * share.ln() };
        power - Scalar::ln_gamma(*weight)
    };
    let sum: f64 = weights.iter().sum();
    Scalar::ln_gamma(sum) + weights.iter().zip(shares).map(of_share).sum::<f64>()
}
