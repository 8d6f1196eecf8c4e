//! The functions of formulas.

use crate::operations::{Binary, Unary};

/// What a function computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Operation {
    OfOne(Unary),
    OfTwo(Binary),
    /// Two numbers or more, one after another.
    OfMany(Binary),
    If,
}

/// A function: its name, the names of what it takes, and a line about it.
#[derive(Debug, PartialEq)]
pub(crate) struct Function {
    pub(crate) name: &'static str,
    pub(crate) parameters: &'static [&'static str],
    pub(crate) about: &'static str,
    pub(crate) operation: Operation,
}

/// A row of the table.
const fn row(
    name: &'static str,
    parameters: &'static [&'static str],
    operation: Operation,
    about: &'static str,
) -> Function {
    Function { name, parameters, about, operation }
}

/// All functions.
pub(crate) static FUNCTIONS: [Function; 25] = [
    row("sqrt", &["x"], Operation::OfOne(Unary::Sqrt), "The square root; NaN below 0."),
    row("exp", &["x"], Operation::OfOne(Unary::Exp), "The exponential."),
    row("log", &["x"], Operation::OfOne(Unary::Log), "The natural logarithm; NaN below 0."),
    row("abs", &["x"], Operation::OfOne(Unary::Abs), "The absolute value."),
    row("sin", &["x"], Operation::OfOne(Unary::Sin), "The sine of an angle in radians."),
    row("cos", &["x"], Operation::OfOne(Unary::Cos), "The cosine of an angle in radians."),
    row("tan", &["x"], Operation::OfOne(Unary::Tan), "The tangent of an angle in radians."),
    row("tanh", &["x"], Operation::OfOne(Unary::Tanh), "The hyperbolic tangent."),
    row("atan", &["x"], Operation::OfOne(Unary::Atan), "The angle within ±π/2 whose tangent is x."),
    row("atan2", &["y", "x"], Operation::OfTwo(Binary::Atan2), "The angle of the point (x, y), within ±π."),
    row("min", &["a", "b", "…"], Operation::OfMany(Binary::Min), "The smallest one, of two or more."),
    row("max", &["a", "b", "…"], Operation::OfMany(Binary::Max), "The largest one, of two or more."),
    row("floor", &["x"], Operation::OfOne(Unary::Floor), "The largest integer that is not above."),
    row("ceil", &["x"], Operation::OfOne(Unary::Ceil), "The smallest integer that is not below."),
    row("round", &["x"], Operation::OfOne(Unary::Round), "The nearest integer; halves go up."),
    row("mod", &["a", "b"], Operation::OfTwo(Binary::Modulo), "a − b·floor(a/b): from 0 up to b."),
    row("sign", &["x"], Operation::OfOne(Unary::Sign), "−1, 0 or 1."),
    row("log1p", &["x"], Operation::OfOne(Unary::Log1p), "log(1 + x), with all digits near 0."),
    row("expm1", &["x"], Operation::OfOne(Unary::Expm1), "exp(x) − 1, with all digits near 0."),
    row("logit", &["p"], Operation::OfOne(Unary::Logit), "log(p/(1 − p))."),
    row("logistic", &["x"], Operation::OfOne(Unary::Logistic), "1/(1 + exp(−x))."),
    row(
        "lgamma",
        &["x"],
        Operation::OfOne(Unary::LogGamma),
        "The logarithm of the gamma function; NaN at 0 and below.",
    ),
    row("erf", &["x"], Operation::OfOne(Unary::Erf), "The error function."),
    row(
        "normal_cdf",
        &["x"],
        Operation::OfOne(Unary::NormalCdf),
        "The probability of a standard normal number below x.",
    ),
    row("if", &["c", "a", "b"], Operation::If, "a where c is not 0, else b."),
];

/// The function of that name.
pub(crate) fn function(name: &str) -> Option<&'static Function> {
    FUNCTIONS.iter().find(|function| function.name == name)
}
