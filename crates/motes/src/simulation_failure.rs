//! Why a series cannot be drawn.

use motes_models::ModelError;

use crate::error::MotesError;
use crate::timeline::TimelineError;

/// Why a series cannot be drawn.
pub(crate) enum SimulationFailure {
    Model(ModelError),
    Timeline(TimelineError),
    /// A state or a measurement at this time is not finite, and why.
    NotFinite {
        time: f64,
        reason: String,
    },
}

impl From<ModelError> for SimulationFailure {
    fn from(error: ModelError) -> Self {
        SimulationFailure::Model(error)
    }
}

impl From<TimelineError> for SimulationFailure {
    fn from(error: TimelineError) -> Self {
        SimulationFailure::Timeline(error)
    }
}

impl From<SimulationFailure> for MotesError {
    fn from(failure: SimulationFailure) -> Self {
        match failure {
            SimulationFailure::Model(error) => error.into(),
            SimulationFailure::Timeline(error) => MotesError::Timeline(Box::new(error)),
            SimulationFailure::NotFinite { time, reason } => {
                MotesError::Simulation(format!("at t = {time}: {reason}"))
            }
        }
    }
}
