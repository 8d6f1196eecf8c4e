//! The tail of the standard normal distribution and its inverse, by logarithms: neither loses digits far out.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2};

use special::Error;

use super::root::root;
use crate::equations::scalar::Scalar;
use crate::gaussian::LN_2PI;

/// From here on the tail's expansion has all digits; further out the tail itself is no number any more.
const FAR: f64 = 35.0;

/// The standard normal quantile `v = Φ⁻¹(p)`: the number that a share `p` of a standard normal distribution lies below. −∞ at 0, ∞ at 1, NaN for what is no
/// probability.
///
/// ```
/// use motes_models::equations::{Scalar, normal_quantile};
///
/// let v = normal_quantile(0.95);
/// assert!((v - 1.6448536269514722).abs() < 1e-14);
/// assert!((v.normal_cdf() - 0.95).abs() < 1e-15);
/// assert!(normal_quantile(0.5).abs() < 1e-15);
/// ```
pub fn normal_quantile(p: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    // From the end that is nearer: the smaller share has the digits.
    if p < 0.5 { -from_log_upper(p.ln()) } else { from_log_upper((1.0 - p).ln()) }
}

/// `log φ(v)`.
pub(in crate::equations) fn log_density(v: f64) -> f64 {
    -0.5 * v * v - 0.5 * LN_2PI
}

/// `1 − Φ(v)`.
pub(in crate::equations) fn upper(v: f64) -> f64 {
    (-v).normal_cdf()
}

/// `log(1 − Φ(v))`.
pub(in crate::equations) fn log_upper(v: f64) -> f64 {
    if v < 0.0 {
        (-upper(-v)).ln_1p()
    } else if v < FAR {
        upper(v).ln()
    } else {
        let w = 1.0 / (v * v);
        let series = -w * (1.0 - 3.0 * w * (1.0 - 5.0 * w * (1.0 - 7.0 * w)));
        log_density(v) - v.ln() + series.ln_1p()
    }
}

/// `log(Φ(high) − Φ(low))`.
pub(in crate::equations) fn log_mass(low: f64, high: f64) -> f64 {
    if low > 0.0 {
        let [whole, beyond] = [low, high].map(log_upper);
        whole + (-(beyond - whole).exp()).ln_1p()
    } else if high < 0.0 {
        log_mass(-high, -low)
    } else {
        (-(upper(high) + upper(-low))).ln_1p()
    }
}

/// `−log 2(1 − Φ(v))` for `v ≥ 0`, with all digits near 0.
pub(in crate::equations) fn depth(v: f64) -> f64 {
    if v < 1.0 { -(-(v * FRAC_1_SQRT_2).error()).ln_1p() } else { -log_upper(v) - LN_2 }
}

/// The `v` with `log(1 − Φ(v)) = log`; NaN for a number above 0.
pub(in crate::equations) fn from_log_upper(log: f64) -> f64 {
    // The other tail is the smaller one where this one has more than half; a logarithm above 0 becomes NaN.
    if log > -LN_2 { -of_small_tail((-log.exp_m1()).ln()) } else { of_small_tail(log) }
}

/// [`from_log_upper`] of a logarithm that is not above `log ½`.
fn of_small_tail(log: f64) -> f64 {
    if log == f64::NEG_INFINITY {
        return f64::INFINITY;
    }
    // Hastings' approximation (Abramowitz and Stegun, 26.2.23) is within 5e-4.
    let t = (-2.0 * log).sqrt();
    let above = 2.515517 + t * (0.802853 + t * 0.010328);
    let below = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    root(t - above / below, 1.0, |v| {
        let tail = log_upper(v);
        // Far out the hazard is v, and the difference of two large logarithms is not.
        let hazard = if v > 1e3 { v } else { (log_density(v) - tail).exp() };
        [tail - log, -hazard, hazard - v]
    })
}
