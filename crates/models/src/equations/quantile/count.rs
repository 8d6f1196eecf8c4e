//! Counts as transports of a standard normal number: the smallest count whose distribution function reaches `Φ(v)`.

use super::normal;
use crate::equations::distribution::Distribution;

/// From here on not every integer is a number.
const LARGEST: f64 = (1_u64 << 53) as f64;

/// Terms that a tail may have: beyond, a count is too spread out to be had in floating point, and in any time.
const MOST_TERMS: usize = 2_000_000;

/// `p(n + 1) / p(n)` of a count.
fn ratio(distribution: &Distribution<f64>, n: f64) -> f64 {
    match *distribution {
        Distribution::Poisson { mean } => mean / (n + 1.0),
        Distribution::NegativeBinomial { mean, size } => (n + size) / (n + 1.0) * (mean / (mean + size)),
        Distribution::Binomial { n: trials, p } => (trials - n) / (n + 1.0) * (p / (1.0 - p)),
        _ => f64::NAN,
    }
}

/// `P(X ≤ n)` and `P(X > n)` of a count, the smaller one from its own end; NaN where there are too many terms.
///
/// A continued fraction of the incomplete beta function takes as many steps at large parameters as there are terms here.
fn tails(distribution: &Distribution<f64>, n: f64) -> [f64; 2] {
    let [mean, _] = distribution.moments();
    let is_upper = n >= mean;
    let (mut at, mut term, mut sum) = if is_upper {
        (n + 1.0, distribution.log_density(n + 1.0).exp(), 0.0)
    } else {
        (n, distribution.log_density(n).exp(), 0.0)
    };
    for _ in 0..MOST_TERMS {
        sum += term;
        if term.is_nan() || term <= sum * (0.01 * f64::EPSILON) {
            let sum: f64 = if sum.is_nan() { sum } else { sum.min(1.0) };
            return if is_upper { [1.0 - sum, sum] } else { [sum, 1.0 - sum] };
        }
        if is_upper {
            term *= ratio(distribution, at);
            at += 1.0;
        } else {
            at -= 1.0;
            term = if at < 0.0 { 0.0 } else { term / ratio(distribution, at) };
        }
    }
    [f64::NAN; 2]
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
        Distribution::Poisson { mean } => mean == 0.0,
        Distribution::NegativeBinomial { mean, size } => mean == 0.0 && size > 0.0,
        Distribution::Binomial { n, p } => n == 0.0 || p == 0.0 || p == 1.0,
        _ => false,
    }
}

/// A count, and the tails `P(X ≤ m)` and `P(X > m)` on both of its sides.
struct CountTails {
    count: f64,
    /// At `m = count − 1`.
    before: [f64; 2],
    /// At `m = count`.
    after: [f64; 2],
}

/// The tails where there is nothing below, and where there is nothing above.
const NOTHING_BELOW: [f64; 2] = [0.0, 1.0];
const NOTHING_ABOVE: [f64; 2] = [1.0, 0.0];

/// The count that `v` is transported to; none where a parameter is out of range, or where it cannot be had in floating point.
fn transported(distribution: &Distribution<f64>, v: f64) -> Option<CountTails> {
    if let Distribution::Binomial { n, p } = *distribution
        && !((0.0..=LARGEST).contains(&n) && n.fract() == 0.0 && (0.0..=1.0).contains(&p))
    {
        return None;
    }
    let [mean, variance] = distribution.moments();
    if is_certain(distribution) {
        return Some(CountTails { count: mean, before: NOTHING_BELOW, after: NOTHING_ABOVE });
    }
    let most = last(distribution);
    // Cornish and Fisher's approximation: the third cumulant of these is variance·(2·variance/mean − 1).
    let skewed = (2.0 * variance / mean - 1.0) * (v * v - 1.0) / 6.0;
    let guess = mean + variance.sqrt() * v + skewed;
    if guess.is_nan() || guess.abs() > LARGEST {
        return None;
    }
    let target = normal::log_upper(v.abs());
    // The tails at n, and whether P(X ≤ n) ≥ Φ(v), by the smaller of both.
    let reaches = |n: f64| {
        if n >= most {
            return Some((true, NOTHING_ABOVE));
        }
        let [below, above] = tails(distribution, n);
        let (reaches, tail) =
            if v <= 0.0 { (below.ln() >= target, below) } else { (above.ln() <= target, above) };
        (!tail.is_nan()).then_some((reaches, [below, above]))
    };
    // Between a count that does not reach it and one that does.
    let (mut low, mut before) = (-1.0, NOTHING_BELOW);
    let (mut high, mut width) = (guess.round().clamp(0.0, most), 1.0);
    let mut after = loop {
        match reaches(high)? {
            (true, found) => break found,
            (false, found) => {
                (low, before) = (high, found);
                high = (high + width).min(most);
                width *= 2.0;
            }
        }
        if high > LARGEST {
            return None;
        }
    };
    width = 1.0;
    while high - low > 1.0 {
        // From above in growing steps, then by halves.
        let middle = if low < high - width { high - width } else { ((low + high) / 2.0).floor() };
        let middle = middle.max(low + 1.0).max(0.0);
        match reaches(middle)? {
            (true, found) => {
                (high, after) = (middle, found);
                width *= 2.0;
            }
            (false, found) => {
                (low, before) = (middle, found);
                width = f64::INFINITY;
            }
        }
    }
    Some(CountTails { count: high, before, after })
}

/// The count that `v` is transported to; NaN where it cannot be had.
pub(super) fn from_normal(distribution: &Distribution<f64>, v: f64) -> f64 {
    transported(distribution, v).map_or(f64::NAN, |found| found.count)
}

