//! Distributions that are made of others: of one draw after another, or of a draw and what is computed of it.

use super::families::Range;

/// By how much the probabilities of a particle may differ from 1 in sum.
pub(crate) const MOST_OFF: f64 = 1e-6;

impl Composition {
    /// Whether parameters can have it as a prior.
    pub(crate) fn is_prior(self) -> bool {
        matches!(self, Composition::Prior(_) | Composition::Dirichlet)
    }
}

/// How a distribution is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Composition {
    /// Binomials, each of those that are left.
    EulerMultinomial,
    /// Where a uniform number lies among the sums of probabilities.
    Categorical,
    /// Normals, each given those before it; its parameters are the means, then the covariance by rows.
    MvNormal,
    /// Betas, each of the share that is left; a prior of lists, too.
    Dirichlet,
    /// One that is only a prior.
    Prior(PriorKind),
}

/// Distributions of parameters alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PriorKind {
    InverseGamma,
    HalfNormal,
    HalfCauchy,
    /// Its first parameter is another distribution.
    Truncated,
}

/// A distribution that is made of others.
#[derive(Debug, PartialEq)]
pub(crate) struct Compound {
    pub(crate) name: &'static str,
    /// The last one but `…` may be there several times.
    pub(crate) parameters: &'static [&'static str],
    /// What the first ones may be; that of the last is that of all others.
    pub(crate) ranges: &'static [Range],
    pub(crate) about: &'static str,
    pub(crate) composition: Composition,
    /// Of a distribution of several parts: how many parameters come before those that are one for each part.
    pub(crate) parts: Option<usize>,
}

impl Compound {
    /// What a parameter is called.
    pub(crate) fn parameter(&self, number: usize) -> &'static str {
        let names = self.parameters.iter().filter(|name| **name != "…");
        names.take(number + 1).last().copied().unwrap_or_default()
    }

    /// What a parameter may be, in words.
    pub(crate) fn words(&self, number: usize) -> &'static str {
        match (self.composition, number) {
            (Composition::MvNormal, 0) => "finite numbers",
            (Composition::MvNormal, _) => "positive definite",
            (Composition::Prior(PriorKind::Truncated), 0) => "a distribution with a density",
            (Composition::Prior(PriorKind::Truncated), 1) => "a number, or -inf",
            (Composition::Prior(PriorKind::Truncated), _) => "a number, or inf",
            _ => self.range(number).words(),
        }
    }

    /// What a parameter may be.
    pub(crate) fn range(&self, number: usize) -> Range {
        let last = self.ranges.last().copied().unwrap_or(Range::Any);
        self.ranges.get(number).copied().unwrap_or(last)
    }
}

/// All of them.
pub(crate) static COMPOUNDS: [Compound; 8] = [
    Compound {
        name: "categorical",
        parameters: &["p0", "p1", "…"],
        ranges: &[Range::Probability],
        about: "0, 1, … with these probabilities, which add up to 1; for states, draws and measurements.",
        composition: Composition::Categorical,
        parts: None,
    },
    Compound {
        name: "euler_multinomial",
        parameters: &["n", "rate", "…"],
        ranges: &[Range::Count, Range::FromZero],
        about: "How many of n leave by each of several ways during a step, at these rates; for draws.",
        composition: Composition::EulerMultinomial,
        parts: Some(1),
    },
    Compound {
        name: "mvnormal",
        parameters: &["[m0, …]", "[[S00, …], …]"],
        ranges: &[Range::Any],
        about: "Normal numbers with these means and this covariance, by rows; for draws and starts.",
        composition: Composition::MvNormal,
        parts: Some(0),
    },
    Compound {
        name: "dirichlet",
        parameters: &["a0", "a1", "…"],
        ranges: &[Range::AboveZero],
        about: "Shares that add up to 1, with means in the ratio of these numbers; for draws, starts, and priors of lists.",
        composition: Composition::Dirichlet,
        parts: Some(0),
    },
    prior(
        "inverse_gamma",
        PriorKind::InverseGamma,
        &["shape", "scale"],
        &[Range::AboveZero],
        "That of scale/G for a gamma G of this shape and scale 1; for priors.",
    ),
    prior(
        "half_normal",
        PriorKind::HalfNormal,
        &["sd"],
        &[Range::AboveZero],
        "The size of a normal number with mean 0; for priors.",
    ),
    prior(
        "half_cauchy",
        PriorKind::HalfCauchy,
        &["scale"],
        &[Range::AboveZero],
        "The size of a number of Cauchy's distribution around 0; for priors.",
    ),
    prior(
        "truncated",
        PriorKind::Truncated,
        &["d", "low", "high"],
        &[Range::Any],
        "What lies between two numbers of a distribution d; for priors.",
    ),
];

/// A row of a distribution of parameters.
const fn prior(
    name: &'static str,
    kind: PriorKind,
    parameters: &'static [&'static str],
    ranges: &'static [Range],
    about: &'static str,
) -> Compound {
    Compound { name, parameters, ranges, about, composition: Composition::Prior(kind), parts: None }
}

/// The one of that name.
pub(crate) fn compound(name: &str) -> Option<&'static Compound> {
    COMPOUNDS.iter().find(|compound| compound.name == name)
}
