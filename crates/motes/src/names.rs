//! What a model calls itself and its coordinates.

use serde::{Deserialize, Serialize};

use crate::model::Model;

/// The names of a model and of its coordinates: all that tables and reports need of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelNames {
    /// What it calls itself.
    pub model: String,
    /// The `N` coordinates of a state.
    pub states: Vec<String>,
    /// The `M` coordinates of a measurement.
    pub measurements: Vec<String>,
}

impl From<&Model> for ModelNames {
    fn from(model: &Model) -> Self {
        ModelNames {
            model: model.name().to_string(),
            states: model.states().to_vec(),
            measurements: model.measurements().to_vec(),
        }
    }
}
