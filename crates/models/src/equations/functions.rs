//! Exponentials, logarithms and sines for any number, without branches where numbers are common.
//!
//! They agree with those of the standard library within a few units in the last place. A loop over them becomes vector instructions, and a number's
//! result does not depend on its neighbours: the standard library answers for the rare ones, number by number.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use crate::batch::by_widest_vectors;
use crate::elementary;

/// Whether [`exp`] needs the standard library.
#[inline(always)]
fn is_rare_exponent(x: f64) -> bool {
    // Written so that NaN is rare.
    !(x > -700.0 && x < 700.0)
}

/// `eˣ` for `|x| < 700`.
#[inline(always)]
fn common_exp(x: f64) -> f64 {
    // The reduction takes what is not positive; the inverse of a number has half a unit of rounding.
    let size = elementary::exp(-x.abs());
    if x > 0.0 { 1.0 / size } else { size }
}

/// Whether [`ln`] needs the standard library.
#[inline(always)]
fn is_rare_logarithm(x: f64) -> bool {
    !(x > 1e-300 && x < 1e300)
}

/// Beyond this an angle loses digits when multiples of `π/2` are taken off it by three parts.
const LARGEST_ANGLE: f64 = 1e5;

/// Whether [`sin`] and [`cos`] need the standard library.
#[inline(always)]
fn is_rare_angle(x: f64) -> bool {
    !(x > -LARGEST_ANGLE && x < LARGEST_ANGLE)
}

/// `sin(x + quarters·π/2)` for a common angle.
#[inline(always)]
fn common_sin(x: f64, quarters: u64) -> f64 {
    // What π/2 is beyond its nearest double, and beyond that.
    const MIDDLE: f64 = 6.123_233_995_736_766e-17;
    const LAST: f64 = -1.497_384_904_859_169e-33;
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
    let rounded = x.mul_add(FRAC_2_PI, ROUND);
    let n = rounded - ROUND;
    let rest = n.mul_add(-LAST, n.mul_add(-MIDDLE, n.mul_add(-FRAC_PI_2, x)));
    let (sin, cos) = elementary::sin_cos(rest);
    let quadrant = rounded.to_bits().wrapping_add(quarters);
    let size = if quadrant & 1 == 0 { sin } else { cos };
    f64::from_bits(size.to_bits() ^ ((quadrant & 2) << 62))
}

/// Whether [`tanh`] needs the standard library.
#[inline(always)]
fn is_rare_tangent(x: f64) -> bool {
    !(x > -1e300 && x < 1e300)
}

/// Whether [`pow`] needs the standard library.
#[inline(always)]
fn is_rare_power(x: f64, y: f64) -> bool {
    // Adding it rounds to an integer.
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
    let [exponent, _] = elementary::log_power(x, y);
    // Powers of integers and square roots may be exact, which the product of a logarithm is not.
    let may_be_exact = ((y + ROUND) - ROUND == y) | (y == 0.5) | (y == -0.5);
    // Larger powers would magnify what rounding took from the logarithm.
    is_rare_logarithm(x) | !(y > -64.0 && y < 64.0) | may_be_exact | is_rare_exponent(exponent)
}

/// `x^y` where `x` and the power are common.
#[inline(always)]
fn common_pow(x: f64, y: f64) -> f64 {
    let [exponent, rest] = elementary::log_power(x, y);
    let power = common_exp(exponent);
    power.mul_add(rest, power)
}

/// `tanh x`.
#[inline(always)]
pub(super) fn tanh(x: f64) -> f64 {
    if is_rare_tangent(x) { x.tanh() } else { elementary::tanh(x) }
}

/// `x^y`.
#[inline(always)]
pub(super) fn pow(x: f64, y: f64) -> f64 {
    if is_rare_power(x, y) { x.powf(y) } else { common_pow(x, y) }
}

/// [`pow`] of each.
pub(super) fn pow_of_all<const W: usize>(bases: &[f64; W], exponents: &[f64; W]) -> [f64; W] {
    let mut found = [0.0; W];
    let is_rare = by_widest_vectors(
        #[inline(always)]
        || {
            let mut is_rare = false;
            for (found, (&x, &y)) in found.iter_mut().zip(bases.iter().zip(exponents)) {
                *found = common_pow(x, y);
                is_rare |= is_rare_power(x, y);
            }
            is_rare
        },
    );
    if is_rare {
        for (found, (&x, &y)) in found.iter_mut().zip(bases.iter().zip(exponents)) {
            if is_rare_power(x, y) {
                *found = x.powf(y);
            }
        }
    }
    found
}

/// `eˣ`.
#[inline(always)]
pub(super) fn exp(x: f64) -> f64 {
    if is_rare_exponent(x) { x.exp() } else { common_exp(x) }
}

/// `ln x`.
#[inline(always)]
pub(super) fn ln(x: f64) -> f64 {
    if is_rare_logarithm(x) { x.ln() } else { elementary::ln(x) }
}

/// `sin x`.
#[inline(always)]
pub(super) fn sin(x: f64) -> f64 {
    if is_rare_angle(x) { x.sin() } else { common_sin(x, 0) }
}

/// `cos x`.
#[inline(always)]
pub(super) fn cos(x: f64) -> f64 {
    if is_rare_angle(x) { x.cos() } else { common_sin(x, 1) }
}

