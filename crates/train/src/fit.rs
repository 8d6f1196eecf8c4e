//! Whether a proposal, a model and measurements fit each other.

use motes_models::batch::there_is_memory_for;
use motes_models::{Measurements, StateGradients, check_model};
use motes_proposals::Learnable;

use crate::TrainError;

/// Refuses one sequence with a proposal and a model that do not fit it or each other, and more particles than there is memory for.
pub(crate) fn check_fit(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    particles: usize,
) -> Result<(), TrainError> {
    check_pair(proposal, model, particles)?;
    check_measurements(proposal, model, measurements, particles)
}

/// Refuses a proposal and a model whose sizes differ or are 0, and no particle.
pub(crate) fn check_pair(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    particles: usize,
) -> Result<(), TrainError> {
    check_model(model)?;
    if particles == 0 {
        return Err(differs("the number of particles K", particles, "at least 1"));
    }
    if proposal.state_dim() != model.state_dim() {
        return Err(differs("the proposal's state dimension", proposal.state_dim(), "that of the model"));
    }
    if proposal.measurement_dim() != model.measurement_dim() {
        let found = proposal.measurement_dim();
        return Err(differs("the proposal's measurement dimension", found, "that of the model"));
    }
    Ok(())
}

/// Refuses measurements of another width, none, more than the proposal has networks for, and more particles than there is memory for along them.
pub(crate) fn check_measurements(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    particles: usize,
) -> Result<(), TrainError> {
    measurements.check_width(model.measurement_dim())?;
    if measurements.is_empty() {
        return Err(differs("the number of measurements T", 0, "at least 1"));
    }
    // States of all times and their derivatives; what networks keep of them comes on top.
    let values =
        particles.checked_mul(measurements.len()).and_then(|rows| rows.checked_mul(model.state_dim()));
    if !values.and_then(|values| values.checked_mul(2)).is_some_and(there_is_memory_for) {
        return Err(differs(
            "the number of particles K",
            particles,
            "as many as there is memory for at all times",
        ));
    }
    if proposal.horizon().is_some_and(|horizon| horizon < measurements.len()) {
        let name = "the number of measurements T";
        return Err(differs(name, measurements.len(), "at most the horizon of the unrolled proposal"));
    }
    Ok(())
}

fn differs(name: &'static str, found: usize, expected: &'static str) -> TrainError {
    TrainError::Setting { name, value: found.to_string(), expected }
}
