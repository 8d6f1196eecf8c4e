//! What a name of a file can mean.

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
    Input(usize),
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
