//! Elementary functions without branches, so that a loop over them becomes vector instructions.
//!
//! They are Taylor series after a reduction to a short interval. The first term left out is below rounding.
//!
//! Every multiplication that is followed by an addition is fused, in hardware or not. The results are therefore the same
//! numbers on every machine.

use std::f64::consts::{LN_2, LOG2_E, SQRT_2};

/// `eˣ` for `x ≤ 0`, within 2 units in the last place.
///
/// It is 0 at −∞, at NaN, and below −708, where the standard library's results lose digits.
///
/// `x = n ln 2 + r` with an integer `n` and `|r| ≤ ½ ln 2`: the Taylor series of `eʳ`, times `2ⁿ`.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    const LOWEST: f64 = -708.0;
    // Adding it rounds to an integer, which then stands in the lowest bits.
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
    // What ln 2 is beyond its nearest double.
    const LN_2_LOW: f64 = 2.319_046_813_846_299_6e-17;
    let kept = if x > LOWEST { x } else { LOWEST };
    let rounded = kept.mul_add(LOG2_E, ROUND);
    let n = rounded - ROUND;
    let r = n.mul_add(-LN_2_LOW, n.mul_add(-LN_2, kept));
    let mut series = 1.0 / 6_227_020_800.0;
    series = r.mul_add(series, 1.0 / 479_001_600.0);
    series = r.mul_add(series, 1.0 / 39_916_800.0);
    series = r.mul_add(series, 1.0 / 3_628_800.0);
    series = r.mul_add(series, 1.0 / 362_880.0);
    series = r.mul_add(series, 1.0 / 40_320.0);
    series = r.mul_add(series, 1.0 / 5040.0);
    series = r.mul_add(series, 1.0 / 720.0);
    series = r.mul_add(series, 1.0 / 120.0);
    series = r.mul_add(series, 1.0 / 24.0);
    series = r.mul_add(series, 1.0 / 6.0);
    series = r.mul_add(series, 1.0 / 2.0);
    series = r.mul_add(series, 1.0);
    series = r.mul_add(series, 1.0);
    let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
    if x > LOWEST { series * power } else { 0.0 }
}

/// `ln x` for a positive normal number `x`, within 2 units in the last place or 2e-16 absolutely.
///
/// With `x = 2ᵉ m` and `m` between `√½` and `√2`, `ln x = e ln 2 + 2 artanh s` for `s = (m − 1)/(m + 1)`.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    const HALF_ROOT: u64 = (SQRT_2 / 2.0).to_bits();
    const BIAS: u64 = 1024;
    // 2⁵² in the exponent's place makes the integer below it a number without a conversion.
    const INTEGER: f64 = (1_u64 << 52) as f64;
    let bits = x.to_bits();
    let exponent = bits.wrapping_sub(HALF_ROOT).wrapping_add(BIAS << 52) >> 52;
    let m = f64::from_bits(bits.wrapping_sub(exponent.wrapping_sub(BIAS) << 52));
    let e = f64::from_bits(exponent | INTEGER.to_bits()) - (INTEGER + BIAS as f64);
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let mut series = 1.0 / 19.0;
    series = square.mul_add(series, 1.0 / 17.0);
    series = square.mul_add(series, 1.0 / 15.0);
    series = square.mul_add(series, 1.0 / 13.0);
    series = square.mul_add(series, 1.0 / 11.0);
    series = square.mul_add(series, 1.0 / 9.0);
    series = square.mul_add(series, 1.0 / 7.0);
    series = square.mul_add(series, 1.0 / 5.0);
    series = square.mul_add(series, 1.0 / 3.0);
    e.mul_add(LN_2, (2.0 * s * square).mul_add(series, 2.0 * s))
}

/// `(sin x, cos x)` for `|x| ≤ π/4`, within 2 units in the last place.
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    let square = -(x * x);
    let mut sin = 1.0 / 1_307_674_368_000.0;
    sin = square.mul_add(sin, 1.0 / 6_227_020_800.0);
    sin = square.mul_add(sin, 1.0 / 39_916_800.0);
    sin = square.mul_add(sin, 1.0 / 362_880.0);
    sin = square.mul_add(sin, 1.0 / 5040.0);
    sin = square.mul_add(sin, 1.0 / 120.0);
    sin = square.mul_add(sin, 1.0 / 6.0);
    let mut cos = 1.0 / 20_922_789_888_000.0;
    cos = square.mul_add(cos, 1.0 / 87_178_291_200.0);
    cos = square.mul_add(cos, 1.0 / 479_001_600.0);
    cos = square.mul_add(cos, 1.0 / 3_628_800.0);
    cos = square.mul_add(cos, 1.0 / 40_320.0);
    cos = square.mul_add(cos, 1.0 / 720.0);
    cos = square.mul_add(cos, 1.0 / 24.0);
    cos = square.mul_add(cos, 1.0 / 2.0);
    ((x * square).mul_add(sin, x), square.mul_add(cos, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_are_those_of_the_standard_library() {
        let mut x = 0.0;
        while x > -708.0 {
            let (found, expected) = (exp(x), x.exp());
            let error = (found / expected - 1.0).abs();
            assert!(error <= 2.0 * f64::EPSILON, "exp({x}) is {found:e} for {expected:e}");
            x -= 0.000_731 + 1e-5 * x.abs();
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-1e-300), 1.0);
        assert_eq!([exp(-708.1), exp(-1e300), exp(f64::NEG_INFINITY)], [0.0; 3]);
    }

    #[test]
    fn logarithms_are_those_of_the_standard_library() {
        let mut x = 2.0_f64.powi(-64);
        while x < 3.0 {
            let expected = x.ln();
            let error = (ln(x) - expected).abs();
            assert!(error <= (2.0 * f64::EPSILON * expected.abs()).max(2e-16), "ln {x:e}: error {error:e}");
            x *= 1.000_37;
        }
        assert_eq!(ln(1.0), 0.0);
        assert!((ln(1.0 - f64::EPSILON / 2.0) / (-f64::EPSILON / 2.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn sines_and_cosines_are_those_of_the_standard_library() {
        for i in -100_000..=100_000 {
            let x = i as f64 * (std::f64::consts::FRAC_PI_4 / 100_000.0);
            let (sin, cos) = sin_cos(x);
            assert!((sin - x.sin()).abs() <= 2.0 * f64::EPSILON * x.sin().abs(), "sin {x}");
            assert!((cos - x.cos()).abs() <= 2.0 * f64::EPSILON * x.cos(), "cos {x}");
        }
    }
}
