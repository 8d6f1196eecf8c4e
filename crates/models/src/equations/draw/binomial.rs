//! Draws of the binomial distribution.

use rand::RngExt;

use super::inversion::{MANY, MOST, count_up};
use super::needs::Needs;
use super::rejection::{Rejection, Try, UNDECIDED};
use super::squeeze::squeeze;
use super::stirling::beyond_stirling;
use crate::Stream;
use crate::batch::by_widest_vectors;
use crate::elementary;
use crate::equations::functions::{exp, exp_of_all, ln};

/// Successes in `a` trials of probability `b`, by the smaller one of successes and failures: by inversion where fewer than fifty are expected, else by Hörmann's
/// transformed rejection with a squeeze (Journal of Statistical Computation and Simulation 46, 1993).
pub(in crate::equations) struct Successes;

/// The largest number of trials of a binomial distribution for which counts are drawn: from here on not every integer is a number. Beyond it draws are NaN.
pub const LARGEST_BINOMIAL: f64 = (1_u64 << 53) as f64;

/// The smaller probability of success and failure; NaN for parameters out of range.
#[inline(always)]
fn smaller(n: f64, p: f64) -> f64 {
    let is_right = (0.0..=LARGEST_BINOMIAL).contains(&n) & (n == n.floor()) & (0.0..=1.0).contains(&p);
    let smaller = if p > 0.5 { 1.0 - p } else { p };
    if is_right { smaller } else { f64::NAN }
}

/// What uniform numbers become: `⌊(2a/(½ − |u|) + b) u + c⌋`, and how tries are accepted.
struct Hat {
    a: f64,
    b: f64,
    centre: f64,
    /// A try that is deep inside is accepted below this share.
    accepted: f64,
    variance: f64,
    /// What a share is multiplied by to be compared with `p(k)/p(m)`.
    size: f64,
    /// The mode `m`.
    mode: f64,
    /// The distance from the mode within which probabilities are between the bounds of [`squeeze`].
    squeezed: f64,
}

impl Hat {
    #[inline(always)]
    fn of(n: f64, p: f64) -> Self {
        let mean = n * p;
        let variance = mean * (1.0 - p);
        let deviation = variance.sqrt();
        let b = 1.15 + 2.53 * deviation;
        let inverse = 1.0 / b;
        Hat {
            a: -0.0873 + 0.0248 * b + 0.01 * p,
            b,
            centre: mean + 0.5,
            accepted: 0.92 - 4.2 * inverse,
            variance,
            size: (2.83 + 5.1 * inverse) * deviation,
            mode: (mean + p).floor(),
            squeezed: 0.5 * variance - 1.0,
        }
    }

    /// The count of a uniform number from −½ to ½, how far this is from the nearer end, and the inverse of that.
    #[inline(always)]
    fn count(&self, u: f64) -> [f64; 3] {
        let depth = 0.5 - u.abs();
        let inverse = 1.0 / depth;
        [((2.0 * self.a * inverse + self.b) * u + self.centre).floor(), depth, inverse]
    }
}

/// Beyond this depth tries below [`Hat::accepted`] are accepted.
const DEEP: f64 = 0.07;

impl Rejection for Successes {
    const NEEDS: Needs = Needs { uniforms: 2, ..Needs::NOTHING };

    #[inline(always)]
    fn quick<const W: usize>(n: &[f64; W], p: &[f64; W], random: &Try<&[f64; W]>, drawn: &mut [f64; W]) {
        let [u, v] = random.uniforms;
        let mut small = [0.0; W];
        *drawn = [f64::NAN; W];
        let [any_few, any_many] = by_widest_vectors(
            #[inline(always)]
            || {
                let (mut any_few, mut any_many) = (false, false);
                for i in 0..W {
                    small[i] = smaller(n[i], p[i]);
                    let is_many = n[i] * small[i] >= MANY;
                    any_many |= is_many;
                    any_few |= !is_many;
                }
                [any_few, any_many]
            },
        );
        if any_many {
            by_widest_vectors(
                #[inline(always)]
                || {
                    for i in 0..W {
                        let hat = Hat::of(n[i], small[i]);
                        let [count, depth, inverse] = hat.count(u[i] - 0.5);
                        let is_inside = (depth >= DEEP) & (v[i] <= hat.accepted);
                        let away = (count - hat.mode).abs();
                        let [below, above] = squeeze(away, hat.variance);
                        let log = elementary::ln(v[i] * hat.size / (hat.a * inverse * inverse + hat.b));
                        let is_near = away < hat.squeezed;
                        let is_accepted = is_inside | (is_near & (log < below));
                        let is_rejected = (count < 0.0) | (count > n[i]) | (is_near & (log > above));
                        let not_accepted = if is_rejected { f64::NAN } else { UNDECIDED };
                        let found = if is_accepted { count } else { not_accepted };
                        drawn[i] = if n[i] * small[i] >= MANY { found } else { f64::NAN };
                    }
                },
            );
        }
        if any_few {
            let (mut none, mut odds) = ([0.0; W], [0.0; W]);
            by_widest_vectors(
                #[inline(always)]
                || {
                    for i in 0..W {
                        let log = n[i] * elementary::ln_1p(-small[i]);
                        // Where many are expected there is nothing to count.
                        none[i] = if n[i] * small[i] < MANY { log } else { 0.0 };
                        odds[i] = small[i] / (1.0 - small[i]);
                    }
                },
            );
            let none = exp_of_all(&none);
            by_widest_vectors(
                #[inline(always)]
                || {
                    let counts = count_up(*u, none, |k, inverse, i| (n[i] - (k - 1.0)) * inverse * odds[i]);
                    for i in 0..W {
                        let is_few = (n[i] * small[i] < MANY) & (counts[i] < MOST as f64);
                        drawn[i] = if is_few { counts[i] } else { drawn[i] };
                    }
                },
            );
        }
        for i in 0..W {
            drawn[i] = if (p[i] > 0.5) & (drawn[i] >= 0.0) { n[i] - drawn[i] } else { drawn[i] };
        }
    }

