//! What can go wrong in training, by kind.

use motes_models::ModelError;
use motes_smc::ProposalError;
use thiserror::Error;

/// An error of training.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrainError {
    /// A setting is outside its range.
    #[error("{name} is {value}; it must be {expected}")]
    Setting {
        /// Which setting.
        name: &'static str,
        /// The value found, as text.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// Of each set of simulated sequences one left the numbers.
    #[error(
        "of each of {tries} sets of sequences that the model drew, one runs to numbers that are not finite; look at the model's transition and noise"
    )]
    Simulations {
        /// How many sets were drawn.
        tries: u64,
    },
    /// Units are to be left out, and the proposal has none that can be.
    #[error(
        "the share of hidden units that are left out is {share}; it must be 0 for this proposal, which has no unit that can be left out"
    )]
    NoHiddenUnits {
        /// The share that was asked for.
        share: f64,
    },
    /// The measurements do not fit the model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// One of many sequences does not fit.
    #[error("sequence {number}, counted from 0: {source}")]
    Recording {
        /// Which one.
        number: usize,
        /// What does not fit.
        source: Box<TrainError>,
    },
    /// The proposal failed.
    #[error("in training step {step}{}, at time {time}: {source}", after(*loss))]
    Proposal {
        /// The training step.
        step: usize,
        /// The loss of the step before, if there was one.
        loss: Option<f64>,
        /// The time in the sequence.
        time: usize,
        /// What failed.
        source: ProposalError,
    },
    /// The proposal's networks could not be asked.
    #[error(transparent)]
    Networks(#[from] ProposalError),
    /// Recorded measurements cannot be learned from.
    #[error("the recorded measurements cannot be filtered: {reason}")]
    Recorded {
        /// Why not.
        reason: String,
    },
    /// There is no model to draw sequences from.
    #[error("there is no model to learn from: {reason}")]
    Source {
        /// Why not.
        reason: String,
    },
    /// An objective learns from recorded measurements, and there are none.
    #[error("the objective {objective} learns from recorded measurements; there are none")]
    NoRecorded {
        /// The objective.
        objective: String,
    },
    /// The draws of a proposal have no derivatives.
    #[error(
        "the objective fivo takes a head whose draws have derivatives: gaussian, kernel or flow; those of a mixture have none"
    )]
    Draws,
    /// The optimiser was handed parameters, gradients or moments that are not of one proposal.
    #[error("{what} are of other parameters; a step takes weights, gradients and moments of one proposal")]
    Optimiser {
        /// What differs from the parameters.
        what: &'static str,
    },
    /// Bytes are not a checkpoint from which this training can go on.
    #[error("this is not a checkpoint of a training with this proposal and these settings: {reason}")]
    NotResumed {
        /// What does not fit.
        reason: String,
    },
    /// The loss, or after the last step the gradient's norm, is not a finite number.
    #[error("training diverged: the loss or its gradient is {loss} in step {step}")]
    Diverged {
        /// The training step.
        step: usize,
        /// Its loss, or its gradient's norm.
        loss: f64,
    },
}

fn after(loss: Option<f64>) -> String {
    loss.map_or_else(String::new, |loss| format!(", after one with a loss of {loss:.1e}"))
}
