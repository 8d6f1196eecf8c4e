//! Numbers that carry their derivatives: forward-mode automatic differentiation.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};
use std::ops::{Add, Div, Mul, Neg, Sub};

use bytemuck::{Pod, Zeroable};

use super::plain::Plain;
use super::scalar::{Scalar, power};

/// A number in the first place, and its derivatives along `E − 1` directions in the others: `f + Σ_i f_i ε_i` with `ε_i ε_j = 0`.
///
/// A formula of such numbers gives itself and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Dual<S, const E: usize>([S; E]);

impl<S: Plain, const E: usize> Dual<S, E> {
    /// `x_i` of a point: its derivative along direction `i` is 1.
    ///
    /// # Panics
    /// If there are not so many directions.
    #[inline(always)]
    pub fn variable(value: S, direction: usize) -> Self {
        let mut dual = Dual::constant(value);
        dual.0[1 + direction] = S::from(1.0);
        dual
    }

    /// A number that no direction changes.
    #[inline(always)]
    pub fn constant(value: S) -> Self {
        let mut dual = Dual([S::from(0.0); E]);
        dual.0[0] = value;
        dual
    }

    /// A number with a derivative along the first direction alone.
    #[inline(always)]
    pub(super) fn along_first(value: S, derivative: S) -> Self {
        let mut dual = Dual::constant(value);
        dual.0[1] = derivative;
        dual
    }

    /// The number itself.
    #[inline(always)]
    pub fn value(self) -> S {
        self.0[0]
    }

    /// Its derivatives, one for each direction.
    #[inline(always)]
    pub fn derivatives(&self) -> &[S] {
        &self.0[1..]
    }

    /// Each part by itself. (Loops: the closures of array functions are not always put in line.)
    #[inline(always)]
    fn each(mut self, of: impl Fn(S) -> S) -> Self {
        for part in &mut self.0 {
            *part = of(*part);
        }
        self
    }

    /// Each pair of parts by itself.
    #[inline(always)]
    fn each_pair(mut self, other: Self, of: impl Fn(S, S) -> S) -> Self {
        for (part, other) in self.0.iter_mut().zip(other.0) {
            *part = of(*part, other);
        }
        self
    }

    /// `f(x)` by the chain rule, from `f` and `df/dx` at the value of `x`.
    #[inline(always)]
    fn chain(self, value: S, slope: S) -> Self {
        let mut dual = self.each(|derivative| derivative * slope);
        dual.0[0] = value;
        dual
    }

    /// `f(x, y)` by the chain rule.
    #[inline(always)]
    fn chain_of_two(self, other: Self, value: S, [by_self, by_other]: [S; 2]) -> Self {
        let mut dual = self.each_pair(other, |own, other| own * by_self + other * by_other);
        dual.0[0] = value;
        dual
    }

    /// Number by number, `then` where `condition` is above 0, else `otherwise`; NaN where it is NaN.
    #[inline(always)]
    fn choose(condition: S, then: Self, otherwise: Self) -> Self {
        then.each_pair(otherwise, |then, otherwise| condition.where_positive(then, otherwise))
    }
}

impl<S: Plain, const E: usize> From<f64> for Dual<S, E> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Dual::constant(S::from(value))
    }
}

impl<S: Plain, const E: usize> Neg for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

impl<S: Plain, const E: usize> Add for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.each_pair(other, |a, b| a + b)
    }
}

impl<S: Plain, const E: usize> Sub for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.each_pair(other, |a, b| a - b)
    }
}

impl<S: Plain, const E: usize> Mul for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value(), other.value());
        self.chain_of_two(other, a * b, [b, a])
    }
}

impl<S: Plain, const E: usize> Div for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let (a, b) = (self.value(), other.value());
        let value = a / b;
        let inverse = S::from(1.0) / b;
        self.chain_of_two(other, value, [inverse, -(value * inverse)])
    }
}

impl<S: Plain, const E: usize> Add<f64> for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: f64) -> Self {
        self.0[0] = self.0[0] + other;
        self
    }
}

impl<S: Plain, const E: usize> Sub<f64> for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: f64) -> Self {
        self.0[0] = self.0[0] - other;
        self
    }
}

impl<S: Plain, const E: usize> Mul<f64> for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.each(|x| x * other)
    }
}

impl<S: Plain, const E: usize> Div<f64> for Dual<S, E> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self.each(|x| x / other)
    }
}

