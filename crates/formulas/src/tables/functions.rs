//! The functions of formulas.

use crate::operations::{Binary, Unary};

/// What a function computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Operation {
    OfOne(Unary),
    OfTwo(Binary),
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
pub(crate) static FUNCTIONS: [Function; 13] = [
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
    row("min", &["a", "b"], Operation::OfTwo(Binary::Min), "The smaller one."),
    row("max", &["a", "b"], Operation::OfTwo(Binary::Max), "The larger one."),
    row("floor", &["x"], Operation::OfOne(Unary::Floor), "The largest integer that is not above."),
];

/// The function of that name.
pub(crate) fn function(name: &str) -> Option<&'static Function> {
    FUNCTIONS.iter().find(|function| function.name == name)
}
