//! What can be wrong with what a file composes: functions of its own, sums, draws of several parts, priors.

use thiserror::Error;

/// What is wrong, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ComposedProblem {
    /// The key of a function that is none.
    #[error(
        "`{0}` is no function; it is written f(x) or f(x, y), with the names of its arguments, each once"
    )]
    BadFunction(String),
    /// A function where there is none.
    #[error("`{0}` is written like a function; functions stand in [definitions]")]
    FunctionElsewhere(String),
    /// A sum that has no end.
    #[error(
        "`{0}` is the index of a sum, and of no vector or list in it; as in sum({0}, x[{0}]), one says how far it goes"
    )]
    SumAlongNothing(String),
    /// A sum along vectors of two lengths.
    #[error("`{index}` goes along vectors or lists of {} and of {}; they must be of one length", lengths[0], lengths[1])]
    SumOfTwoLengths {
        /// The index.
        index: String,
        /// The lengths.
        lengths: [usize; 2],
    },
    /// A distribution that is made of others, in a formula.
    #[error("`{name}` stands alone; {cure}")]
    CompoundMoved {
        /// The distribution.
        name: String,
        /// What can be done in this section.
        cure: &'static str,
    },
    /// A distribution that is only a prior, in a formula.
    #[error("`{0}` stands alone in a prior; it is not shifted or scaled")]
    PriorMoved(String),
    /// A covariance that is no square.
    #[error(
        "the row has {found} of {expected} numbers; the covariance has as many rows and columns as there are means"
    )]
    RowOfCovariance {
        /// Its numbers.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// A covariance that is none.
    #[error("the covariance is not symmetric and positive definite; it must be")]
    NoCovariance,
    /// A distribution of several parts where one number is.
    #[error(
        "`{0}` draws several numbers at once; as a line of [draws], n = \"{0}(…)\", they are n[0], n[1], …, which any line of [transition] may use, as in x[2] = \"n[i]\""
    )]
    PartsElsewhere(String),
    /// A distribution of several parts as a start.
    #[error("`{0}` draws several numbers at once; a start that does is an mvnormal or a dirichlet")]
    PartsAtStart(String),
    /// A distribution of several parts as a measurement.
    #[error(
        "`{0}` has several numbers, and a measurement is one; measure each in a line of its own, with what they share as a draw of [draws]"
    )]
    PartsMeasured(String),
    /// Several draws of several parts each.
    #[error("`{0}` has as many coordinates as its distribution has parts; it is written without a length")]
    VectorOfParts(String),
    /// A distribution that is no prior.
    #[error("`{0}` is for states and draws; a prior is a distribution of one number, or a dirichlet")]
    NoPrior(String),
    /// A distribution that is only a prior.
    #[error("`{0}` is for priors, in [parameters]")]
    OnlyPrior(String),
    /// A prior that needs a parameter with a prior.
    #[error(
        "`{0}` has a prior itself; a prior is made of numbers, and of parameters above it that are numbers"
    )]
    PriorOfPrior(String),
    /// A prior with nothing in it.
    #[error("between {low} and {high} the distribution has no probability")]
    NothingBetween {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// A start that the prior does not have.
    #[error("the start {0} is no value that the prior can give")]
    StartOutside(f64),
    /// Functions that call functions without end.
    #[error("functions call each other more than {0} deep; fewer would do")]
    CallsTooDeep(usize),
}
