//! What names mean where a formula stands.

use std::collections::BTreeMap;

use crate::error::Section;

/// What a name of the file means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Meaning {
    Parameter(f64),
    /// Coordinates of the state from `first` on.
    State {
        first: usize,
        length: Option<usize>,
    },
    Measurement,
    Definition {
        number: usize,
        length: Option<usize>,
        needs_states: bool,
    },
}

/// What is known to a formula.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scope<'a> {
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    pub(crate) section: Section,
    /// Whether it is the formula of a vector.
    pub(crate) is_vector: bool,
}
