//! Draws of the Poisson distribution.

use rand::RngExt;

use super::inversion::{MANY, MOST, count_up};
use super::needs::Needs;
use super::rejection::{Rejection, Try, UNDECIDED};
use super::squeeze::squeeze;
use super::stirling::{beyond_stirling, of_large};
use crate::Stream;
use crate::batch::by_widest_vectors;
use crate::elementary;
use crate::equations::functions::{exp, exp_of_all, ln};
use crate::gaussian::LN_2PI;

/// That with mean `a`: by inversion where it is below fifty, else by Hörmann's transformed rejection with a squeeze (Insurance: Mathematics and Economics 12, 1993).
pub(in crate::equations) struct Events;

/// The largest mean of a Poisson distribution for which counts are drawn: larger ones give counts that are no integers of 64 bits. Beyond it draws are NaN.
pub const LARGEST_POISSON: f64 = (1_u64 << 63) as f64;

/// What uniform numbers become: `⌊(2a/(½ − |u|) + b) u + c⌋`, and the share below which a try is accepted at once.
struct Hat {
    a: f64,
    b: f64,
    centre: f64,
    accepted: f64,
    /// What a share is multiplied by to be compared with `p(k)`.
    size: f64,
}

impl Hat {
    #[inline(always)]
    fn of(mean: f64) -> Self {
        let b = 0.931 + 2.53 * mean.sqrt();
        let a = -0.059 + 0.024_83 * b;
        let size = 1.1239 + 1.1328 / (b - 3.4);
        Hat { a, b, centre: mean + 0.43, accepted: 0.9277 - 3.6224 / (b - 2.0), size }
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
/// Below this depth nothing above it is accepted.
const SHALLOW: f64 = 0.013;

impl Rejection for Events {
    const NEEDS: Needs = Needs { uniforms: 2, ..Needs::NOTHING };

    #[inline(always)]
    fn quick<const W: usize>(mean: &[f64; W], _: &[f64; W], random: &Try<&[f64; W]>, drawn: &mut [f64; W]) {
        let [u, v] = random.uniforms;
        *drawn = [f64::NAN; W];
        let (mut none, mut any_many) = ([0.0; W], false);
        for i in 0..W {
            // Where many are expected there is nothing to count.
            none[i] = if mean[i] < MANY { -mean[i] } else { 0.0 };
            any_many |= mean[i] >= MANY;
        }
        if any_many {
            by_widest_vectors(
                #[inline(always)]
                || {
                    for i in 0..W {
                        let hat = Hat::of(mean[i]);
                        let [count, depth, of_depth] = hat.count(u[i] - 0.5);
                        let is_right = (mean[i] >= MANY) & (mean[i] <= LARGEST_POISSON);
                        let is_inside = (depth >= DEEP) & (v[i] <= hat.accepted);
                        let mode = mean[i].floor();
                        let away = (count - mode).abs();
                        let [below, above] = squeeze(away, mean[i]);
                        let bound = v[i] * hat.size / (hat.a * of_depth * of_depth + hat.b);
                        // log v/p(m), with Stirling's series for the mode's factorial.
                        let (next, inverse) = (mode + 1.0, 1.0 / (mode + 1.0));
                        let rest = next - mean[i];
                        let of_mode = mode * elementary::ln_1p(-rest * inverse) + rest - of_large(inverse);
                        let log = elementary::ln(bound * next.sqrt()) + 0.5 * LN_2PI - of_mode;
                        let is_near = away < 0.5 * mean[i] - 1.0;
                        let is_accepted = is_inside | (is_near & (log < below));
                        let is_rejected = (count < 0.0) | (is_near & (log > above));
                        let not_accepted = if is_rejected { f64::NAN } else { UNDECIDED };
                        let found = if is_accepted { count } else { not_accepted };
                        drawn[i] = if is_right { found } else { f64::NAN };
                    }
                },
            );
        }
        if mean.iter().any(|mean| *mean < MANY) {
            let none = exp_of_all(&none);
            by_widest_vectors(
                #[inline(always)]
                || {
                    let counts = count_up(*u, none, |_, inverse, i| mean[i] * inverse);
                    for i in 0..W {
                        let is_few = (mean[i] >= 0.0) & (mean[i] < MANY) & (counts[i] < MOST as f64);
                        drawn[i] = if is_few { counts[i] } else { drawn[i] };
                    }
                },
            );
        }
    }

    #[inline(always)]
    fn draw(mean: f64, _: f64, first: Try<f64>, stream: &mut Stream) -> f64 {
        if !(0.0..=LARGEST_POISSON).contains(&mean) {
            return f64::NAN;
        }
        if mean >= MANY {
            return many(mean, first.uniforms, stream);
        }
        // One that was not found by the first try is found by the next one.
        loop {
            let [count] = count_up([stream.random()], [exp(-mean)], |_, inverse, _| mean * inverse);
            if count < MOST as f64 {
                return count;
            }
        }
    }
}

/// A draw where many are expected, from its first uniform numbers on.
#[inline(always)]
fn many(mean: f64, [mut u, mut v]: [f64; 2], stream: &mut Stream) -> f64 {
    let hat = Hat::of(mean);
    loop {
        let [count, depth, of_depth] = hat.count(u - 0.5);
        if depth >= DEEP && v <= hat.accepted {
            return count;
        }
        if count >= 0.0 && (depth >= SHALLOW || v <= depth) {
            let bound = v * hat.size / (hat.a * of_depth * of_depth + hat.b);
            if ln(bound) <= log_probability(mean, count) {
                return count;
            }
        }
        [u, v] = [stream.random(), stream.random()];
    }
}

/// `log p(k)`. The logarithm is that of a ratio near 1, so that large counts lose no digits.
#[inline(always)]
fn log_probability(mean: f64, k: f64) -> f64 {
    let next = k + 1.0;
    // k log(mean) − mean − log k! by Stirling's formula.
    let away = next - mean;
    k * elementary::ln_1p(-away / next) + away - 0.5 * ln(next) - 0.5 * LN_2PI - beyond_stirling(k)
}
