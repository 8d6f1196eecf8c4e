//! The exponential function without branches, so that a loop over it becomes vector instructions.

use std::f64::consts::{LN_2, LOG2_E};

/// `eˣ` for `x ≤ 0`, within 2 units in the last place; 0 below −708, where the standard library's results lose digits, and at −∞.
///
/// `x = n ln 2 + r` with an integer `n` and `|r| ≤ ½ ln 2`: the Taylor series of `eʳ`, times `2ⁿ`.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
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
}
