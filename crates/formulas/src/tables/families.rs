//! The distributions of formulas.

use motes_models::equations::{
    Beta, Binomial, Coordinates, Distribution, Exponential, Gamma, Laplace, LogNormal, NegativeBinomial,
    Normal, Poisson, Scalar, StudentT, Uniform, normal,
};

/// Which distribution it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Normal,
    /// A normal distribution whose standard deviation may be 0.
    Exact,
    StudentT,
    Laplace,
    LogNormal,
    Exponential,
    Gamma,
    Beta,
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

/// Which numbers a distribution can give, before it is shifted and scaled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Values {
    Any,
    FromZero,
    /// Its density is 0 at 0 itself.
    AboveZero,
    /// Those between 0 and 1, without these.
    InsideOne,
    /// Those from its first parameter to its second.
    Between,
    Counts(Most),
}

/// The largest count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Most {
    Any,
    One,
    /// The first parameter.
    First,
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
    pub(crate) values: Values,
    /// Which of its parameters is a location that the next one is the scale to, if there are such.
    pub(crate) location: Option<usize>,
}

impl Family {
    /// Whether it is one of counts, which can be neither shifted nor scaled.
    pub fn is_of_counts(&self) -> bool {
        matches!(self.values, Values::Counts(_))
    }

    /// The distribution with these parameters, of which there are as many as the family has; `number` makes a parameter of a plain number. Nothing is checked.
    pub fn distribution<T>(
        &self,
        parameters: impl IntoIterator<Item = T>,
        number: impl Fn(f64) -> T,
    ) -> Distribution<T> {
        let mut parameters = parameters.into_iter();
        let [a, b, c] = std::array::from_fn(|_| parameters.next().unwrap_or_else(|| number(f64::NAN)));
        self.kind.distribution([a, b, c], number)
    }
}

/// A row of the table.
const fn row(
    name: &'static str,
    kind: Kind,
    parameters: &'static [&'static str],
    ranges: &'static [Range],
    values: Values,
    about: &'static str,
) -> Family {
    Family { name, parameters, ranges, about, kind, values, location: None }
}

impl Family {
    /// With a parameter that is a location, and the scale behind it.
    const fn located(self, at: usize) -> Family {
        Family { location: Some(at), ..self }
    }
}

use Range::{AboveZero, Any, Count, FromZero, Probability};

/// All distributions.
pub(crate) static FAMILIES: [Family; 12] = [
    row("normal", Kind::Normal, &["mean", "sd"], &[Any, AboveZero], Values::Any, "The normal distribution.")
        .located(0),
    row(
        "student_t",
        Kind::StudentT,
        &["df", "location", "scale"],
        &[AboveZero, Any, AboveZero],
        Values::Any,
        "Student's t with df degrees of freedom, for noise with outliers.",
    )
    .located(1),
    row(
        "laplace",
        Kind::Laplace,
        &["location", "scale"],
        &[Any, AboveZero],
        Values::Any,
        "Laplace's distribution; its standard deviation is √2·scale.",
    )
    .located(0),
    row(
        "log_normal",
        Kind::LogNormal,
        &["location", "scale"],
        &[Any, AboveZero],
        Values::AboveZero,
        "That of e^z for a normal z with this mean and standard deviation.",
    ),
    row(
        "exponential",
        Kind::Exponential,
        &["mean"],
        &[AboveZero],
        Values::FromZero,
        "The exponential distribution.",
    ),
    row(
        "gamma",
        Kind::Gamma,
        &["shape", "scale"],
        &[AboveZero, AboveZero],
        Values::AboveZero,
        "The gamma distribution with mean shape·scale.",
    ),
    row(
        "beta",
        Kind::Beta,
        &["a", "b"],
        &[AboveZero, AboveZero],
        Values::InsideOne,
        "The beta distribution between 0 and 1, with mean a/(a + b).",
    ),
    row(
        "uniform",
        Kind::Uniform,
        &["low", "high"],
        &[Any, Any],
        Values::Between,
        "All numbers from low to high alike.",
    ),
    row(
        "poisson",
        Kind::Poisson,
        &["mean"],
        &[FromZero],
        Values::Counts(Most::Any),
        "Counts of events, where mean are expected.",
    ),
    row(
        "negative_binomial",
        Kind::NegativeBinomial,
        &["mean", "size"],
        &[FromZero, AboveZero],
        Values::Counts(Most::Any),
        "Counts with the variance mean + mean²/size.",
    ),
    row(
        "binomial",
        Kind::Binomial,
        &["n", "p"],
        &[Count, Probability],
        Values::Counts(Most::First),
        "Successes in n trials with probability p each.",
    ),
    row(
        "bernoulli",
        Kind::Bernoulli,
        &["p"],
        &[Probability],
        Values::Counts(Most::One),
        "1 with probability p, else 0.",
    ),
];

