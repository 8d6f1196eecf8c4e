//! The weight penalty: large weights cost.

use motes_proposals::{Parametric, Workspace};

use crate::TrainError;

/// Refuses a penalty that is none.
pub(crate) fn check_penalty(penalty: f64) -> Result<(), TrainError> {
    match penalty >= 0.0 && penalty.is_finite() {
        true => Ok(()),
        false => Err(TrainError::Setting {
            name: "the weight penalty",
            value: penalty.to_string(),
            expected: "at least 0 and finite",
        }),
    }
}

/// Adds the gradient of `λ/2 Σ w²` to that of a loss: `λ w` for each weight, over the matrices that the loss depends on.
///
/// It goes through the gradient, as the penalty is a part of the loss: clipping, moments and steps see it. (AdamW, Loshchilov and Hutter 2019, takes
/// `w ← w − α λ w` beside Adam's step instead, which is the gradient of no loss; what is here can be held against differences.)
/// Offsets, and what scales inputs or a distribution, are not penalised ([`Parametric::weight_matrices`]).
pub(crate) fn add_penalty(penalty: f64, proposal: &(impl Parametric + ?Sized), workspace: &mut Workspace) {
    if penalty == 0.0 {
        return;
    }
    let (parameters, gradients) = (proposal.parameters(), workspace.gradients());
    for matrix in proposal.weight_matrices() {
        if gradients.has(matrix) {
            let mut slopes = parameters.host(matrix);
            slopes.iter_mut().for_each(|weight| *weight *= penalty);
            gradients.add_wide(matrix, &slopes);
        }
    }
}
