//! What names mean where a formula stands.

use std::collections::BTreeMap;

use crate::error::Section;

/// What a name of the file means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Meaning {
    Parameter(f64),
    /// A parameter that is a list, with so many indices.
    List {
        number: usize,
        dimensions: usize,
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
    Definition {
        number: usize,
        length: Option<usize>,
    },
}

/// What is known to a formula.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scope<'a> {
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    pub(crate) section: Section,
    /// Whose formula it is.
    pub(crate) own: &'a str,
    /// Whether it is the formula of a vector.
    pub(crate) is_vector: bool,
}
