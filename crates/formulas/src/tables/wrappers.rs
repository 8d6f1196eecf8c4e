//! What measurements can have besides the distributions of states: these made into others.

use super::families::Range;

/// Which one it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wrapping {
    VonMises,
    Rounded,
    Censored,
    Truncated,
    ZeroInflated,
    Mixture,
    Floored,
    LogDensity,
    /// A categorical that is measured: its arguments are probabilities.
    Categorical,
}

/// What an argument is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Argument {
    Number(Range),
    /// A number or an infinite one.
    End,
    Distribution,
    /// A number that may depend on the measurement itself.
    Formula,
}

impl Argument {
    /// Whether a number is in its range.
    pub(crate) fn has(self, value: f64) -> bool {
        match self {
            Argument::Number(range) => range.has(value),
            Argument::End => !value.is_nan(),
            Argument::Distribution | Argument::Formula => true,
        }
    }

    /// Its range in words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Argument::Number(range) => range.words(),
            Argument::End => "a number, inf or -inf",
            Argument::Distribution => "a distribution",
            Argument::Formula => "a formula",
        }
    }
}

/// What makes a distribution of a measurement: its name, its arguments, and a line about it.
#[derive(Debug, PartialEq)]
pub(crate) struct Wrapper {
    pub(crate) name: &'static str,
    pub(crate) parameters: &'static [&'static str],
    pub(crate) arguments: &'static [Argument],
    pub(crate) about: &'static str,
    pub(crate) wrapping: Wrapping,
}

impl Wrapper {
    /// Whether the parts must have a distribution function.
    pub(crate) fn needs_masses(&self) -> bool {
        matches!(self.wrapping, Wrapping::Rounded | Wrapping::Censored | Wrapping::Truncated)
    }

    /// Whether its distribution function serves another, as far as it is its own business. Ends may lie on numbers with a probability of their own, which intervals of a
    /// rounded number do not.
    pub(crate) fn has_masses_for(&self, outer: Wrapping) -> bool {
        match self.wrapping {
            Wrapping::Rounded | Wrapping::Truncated | Wrapping::Mixture => true,
            Wrapping::Censored | Wrapping::ZeroInflated => outer == Wrapping::Rounded,
            Wrapping::VonMises | Wrapping::Floored | Wrapping::LogDensity | Wrapping::Categorical => false,
        }
    }

    /// Which arguments are its two ends, if it has such.
    pub(crate) fn ends(&self) -> Option<[usize; 2]> {
        let is_end = |at: &usize| self.arguments[*at] == Argument::End;
        let mut ends = (0..self.arguments.len()).filter(is_end);
        Some([ends.next()?, ends.next()?])
    }
}

/// A row of the table.
const fn row(
    name: &'static str,
    wrapping: Wrapping,
    parameters: &'static [&'static str],
    arguments: &'static [Argument],
    about: &'static str,
) -> Wrapper {
    Wrapper { name, parameters, arguments, about, wrapping }
}

use Argument::{Distribution, End, Formula, Number};

/// All of them.
pub(crate) static WRAPPERS: [Wrapper; 8] = [
    row(
        "von_mises",
        Wrapping::VonMises,
        &["mu", "kappa"],
        &[Number(Range::Any), Number(Range::FromZero)],
        "An angle in radians, any number of turns; kappa is about 1/variance.",
    ),
    row(
        "rounded",
        Wrapping::Rounded,
        &["d"],
        &[Distribution],
        "A number of d rounded to an integer: y has the mass of d from y − ½ to y + ½.",
    ),
    row(
        "censored",
        Wrapping::Censored,
        &["d", "low", "high"],
        &[Distribution, End, End],
        "A number of d; where it lies below low or above high, that end instead.",
    ),
    row(
        "truncated",
        Wrapping::Truncated,
        &["d", "low", "high"],
        &[Distribution, End, End],
        "A number of d, given that it lies from low to high.",
    ),
    row(
        "zero_inflated",
        Wrapping::ZeroInflated,
        &["p", "d"],
        &[Number(Range::Probability), Distribution],
        "0 with probability p, else a number of d.",
    ),
    row(
        "mixture",
        Wrapping::Mixture,
        &["w", "d1", "d2"],
        &[Number(Range::Probability), Distribution, Distribution],
        "A number of d1 with probability w, else of d2.",
    ),
    row(
        "floored",
        Wrapping::Floored,
        &["d", "eps"],
        &[Distribution, Number(Range::AboveZero)],
        "The density of d plus eps; eps alone where a parameter of d is out of range. Simulated as d.",
    ),
    row(
        "log_density",
        Wrapping::LogDensity,
        &["f"],
        &[Formula],
        "The log density itself; f may use the measurement by its name. It filters and cannot be simulated.",
    ),
];

/// What a categorical is to measurements, whose row is among the distributions that states have, too.
pub(crate) static MEASURED_CATEGORICAL: Wrapper = row(
    "categorical",
    Wrapping::Categorical,
    &["p0", "p1", "…"],
    &[Number(Range::Probability)],
    "0, 1, … with these probabilities.",
);

/// The one of that name.
pub(crate) fn wrapper(name: &str) -> Option<&'static Wrapper> {
    WRAPPERS.iter().find(|wrapper| wrapper.name == name)
}
