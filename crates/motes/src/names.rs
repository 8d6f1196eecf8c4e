//! What a model calls itself and its coordinates.

use motes_formulas::InputSource;
#[cfg(feature = "report")]
use motes_models::StepRecord;
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
    /// The inputs that data do not have: those of files that the model names.
    pub file_inputs: Vec<FileInput>,
}

impl From<&Model> for ModelNames {
    fn from(model: &Model) -> Self {
        ModelNames {
            model: model.name().to_string(),
            states: model.states().to_vec(),
            measurements: model.measurements().to_vec(),
            file_inputs: FileInput::of(model),
        }
    }
}

/// An input that comes from a file of its own, and where a step has it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileInput {
    /// What it is called.
    pub name: String,
    number: usize,
    /// All inputs of a sub-step.
    count: usize,
    /// Whether measurements use it, so that it is known at rows.
    is_measured: bool,
}

impl FileInput {
    fn of(model: &Model) -> Vec<Self> {
        let Some(frame) = model.frame() else { return vec![] };
        let inputs = frame.inputs().iter().enumerate();
        let of_files = inputs.filter(|(_, input)| matches!(input.source, InputSource::File { .. }));
        let made = of_files.map(|(number, input)| FileInput {
            name: input.name.clone(),
            number,
            count: frame.input_dim(),
            is_measured: frame.is_measured_by(number),
        });
        made.collect()
    }

    /// Its value at the row that steps lead to, or else in the last sub-step before; none where there was no step, or where nobody knows it.
    #[cfg(feature = "report")]
    pub(crate) fn value(&self, steps: &[StepRecord]) -> Option<f64> {
        let step = steps.last()?.step();
        let part = match self.is_measured {
            true => step.sub_steps,
            false if step.index == 0 => return None,
            false => step.sub_steps.checked_sub(1)?,
        };
        step.inputs.get(part * self.count + self.number).copied().filter(|value| !value.is_nan())
    }
}
