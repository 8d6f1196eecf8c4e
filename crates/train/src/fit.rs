//! Whether a proposal, a model and measurements fit each other.

use motes_models::batch::there_is_memory_for;
use motes_models::{Measurements, StateGradients, check_dimensions};
use motes_proposals::Learnable;

use crate::TrainError;

/// Refuses sizes that differ, sizes of 0, and more particles than there is memory for.
pub(crate) fn check_fit(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    particles: usize,
) -> Result<(), TrainError> {
    check_dimensions(model)?;
    measurements.check_width(model.measurement_dim())?;
    let differs =
        |name, found: usize, expected| TrainError::Setting { name, value: found.to_string(), expected };
    for (name, value) in
        [("the number of particles K", particles), ("the number of measurements T", measurements.len())]
    {
        if value == 0 {
            return Err(differs(name, value, "at least 1"));
        }
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
    if proposal.state_dim() != model.state_dim() {
        return Err(differs("the proposal's state dimension", proposal.state_dim(), "that of the model"));
    }
    if proposal.measurement_dim() != model.measurement_dim() {
        let found = proposal.measurement_dim();
        return Err(differs("the proposal's measurement dimension", found, "that of the model"));
    }
    if proposal.horizon().is_some_and(|horizon| horizon < measurements.len()) {
        let name = "the number of measurements T";
        return Err(differs(name, measurements.len(), "at most the horizon of the unrolled proposal"));
    }
    Ok(())
}
