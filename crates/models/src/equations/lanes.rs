//! Numbers of several particles side by side, on which one formula works at once.

use std::ops::{Add, Div, Mul, Neg, Sub};

use bytemuck::{Pod, TransparentWrapper, Zeroable};

use super::functions::{cos_of_all, exp_of_all, ln_of_all, sin_of_all};
use super::scalar::{Scalar, power};
use crate::batch::LANES;

/// One number of each of [`LANES`] particles. Every lane is computed by itself, to the last bit as a number alone.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, TransparentWrapper)]
#[repr(transparent)]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// A function of each number.
    #[inline(always)]
    fn map(self, function: impl Fn(f64) -> f64) -> Lanes {
        Lanes(std::array::from_fn(|lane| function(self.0[lane])))
    }

    /// A function of each pair of numbers.
    #[inline(always)]
    fn zip(self, other: Lanes, function: impl Fn(f64, f64) -> f64) -> Lanes {
        Lanes(std::array::from_fn(|lane| function(self.0[lane], other.0[lane])))
    }
}

impl From<f64> for Lanes {
    #[inline(always)]
    fn from(value: f64) -> Lanes {
        Lanes([value; LANES])
    }
}

impl Neg for Lanes {
    type Output = Lanes;

    #[inline(always)]
    fn neg(self) -> Lanes {
        self.map(|x| -x)
    }
}

/// An operator on two, and on one and a plain number.
macro_rules! operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Lanes {
            type Output = Lanes;

            #[inline(always)]
            fn $method(self, other: Lanes) -> Lanes {
                self.zip(other, |a, b| a $operator b)
            }
        }

        impl $trait<f64> for Lanes {
            type Output = Lanes;

            #[inline(always)]
            fn $method(self, other: f64) -> Lanes {
                self.map(|a| a $operator other)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Scalar for Lanes {
    #[inline(always)]
    fn sqrt(self) -> Lanes {
        self.map(f64::sqrt)
    }

    fn exp(self) -> Lanes {
        Lanes(exp_of_all(&self.0))
    }

    fn ln(self) -> Lanes {
        Lanes(ln_of_all(&self.0))
    }

    #[inline(always)]
    fn abs(self) -> Lanes {
        self.map(f64::abs)
    }

    fn sin(self) -> Lanes {
        Lanes(sin_of_all(&self.0))
    }

    fn cos(self) -> Lanes {
        Lanes(cos_of_all(&self.0))
    }

    fn tan(self) -> Lanes {
        self.map(f64::tan)
    }

    fn tanh(self) -> Lanes {
        self.map(f64::tanh)
    }

    fn atan(self) -> Lanes {
        self.map(f64::atan)
    }

    fn atan2(self, x: Lanes) -> Lanes {
        self.zip(x, f64::atan2)
    }

    #[inline(always)]
    fn floor(self) -> Lanes {
        self.map(f64::floor)
    }

    #[inline(always)]
    fn powi(self, n: i32) -> Lanes {
        power(self, n, Lanes::from(1.0))
    }

    fn pow(self, y: Lanes) -> Lanes {
        self.zip(y, f64::powf)
    }

    #[inline(always)]
    fn min(self, other: Lanes) -> Lanes {
        self.zip(other, Scalar::min)
    }

    #[inline(always)]
    fn max(self, other: Lanes) -> Lanes {
        self.zip(other, Scalar::max)
    }

    #[inline(always)]
    fn where_positive(self, then: Lanes, otherwise: Lanes) -> Lanes {
        let chosen = |lane: usize| self.0[lane].where_positive(then.0[lane], otherwise.0[lane]);
        Lanes(std::array::from_fn(chosen))
    }

    fn ln_gamma(self) -> Lanes {
        self.map(Scalar::ln_gamma)
    }
}
