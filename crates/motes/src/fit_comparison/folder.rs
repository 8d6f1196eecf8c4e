//! A model with the folder of its fit.

use std::path::Path;

use motes_inference::MarginalLikelihood;
use serde::Deserialize;

use crate::data::Data;
use crate::error::MotesError;
use crate::fitting::{FitParameters, FitRecord, SUMMARY};
use crate::model::Model;

/// A model, what was fitted of it, and the data of the fit.
#[derive(Debug, Clone)]
pub struct FittedModel {
    /// The model.
    pub model: Model,
    /// Its parameters.
    pub parameters: FitParameters,
    /// The data as this model reads them.
    pub data: Data,
    /// `log p(y)`; none of a maximum, and where draws do not tell.
    pub marginal_likelihood: Option<MarginalLikelihood>,
    /// Akaike's information criterion; none of a posterior.
    pub aic: Option<f64>,
}

/// What is read of a summary.
#[derive(Deserialize)]
struct Summary {
    log_marginal_likelihood: Option<f64>,
    log_marginal_likelihood_error: Option<f64>,
    aic: Option<f64>,
}

impl FittedModel {
    /// Reads the fit of `model` to `data` that is in a folder.
    ///
    /// # Errors
    /// [`MotesError::Fit`] if there is none, it is one of another model or of other data, or its files are not as they were written.
    pub fn load(folder: &Path, model: Model, data: Data) -> Result<Self, MotesError> {
        let refused = |reason: String| MotesError::Fit { folder: folder.display().to_string(), reason };
        let parameters = FitParameters::load(folder, &model)?;
        let read = |name: &str| {
            std::fs::read_to_string(folder.join(name)).map_err(|error| refused(format!("{name}: {error}")))
        };
        if !FitRecord::load(folder)?.is_of_data(&data)? {
            return Err(refused("it is a fit to other data; fit it to these".into()));
        }
        let summary: Summary =
            serde_json::from_str(&read(SUMMARY)?).map_err(|error| refused(format!("{SUMMARY}: {error}")))?;
        let marginal_likelihood = summary.log_marginal_likelihood.zip(summary.log_marginal_likelihood_error);
        let marginal_likelihood =
            marginal_likelihood.map(|(log, standard_error)| MarginalLikelihood { log, standard_error });
        Ok(FittedModel { model, parameters, data, marginal_likelihood, aic: summary.aic })
    }
}