impl<S: Plain, const E: usize> Scalar for Dual<S, E> {
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.chain(root, S::from(0.5) / root)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value().exp();
        self.chain(value, value)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value().ln(), S::from(1.0) / self.value())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let value = self.value();
        let (one, zero) = (S::from(1.0), S::from(0.0));
        let sign = value.where_positive(one, (-value).where_positive(-one, zero));
        self.chain(value.abs(), sign)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        self.chain(self.value().sin(), self.value().cos())
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.chain(self.value().cos(), -self.value().sin())
    }

    #[inline(always)]
    fn tan(self) -> Self {
        let value = self.value().tan();
        self.chain(value, value * value + 1.0)
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        let value = self.value().tanh();
        self.chain(value, S::from(1.0) - value * value)
    }

    #[inline(always)]
    fn atan(self) -> Self {
        let value = self.value();
        self.chain(value.atan(), S::from(1.0) / (value * value + 1.0))
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let (a, b) = (self.value(), x.value());
        let square = a * a + b * b;
        self.chain_of_two(x, a.atan2(b), [b / square, -(a / square)])
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Dual::constant(self.value().floor())
    }

    #[inline(always)]
    fn powi(self, n: i32) -> Self {
        match n {
            0 => Dual::from(1.0),
            // One more than the smallest integer cannot be less by one.
            i32::MIN => power(self, n, Dual::from(1.0)),
            _ => {
                let below = self.value().powi(n - 1);
                self.chain(self.value().powi(n), below * f64::from(n))
            }
        }
    }

    #[inline(always)]
    fn pow(self, y: Self) -> Self {
        let (a, b) = (self.value(), y.value());
        let value = a.pow(b);
        let by_exponent = a.where_positive(value * a.ln(), S::from(0.0));
        self.chain_of_two(y, value, [b * a.pow(b - 1.0), by_exponent])
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Dual::choose(other.value() - self.value(), self, other).with_value(self.value().min(other.value()))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Dual::choose(self.value() - other.value(), self, other).with_value(self.value().max(other.value()))
    }

    #[inline(always)]
    fn where_positive(self, then: Self, otherwise: Self) -> Self {
        Dual::choose(self.value(), then, otherwise)
    }

    #[inline(always)]
    fn ln_gamma(self) -> Self {
        self.chain(self.value().ln_gamma(), self.value().digamma())
    }

    #[inline(always)]
    fn erf(self) -> Self {
        let x = self.value();
        self.chain(x.erf(), (-(x * x)).exp() * FRAC_2_SQRT_PI)
    }

    #[inline(always)]
    fn normal_cdf(self) -> Self {
        let x = self.value();
        self.chain(x.normal_cdf(), (x * x * -0.5).exp() * (FRAC_2_SQRT_PI * FRAC_1_SQRT_2 * 0.5))
    }

    fn custom<const K: usize>(
        arguments: [Self; K],
        of: impl Fn([f64; K]) -> f64,
        slopes: impl Fn([f64; K], f64) -> [f64; K],
    ) -> Self {
        let values = arguments.map(Dual::value);
        let value = S::custom(values, of, |_, _| [0.0; K]);
        let (zero, mut sum) = (S::from(0.0), Dual::constant(S::from(0.0)));
        for (argument, slope) in arguments.iter().zip(S::slopes(values, value, slopes)) {
            sum = sum.each_pair(*argument, |sum, own| sum + slope.abs().where_positive(own * slope, zero));
        }
        sum.with_value(value)
    }
}

impl<S: Plain, const E: usize> Dual<S, E> {
    /// The same derivatives with another number.
    #[inline(always)]
    fn with_value(mut self, value: S) -> Self {
        self.0[0] = value;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::lanes::Lanes;

    type Number = Dual<f64, 3>;

    /// Every function, at a point of two coordinates inside of all domains.
    fn all<S: Scalar>([x, y]: [S; 2]) -> Vec<S> {
        vec![
            -x + y * 2.0 - 1.0,
            x * y / (y + 0.5),
            (x / 3.0).sqrt() - y,
            x.exp() * y.ln(),
            (x - y).abs(),
            (y - x).abs(),
            x.sin() * y.cos(),
            x.tan() + y.tanh(),
            x.atan() * y,
            x.atan2(y),
            (-x).atan2(-y),
            x.floor() * y,
            x.powi(3) * y.powi(-2) + y.powi(0),
            x.pow(y),
            (-x).pow(S::from(3.0)) * y,
            x.min(y) * x,
            x.max(y) * y,
            (x - y).where_positive(x * x, y * 2.0),
            (y - x).where_positive(x * x, y * 2.0),
            (x * y).ln_gamma(),
            (x - y).erf() + (y - x * 2.0).normal_cdf(),
        ]
    }

    #[test]
    fn derivatives_are_those_of_central_differences() {
        let (point, step) = ([1.3, 0.8], 1e-6);
        let found = all([Number::variable(point[0], 0), Number::variable(point[1], 1)]);
        let values = all(point);
        for direction in 0..2 {
            let moved = |by: f64| {
                let mut moved = point;
                moved[direction] += by;
                all(moved)
            };
            let (above, below) = (moved(step), moved(-step));
            for (number, found) in found.iter().enumerate() {
                assert_eq!(found.value(), values[number], "function {number}");
                let difference = (above[number] - below[number]) / (2.0 * step);
                let error = (found.derivatives()[direction] - difference).abs();
                assert!(
                    error < 1e-8 * (1.0 + difference.abs()),
                    "function {number}, direction {direction}: {error}"
                );
            }
        }
    }

    #[test]
    fn numbers_side_by_side_are_numbers_alone() {
        let at = |lane: usize| [0.3 + 0.17 * lane as f64, 1.9 - 0.05 * lane as f64];
        let lanes = |which: usize| Lanes(std::array::from_fn(|lane| at(lane)[which]));
        let side = all([Dual::<Lanes, 3>::variable(lanes(0), 0), Dual::variable(lanes(1), 1)]);
        for lane in 0..crate::batch::LANES {
            let alone = all([Number::variable(at(lane)[0], 0), Number::variable(at(lane)[1], 1)]);
            for (number, (side, alone)) in side.iter().zip(alone).enumerate() {
                let bits = side.0.map(|values| values.0[lane].to_bits());
                assert_eq!(bits, alone.0.map(f64::to_bits), "function {number}, lane {lane}");
            }
        }
    }

    #[test]
    fn where_there_is_no_slope_it_is_zero() {
        let zero = Number::variable(0.0, 0);
        assert_eq!(zero.abs().derivatives(), [0.0, 0.0]);
        assert_eq!(zero.powi(2).derivatives(), [0.0, 0.0]);
        assert_eq!(zero.pow(Number::from(2.0)).derivatives(), [0.0, 0.0]);
        assert_eq!(Number::variable(-2.0, 0).pow(Number::from(2.0)).derivatives(), [-4.0, 0.0]);
    }
}
