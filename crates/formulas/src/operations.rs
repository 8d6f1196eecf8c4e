//! The operations that formulas are made of.

use motes_models::equations::Scalar;

/// An operation on one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Unary {
    Negative,
    Sqrt,
    Exp,
    Log,
    Abs,
    Sin,
    Cos,
    Tan,
    Tanh,
    Atan,
    Floor,
}

impl Unary {
    #[inline(always)]
    pub(crate) fn of<S: Scalar>(self, a: S) -> S {
        match self {
            Unary::Negative => -a,
            Unary::Sqrt => a.sqrt(),
            Unary::Exp => a.exp(),
            Unary::Log => a.ln(),
            Unary::Abs => a.abs(),
            Unary::Sin => a.sin(),
            Unary::Cos => a.cos(),
            Unary::Tan => a.tan(),
            Unary::Tanh => a.tanh(),
            Unary::Atan => a.atan(),
            Unary::Floor => a.floor(),
        }
    }
}

/// An operation on two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Atan2,
    Min,
    Max,
}

impl Binary {
    #[inline(always)]
    pub(crate) fn of<S: Scalar>(self, a: S, b: S) -> S {
        match self {
            Binary::Add => a + b,
            Binary::Subtract => a - b,
            Binary::Multiply => a * b,
            Binary::Divide => a / b,
            Binary::Power => a.pow(b),
            Binary::Atan2 => a.atan2(b),
            Binary::Min => a.min(b),
            Binary::Max => a.max(b),
        }
    }
}

/// The exponent as the integer that it is, where it is one that repeated products are for.
pub(crate) fn integer_exponent(exponent: f64) -> Option<i32> {
    /// Beyond this the rounding of products adds up.
    const LARGEST: f64 = 1024.0;
    (exponent.fract() == 0.0 && exponent.abs() <= LARGEST).then_some(exponent as i32)
}
