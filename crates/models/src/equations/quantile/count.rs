//! Counts as transports of a standard normal number: the smallest count whose distribution function reaches `Φ(v)`.

use statrs::function::beta::checked_beta_reg;
use statrs::function::gamma::{checked_gamma_lr, checked_gamma_ur};

use super::normal;
use crate::equations::distribution::Distribution;

/// From here on not every integer is a number.
const LARGEST: f64 = (1_u64 << 53) as f64;

/// `P(X ≤ n)` and `P(X > n)` of a count, each from its own end.
fn tails(distribution: &Distribution<f64>, n: f64) -> [f64; 2] {
    let number = |found: Result<f64, _>| found.unwrap_or(f64::NAN);
    match *distribution {
        Distribution::Poisson { mean } => [
            checked_gamma_ur(n + 1.0, mean).unwrap_or(f64::NAN),
            checked_gamma_lr(n + 1.0, mean).unwrap_or(f64::NAN),
        ],
        Distribution::NegativeBinomial { mean, size } => {
            let whole = mean + size;
            [
                number(checked_beta_reg(size, n + 1.0, size / whole)),
                number(checked_beta_reg(n + 1.0, size, mean / whole)),
            ]
        }
        Distribution::Binomial { n: trials, p } => [
            number(checked_beta_reg(trials - n, n + 1.0, 1.0 - p)),
            number(checked_beta_reg(n + 1.0, trials - n, p)),
        ],
        _ => [f64::NAN; 2],
    }
}

/// The largest count that there can be.
fn last(distribution: &Distribution<f64>) -> f64 {
    match *distribution {
        Distribution::Binomial { n, .. } => n,
        _ => f64::INFINITY,
    }
}

/// Whether there is but one count.
fn is_certain(distribution: &Distribution<f64>) -> bool {
    match *distribution {
        Distribution::Poisson { mean } | Distribution::NegativeBinomial { mean, .. } => mean == 0.0,
        Distribution::Binomial { n, p } => n == 0.0 || p == 0.0 || p == 1.0,
        _ => false,
    }
}

/// The count that `v` is transported to; NaN where a parameter is out of range, or where it cannot be had in floating point.
pub(super) fn from_normal(distribution: &Distribution<f64>, v: f64) -> f64 {
    if let Distribution::Binomial { n, p } = *distribution
        && !((0.0..=LARGEST).contains(&n) && n.fract() == 0.0 && (0.0..=1.0).contains(&p))
    {
        return f64::NAN;
    }
    if is_certain(distribution) {
        return distribution.moments()[0];
    }
    let most = last(distribution);
    let [mean, variance] = distribution.moments();
    let guess = mean + variance.sqrt() * v;
    if !(guess.abs() <= LARGEST) {
        return f64::NAN;
    }
    let target = normal::log_upper(v.abs());
    // Whether P(X ≤ n) ≥ Φ(v), by the smaller of both tails.
    let reaches = |n: f64| {
        if n >= most {
            return Some(true);
        }
        let [below, above] = tails(distribution, n);
        let (reaches, tail) =
            if v <= 0.0 { (below.ln() >= target, below) } else { (above.ln() <= target, above) };
        (!tail.is_nan()).then_some(reaches)
    };
    // Between a count that does not reach it and one that does.
    let (mut low, mut high, mut width) = (-1.0, guess.round().clamp(0.0, most), 1.0);
    loop {
        match reaches(high) {
            None => return f64::NAN,
            Some(true) => break,
            Some(false) => {
                low = high;
                high = (high + width).min(most);
                width *= 2.0;
            }
        }
        if high > LARGEST {
            return f64::NAN;
        }
    }
    width = 1.0;
    while high - low > 1.0 {
        // From above in growing steps, then by halves.
        let middle = if low < high - width { high - width } else { ((low + high) / 2.0).floor() };
        let middle = middle.max(low + 1.0).max(0.0);
        match reaches(middle) {
            None => return f64::NAN,
            Some(true) => {
                high = middle;
                width *= 2.0;
            }
            Some(false) => {
                low = middle;
                width = f64::INFINITY;
            }
        }
    }
    high
}

/// A count that a Gaussian of its noise `v` was asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::equations) struct GuidedCount {
    /// `log Q(n) − log p(n)`, where `Q(n)` is the Gaussian's mass of the `v` that are transported to `n`.
    pub(in crate::equations) log_ratio: f64,
    /// The most likely of these `v`.
    pub(in crate::equations) noise: f64,
}

impl Distribution<f64> {
    /// What the Gaussian `v ~ N(centre, scale⁻²)` says of the count `n`; NaN where the mass cannot be had in floating point.
    pub(in crate::equations) fn guided_count(&self, n: f64, centre: f64, scale: f64) -> GuidedCount {
        let [low, high] = interval(self, n);
        let mass = normal::log_mass(scale * (low - centre), scale * (high - centre));
        let log_ratio = if mass.is_finite() { mass - self.log_density(n) } else { f64::NAN };
        GuidedCount { log_ratio, noise: centre.max(low).min(high) }
    }
}

/// Which `v` are transported to `n`.
fn interval(distribution: &Distribution<f64>, n: f64) -> [f64; 2] {
    let end = |n: f64| {
        let [below, above] = tails(distribution, n);
        if below <= above { -normal::from_log_upper(below.ln()) } else { normal::from_log_upper(above.ln()) }
    };
    let last = last(distribution);
    [
        if n == 0.0 || is_certain(distribution) { f64::NEG_INFINITY } else { end(n - 1.0) },
        if n == last || is_certain(distribution) { f64::INFINITY } else { end(n) },
    ]
}
