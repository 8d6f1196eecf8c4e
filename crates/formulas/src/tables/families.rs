//! The distributions of formulas.

use motes_models::equations::{
    Coordinates, Distribution, Scalar, bernoulli, binomial, exponential, gamma, laplace, log_normal,
    negative_binomial, normal, poisson, student_t, uniform,
};

/// Which distribution it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Normal,
    StudentT,
    Laplace,
    LogNormal,
    Exponential,
    Gamma,
    Uniform,
    Poisson,
    NegativeBinomial,
    Binomial,
    Bernoulli,
}

/// What a parameter of a distribution may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// A finite number.
    Any,
    /// Above 0.
    AboveZero,
    /// At least 0.
    FromZero,
    /// Between 0 and 1.
    Probability,
    /// An integer of at least 0.
    Count,
}

impl Range {
    /// Whether a number is in it; infinite ones are in none.
    pub fn has(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Range::Any => true,
                Range::AboveZero => value > 0.0,
                Range::FromZero => value >= 0.0,
                Range::Probability => (0.0..=1.0).contains(&value),
                Range::Count => value >= 0.0 && value.fract() == 0.0,
            }
    }

    /// The range in words.
    pub fn words(self) -> &'static str {
        match self {
            Range::Any => "a finite number",
            Range::AboveZero => "above 0",
            Range::FromZero => "at least 0",
            Range::Probability => "between 0 and 1",
            Range::Count => "an integer of at least 0",
        }
    }
}

/// A distribution: its name, the names and ranges of its parameters, and a line about it.
#[derive(Debug, PartialEq)]
pub struct Family {
    /// Its name, by which it is called.
    pub name: &'static str,
    /// The names of its parameters.
    pub parameters: &'static [&'static str],
    /// What each of them may be.
    pub ranges: &'static [Range],
    /// What it is, in a sentence.
    pub about: &'static str,
    pub(crate) kind: Kind,
}

impl Family {
    /// Whether it is one of counts, which can be neither shifted nor scaled.
    pub fn is_of_counts(&self) -> bool {
        matches!(self.kind, Kind::Poisson | Kind::NegativeBinomial | Kind::Binomial | Kind::Bernoulli)
    }
}

/// A row of the table.
const fn row(
    name: &'static str,
    kind: Kind,
    parameters: &'static [&'static str],
    ranges: &'static [Range],
    about: &'static str,
) -> Family {
    Family { name, parameters, ranges, about, kind }
}

use Range::{AboveZero, Any, Count, FromZero, Probability};

/// All distributions.
pub(crate) static FAMILIES: [Family; 11] = [
    row("normal", Kind::Normal, &["mean", "sd"], &[Any, AboveZero], "The normal distribution."),
    row(
        "student_t",
        Kind::StudentT,
        &["df", "location", "scale"],
        &[AboveZero, Any, AboveZero],
        "Student's t with df degrees of freedom, for noise with outliers.",
    ),
    row(
        "laplace",
        Kind::Laplace,
        &["location", "scale"],
        &[Any, AboveZero],
        "Laplace's distribution; its standard deviation is √2·scale.",
    ),
    row(
        "log_normal",
        Kind::LogNormal,
        &["location", "scale"],
        &[Any, AboveZero],
        "That of e^z for a normal z with this mean and standard deviation.",
    ),
    row("exponential", Kind::Exponential, &["mean"], &[AboveZero], "The exponential distribution."),
    row(
        "gamma",
        Kind::Gamma,
        &["shape", "scale"],
        &[AboveZero, AboveZero],
        "The gamma distribution with mean shape·scale.",
    ),
    row("uniform", Kind::Uniform, &["low", "high"], &[Any, Any], "All numbers from low to high alike."),
    row("poisson", Kind::Poisson, &["mean"], &[FromZero], "Counts of events, where mean are expected."),
    row(
        "negative_binomial",
        Kind::NegativeBinomial,
        &["mean", "size"],
        &[FromZero, AboveZero],
        "Counts with the variance mean + mean²/size.",
    ),
    row(
        "binomial",
        Kind::Binomial,
        &["n", "p"],
        &[Count, Probability],
        "Successes in n trials with probability p each.",
    ),
    row("bernoulli", Kind::Bernoulli, &["p"], &[Probability], "1 with probability p, else 0."),
];

/// The distribution of that name.
pub fn family(name: &str) -> Option<&'static Family> {
    FAMILIES.iter().find(|family| family.name == name)
}

/// The family of a kind.
pub(crate) fn of_kind(kind: Kind) -> &'static Family {
    // Each kind has a row.
    FAMILIES.iter().find(|family| family.kind == kind).unwrap_or(&FAMILIES[0])
}

impl Kind {
    /// Pushes the distribution with these parameters, `shift + scale·x` of it where there are such. Parameters that it does not take are ignored.
    #[inline(always)]
    pub(crate) fn push<S: Scalar>(
        self,
        parameters: [S; 3],
        scale: Option<S>,
        shift: Option<S>,
        coordinates: &mut impl Coordinates<S>,
    ) {
        let [a, b, _] = parameters;
        // What takes it is compiled once for the common one, which it then knows, and once for all others.
        match self {
            Kind::Normal => coordinates.push(normal(a, b)),
            _ => coordinates.push(self.moved(parameters, scale, shift)),
        }
    }

    /// The distribution with these parameters, as [`Kind::push`] takes them.
    pub(crate) fn moved<S: Scalar>(
        self,
        [a, b, c]: [S; 3],
        scale: Option<S>,
        shift: Option<S>,
    ) -> Distribution<S> {
        let distribution = match self {
            Kind::Normal => normal(a, b),
            Kind::StudentT => student_t(a, b, c),
            Kind::Laplace => laplace(a, b),
            Kind::LogNormal => log_normal(a, b),
            Kind::Exponential => exponential(a),
            Kind::Gamma => gamma(a, b),
            Kind::Uniform => uniform(a, b),
            Kind::Poisson => poisson(a),
            Kind::NegativeBinomial => negative_binomial(a, b),
            Kind::Binomial => binomial(a, b),
            Kind::Bernoulli => bernoulli(a),
        };
        match (scale, shift) {
            (None, None) => distribution,
            (Some(scale), None) => distribution.scaled(scale),
            (None, Some(shift)) => distribution.shifted(shift),
            (Some(scale), Some(shift)) => distribution.scaled(scale).shifted(shift),
        }
    }
}