/// What a Gaussian of its noise says of a count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::equations) struct GuidedCount {
    pub(in crate::equations) count: f64,
    /// `log Q(n) − log p(n)`, where `Q(n)` is the Gaussian's mass of the `v` that are transported to `n`.
    pub(in crate::equations) log_ratio: f64,
    /// The most likely of these `v`.
    pub(in crate::equations) noise: f64,
}

impl Distribution<f64> {
    /// The count that `v` is transported to, and what the Gaussian `N(centre, scale⁻²)` of `v` says of it; NaN where it cannot be had in floating point.
    pub(in crate::equations) fn guided_count(&self, v: f64, centre: f64, scale: f64) -> GuidedCount {
        let Some(found) = transported(self, v) else {
            return GuidedCount { count: f64::NAN, log_ratio: f64::NAN, noise: f64::NAN };
        };
        let (count, own) = (found.count, self.log_density(found.count));
        let [low, high] = found.interval(self.moments()[0], own.exp());
        let mass = normal::log_mass(scale * (low - centre), scale * (high - centre));
        let log_ratio = if mass.is_finite() { mass - own } else { f64::NAN };
        GuidedCount { count, log_ratio, noise: centre.max(low).min(high) }
    }
}

impl CountTails {
    /// Which `v` are transported to the count, of which `own` is the probability.
    ///
    /// One tail gives both ends: what the count adds to it is its own probability, with whatever rounding that has.
    fn interval(&self, mean: f64, own: f64) -> [f64; 2] {
        let end = |[below, above]: [f64; 2]| {
            if below <= above {
                -normal::from_log_upper(below.ln())
            } else {
                normal::from_log_upper(above.ln())
            }
        };
        let CountTails { count, before, after } = *self;
        let is_last = after == NOTHING_ABOVE;
        let [before, after] = match count < mean {
            true if !is_last => [before, [before[0] + own, before[1] - own]],
            false if before != NOTHING_BELOW => [[after[0] - own, after[1] + own], after],
            _ => [before, after],
        };
        [end(before), end(after)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::{binomial, negative_binomial, poisson};

    fn counts() -> [Distribution<f64>; 5] {
        [poisson(0.3), poisson(40.0), negative_binomial(6.0, 1.5), binomial(15.0, 0.2), binomial(1.0, 0.9)]
    }

    #[test]
    fn noise_is_transported_to_the_smallest_count_that_reaches_it() {
        for distribution in counts() {
            for v in [-6.0, -2.3, -0.4, 0.0, 0.8, 2.9, 5.5] {
                let (mut n, mut below) = (0.0, distribution.log_density(0.0).exp());
                // Φ(v) by its smaller tail; sums from 0 on are exact enough for these.
                let reached = if v < 0.0 { normal::upper(-v) } else { 1.0 - normal::upper(v) };
                while below < reached - 1e-13 {
                    n += 1.0;
                    below += distribution.log_density(n).exp();
                }
                let found = from_normal(&distribution, v);
                assert_eq!(found, n, "{distribution:?} at {v}");
            }
        }
    }

    /// Whatever the Gaussian is, it gives all counts together the mass 1.
    #[test]
    fn masses_of_all_counts_add_up_to_one() {
        for distribution in counts() {
            for (centre, scale) in [(0.0, 1.0), (1.3, 4.0), (-2.0, 0.7)] {
                // Of each count that any noise is transported to.
                let (mut sum, mut count) = (0.0, -1.0);
                for v in (0..=14_000).map(|i| -14.0 + 2e-3 * f64::from(i)) {
                    let guided = distribution.guided_count(v, centre, scale);
                    if guided.count > count {
                        count = guided.count;
                        sum += (guided.log_ratio + distribution.log_density(count)).exp();
                    }
                }
                assert!((sum - 1.0).abs() < 1e-9, "{distribution:?}: {sum}");
            }
            let prior = distribution.guided_count(0.3, 0.0, 1.0);
            assert!(prior.log_ratio.abs() < 1e-12, "the noise's own distribution: {prior:?}");
        }
    }

    /// Catches a distribution function whose series ends too early.
    #[test]
    fn masses_of_large_counts_are_their_probabilities() {
        for distribution in
            [binomial(1e7, 0.3), poisson(3e6), negative_binomial(1e5, 1e5), binomial(1e6, 0.999)]
        {
            for v in [-5.0, -1.2, -0.01, 0.3, 4.0] {
                let n = from_normal(&distribution, v);
                let [mean, variance] = distribution.moments();
                // Nearly normal, but for its skewness.
                assert!(
                    (n - mean - variance.sqrt() * v).abs() < 0.2 * variance.sqrt(),
                    "{distribution:?}: {n}"
                );
                let found = distribution.guided_count(v, 0.0, 1.0);
                assert_eq!(found.count, n);
                assert!(found.log_ratio.abs() < 1e-6, "{distribution:?} at {v}: {found:?}");
            }
        }
    }

    #[test]
    fn a_count_that_floating_point_does_not_have_is_none() {
        assert!(from_normal(&negative_binomial(0.0, -1.0), 0.0).is_nan());
        assert!(from_normal(&poisson(1e17), 0.0).is_nan());
        assert!(from_normal(&binomial(2.5, 0.5), 0.0).is_nan());
        assert!(from_normal(&binomial(3.0, 1.5), 0.0).is_nan());
        assert!(from_normal(&poisson(-1.0), 0.0).is_nan());
        assert_eq!(from_normal(&poisson(0.0), 3.0), 0.0);
        assert_eq!(from_normal(&binomial(7.0, 1.0), -3.0), 7.0);
    }
}
