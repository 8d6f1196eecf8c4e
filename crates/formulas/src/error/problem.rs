//! Everything that can be wrong with what a model file says.

use thiserror::Error;

use super::composed::ComposedProblem;

/// What is wrong, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Problem {
    /// The text is not UTF-8.
    #[error("this is no UTF-8 text; a model file must be")]
    NotUtf8,
    /// The text is not TOML: the parser's reason.
    #[error("this is not TOML: {0}")]
    NotToml(String),
    /// A formula without quotes.
    #[error("a formula stands in quotes: {key} = \"{formula}\"")]
    NoQuotes {
        /// The key.
        key: String,
        /// What stands after it.
        formula: String,
    },
    /// A key or section that is there twice.
    #[error("`{0}` is there twice; it can be there only once")]
    TwiceHere(String),
    /// A key or section that model files do not have.
    #[error("a model file has no `{name}` here; {advice}")]
    UnknownKey {
        /// The key.
        name: String,
        /// What was meant, or what there is.
        advice: String,
    },
    /// A section for equations, of a model whose equations are functions.
    #[error(
        "functions state what {0} does in a model file; beside them there are [time], [inputs], [parameters] and [series]"
    )]
    OfFunctions(&'static str),
    /// A section or key that is needed is not there.
    #[error("there is no {name}; it is needed: {example}")]
    Missing {
        /// What is missing.
        name: &'static str,
        /// How it may look.
        example: &'static str,
    },
    /// A kind of model that there is not.
    #[error(
        "there is no kind `{0}`; it must be \"linear-gaussian\", and is left out where there are formulas"
    )]
    UnknownKind(String),
    /// A value of the wrong kind.
    #[error("it is {found}; it must be {expected}")]
    Value {
        /// What is there.
        found: String,
        /// What would be right.
        expected: String,
    },

    /// A key that is no name.
    #[error("`{0}` is no name; a name has letters, digits and _, and begins with a letter")]
    BadName(String),
    /// A vector of an impossible length.
    #[error(
        "`{length}` is no length of a vector; it must be an integer from 1 to {longest}, or a parameter that is one"
    )]
    BadLength {
        /// The length.
        length: String,
        /// The longest vector.
        longest: usize,
    },
    /// A part of a vector without a coordinate.
    #[error("the part from {first} to before {end} is empty; x[1..4] are x[1], x[2] and x[3]")]
    EmptyPart {
        /// Its first coordinate.
        first: usize,
        /// The first coordinate behind it.
        end: usize,
    },
    /// A part of a vector that does not go on where the one before ends.
    #[error(
        "parts of a vector go on without gaps: this one of `{name}` must begin at {expected}, not at {found}"
    )]
    PartApart {
        /// The vector.
        name: String,
        /// Where it begins.
        found: usize,
        /// Where it must begin.
        expected: usize,
    },
    /// A part of a vector that is defined.
    #[error(
        "`{0}` is defined by parts; a definition has one formula for all coordinates, which may use if(i == 0, …)"
    )]
    PartOfDefinition(String),
    /// A name that has a meaning of its own.
    #[error("`{name}` is {what}; another name is needed")]
    Reserved {
        /// The name.
        name: String,
        /// What it means.
        what: &'static str,
    },
    /// A name with two meanings.
    #[error("`{name}` stands in {other}, too; a name can mean one thing only")]
    Twice {
        /// The name.
        name: String,
        /// The section of the other meaning.
        other: &'static str,
    },
    /// A coordinate that only one of two sections has.
    #[error(
        "`{name}` is in {present}, but not in {absent}; each coordinate of the state needs a line in both"
    )]
    OneSided {
        /// The coordinate.
        name: String,
        /// The section that has it.
        present: &'static str,
        /// The section that does not.
        absent: &'static str,
    },
    /// A vector with two lengths.
    #[error("it must be {expected}, as in [initial]")]
    OtherLength {
        /// The name with the length of the other section.
        expected: String,
    },
    /// More coordinates than can be had.
    #[error("with it there are more than {0} coordinates; there can be at most so many")]
    TooMany(usize),
    /// A parameter is to be set that there is not.
    #[error("there is no parameter `{name}` to set; {advice}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// What was meant, or what there is.
        advice: String,
    },
    /// A parameter is to be set to what is no number.
    #[error("the parameter `{name}` is set to {value}; it must be a finite number")]
    ParameterNotFinite {
        /// The name.
        name: String,
        /// The value.
        value: f64,
    },

    /// A formula without anything.
    #[error("the formula is empty; it may look like \"normal(0, 1)\"")]
    Empty,
    /// A formula that is too long to be meant.
    #[error("the formula has {length} characters; it can have at most {longest}")]
    TooLong {
        /// Its characters.
        length: usize,
        /// The most that it can have.
        longest: usize,
    },
    /// Nesting without end.
    #[error(
        "parentheses, signs and powers are nested more than {0} deep; parts of it belong into [definitions]"
    )]
    TooDeep(usize),
    /// A character that formulas do not have.
    #[error("`{found}` has no meaning in a formula; {advice}")]
    UnexpectedCharacter {
        /// The character.
        found: char,
        /// What would be right.
        advice: &'static str,
    },
    /// Something in the wrong place.
    #[error("there is {found} where {expected} should be")]
    Unexpected {
        /// What is there.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// Two operands side by side.
    #[error("an operator is missing before {0}; a product is written with *, as in 2*x")]
    NoOperator(String),
    /// A number that is written otherwise.
    #[error("`{0}` is no number; numbers are written 0.5, 10, 1e-3")]
    BadNumber(String),
    /// A number beyond those of 64 bits.
    #[error("`{0}` is too large; numbers are below 1.8e308")]
    NumberTooLarge(String),

    /// A comparison of a comparison.
    #[error("{0} compares a comparison; write both with and, as in 0 < x and x < 1")]
    ChainedComparison(String),
    /// A name without a meaning.
    #[error("`{name}` is not known here; {advice}")]
    UnknownName {
        /// The name.
        name: String,
        /// What was meant, or what there is.
        advice: String,
    },
    /// A name that is a column of the data, and no input.
    #[error(
        "`{name}` is a column of {data}; formulas can use it where [inputs] has it, as in {name} = \"hold\""
    )]
    Undeclared {
        /// The name.
        name: String,
        /// The data.
        data: String,
    },
    /// A function with too many or too few arguments.
    #[error("`{call}` takes {expected}, not {found}")]
    Arity {
        /// The function with its parameters.
        call: String,
        /// How many it takes, in words.
        expected: String,
        /// How many it was given.
        found: usize,
    },
    /// A function that is not called.
    #[error("`{name}` stands alone; it is written {call}")]
    NotCalled {
        /// The function.
        name: String,
        /// How it is called.
        call: String,
    },
    /// What is no function is called.
    #[error("`{0}` is no function; a product is written {0}*(…)")]
    NotAFunction(String),
    /// What is no vector has an index.
    #[error("`{0}` is no vector; it is written without an index")]
    NotAVector(String),
    /// A vector has no index.
    #[error(
        "`{name}` is a vector of {length}; one of its coordinates is written {name}[0], or {name}[i] in the formula of a vector"
    )]
    NoIndex {
        /// The vector.
        name: String,
        /// Its length.
        length: usize,
    },
    /// An index that is no integer.
    #[error(
        "{0} is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *"
    )]
    BadIndex(String),
    /// An index of a list that it does not have.
    #[error("`{name}` has no entry {index}; its indices are 0 to {last}")]
    BeyondList {
        /// The list.
        name: String,
        /// The index.
        index: f64,
        /// The last index.
        last: usize,
    },
    /// A list with another number of indices.
    #[error("`{name}` is a list; an entry is written {example}")]
    Indices {
        /// The list.
        name: String,
        /// How an entry is written.
        example: String,
    },
    /// `i` where there is no vector.
    #[error(
        "`i` counts the coordinates of a vector; it has a meaning only in a formula like x[40] = \"…x[i-1]…\""
    )]
    NoCoordinate,
    /// A coordinate or draw before it has a value.
    #[error("`{name}` has no value here yet; {section} goes in order, and a line can use those above it")]
    NoValueYet {
        /// Its name.
        name: String,
        /// The section.
        section: &'static str,
    },
    /// A draw where there is none.
    #[error("`{0}` is a draw of a step; [draws] and [transition] can use it, and a state can keep it")]
    DrawElsewhere(String),
    /// A key of an input that does not go with its other keys.
    #[error("`{key}` is of {needs}; it must be left out here")]
    InputKey {
        /// The key.
        key: &'static str,
        /// What such an input is.
        needs: &'static str,
    },
    /// A sum over sub-steps where there is none.
    #[error("`{0}` sums up what came since the row before; it belongs into a measurement")]
    TotalElsewhere(&'static str),
    /// A sum over sub-steps of something else.
    #[error(
        "`{name}` is of {found}; it must be of a draw or a state by its name, as in {name}(x) or {name}(x[2])"
    )]
    TotalOf {
        /// The function.
        name: &'static str,
        /// What stands there.
        found: String,
    },
    /// A sum that each coordinate of a measured vector would begin anew.
    #[error(
        "`total_since_measured` is of one measurement; a vector of them takes a line for each coordinate, as y[0] and y[1]"
    )]
    TotalOfVector,
    /// A measurement in a formula.
    #[error(
        "`{0}` is a measurement; formulas are made of states, draws, inputs, parameters, definitions and t"
    )]
    MeasurementInFormula(String),

    /// A distribution in a definition.
    #[error("`{0}` is a distribution; it belongs where the definition is used")]
    RandomInDefinition(String),
    /// What measurements alone can have, elsewhere.
    #[error("`{0}` is for measurements; a state or a draw cannot have it")]
    OnlyMeasured(String),
    /// A number where a distribution belongs.
    #[error("`{found}` is no distribution; {parameter} of {call} is one, as in normal(x, 1)")]
    NoDistribution {
        /// What is there.
        found: String,
        /// The parameter.
        parameter: &'static str,
        /// What is called.
        call: String,
    },
    /// A distribution without a distribution function where one is needed.
    #[error(
        "`{inner}` has no masses for {call}; those of the table of distributions have, and {others} made of these"
    )]
    NoMasses {
        /// The distribution.
        inner: &'static str,
        /// What needs its masses.
        call: String,
        /// What else has masses.
        others: &'static str,
    },
    /// What is made of other distributions is shifted or scaled.
    #[error("`{0}` cannot be shifted or scaled; what stands inside of it can")]
    WrapperMoved(String),
    /// Another index of the measurement than its own.
    #[error("in its own log density `{0}` is the coordinate itself; it is written {0}, or {0}[i]")]
    OwnIndex(String),
    /// Two distributions in one formula.
    #[error("`{0}` is a second distribution; a coordinate has one, and others stand in [draws]")]
    TwoDistributions(String),
    /// A distribution where only numbers can be.
    #[error(
        "`{family}` stands inside of {inside}; it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value"
    )]
    RandomInside {
        /// The distribution.
        family: String,
        /// What it stands in.
        inside: String,
    },
    /// Counts that are shifted or scaled.
    #[error(
        "`{0}` gives counts, which cannot be shifted or scaled; as a line of [draws] it can be part of any formula of [transition]"
    )]
    CountsMoved(String),
    /// A measurement that is a function of states.
    #[error("a measurement has a distribution, as in \"{example}\"; a formula without noise can be a state")]
    NoNoise {
        /// The same formula with noise.
        example: String,
    },
    /// A coordinate whose noise is multiplied by 0.
    #[error(
        "`{0}` is multiplied by 0, so that the coordinate has no noise; the factor must be another number"
    )]
    NoNoiseLeft(String),
    /// A number that is out of range whatever the states are.
    #[error("{what} is {value}; it must be {expected}")]
    OutOfRange {
        /// Which number: a parameter of a distribution.
        what: String,
        /// Its value.
        value: f64,
        /// What would be right.
        expected: String,
    },
    /// Formulas that come to too much.
    #[error("up to here the formulas come to more than {0} operations; shorter vectors would do")]
    TooLarge(usize),
    /// Definitions that need each other.
    #[error("definitions go in a circle: {0}; one of them must do without the others")]
    Cycle(String),

    /// Something in functions of one's own, sums, draws of several parts, or priors.
    #[error(transparent)]
    Composed(#[from] ComposedProblem),
    /// Matrices that make no model.
    #[error("{0}")]
    Matrix(String),
}
