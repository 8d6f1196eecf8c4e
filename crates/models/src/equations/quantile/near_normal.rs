//! Counts on the scale of normal numbers, nearly.

use super::count::{self, Count, LARGEST, cornish_fisher};
use crate::elementary;
use crate::equations::draw::beyond_stirling_of_all;

/// Counts whose boundaries `b_n ≈ Φ⁻¹(P(X ≤ n))` have a formula: Peizer and Pratt's (Journal of the American Statistical Association 63, 1968), which is
/// right to a few thousandths where few are expected and nearly exact where many are, far out in the tails as well. They grow with `n`.
pub(in crate::equations) trait NearNormal: Count {
    /// `b_n` of a count from 0 to the last but one.
    fn boundary(self, n: f64) -> f64;

    /// How many are expected, or of binomial counts the smaller one of successes and failures; NaN, or below 0, for parameters out of range.
    fn fewest(self) -> f64;

    /// How many of [`NearNormal::factorials`] there are.
    const FACTORIALS: usize;

    /// The numbers whose remainders beyond Stirling's formula [`NearNormal::log_probability_by`] takes, then any.
    fn factorials(self, n: f64) -> [f64; 3];

    /// `log p(n)` of a possible count.
    fn log_probability_by(self, n: f64, remainders: [f64; 3]) -> f64;
}

/// Where fewer are expected there is no count but the mean's, as far as numbers go.
pub(super) const NONE: f64 = 1e-290;

/// `b_n`, which is infinite beyond the ends.
#[inline(always)]
pub(super) fn boundary(counts: impl NearNormal, n: f64) -> f64 {
    let inside = counts.boundary(n);
    let inside = if n >= counts.last() { f64::INFINITY } else { inside };
    if n < 0.0 { f64::NEG_INFINITY } else { inside }
}

/// `2 ((1 + e) log(1 + e) − e)/e²`, with `x = 1 + e`; 1 at `e = 0`.
#[inline(always)]
pub(in crate::equations) fn bend(e: f64, x: f64) -> f64 {
    let s = e / (2.0 + e);
    let near = (1.0 - s) * (1.0 + (1.0 + s) * s * elementary::artanh_series(s * s));
    let far = 2.0 * ((x / e) * elementary::ln(x) - 1.0) / e;
    if e.abs() < 0.25 { near } else { far }
}

/// `x log(x/mean) − x + mean`, the deviance, of which there is none at the mean.
#[inline(always)]
pub(in crate::equations) fn deviance(x: f64, mean: f64) -> f64 {
    let away = x - mean;
    0.5 * away * away * bend(away / mean, x / mean) / mean
}

/// `log p(n)` of possible counts.
#[inline(always)]
pub(super) fn log_probabilities<C: NearNormal, const W: usize>(
    of: impl Fn(usize) -> C,
    counts: &[f64; W],
) -> [f64; W] {
    let mut remainders = [[0.0; W]; 3];
    for (which, remainders) in remainders.iter_mut().take(C::FACTORIALS).enumerate() {
        for i in 0..W {
            remainders[i] = of(i).factorials(counts[i])[which];
        }
        *remainders = beyond_stirling_of_all(remainders);
    }
    let mut found = [0.0; W];
    for i in 0..W {
        found[i] = of(i).log_probability_by(counts[i], [0, 1, 2].map(|which| remainders[which][i]));
    }
    found
}

/// Rounds within which the count of every number is found: more than halving takes.
const ROUNDS: usize = 200;

/// From this round on steps halve what is left.
const HALVING: usize = 6;

/// The smallest counts with `b_n ≥ v`, and `b_{n−1}` and `b_n`. Of parameters out of range it is any number.
#[inline(always)]
pub(super) fn counts_at<C: NearNormal, const W: usize>(
    of: impl Fn(usize) -> C,
    v: &[f64; W],
) -> [[f64; W]; 3] {
    let [mut count, mut low, mut high, mut before, mut after] = [[0.0; W]; 5];
    for i in 0..W {
        let counts = of(i);
        let guess = cornish_fisher(counts.moments(), v[i]).floor();
        low[i] = -1.0;
        high[i] = if counts.last() < LARGEST { counts.last() } else { LARGEST };
        let guess = if guess > 0.0 { guess } else { 0.0 };
        count[i] = if guess < high[i] { guess } else { high[i] };
    }
    for round in 0..ROUNDS {
        let mut is_open = false;
        for i in 0..W {
            let counts = of(i);
            let n = count[i];
            (before[i], after[i]) = (boundary(counts, n - 1.0), boundary(counts, n));
            let (is_low, is_high) = (after[i] < v[i], before[i] >= v[i]);
            low[i] = if is_low { n } else { low[i] };
            high[i] = if is_high { n - 1.0 } else { high[i] };
            // As many counts further as boundaries are apart here, and one at least.
            let apart = after[i] - before[i];
            let up = ((v[i] - after[i]) / apart).ceil();
            let down = ((before[i] - v[i]) / apart).ceil();
            let up = n + if up > 1.0 { up } else { 1.0 };
            let down = n - if down > 1.0 { down } else { 1.0 };
            let middle = ((low[i] + 1.0 + high[i]) * 0.5).floor();
            let next = if is_low { up } else { down };
            let next = if round < HALVING { next } else { middle };
            let next = if next > low[i] + 1.0 { next } else { low[i] + 1.0 };
            let next = if next < high[i] { next } else { high[i] };
            let is_off = is_low | is_high;
            count[i] = if is_off { next } else { n };
            is_open |= is_off & (high[i] > low[i]);
        }
        if !is_open {
            break;
        }
    }
    [count, before, after]
}

/// From here on boundaries are within [`MARGIN`] of the exact ones, as far out as [`FAR`].
pub(super) const MANY: f64 = 100.0;
const FAR: f64 = 6.0;
pub(super) const MARGIN: f64 = 1e-3;

/// The count that `v` is transported to exactly; NaN where it cannot be had. Where many are expected the distribution function is asked only near boundaries.
pub(in crate::equations) fn from_normal(counts: impl NearNormal, v: f64) -> f64 {
    if counts.is_possible() && counts.fewest() >= MANY && counts.moments()[0] <= LARGEST && v.abs() < FAR {
        let [[count], [before], [after]] = counts_at(|_| counts, &[v]);
        if v - before > MARGIN && after - v > MARGIN {
            return count;
        }
    }
    count::from_normal(counts, v)
}
