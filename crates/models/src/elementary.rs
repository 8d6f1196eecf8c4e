//! Elementary functions without branches, so that a loop over them becomes vector instructions.
//!
//! They are series after a reduction to a short interval, Taylor's but for [`ln_1p`]. What is left out is below rounding.
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
    let Reduced { r, series, power } = Reduced::of(x);
    let series = r.mul_add(r.mul_add(series, 1.0), 1.0);
    if x > LOWEST { series * power } else { 0.0 }
}

/// `eˣ − 1` for `x ≤ 0`, within 2 units in the last place; −1 at −∞, at NaN, and below −708.
///
/// As [`exp`], with the series of `eʳ − 1`.
#[inline(always)]
pub(crate) fn exp_m1(x: f64) -> f64 {
    let Reduced { r, series, power } = Reduced::of(x);
    let less_one = (r * r).mul_add(series, r);
    power.mul_add(less_one, power - 1.0)
}

/// Below it exponentials lose digits.
const LOWEST: f64 = -708.0;

/// `x = n ln 2 + r`, with `(eʳ − 1 − r)/r²` and `2ⁿ`.
struct Reduced {
    r: f64,
    series: f64,
    power: f64,
}

impl Reduced {
    /// Of a number above [`LOWEST`], or of that.
    #[inline(always)]
    fn of(x: f64) -> Self {
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
        let power = f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52);
        Reduced { r, series, power }
    }
}

/// `tanh x`, within 4 units in the last place; NaN is 1.
#[inline(always)]
pub(crate) fn tanh(x: f64) -> f64 {
    let less_one = exp_m1(-2.0 * x.abs());
    (-less_one / (less_one + 2.0)).copysign(x)
}

/// `ln x` for a positive normal number `x`, in two parts of which the second is what rounding took from the first.
///
/// As [`ln`], with the remainder of the quotient and a multiple of `ln 2` that is exact.
#[inline(always)]
fn ln_in_two(x: f64) -> [f64; 2] {
    const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
    const LN_2_LOW: f64 = f64::from_bits(0x3dea_39ef_3579_3c76);
    let [e, m] = split(x);
    let (difference, sum) = (m - 1.0, m + 1.0);
    let lost = m - (sum - 1.0);
    let s = difference / sum;
    let of_quotient = (-s).mul_add(lost, (-s).mul_add(sum, difference)) / sum;
    let square = s * s;
    let series = artanh_series(square);
    let (large, small) = (e * LN_2_HIGH, 2.0 * s);
    let high = large + small;
    let low =
        small - (high - large) + e.mul_add(LN_2_LOW, (small * square).mul_add(series, 2.0 * of_quotient));
    [high, low]
}

/// `y ln x` for a positive normal number `x`, in two parts.
#[inline(always)]
pub(crate) fn log_power(x: f64, y: f64) -> [f64; 2] {
    let [high, low] = ln_in_two(x);
    let product = y * high;
    let rest = y.mul_add(low, y.mul_add(high, -product));
    let sum = product + rest;
    [sum, rest - (sum - product)]
}

/// `ln x` for a positive normal number `x`, within 2 units in the last place or 2e-16 absolutely.
///
/// With `x = 2ᵉ m` and `m` between `√½` and `√2`, `ln x = e ln 2 + 2 artanh s` for `s = (m − 1)/(m + 1)`.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    let [e, m] = split(x);
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let series = artanh_series(square);
    e.mul_add(LN_2, (2.0 * s * square).mul_add(series, 2.0 * s))
}

/// `e` and `m` of a positive normal number `2ᵉ m` with `m` between `√½` and `√2`.
#[inline(always)]
fn split(x: f64) -> [f64; 2] {
    const HALF_ROOT: u64 = (SQRT_2 / 2.0).to_bits();
    const BIAS: u64 = 1024;
    // 2⁵² in the exponent's place makes the integer below it a number without a conversion.
    const INTEGER: f64 = (1_u64 << 52) as f64;
    let bits = x.to_bits();
    let exponent = bits.wrapping_sub(HALF_ROOT).wrapping_add(BIAS << 52) >> 52;
    let m = f64::from_bits(bits.wrapping_sub(exponent.wrapping_sub(BIAS) << 52));
    [f64::from_bits(exponent | INTEGER.to_bits()) - (INTEGER + BIAS as f64), m]
}

/// `(artanh s − s)/s³` of `s²`.
#[inline(always)]
pub(crate) fn artanh_series(square: f64) -> f64 {
    let mut series = 1.0 / 19.0;
    series = square.mul_add(series, 1.0 / 17.0);
    series = square.mul_add(series, 1.0 / 15.0);
    series = square.mul_add(series, 1.0 / 13.0);
    series = square.mul_add(series, 1.0 / 11.0);
    series = square.mul_add(series, 1.0 / 9.0);
    series = square.mul_add(series, 1.0 / 7.0);
    series = square.mul_add(series, 1.0 / 5.0);
    series = square.mul_add(series, 1.0 / 3.0);
    series
}

