//! Potentials that serve a model with any parameters of its prior.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use crate::error::MotesError;
use crate::model::Model;
use crate::priors::{drawn, free, rounded};

/// How often parameters are drawn again with which there is no model.
const TRIES: u64 = 100;

/// The prior over which potentials were learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingPrior {
    /// The parameters, or lists of these, in the order of the model file.
    pub parameters: Vec<PriorParameter>,
}

/// A parameter, or a list of these, with its prior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PriorParameter {
    /// The name in the model file.
    pub name: String,
    /// The prior, as the model file states it.
    pub prior: String,
    /// The names of its entries, and the values by which the model is recognised.
    pub values: Vec<(String, f64)>,
}

impl TrainingPrior {
    /// That of the parameters that have a prior and were given no value; none where there are none.
    pub(crate) fn of(model: &Model) -> Option<Self> {
        let parameters: Vec<PriorParameter> = free(model)
            .map(|prior| PriorParameter {
                name: prior.name().into(),
                prior: prior.text().into(),
                values: prior.entries().iter().cloned().zip(prior.start().iter().copied()).collect(),
            })
            .collect();
        (!parameters.is_empty()).then_some(TrainingPrior { parameters })
    }

    /// The names of the parameters.
    pub fn names(&self) -> Vec<&str> {
        self.parameters.iter().map(|parameter| parameter.name.as_str()).collect()
    }

    /// The parameters by which the model is recognised, with their values, for people.
    pub fn describe(&self) -> String {
        let values = self.parameters.iter().flat_map(|parameter| &parameter.values);
        let texts: Vec<String> =
            values.map(|(name, value)| format!("{name} = {}", rounded(*value))).collect();
        texts.join(", ")
    }

    /// The model at the parameters by which it is recognised.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] of a proposal of that name if the model has another prior.
    pub(crate) fn reference(&self, model: &Model, proposal: &str) -> Result<Model, MotesError> {
        let refused = |reason: String| MotesError::Proposal { proposal: proposal.into(), reason };
        for PriorParameter { name, prior, .. } in &self.parameters {
            let there = model.priors().iter().find(|prior| prior.name() == name);
            match there.map(|there| there.text()) {
                Some(text) if text == prior => {}
                found => {
                    let found = found.map_or("no prior".into(), |text| format!("{name} ~ {text}"));
                    return Err(refused(format!(
                        "it was learned over {name} ~ {prior}, and the model has {found}; learn it again"
                    )));
                }
            }
        }
        let values: Vec<(String, f64)> =
            self.parameters.iter().flat_map(|parameter| parameter.values.iter().cloned()).collect();
        model.with_parameters(&values).map_err(|error| refused(error.to_string()))
    }

    /// A model at parameters that are drawn from their priors.
    ///
    /// # Errors
    /// [`MotesError::Model`] if there is no model at any of a hundred draws.
    pub(crate) fn draw(model: &Model, seed: &Seed) -> Result<Model, MotesError> {
        let at = |number: u64| model.with_parameters(&drawn(model, &seed.nth(number)));
        Ok((1..TRIES).map(at).find(Result::is_ok).unwrap_or_else(|| at(0))?)
    }
}
