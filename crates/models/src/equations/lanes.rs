//! Numbers of several particles side by side, on which one formula works at once.

use std::ops::{Add, Div, Mul, Neg, Sub};

use bytemuck::{Pod, TransparentWrapper, Zeroable};

use super::functions::{self, cos_of_all, exp_of_all, ln_of_all, pow_of_all, sin_of_all, tanh_of_all};
use super::scalar::{Scalar, power};
use crate::batch::{LANES, by_widest_vectors};

/// One number of each of `W` particles, [`LANES`] if nothing else is said. Every lane is computed by itself, to the last bit as a number alone.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, TransparentWrapper)]
#[repr(transparent)]
pub struct Lanes<const W: usize = LANES>(pub [f64; W]);

impl<const W: usize> Lanes<W> {
    /// A function of each number.
    #[inline(always)]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        let mut found = [0.0; W];
        for (found, x) in found.iter_mut().zip(self.0) {
            *found = function(x);
        }
        Lanes(found)
    }

    /// The number, where it is the same in all lanes.
    #[inline(always)]
    fn same(self) -> Option<f64> {
        let first = self.0[0];
        let is_same = self.0.iter().fold(true, |same, x| same & (x.to_bits() == first.to_bits()));
        is_same.then_some(first)
    }

    /// A function of each pair of numbers.
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut found = [0.0; W];
        for ((found, x), y) in found.iter_mut().zip(self.0).zip(other.0) {
            *found = function(x, y);
        }
        Lanes(found)
    }
}

impl<const W: usize> From<f64> for Lanes<W> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Lanes([value; W])
    }
}

impl<const W: usize> Neg for Lanes<W> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

/// An operator on two, and on one and a plain number.
macro_rules! operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl<const W: usize> $trait for Lanes<W> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
            }
        }

        impl<const W: usize> $trait<f64> for Lanes<W> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.map(|a| a $operator other)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<const W: usize> Scalar for Lanes<W> {
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    fn exp(self) -> Self {
        Lanes(exp_of_all(&self.0))
    }

    #[inline]
    fn ln(self) -> Self {
        // Most scales are the same for all particles.
        match self.same() {
            Some(same) => Lanes::from(by_widest_vectors(
                #[inline(always)]
                || functions::ln(same),
            )),
            None => Lanes(ln_of_all(&self.0)),
        }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    fn sin(self) -> Self {
        Lanes(sin_of_all(&self.0))
    }

    fn cos(self) -> Self {
        Lanes(cos_of_all(&self.0))
    }

    fn tan(self) -> Self {
        self.map(f64::tan)
    }

    fn tanh(self) -> Self {
        Lanes(tanh_of_all(&self.0))
    }

    fn atan(self) -> Self {
        self.map(f64::atan)
    }

    fn atan2(self, x: Self) -> Self {
        self.zip(x, f64::atan2)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        self.map(f64::floor)
    }

    #[inline(always)]
    fn powi(self, n: i32) -> Self {
        power(self, n, Lanes::from(1.0))
    }

    fn pow(self, y: Self) -> Self {
        Lanes(pow_of_all(&self.0, &y.0))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, Scalar::min)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, Scalar::max)
    }

    #[inline(always)]
    fn where_positive(self, then: Self, otherwise: Self) -> Self {
        let mut found = [0.0; W];
        for (((found, x), then), otherwise) in found.iter_mut().zip(self.0).zip(then.0).zip(otherwise.0) {
            *found = x.where_positive(then, otherwise);
        }
        Lanes(found)
    }

    fn ln_gamma(self) -> Self {
        // Trials, and what was counted, are the same for all particles.
        self.same().map_or_else(|| self.map(Scalar::ln_gamma), |same| Lanes::from(Scalar::ln_gamma(same)))
    }

    fn erf(self) -> Self {
        self.map(Scalar::erf)
    }

    fn normal_cdf(self) -> Self {
        self.map(Scalar::normal_cdf)
    }
    fn custom<const K: usize>(
        arguments: [Self; K],
        of: impl Fn([f64; K]) -> f64,
        _: impl Fn([f64; K], f64) -> [f64; K],
    ) -> Self {
        Lanes(std::array::from_fn(|lane| of(arguments.map(|argument| argument.0[lane]))))
    }
}