/// A measurement without error, which has no row of its own: it is written as a normal number.
pub(crate) static EXACT: Family = row(
    "normal",
    Kind::Exact,
    &["mean", "sd"],
    &[Any, FromZero],
    Values::Any,
    "A normal number without spread.",
)
.located(0);

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
        // What takes it is compiled once for the common one, which it then knows, and once for all others: apart, because the compiler takes minutes for functions that are
        // too large.
        match self {
            Kind::Normal => coordinates.push(normal(a, b)),
            _ => self.push_apart(parameters, scale, shift, coordinates),
        }
    }

    #[inline(never)]
    fn push_apart<S: Scalar>(
        self,
        parameters: [S; 3],
        scale: Option<S>,
        shift: Option<S>,
        coordinates: &mut impl Coordinates<S>,
    ) {
        let [mean, sd, _] = parameters;
        coordinates.push(match self {
            Kind::Exact => Distribution::Normal(Normal { mean, sd }),
            _ => self.moved(parameters, scale, shift),
        });
    }

    /// `shift + scale·x` of the distribution with these parameters.
    pub(crate) fn moved<S: Scalar>(
        self,
        parameters: [S; 3],
        scale: Option<S>,
        shift: Option<S>,
    ) -> Distribution<S> {
        let distribution = self.distribution(parameters, S::from).guarded();
        match (scale, shift) {
            (None, None) => distribution,
            (Some(scale), None) => distribution.scaled(scale),
            (None, Some(shift)) => distribution.shifted(shift),
            (Some(scale), Some(shift)) => distribution.scaled(scale).shifted(shift),
        }
    }

    /// With parameters of any kind, which are not checked; `number` makes one of a plain number.
    fn distribution<T>(self, [a, b, c]: [T; 3], number: impl Fn(f64) -> T) -> Distribution<T> {
        let (zero, one) = (|| number(0.0), || number(1.0));
        match self {
            Kind::Normal | Kind::Exact => Distribution::Normal(Normal { mean: a, sd: b }),
            Kind::StudentT => Distribution::StudentT(StudentT { df: a, location: b, scale: c }),
            Kind::Laplace => Distribution::Laplace(Laplace { location: a, scale: b }),
            Kind::LogNormal => {
                Distribution::LogNormal(LogNormal { origin: zero(), sign: one(), location: a, scale: b })
            }
            Kind::Exponential => Distribution::Exponential(Exponential { origin: zero(), mean: a }),
            Kind::Gamma => Distribution::Gamma(Gamma { origin: zero(), shape: a, scale: b }),
            Kind::Beta => Distribution::Beta(Beta { origin: zero(), scale: one(), a, b }),
            Kind::Uniform => Distribution::Uniform(Uniform { low: a, high: b }),
            Kind::Poisson => Distribution::Poisson(Poisson { mean: a }),
            Kind::NegativeBinomial => Distribution::NegativeBinomial(NegativeBinomial { mean: a, size: b }),
            Kind::Binomial => Distribution::Binomial(Binomial { n: a, p: b }),
            Kind::Bernoulli => Distribution::Binomial(Binomial { n: one(), p: a }),
        }
    }
}
