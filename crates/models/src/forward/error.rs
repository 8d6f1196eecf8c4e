//! Why there are no exact probabilities.

use thiserror::Error;

use crate::ModelError;

/// Why the forward algorithm does not go on.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ForwardError {
    /// More states can be reached than are looked at.
    #[error("more than {0} states of the model can be reached")]
    TooManyStates(usize),
    /// There are more ways from the states of one time to those of the next than are looked at.
    #[error("there are more than {0} ways from the states of one time to those of the next")]
    TooManyWays(usize),
    /// Something is drawn from a distribution without masses, or with infinitely many.
    #[error("something is drawn that is not one of a few values")]
    NotDiscrete,
    /// A state, or the density of the measurement there, is NaN or infinite.
    #[error("at the state {state:?} a state or a density is not a finite number")]
    NotANumber {
        /// The state that it came of, if there is one.
        previous: Option<Vec<f64>>,
        /// The state.
        state: Vec<f64>,
    },
    /// No state explains the measurement.
    #[error("no state explains the measurement")]
    Impossible,
    /// The model cannot be used.
    #[error(transparent)]
    Model(#[from] ModelError),
}
