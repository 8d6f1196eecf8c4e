//! Counts as transports of a standard normal number: the smallest count whose distribution function reaches `Φ(v)`.

use super::normal;
use crate::equations::family::Family;
use crate::equations::scalar::Scalar;

/// Counts, of which the distribution function is a sum.
pub(in crate::equations) trait Count: Family<f64> {
    /// Whether parameters are in range, as far as moments do not show it.
    fn is_possible(self) -> bool {
        true
    }

    /// `p(n + 1) / p(n)`.
    fn ratio(self, n: f64) -> f64;

    /// The largest count that there can be.
    fn last(self) -> f64 {
        f64::INFINITY
    }

    /// Whether there is but one count.
    fn is_certain(self) -> bool;

    /// `p(n)`.
    fn probability(self, n: f64) -> f64 {
        log_probability(self, n).exp()
    }
}

/// `log p(n)`.
fn log_probability(counts: impl Count, n: f64) -> f64 {
    counts.log_density(n, || Scalar::ln_gamma(n + 1.0))
}

/// From here on not every integer is a number.
pub(in crate::equations) const LARGEST: f64 = (1_u64 << 53) as f64;

/// Terms that a tail may have: beyond, a count is too spread out to be had in floating point, and in any time.
const MOST_TERMS: usize = 2_000_000;

/// `P(X ≤ n)` and `P(X > n)` of a count, the smaller one from its own end; NaN where there are too many terms.
///
/// A continued fraction of the incomplete beta function takes as many steps at large parameters as there are terms here.
fn tails(counts: impl Count, n: f64) -> [f64; 2] {
    let [mean, _] = counts.moments();
    let is_upper = n >= mean;
    let (mut at, mut term, mut sum) =
        if is_upper { (n + 1.0, counts.probability(n + 1.0), 0.0) } else { (n, counts.probability(n), 0.0) };
    for _ in 0..MOST_TERMS {
        sum += term;
        if term.is_nan() || term <= sum * (0.01 * f64::EPSILON) {
            let sum: f64 = if sum.is_nan() { sum } else { sum.min(1.0) };
            return if is_upper { [1.0 - sum, sum] } else { [sum, 1.0 - sum] };
        }
        if is_upper {
            term *= counts.ratio(at);
            at += 1.0;
        } else {
            at -= 1.0;
            term = if at < 0.0 { 0.0 } else { term / counts.ratio(at) };
        }
    }
    [f64::NAN; 2]
}

/// `log P(X ≤ n)`, or `log P(X > n)`: the tail beyond which the mean does not lie.
fn log_tail(counts: impl Count, n: f64, is_upper: bool) -> f64 {
    let (mut at, mut term, mut sum) = (if is_upper { n + 1.0 } else { n }, 1.0_f64, 0.0);
    let first = log_probability(counts, at);
    for _ in 0..MOST_TERMS {
        sum += term;
        if term.is_nan() || term <= sum * (0.01 * f64::EPSILON) {
            return first + sum.ln();
        }
        if is_upper {
            term *= counts.ratio(at);
            at += 1.0;
        } else {
            at -= 1.0;
            term = if at < 0.0 { 0.0 } else { term / counts.ratio(at) };
        }
    }
    f64::NAN
}

/// So few counts are added up one by one.
const FEW: f64 = 40.0;

/// `log P(low < X ≤ high)`.
pub(in crate::equations) fn log_mass(counts: impl Count, low: f64, high: f64) -> f64 {
    let [mean, _] = counts.moments();
    // A parameter that is out of range.
    if !counts.is_possible() || counts.probability(0.0).is_nan() || low.is_nan() || high.is_nan() {
        return f64::NAN;
    }
    let (low, high) = (Scalar::max(low.floor(), -1.0), Scalar::min(high.floor(), counts.last()));
    if low >= high {
        return f64::NEG_INFINITY;
    }
    if counts.is_certain() {
        return if low < mean && mean <= high { 0.0 } else { f64::NEG_INFINITY };
    }
    if high - low <= FEW {
        let all = (1..=(high - low) as usize).map(|more| log_probability(counts, low + more as f64));
        let largest = all.clone().fold(f64::NEG_INFINITY, f64::max);
        return if largest.is_infinite() {
            largest
        } else {
            largest + all.map(|log| (log - largest).exp()).sum::<f64>().ln()
        };
    }
    let below = |n: f64| if n < 0.0 { f64::NEG_INFINITY } else { log_tail(counts, n, false) };
    let above = |n: f64| if n >= counts.last() { f64::NEG_INFINITY } else { log_tail(counts, n, true) };
    let less = |whole: f64, part: f64| whole + (-(part - whole).exp()).ln_1p();
    match (low < mean, high < mean) {
        (true, true) => less(below(high), below(low)),
        (false, _) => less(above(low), above(high)),
        _ => (-(below(low).exp() + above(high).exp())).ln_1p(),
    }
}

