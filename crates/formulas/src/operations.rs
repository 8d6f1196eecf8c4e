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
    Ceil,
    Round,
    Sign,
    Log1p,
    Expm1,
    Logit,
    Logistic,
    LogGamma,
    Erf,
    NormalCdf,
    Not,
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
            // What only some models use is not part of each loop over instructions.
            _ => self.of_rare(a),
        }
    }

    #[inline(never)]
    fn of_rare<S: Scalar>(self, a: S) -> S {
        let (zero, one) = (S::from(0.0), S::from(1.0));
        match self {
            Unary::Ceil => -(-a).floor(),
            Unary::Round => {
                let down = a.floor();
                // Halves go up; `a + 0.5` would be 1 for the number below 0.5, and of large numbers even `down + 0.5` is rounded.
                (-(a - down) + 0.5).where_positive(down, down + 1.0)
            }
            Unary::Sign => a.where_positive(one, (-a).where_positive(-one, zero)),
            Unary::Log1p => {
                // What rounding takes from 1 + a is given back.
                let sum = a + 1.0;
                let lost = (sum - 1.0 - a) / sum;
                let is_small = -a.abs() + 1e15;
                // Beyond, and at −1, it is nothing or no number.
                sum.ln() - is_small.where_positive(sum.where_positive(lost, zero), zero)
            }
            Unary::Expm1 => (a * 0.5).tanh() * (a.exp() + 1.0),
            Unary::Logit => (a / (-a + 1.0)).ln(),
            // The exponential of what is negative stays finite, and its derivative with it. At 0 it is that of a: an absolute value has none there.
            Unary::Logistic => {
                let small = (-a).min(a).exp();
                a.where_positive(one, small) / (small + 1.0)
            }
            Unary::LogGamma => a.ln_gamma(),
            Unary::Erf => a.erf(),
            Unary::NormalCdf => a.normal_cdf(),
            Unary::Not => a.abs().where_positive(zero, one),
            _ => S::from(f64::NAN),
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
    /// The remainder of the first, from 0 up to the second.
    Modulo,
    /// 1 where it holds, else 0.
    Less,
    AtMost,
    Equal,
    NotEqual,
    And,
    Or,
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
            _ => self.of_rare(a, b),
        }
    }

    #[inline(never)]
    fn of_rare<S: Scalar>(self, a: S, b: S) -> S {
        let (zero, one) = (S::from(0.0), S::from(1.0));
        match self {
            Binary::Modulo => a - b * (a / b).floor(),
            Binary::Less => (b - a).where_positive(one, zero),
            Binary::AtMost => (a - b).where_positive(zero, one),
            Binary::Equal => (a - b).abs().where_positive(zero, one),
            Binary::NotEqual => (a - b).abs().where_positive(one, zero),
            Binary::And => choice(a, choice(b, one, zero), zero),
            Binary::Or => choice(a, one, choice(b, one, zero)),
            _ => S::from(f64::NAN),
        }
    }
}

/// The first where the condition is not 0, else the other.
#[inline(always)]
pub(crate) fn choice<S: Scalar>(condition: S, then: S, otherwise: S) -> S {
    condition.abs().where_positive(then, otherwise)
}

/// The exponent as the integer that it is, where it is one that repeated products are for.
pub(crate) fn integer_exponent(exponent: f64) -> Option<i32> {
    /// Beyond this the rounding of products adds up.
    const LARGEST: f64 = 1024.0;
    (exponent.fract() == 0.0 && exponent.abs() <= LARGEST).then_some(exponent as i32)
}
