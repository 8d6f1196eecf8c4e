//! What a name of a file can mean.

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
    Input(usize),
    Definition {
        number: usize,
        length: Option<usize>,
    },
}