    #[inline(always)]
    fn draw(n: f64, p: f64, first: Try<f64>, stream: &mut Stream) -> f64 {
        let small = smaller(n, p);
        if small.is_nan() {
            return f64::NAN;
        }
        let count = match n * small < MANY {
            // One that was not found by the first try is found by the next one.
            true => loop {
                let none = exp(n * elementary::ln_1p(-small));
                let odds = small / (1.0 - small);
                let [count] =
                    count_up([stream.random()], [none], |k, inverse, _| (n - (k - 1.0)) * inverse * odds);
                if count < MOST as f64 {
                    break count;
                }
            },
            false => many(n, small, first.uniforms, stream),
        };
        if p > 0.5 { n - count } else { count }
    }
}

/// A draw where many are expected and half of the trials at most, from its first uniform numbers on.
#[inline(always)]
fn many(n: f64, p: f64, [mut u, mut v]: [f64; 2], stream: &mut Stream) -> f64 {
    let hat = Hat::of(n, p);
    loop {
        let [count, depth, inverse] = hat.count(u - 0.5);
        if depth >= DEEP && v <= hat.accepted {
            return count;
        }
        if count >= 0.0 && count <= n {
            let bound = v * hat.size / (hat.a * inverse * inverse + hat.b);
            if is_below_share_of_mode(ln(bound), n, p, &hat, count) {
                return count;
            }
        }
        [u, v] = [stream.random(), stream.random()];
    }
}

/// Whether a logarithm is at most `log p(k)/p(m)`; the squeeze spares nearly all logarithms of factorials.
#[inline(always)]
fn is_below_share_of_mode(log: f64, n: f64, p: f64, hat: &Hat, count: f64) -> bool {
    let away = (count - hat.mode).abs();
    if away < hat.squeezed {
        let [below, above] = squeeze(away, hat.variance);
        if log < below {
            return true;
        }
        if log > above {
            return false;
        }
    }
    log <= log_share_of_mode(n, p, hat.mode, count)
}

/// `log p(k)/p(m)`. Differences of logarithms are those of ratios near 1, so that large counts lose no digits.
#[inline(always)]
fn log_share_of_mode(n: f64, p: f64, m: f64, k: f64) -> f64 {
    let (of_mode, of_count) = (n - m + 1.0, n - k + 1.0);
    let away = k - m;
    away * ln(of_count / (k + 1.0) * (p / (1.0 - p))) + (of_mode - 0.5) * elementary::ln_1p(away / of_count)
        - (m + 0.5) * elementary::ln_1p(away / (m + 1.0))
        + beyond_stirling(m)
        + beyond_stirling(n - m)
        - beyond_stirling(k)
        - beyond_stirling(n - k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    /// Catches a squeeze that decides what the probabilities do not say, and a product of other ratios.
    #[test]
    fn squeezes_decide_as_probabilities_do() {
        for (n, p) in [
            (100.0, 0.5),
            (120.0, 0.45),
            (5000.0, 0.0101),
            (1e5, 0.3),
            (1e9, 0.2),
            (3e13, 0.5),
            (3e13, 2e-12),
        ] {
            let hat = Hat::of(n, p);
            let mode = hat.mode;
            for steps in -600..=600 {
                let count = (mode + f64::from(steps) / 80.0 * hat.variance.sqrt()).round();
                if count < 0.0 || count > n {
                    continue;
                }
                let log = log_share_of_mode(n, p, mode, count);
                for off in [-1.0, -0.1, -1e-3, -1e-6, 1e-6, 1e-3, 0.1, 1.0] {
                    let found = is_below_share_of_mode(log + off, n, p, &hat, count);
                    assert_eq!(found, off < 0.0, "n {n}, p {p}, {count} of {mode}, {off}");
                }
            }
        }
    }

    #[test]
    fn shares_of_the_mode_are_ratios_of_probabilities() {
        let (n, p) = (60.0, 0.3);
        let mode = 18.0;
        let mut log: f64 = 0.0;
        for k in 19..=60 {
            log += ((n + 1.0 - f64::from(k)) / f64::from(k) * (p / (1.0 - p))).ln();
            let found = log_share_of_mode(n, p, mode, f64::from(k));
            assert!((found - log).abs() < 1e-9, "{k}: {found} for {log}");
        }
    }

    #[test]
    fn counts_at_the_ends_of_all_parameters() {
        let mut stream = Seed::from_u64(1).stream();
        let random = Try { normal: 0.0, uniforms: [0.5, 0.99] };
        let mut drawn = |n, p| Successes::draw(n, p, random, &mut stream);
        assert_eq!(
            [drawn(0.0, 0.3), drawn(7.0, 0.0), drawn(7.0, 1.0), drawn(1e15, 1.0)],
            [0.0, 0.0, 7.0, 1e15]
        );
        for (n, p) in
            [(2.5, 0.3), (-1.0, 0.3), (3.0, 1.1), (3.0, -0.1), (f64::NAN, 0.5), (3.0, f64::NAN), (1e16, 0.5)]
        {
            assert!(drawn(n, p).is_nan(), "{n}, {p}");
        }
        for p in [1e-300, 1e-12, 0.5, 1.0 - 1e-12] {
            let found = drawn(9e15, p);
            let error = (9e15 * p * (1.0 - p)).sqrt();
            assert!((found - 9e15 * p).abs() <= 6.0 * error + 1.0, "{p}: {found}");
        }
    }
}
