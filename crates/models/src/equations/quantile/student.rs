//! Student's t as a transport of a standard normal number.
//!
//! All is said in `s = asinh(t/√df)`, whose density is `c·cosh^{−df} s`: log-concave, with a tail `e^{−df·s}` whatever `df` is.

use std::f64::consts::{LN_2, PI};

use statrs::function::beta::checked_beta_reg;

use super::normal;
use super::root::root;
use crate::equations::scalar::Scalar;

/// From so many degrees of freedom on, the Cornish–Fisher expansion has all digits that are asked for.
const MANY: f64 = 1e4;

/// Beyond this `cosh s` is `eˢ/2` to the last digit.
const FAR: f64 = 20.0;

/// Beyond this the expansion is given up for Wallace's approximation, which grows for any number.
const OUTSIDE: f64 = 40.0;

/// Nearer to the centre than this, a cubic has all digits.
const NEAR: f64 = 1e-3;

/// `log c`, `c = Γ((df+1)/2) / (Γ(df/2) √π)`.
fn log_constant(df: f64) -> f64 {
    Scalar::ln_gamma(0.5 * (df + 1.0)) - Scalar::ln_gamma(0.5 * df) - 0.5 * PI.ln()
}

/// `log cosh s` for `s ≥ 0`.
fn log_cosh(s: f64) -> f64 {
    if s > FAR { s - LN_2 } else { s.cosh().ln() }
}

/// `log P(S > s)` for `s ≥ 0`; `constant` is [`log_constant`].
fn log_tail(df: f64, constant: f64, s: f64) -> f64 {
    if s > FAR {
        return constant + df * LN_2 - df.ln() - df * s;
    }
    let share = |a: f64, b: f64, x: f64| checked_beta_reg(a, b, x).unwrap_or(f64::NAN);
    let (sine, slope) = (s.sinh(), s.tanh());
    // Each side by the fraction that converges there and takes nothing off 1.
    if df * sine * sine < 3.0 {
        return (0.5 - 0.5 * share(0.5, 0.5 * df, slope * slope)).ln();
    }
    let tail = 0.5 * share(0.5 * df, 0.5, s.cosh().powi(-2));
    // Where it is too small for a number, the first term of its expansion.
    if tail > f64::MIN_POSITIVE { tail.ln() } else { constant - df * log_cosh(s) - (df * slope).ln() }
}

/// `t` and `dt/dv`, by the expansion in `1/df` (Abramowitz and Stegun, 26.7.5).
fn expansion(df: f64, v: f64) -> [f64; 2] {
    let (w, by) = (v * v, 1.0 / df);
    let sum =
        |[a, b, c, d]: [f64; 4]| 1.0 + by * (a / 4.0 + by * (b / 96.0 + by * (c / 384.0 + by * d / 92160.0)));
    let value = sum([
        w + 1.0,
        (5.0 * w + 16.0) * w + 3.0,
        ((3.0 * w + 19.0) * w + 17.0) * w - 15.0,
        (((79.0 * w + 776.0) * w + 1482.0) * w - 1920.0) * w - 945.0,
    ]);
    let slope = sum([
        3.0 * w + 1.0,
        (25.0 * w + 48.0) * w + 3.0,
        ((21.0 * w + 95.0) * w + 51.0) * w - 15.0,
        (((711.0 * w + 5432.0) * w + 7410.0) * w - 5760.0) * w - 945.0,
    ]);
    [v * value, slope]
}

/// `2 log cosh s` of `v`, about: Wallace's approximation.
fn wallace(df: f64, v: f64) -> f64 {
    (v * (8.0 * df + 3.0) / (8.0 * df + 1.0)).powi(2) / df
}

/// `v` of `s ≥ 0`, by the same approximation.
fn from_wallace(df: f64, s: f64) -> f64 {
    (2.0 * df * log_cosh(s)).sqrt() * (8.0 * df + 1.0) / (8.0 * df + 3.0)
}

/// `t` and `log dt/dv` for many degrees of freedom.
fn of_many(df: f64, v: f64) -> [f64; 2] {
    if v.abs() < OUTSIDE {
        let [t, slope] = expansion(df, v);
        return [t, slope.ln()];
    }
    let twice = wallace(df, v);
    let sine = (0.5 * twice).exp().acosh().sinh();
    [(df.sqrt() * sine).copysign(v), 0.5 * df.ln() + twice - sine.ln() + (twice / v.abs()).ln()]
}

/// The standard `t` of a standard normal `v`, and `log dt/dv`; NaN for degrees of freedom that are out of range.
pub(in crate::equations) fn from_normal(df: f64, v: f64) -> [f64; 2] {
    if !(df > 0.0 && df < f64::INFINITY) || v.is_nan() {
        return [f64::NAN; 2];
    }
    if df >= MANY {
        return of_many(df, v);
    }
    let size = v.abs();
    if size == f64::INFINITY {
        return [v, f64::INFINITY];
    }
    let constant = log_constant(df);
    let centre = (normal::log_density(0.0) - constant).exp();
    if size * centre.max(1.0) < NEAR {
        // dt/dv = φ(v)/f(t), twice differentiated at 0.
        let cubic = (df + 1.0) * centre * centre - 1.0;
        let (t, slope) = (v * centre * (1.0 + cubic * v * v / 6.0), centre * (1.0 + 0.5 * cubic * v * v));
        return [df.sqrt() * t, slope.ln() + 0.5 * df.ln()];
    }
    let log = normal::log_upper(size);
    // The tail of e^{−df·s} lies above the true one, so that s is not above this.
    let most = (constant + df * LN_2 - df.ln() - log) / df;
    let s = if most > FAR {
        most
    } else {
        root((0.5 * wallace(df, size)).exp().acosh().min(most), 1.0 / (1.0 + df.sqrt()), |s| {
            let tail = log_tail(df, constant, s);
            let hazard = (constant - df * log_cosh(s) - tail).exp();
            [tail - log, -hazard, hazard - df * s.tanh()]
        })
    };
    let log_slope = normal::log_density(v) - constant + 0.5 * df.ln() + (df + 1.0) * log_cosh(s);
    [(df.sqrt() * s.sinh()).copysign(v), log_slope]
}

/// The standard normal `v` of a standard `t`.
pub(in crate::equations) fn to_normal(df: f64, t: f64) -> f64 {
    if !(df > 0.0 && df < f64::INFINITY) || t.is_nan() {
        return f64::NAN;
    }
    if t.is_infinite() {
        return t;
    }
    let s = (t.abs() / df.sqrt()).asinh();
    if df >= MANY {
        let start = from_wallace(df, s);
        let refined = |v: f64| {
            let [value, slope] = expansion(df, v);
            [value - t.abs(), slope, 0.0]
        };
        return if start < OUTSIDE { root(start, 1.0, refined) } else { start }.copysign(t);
    }
    normal::from_log_upper(log_tail(df, log_constant(df), s)).copysign(t)
}