/// The derivative of [`log_mass`] along a parameter, for which that of `P(X ≤ n)` is `p(n)` times a factor.
pub(in crate::equations) fn slope(
    counts: impl Count,
    [low, high]: [f64; 2],
    log_mass: f64,
    factor: impl Fn(f64) -> f64,
) -> f64 {
    let at = |n: f64| {
        let n = n.floor();
        let is_end = n < 0.0 || n >= counts.last() || log_mass == f64::NEG_INFINITY;
        if is_end { 0.0 } else { factor(n) * (log_probability(counts, n) - log_mass).exp() }
    };
    at(high) - at(low)
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

/// Cornish and Fisher's approximation of the count that `v` is transported to: the third cumulant of these counts is variance·(2·variance/mean − 1).
#[inline(always)]
pub(super) fn cornish_fisher([mean, variance]: [f64; 2], v: f64) -> f64 {
    let skewed = (2.0 * variance / mean - 1.0) * (v * v - 1.0) / 6.0;
    mean + variance.sqrt() * v + skewed
}

/// The count that `v` is transported to; none where a parameter is out of range, or where it cannot be had in floating point.
fn transported(counts: impl Count, v: f64) -> Option<CountTails> {
    if !counts.is_possible() {
        return None;
    }
    let [mean, variance] = counts.moments();
    if counts.is_certain() {
        return Some(CountTails { count: mean, before: NOTHING_BELOW, after: NOTHING_ABOVE });
    }
    let most = counts.last();
    let guess = cornish_fisher([mean, variance], v);
    if guess.is_nan() || guess.abs() > LARGEST {
        return None;
    }
    let target = normal::log_upper(v.abs());
    // The tails at n, and whether P(X ≤ n) ≥ Φ(v), by the smaller of both.
    let reaches = |n: f64| {
        if n >= most {
            return Some((true, NOTHING_ABOVE));
        }
        let [below, above] = tails(counts, n);
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
pub(in crate::equations) fn from_normal(counts: impl Count, v: f64) -> f64 {
    transported(counts, v).map_or(f64::NAN, |found| found.count)
}

/// The count that `v` is transported to, `log Q(n) − log p(n)` with the mass `Q(n)` that the Gaussian `N(centre, scale⁻²)` has of the `v` that are transported to `n`, and the
/// most likely of these; NaN where it cannot be had in floating point.
pub(in crate::equations) fn guided(counts: impl Count, v: f64, centre: f64, scale: f64) -> [f64; 3] {
    let Some(found) = transported(counts, v) else { return [f64::NAN; 3] };
    let (count, own) = (found.count, log_probability(counts, found.count));
    let [low, high] = found.interval(counts.moments()[0], own.exp());
    let mass = normal::log_mass(scale * (low - centre), scale * (high - centre));
    let log_ratio = if mass.is_finite() { mass - own } else { f64::NAN };
    [count, log_ratio, centre.max(low).min(high)]
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
    use crate::equations::distribution::NegativeBinomial;

    /// Whatever the Gaussian is, it gives all counts together the mass 1.
    #[test]
    fn masses_of_all_counts_add_up_to_one() {
        let counts = NegativeBinomial { mean: 6.0, size: 1.5 };
        for (centre, scale) in [(0.0, 1.0), (1.3, 4.0), (-2.0, 0.7)] {
            // Of each count that any noise is transported to.
            let (mut sum, mut last) = (0.0, -1.0);
            for v in (0..=14_000).map(|i| -14.0 + 2e-3 * f64::from(i)) {
                let [count, log_ratio, _] = guided(counts, v, centre, scale);
                if count > last {
                    last = count;
                    sum += (log_ratio + log_probability(counts, count)).exp();
                }
            }
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        }
        let [_, log_ratio, _] = guided(counts, 0.3, 0.0, 1.0);
        assert!(log_ratio.abs() < 1e-12, "the noise's own distribution: {log_ratio}");
    }

    /// Catches a distribution function whose series ends too early.
    #[test]
    fn masses_of_large_counts_are_their_probabilities() {
        let counts = NegativeBinomial { mean: 1e5, size: 1e5 };
        for v in [-5.0, -1.2, -0.01, 0.3, 4.0] {
            let [n, log_ratio, _] = guided(counts, v, 0.0, 1.0);
            let [mean, variance] = counts.moments();
            // Nearly normal, but for its skewness.
            assert!((n - mean - variance.sqrt() * v).abs() < 0.2 * variance.sqrt(), "{n}");
            assert!(log_ratio.abs() < 1e-6, "{v}: {log_ratio}");
        }
    }
}
