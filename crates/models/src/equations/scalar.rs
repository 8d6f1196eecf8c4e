//! What the formulas of a model are computed with: a number, many numbers side by side, or numbers that carry derivatives.

use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use bytemuck::Pod;
use special::Gamma;

use super::functions;

/// A real number, or several side by side, that formulas are written in.
///
/// A model's formulas are generic over it, so that one text serves drawing, densities and derivatives. Plain numbers stand on the right of an
/// operator: `x * 2.0`, not `2.0 * x`.
///
/// There is no comparison: side by side, numbers would have to take both branches. [`Scalar::min`], [`Scalar::max`] and
/// [`Scalar::where_positive`] choose number by number.
pub trait Scalar:
    Copy
    + Debug
    + Pod
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// `√x`.
    #[must_use]
    fn sqrt(self) -> Self;
    /// `eˣ`.
    #[must_use]
    fn exp(self) -> Self;
    /// The natural logarithm.
    #[must_use]
    fn ln(self) -> Self;
    /// `|x|`; its derivative at 0 is 0.
    #[must_use]
    fn abs(self) -> Self;
    /// The sine of an angle in radians.
    #[must_use]
    fn sin(self) -> Self;
    /// The cosine of an angle in radians.
    #[must_use]
    fn cos(self) -> Self;
    /// The tangent of an angle in radians.
    #[must_use]
    fn tan(self) -> Self;
    /// The hyperbolic tangent.
    #[must_use]
    fn tanh(self) -> Self;
    /// The angle in radians, within `±π/2`, whose tangent this is.
    #[must_use]
    fn atan(self) -> Self;
    /// The angle of the point `(x, self)` in radians, within `±π`.
    #[must_use]
    fn atan2(self, x: Self) -> Self;
    /// The largest integer that is not above; its derivative is 0.
    #[must_use]
    fn floor(self) -> Self;
    /// `selfⁿ`.
    #[must_use]
    fn powi(self, n: i32) -> Self;
    /// `selfʸ`, for `self ≥ 0` or an integer `y`. Its derivative in `y` is 0 where `self` is 0 or less.
    #[must_use]
    fn pow(self, y: Self) -> Self;
    /// The smaller one; NaN where one is NaN.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// The larger one; NaN where one is NaN.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// `then` where this is above 0, `otherwise` elsewhere, and NaN where it is NaN.
    #[must_use]
    fn where_positive(self, then: Self, otherwise: Self) -> Self;
    /// `log Γ(x)` for `x > 0`, NaN elsewhere.
    #[must_use]
    fn ln_gamma(self) -> Self;
    /// The error function, `2/√π ∫₀ˣ e^{−u²} du`.
    #[must_use]
    fn erf(self) -> Self;
    /// `Φ(x)`, the distribution function of the standard normal distribution, with all digits in the lower tail.
    #[must_use]
    fn normal_cdf(self) -> Self;
    /// A function of a few numbers that is no formula: `of` gives its value for plain numbers, and `slopes` its derivative along each of them, given this value. Where a
    /// derivative is 0, that of the number itself may be NaN.
    #[must_use]
    fn custom<const K: usize>(
        arguments: [Self; K],
        of: impl Fn([f64; K]) -> f64,
        slopes: impl Fn([f64; K], f64) -> [f64; K],
    ) -> Self;
}

impl Scalar for f64 {
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn exp(self) -> f64 {
        functions::exp(self)
    }

    #[inline(always)]
    fn ln(self) -> f64 {
        functions::ln(self)
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn sin(self) -> f64 {
        functions::sin(self)
    }

    #[inline(always)]
    fn cos(self) -> f64 {
        functions::cos(self)
    }

    #[inline(always)]
    fn tan(self) -> f64 {
        f64::tan(self)
    }

    #[inline(always)]
    fn tanh(self) -> f64 {
        functions::tanh(self)
    }

    #[inline(always)]
    fn atan(self) -> f64 {
        f64::atan(self)
    }

    #[inline(always)]
    fn atan2(self, x: f64) -> f64 {
        f64::atan2(self, x)
    }

    #[inline(always)]
    fn floor(self) -> f64 {
        f64::floor(self)
    }

    #[inline(always)]
    fn powi(self, n: i32) -> f64 {
        power(self, n, 1.0)
    }

    #[inline(always)]
    fn pow(self, y: f64) -> f64 {
        functions::pow(self, y)
    }

    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        // The order makes NaN of either side the result.
        if self < other || self.is_nan() { self } else { other }
    }

    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        if self > other || self.is_nan() { self } else { other }
    }

    #[inline(always)]
    fn where_positive(self, then: f64, otherwise: f64) -> f64 {
        let chosen = if self > 0.0 { then } else { otherwise };
        if self.is_nan() { self } else { chosen }
    }

    #[inline(always)]
    fn ln_gamma(self) -> f64 {
        if self > 0.0 { Gamma::ln_gamma(self).0 } else { f64::NAN }
    }

    #[inline(always)]
    fn erf(self) -> f64 {
        special::Error::error(self)
    }

    #[inline(always)]
    fn normal_cdf(self) -> f64 {
        0.5 * special::Error::compl_error(-self * FRAC_1_SQRT_2)
    }

    #[inline(always)]
    fn custom<const K: usize>(
        arguments: [f64; K],
        of: impl Fn([f64; K]) -> f64,
        _: impl Fn([f64; K], f64) -> [f64; K],
    ) -> f64 {
        of(arguments)
    }
}

/// `xⁿ` by repeated squaring, in an order that depends on `n` alone; `one` is 1.
#[inline(always)]
pub(super) fn power<S: Copy + Mul<Output = S> + Div<Output = S>>(x: S, n: i32, one: S) -> S {
    let (mut result, mut factor, mut left) = (None, x, n.unsigned_abs());
    while left > 0 {
        if left & 1 == 1 {
            result = Some(result.map_or(factor, |result: S| result * factor));
        }
        left >>= 1;
        if left > 0 {
            factor = factor * factor;
        }
    }
    let result = result.unwrap_or(one);
    if n < 0 { one / result } else { result }
}

/// `ψ(x)`, the derivative of `log Γ`, for `x > 0`, NaN elsewhere.
pub(super) fn digamma(x: f64) -> f64 {
    if x > 0.0 { Gamma::digamma(x) } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_repeated_products() {
        for n in -9..=9 {
            let expected = 1.7_f64.powf(f64::from(n));
            assert!((Scalar::powi(1.7, n) / expected - 1.0).abs() < 1e-14, "{n}");
        }
        assert_eq!(Scalar::powi(-2.0, 3), -8.0);
        assert_eq!(Scalar::powi(0.0, 0), 1.0);
    }

    #[test]
    fn nothing_hides_nan() {
        for found in [
            Scalar::min(f64::NAN, 1.0),
            Scalar::min(1.0, f64::NAN),
            Scalar::max(f64::NAN, 1.0),
            Scalar::max(1.0, f64::NAN),
            f64::NAN.where_positive(1.0, 2.0),
            Scalar::ln_gamma(-0.5),
            digamma(-1e9),
        ] {
            assert!(found.is_nan());
        }
        assert_eq!((Scalar::min(1.0, 2.0), Scalar::max(1.0, 2.0)), (1.0, 2.0));
    }
}
