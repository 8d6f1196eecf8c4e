//! The two files of a saved family, in memory.

use std::path::Path;

use motes_models::{ModelShape, Seed, StateSpaceModel};
use motes_networks::Compute;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::description::{Description, SAVED_FORMAT};
use super::error::SavedError;
use super::fingerprint::Fingerprint;
use super::seal::{seal, unsealed};
use super::weights;
use crate::family::Family;

/// The two files of a saved proposal: what [`crate::save`] writes into a folder, for who keeps it elsewhere.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SavedFiles {
    /// The description, whose first line is a hash of all the rest.
    pub description: String,
    /// The weights, a safetensors file.
    #[serde(with = "serde_bytes")]
    pub weights: Vec<u8>,
}

/// The part of a description about training.
#[derive(Deserialize)]
struct Training {
    training: toml::Table,
}

impl SavedFiles {
    /// Those of `proposal`, made for `shape` and trained for `model` with the given settings; errors call them `place`.
    ///
    /// # Errors
    /// [`SavedError::Damaged`] if something of it has no form in these files.
    pub fn of<F: Family>(
        proposal: &F,
        model: &dyn StateSpaceModel,
        shape: &ModelShape,
        training: &impl Serialize,
        place: &Path,
    ) -> Result<Self, SavedError> {
        let damaged = |name: &str, reason| SavedError::Damaged { path: place.join(name), reason };
        let [description, weights] = F::FILES;
        let bytes = weights::encode(proposal.parameters()).map_err(|reason| damaged(weights, reason))?;
        let text = Description::of(proposal, model, shape.graph.as_ref(), training)
            .map_err(|reason| damaged(description, reason))?;
        Ok(SavedFiles { description: seal(&text, &bytes), weights: bytes })
    }

    /// Reads both files of a family from a folder.
    pub(super) fn read<F: Family>(folder: &Path) -> Result<Self, SavedError> {
        let [description, weights] = F::FILES;
        let read = |name: &str| {
            let path = folder.join(name);
            std::fs::read(&path).map_err(|source| SavedError::Io { path, source })
        };
        let text = String::from_utf8(read(description)?).map_err(|_| SavedError::Damaged {
            path: folder.join(description),
            reason: "it is not text".into(),
        })?;
        Ok(SavedFiles { description: text, weights: read(weights)? })
    }

    /// The proposal of family `F` for `model`; `shape` is what it was made for. Errors call the files `place`.
    ///
    /// # Errors
    /// As [`crate::load`].
    pub fn proposal<F: Family>(
        &self,
        place: &Path,
        model: &dyn StateSpaceModel,
        shape: &ModelShape,
        compute: Compute,
    ) -> Result<F, SavedError> {
        let given = Fingerprint::of(model, shape.graph.as_ref());
        self.proposal_of(place, shape, compute, |saved| {
            check_system(place, saved, &given)?;
            if saved.len() == given.len() {
                return Ok(());
            }
            let reason = format!("the fingerprint has {} entries instead of {}", saved.len(), given.len());
            Err(SavedError::Damaged { path: place.join(F::FILES[0]), reason })
        })
    }

    /// The same for another system of the same sizes, as [`crate::load_to_tune`].
    ///
    /// # Errors
    /// As [`crate::load_to_tune`].
    pub fn proposal_to_tune<F: Family>(
        &self,
        place: &Path,
        shape: &ModelShape,
        compute: Compute,
    ) -> Result<F, SavedError> {
        // A fingerprint begins with the sizes.
        let given = Fingerprint::of_sizes(shape.state_dim, shape.measurement_dim);
        self.proposal_of(place, shape, compute, |saved| check_system(place, saved, &given))
    }

    /// What was written down about the training of the proposal; errors call the files `place`.
    ///
    /// # Errors
    /// [`SavedError`] if the description says something else.
    pub fn notes<Notes: DeserializeOwned>(&self, place: &Path) -> Result<Notes, SavedError> {
        notes_of(&self.description, place)
    }

    /// The proposal for a system that `check` finds to be the right one by its fingerprint.
    fn proposal_of<F: Family>(
        &self,
        place: &Path,
        shape: &ModelShape,
        compute: Compute,
        check: impl FnOnce(&Fingerprint) -> Result<(), SavedError>,
    ) -> Result<F, SavedError> {
        let [description_file, weights_file] = F::FILES;
        let damaged = |name: &str, reason| SavedError::Damaged { path: place.join(name), reason };
        let unfit = |what, found, expected| SavedError::Unfit { path: place.into(), what, found, expected };
        let (format, family) =
            Description::peek(&self.description).map_err(|reason| damaged(description_file, reason))?;
        if format != SAVED_FORMAT {
            return Err(SavedError::Format { path: place.into(), found: format });
        }
        if family != F::NAME {
            return Err(unfit("the family", family, F::NAME.into()));
        }
        let Some(description) = unsealed(&self.description, &self.weights) else {
            let reason = format!(
                "its files are not as they were saved: the hash in the first line of {description_file} says so"
            );
            return Err(SavedError::Damaged { path: place.into(), reason });
        };
        // Nothing was damaged: the settings are those of something else, such as a family with standardised inputs.
        let saved: Description<F::Config> = Description::parse(description).map_err(|reason| {
            unfit("the proposal that its settings describe", format!("another ({reason})"), F::NAME.into())
        })?;
        check(&saved.system)?;
        let matrices = weights::decode(&self.weights).map_err(|reason| damaged(weights_file, reason))?;

        // Before anything is allocated by sizes that a file claims.
        let found: usize = matrices.iter().map(|matrix| matrix.values.len()).sum();
        let horizon = saved.horizon.unwrap_or(0);
        let expected = F::count(&saved.proposal, shape, horizon);
        if expected != Some(found) {
            let expected = expected.map_or("more than can be counted".into(), |count| count.to_string());
            return Err(unfit("the number of weights", found.to_string(), expected));
        }
        let refused = |source| SavedError::Proposal { path: place.into(), source };
        let seed = Seed::from_u64(0);
        let mut proposal = F::create(&saved.proposal, shape, horizon, compute, &seed).map_err(refused)?;
        if proposal.horizon() != saved.horizon {
            let text = |horizon: Option<usize>| horizon.map_or("none".into(), |horizon| horizon.to_string());
            return Err(unfit("the horizon", text(saved.horizon), text(proposal.horizon())));
        }
        weights::place(&matrices, proposal.parameters_mut())
            .map_err(|reason| damaged(weights_file, reason))?;
        Ok(proposal)
    }
}

/// Holds the saved fingerprint against that of the model given.
fn check_system(place: &Path, saved: &Fingerprint, given: &Fingerprint) -> Result<(), SavedError> {
    saved.check(given).map_err(|source| SavedError::OtherSystem { path: place.into(), source })
}

/// What a description says about training; errors call it `path`.
pub(super) fn notes_of<Notes: DeserializeOwned>(description: &str, path: &Path) -> Result<Notes, SavedError> {
    let damaged = |reason: toml::de::Error| {
        let reason = reason.message().lines().collect::<Vec<_>>().join(" ");
        SavedError::Damaged { path: path.into(), reason }
    };
    let Training { training } = toml::from_str(description).map_err(damaged)?;
    training.try_into().map_err(damaged)
}