/// A function of many numbers side by side, by vector instructions for common numbers.
macro_rules! of_all {
    ($(#[$doc:meta])* $name:ident, $is_rare:ident, |$x:ident| $common:expr, $rare:expr) => {
        $(#[$doc])*
        pub(super) fn $name<const W: usize>(values: &[f64; W]) -> [f64; W] {
            let mut found = [0.0; W];
            let is_rare = by_widest_vectors(
                #[inline(always)]
                || {
                    // Its own, not the closure's: what is written through a reference in each round keeps a loop from vectors.
                    let mut is_rare = false;
                    for (found, &$x) in found.iter_mut().zip(values) {
                        *found = $common;
                        is_rare |= $is_rare($x);
                    }
                    is_rare
                },
            );
            if is_rare {
                for (found, &value) in found.iter_mut().zip(values) {
                    if $is_rare(value) {
                        *found = $rare(value);
                    }
                }
            }
            found
        }
    };
}

of_all!(
    /// [`exp`] of each.
    exp_of_all, is_rare_exponent, |x| common_exp(x), f64::exp
);
of_all!(
    /// [`ln`] of each.
    ln_of_all, is_rare_logarithm, |x| elementary::ln(x), f64::ln
);
of_all!(
    /// [`tanh`] of each.
    tanh_of_all, is_rare_tangent, |x| elementary::tanh(x), f64::tanh
);
of_all!(
    /// [`sin`] of each.
    sin_of_all, is_rare_angle, |x| common_sin(x, 0), f64::sin
);
of_all!(
    /// [`cos`] of each.
    cos_of_all, is_rare_angle, |x| common_sin(x, 1), f64::cos
);

#[cfg(test)]
mod tests {
    use super::*;

    fn check(
        found: fn(f64) -> f64,
        all: fn(&[f64; 4]) -> [f64; 4],
        expected: fn(f64) -> f64,
        points: &[f64],
        units: f64,
    ) {
        for &x in points {
            let (found, expected) = (found(x), expected(x));
            let same = found == expected || found.is_nan() && expected.is_nan();
            let error = (found - expected).abs();
            let allowed = units * f64::EPSILON * expected.abs().max(f64::MIN_POSITIVE);
            assert!(same || error <= allowed, "at {x:e}: {found:e} for {expected:e}");
            // Beside a rare number, and beside a common one.
            for other in [f64::NAN, 0.5] {
                assert_eq!(all(&[x, other, 1.0, x]).map(f64::to_bits)[0], found.to_bits(), "at {x:e}");
                assert_eq!(all(&[x, other, 1.0, x]).map(f64::to_bits)[3], found.to_bits(), "at {x:e}");
            }
        }
    }

    /// Numbers of all sizes and both signs, and those that no formula likes.
    fn points() -> Vec<f64> {
        let sizes = (0..4000).map(|i| 1e-310 * 1.44_f64.powi(i)).take_while(|x| x.is_finite());
        let special = [0.0, f64::INFINITY, f64::NAN, f64::MAX, 700.0, 709.5, 710.0, 745.0, 1e5];
        sizes.chain(special).flat_map(|x| [x, -x]).collect()
    }

    #[test]
    fn they_are_those_of_the_standard_library() {
        check(exp, exp_of_all, f64::exp, &points(), 3.0);
        check(ln, ln_of_all, f64::ln, &points(), 3.0);
        let exponents: Vec<f64> = (-7100..7100).map(|i| 0.1 * f64::from(i) + 1e-3).collect();
        check(exp, exp_of_all, f64::exp, &exponents, 3.0);
    }

    #[test]
    fn hyperbolic_tangents_are_those_of_the_standard_library() {
        check(tanh, tanh_of_all, f64::tanh, &points(), 4.0);
        let near: Vec<f64> = (-40_000..40_000).map(|i| 5e-4 * f64::from(i)).collect();
        check(tanh, tanh_of_all, f64::tanh, &near, 4.0);
    }

    #[test]
    fn powers_are_those_of_the_standard_library() {
        let bases = [
            0.0,
            -0.0,
            1.0,
            0.3,
            0.999_999,
            1.000_001,
            2.0,
            17.5,
            4e5,
            1e-280,
            1e290,
            -2.0,
            1e-310,
            f64::INFINITY,
            f64::NAN,
        ];
        let exponents =
            [0.0, 1.0, -1.0, 0.5, 0.976, -0.7, 3.0, 2.5, 17.0, -40.1, 1e3, 1e7, f64::INFINITY, f64::NAN];
        for x in bases.into_iter().chain((1..4000).map(|i| 0.01 * 1.005_f64.powi(i))) {
            for y in exponents {
                let (found, expected) = (pow(x, y), x.powf(y));
                let same = found == expected || found.is_nan() && expected.is_nan();
                let allowed = 3.0 * f64::EPSILON * expected.abs();
                assert!(same || (found - expected).abs() <= allowed, "{x:e}^{y}: {found:e} for {expected:e}");
                let beside = pow_of_all(&[x, f64::NAN, 2.0, x], &[y, 1.0, 0.5, y]);
                assert_eq!(
                    [beside[0], beside[3]].map(f64::to_bits),
                    [found; 2].map(f64::to_bits),
                    "{x:e}^{y}"
                );
            }
        }
    }

    #[test]
    fn angles_keep_their_digits() {
        for (found, all, expected) in [
            (sin as fn(f64) -> f64, sin_of_all as fn(&[f64; 4]) -> [f64; 4], f64::sin as fn(f64) -> f64),
            (cos, cos_of_all, f64::cos),
        ] {
            let angles: Vec<f64> = (-200_000..200_000).map(|i| 0.7 * f64::from(i)).collect();
            check(found, all, expected, &angles, 4.0);
            check(found, all, expected, &points(), 4.0);
        }
    }
}