/// `ln(1 + x)`, within 1 unit in the last place as FDLIBM states it. It is −∞ at −1, and NaN below and at NaN.
///
/// The approximation is FDLIBM's, which most C libraries have; its sums are those of glibc on processors with fused multiplication, bit by
/// bit. With `1 + x = 2ᵏ (1 + f)` and `1 + f` between `√½` and `√2`, `ln(1 + x) = k ln 2 + c + f − (f²/2 − s (f²/2 + R(s²)))` for
/// `s = f/(2 + f)`, a polynomial `R`, and `c`, what rounding took from `1 + x`, over `1 + x`.
#[inline(always)]
pub fn ln_1p(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1.0_f64.to_bits();
    const HALF: u64 = 0.5_f64.to_bits();
    const INTEGER: f64 = (1_u64 << 52) as f64;
    // Limits that FDLIBM compares the upper halves of numbers with.
    const UNREDUCED: (f64, f64) =
        (-f64::from_bits(0x3fd2_bec4_0000_0000), f64::from_bits(0x3fda_827a_0000_0000));
    const ROOT: u64 = 0x6_a09e << 32;
    const ABOVE_POWER: u64 = 1 << 32;
    const BELOW_POWER: u64 = 0xf_fffd << 32;
    const SMALL: f64 = 1.0 / (1_u64 << 29) as f64;
    const TINY: f64 = 1.0 / (1_u64 << 54) as f64;
    // ln 2 in two parts, the first with zeros at its end, so that multiples of it are exact.
    const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
    const LN_2_LOW: f64 = f64::from_bits(0x3dea_39ef_3579_3c76);
    // Of (ln(1 + s) − ln(1 − s) − 2s)/s in s², the best to 2⁻⁵⁸.
    const R: [f64; 7] = [
        f64::from_bits(0x3fe5_5555_5555_5593),
        f64::from_bits(0x3fd9_9999_9997_fa04),
        f64::from_bits(0x3fd2_4924_9422_9359),
        f64::from_bits(0x3fcc_71c5_1d8e_78af),
        f64::from_bits(0x3fc7_4664_96cb_03de),
        f64::from_bits(0x3fc3_9a09_d078_c69f),
        f64::from_bits(0x3fc2_f112_df3e_5244),
    ];
    let is_reduced = !(x > UNREDUCED.0 && x < UNREDUCED.1);
    let u = if x < 2.0 * INTEGER { 1.0 + x } else { x };
    let bits = u.to_bits();
    let (exponent, mantissa) = (bits >> 52, bits & MANTISSA);
    let is_upper = mantissa >= ROOT;
    let exponent = f64::from_bits(exponent | INTEGER.to_bits()) - (INTEGER + 1023.0);
    let lost = if exponent > 0.0 { 1.0 - (u - x) } else { x - (u - 1.0) };
    let k = exponent + if is_upper { 1.0 } else { 0.0 };
    let k = if is_reduced { k } else { 0.0 };
    let c = if k == 0.0 || x >= 2.0 * INTEGER { 0.0 } else { lost / u };
    let reduced = f64::from_bits(mantissa | if is_upper { HALF } else { ONE }) - 1.0;
    let f = if is_reduced { reduced } else { x };
    // Beside a power of two a polynomial of low degree is enough.
    let is_near = is_reduced & if is_upper { mantissa >= BELOW_POWER } else { mantissa < ABOVE_POWER };
    let half = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let square = z * z;
    let fourth = square * square;
    let series = z.mul_add(R[0], square * z.mul_add(R[2], R[1]));
    let series = fourth.mul_add(z.mul_add(R[4], R[3]), series);
    let series = (square * fourth).mul_add(z.mul_add(R[6], R[5]), series);
    let first = if is_near { half * f.mul_add(-2.0 / 3.0, 1.0) } else { half };
    let second = if is_near { 0.0 } else { s * (half + series) };
    let found = k.mul_add(LN_2_HIGH, f - (first - (second + k.mul_add(LN_2_LOW, c))));
    let magnitude = x.abs();
    let found = if magnitude < SMALL { x - x * x * 0.5 } else { found };
    let found = if magnitude < TINY { x } else { found };
    let found = if x > -1.0 { found } else { f64::NAN };
    let found = if x == -1.0 { f64::NEG_INFINITY } else { found };
    if x == f64::INFINITY { x } else { found }
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
    fn logarithms_of_one_and_more_are_those_of_the_standard_library() {
        let check = |x: f64| {
            let (found, expected) = (ln_1p(x), x.ln_1p());
            let is_close = (found - expected).abs() <= 2.0 * f64::EPSILON * expected.abs();
            assert!(found == expected || is_close, "ln(1 + {x:e}) is {found:e} for {expected:e}");
        };
        let mut x = 1e-300;
        while x < 1e300 {
            check(x);
            check(-x / (1.0 + x));
            x *= 1.003;
        }
        for x in [1.0, 3.0, -0.5, -0.25, f64::from_bits(0x3fda_827a_0000_0000)] {
            for near in -3..=3 {
                check(x + f64::from(near) * 1e-16);
                check(x + f64::from(near) * 1e-7);
            }
        }
        assert_eq!([0.0, -1.0, f64::INFINITY].map(ln_1p), [0.0, f64::NEG_INFINITY, f64::INFINITY]);
        assert!(ln_1p(-1.1).is_nan() && ln_1p(f64::NEG_INFINITY).is_nan() && ln_1p(f64::NAN).is_nan());
    }

    #[test]
    fn logarithms_of_one_and_more_have_these_bits_on_every_machine() {
        let mut all = 0_u64;
        for i in 1..=1_000_000 {
            let y = f64::from(i) / 1_000_001.0;
            for x in [-y, y, 8.0 * y, 1.0 / (y * y * y)] {
                all = all.rotate_left(1) ^ ln_1p(x).to_bits();
            }
        }
        // What glibc 2.36 finds on a processor with fused multiplication.
        assert_eq!(all, 14_118_653_068_930_221_345);
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
