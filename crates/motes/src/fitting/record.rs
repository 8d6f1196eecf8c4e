//! What a fit was made with.

use std::collections::BTreeMap;
use std::path::Path;

use motes_formulas::Origin;
use serde::{Deserialize, Serialize};

use super::options::FitOptions;
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::packed::pack;

/// The file of a folder that says what a fit was made with.
pub(crate) const RECORD: &str = "fit.toml";

/// What the methods are called.
pub(super) const POSTERIOR_METHOD: &str = "posterior";
pub(super) const MAXIMUM_METHOD: &str = "maximum";

/// What all draws of a fit depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitRecord {
    /// The version of motes.
    pub motes: String,
    /// The model's name.
    pub model: String,
    /// A hash of the model file.
    pub model_hash: String,
    /// A hash of the measurements with their steps.
    pub data_hash: String,
    /// How parameters are found.
    pub method: String,
    /// The estimator that was asked for; none where it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proposal: Option<String>,
    /// The number of particles that was asked for; none where it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles: Option<usize>,
    /// The number of chains.
    pub chains: usize,
    /// The number of draws of each that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draws: Option<usize>,
    /// Of a maximum, the parameters whose profiles were asked for; none where all were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<String>,
    /// Of a maximum, the passes of iterated filtering that were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes: Option<usize>,
    /// The seed.
    pub seed: u64,
    /// Parameters that have a prior and were given a value.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
}

impl FitRecord {
    /// That of a fit.
    ///
    /// # Errors
    /// [`MotesError::Packed`] if data cannot be hashed.
    pub fn of(model: &Model, data: &Data, options: &FitOptions) -> Result<Self, MotesError> {
        let set = model.priors().iter().filter(|prior| prior.origin() == Origin::Set);
        let set = set.flat_map(|prior| prior.entries().iter().cloned().zip(prior.start().iter().copied()));
        Ok(FitRecord {
            motes: env!("CARGO_PKG_VERSION").into(),
            model: model.name().into(),
            model_hash: hash_of_model(model),
            data_hash: hash_of_data(data)?,
            method: POSTERIOR_METHOD.into(),
            proposal: options.proposal.as_ref().map(ToString::to_string),
            particles: options.particles,
            chains: options.chains,
            draws: options.draws,
            profiles: Vec::new(),
            passes: None,
            seed: options.seed,
            set: set.collect(),
        })
    }

    /// That of a search for the maximum.
    ///
    /// # Errors
    /// As [`FitRecord::of`].
    pub fn of_maximum(model: &Model, data: &Data, options: &FitOptions) -> Result<Self, MotesError> {
        Ok(FitRecord {
            method: MAXIMUM_METHOD.into(),
            draws: None,
            profiles: options.profiles.clone(),
            passes: options.passes,
            ..FitRecord::of(model, data, options)?
        })
    }

    /// Whether it was made for these data.
    ///
    /// # Errors
    /// [`MotesError::Packed`] if data cannot be hashed.
    pub fn is_of_data(&self, data: &Data) -> Result<bool, MotesError> {
        Ok(self.data_hash == hash_of_data(data)?)
    }

    /// That in the folder of a fit.
    ///
    /// # Errors
    /// [`MotesError::Fit`] if there is none, or it is not as it was written.
    pub(crate) fn load(folder: &Path) -> Result<Self, MotesError> {
        let refused = |reason: String| MotesError::Fit { folder: folder.display().to_string(), reason };
        let text = std::fs::read_to_string(folder.join(RECORD)).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => {
                refused(format!("there is no {RECORD} in it; motes fit writes such folders with -o"))
            }
            _ => refused(format!("{RECORD}: {error}")),
        })?;
        toml::from_str(&text).map_err(|error| {
            refused(format!("{RECORD}: {}", error.message().lines().next().unwrap_or_default()))
        })
    }

    /// Whether it was made for this model file.
    pub fn is_of(&self, model: &Model) -> bool {
        self.model_hash == hash_of_model(model)
    }
}

fn hash_of_data(data: &Data) -> Result<String, MotesError> {
    Ok(blake3::hash(&pack("data", 1, data)?).to_hex().to_string())
}

fn hash_of_model(model: &Model) -> String {
    blake3::hash(model.text().unwrap_or_default().as_bytes()).to_hex().to_string()
}
