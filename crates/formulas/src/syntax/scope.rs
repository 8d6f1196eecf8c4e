//! What names mean where a formula stands.

use std::collections::BTreeMap;

use crate::error::Section;

/// What a name of the file means.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Meaning {
    Parameter(f64),
    /// A parameter that is a list, with so many entries along each index.
    List {
        number: usize,
        lengths: Vec<usize>,
    },
    /// Coordinates of the state from `first` on.
    State {
        first: usize,
        length: Option<usize>,
    },
    /// Draws of a step, the first of which is so much behind the states.
    Draw {
        first: usize,
        length: Option<usize>,
    },
    Measurement,
    /// A parameter with a prior, in the prior of another one.
    Prior,
    Definition {
        number: usize,
        length: Option<usize>,
    },
    /// A function, which has a number among the definitions.
    Function {
        number: usize,
        arguments: Vec<String>,
    },
}

/// What is known to a formula.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scope<'a> {
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    pub(crate) section: Section,
    /// Whether it is the formula of a vector.
    pub(crate) is_vector: bool,
    /// The arguments of the function whose formula it is; none elsewhere. They come before all other names.
    pub(crate) arguments: &'a [String],
}

/// A sum that is read.
pub(super) struct Along<'a> {
    /// The name of its index.
    pub(super) index: &'a str,
    /// The value of the index now.
    pub(super) value: usize,
    /// How long the vectors and lists are that the index goes along, once there is one.
    pub(super) length: Option<usize>,
}
