//! Reading a proposal, and refusing what was damaged or does not fit.

use std::path::Path;

use motes_models::{ModelShape, Seed, StateSpaceModel};
use motes_networks::Compute;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::description::{DESCRIPTION, Description, SAVED_FORMAT};
use super::error::SavedError;
use super::fingerprint::{Entry, fingerprint, sizes};
use super::seal::unsealed;
use super::weights::{self, WEIGHTS};
use crate::family::Family;

/// Reads a proposal of family `F` for `model` from `folder`; `shape` is what it was made for.
///
/// # Errors
/// [`SavedError`] if a file is missing, damaged or of another version, if the proposal is of another family or was trained for
/// another system, or if its weights do not have the names and shapes of its settings or are not finite.
pub fn load<F: Family>(
    folder: &Path,
    model: &dyn StateSpaceModel,
    shape: &ModelShape,
    compute: Compute,
) -> Result<F, SavedError> {
    let given = fingerprint(model, shape.graph.as_ref());
    read::<F>(folder, shape, compute, |saved| check_system(folder, saved, &given))
}

/// Reads a proposal of family `F` from `folder` to be trained further, perhaps for another system of the same sizes: one with other parameters.
///
/// As it is it may be a poor proposal for that system. Weights stay right: a filter has the density of whatever it draws from.
///
/// # Errors
/// As [`load`], but that a system is another one only where its states or measurements have other numbers of coordinates.
pub fn load_to_tune<F: Family>(folder: &Path, shape: &ModelShape, compute: Compute) -> Result<F, SavedError> {
    let given = sizes(shape.state_dim, shape.measurement_dim);
    // A fingerprint begins with the sizes.
    let check = |saved: &[Entry]| check_system(folder, saved.get(..given.len()).unwrap_or(saved), &given);
    read::<F>(folder, shape, compute, check)
}

/// Reads a proposal for a system that `check` finds to be the right one by its fingerprint.
fn read<F: Family>(
    folder: &Path,
    shape: &ModelShape,
    compute: Compute,
    check: impl FnOnce(&[Entry]) -> Result<(), SavedError>,
) -> Result<F, SavedError> {
    let read = |name: &str| {
        let path = folder.join(name);
        std::fs::read(&path).map_err(|source| SavedError::Io { path, source })
    };
    let damaged = |name: &str, reason| SavedError::Damaged { path: folder.join(name), reason };
    let unfit = |what, found, expected| SavedError::Unfit { path: folder.into(), what, found, expected };

    let text =
        String::from_utf8(read(DESCRIPTION)?).map_err(|_| damaged(DESCRIPTION, "it is not text".into()))?;
    let (format, family) = Description::peek(&text).map_err(|reason| damaged(DESCRIPTION, reason))?;
    if format != SAVED_FORMAT {
        return Err(unfit("the format version", format.to_string(), SAVED_FORMAT.to_string()));
    }
    if family != F::NAME {
        return Err(unfit("the family", family, F::NAME.into()));
    }
    let bytes = read(WEIGHTS)?;
    let Some(description) = unsealed(&text, &bytes) else {
        let reason =
            "its files are not as they were saved: the hash in the first line of proposal.toml says so";
        return Err(SavedError::Damaged { path: folder.into(), reason: reason.into() });
    };
    // Nothing was damaged: the settings are those of something else, such as a family with standardised inputs.
    let saved: Description<F::Config> = Description::parse(description).map_err(|reason| {
        unfit("the proposal that its settings describe", format!("another ({reason})"), F::NAME.into())
    })?;
    check(&saved.system)?;
    let matrices = weights::decode(&bytes).map_err(|reason| damaged(WEIGHTS, reason))?;

    // Before anything is allocated by sizes that a file claims.
    let found: usize = matrices.iter().map(|matrix| matrix.values.len()).sum();
    let horizon = saved.horizon.unwrap_or(0);
    let expected = F::count(&saved.proposal, shape, horizon);
    if expected != Some(found) {
        let expected = expected.map_or("more than can be counted".into(), |count| count.to_string());
        return Err(unfit("the number of weights", found.to_string(), expected));
    }
    let refused = |source| SavedError::Proposal { path: folder.into(), source };
    let seed = Seed::from_u64(0);
    let mut proposal = F::create(&saved.proposal, shape, horizon, compute, &seed).map_err(refused)?;
    if proposal.horizon() != saved.horizon {
        let text = |horizon: Option<usize>| horizon.map_or("none".into(), |horizon| horizon.to_string());
        return Err(unfit("the horizon", text(saved.horizon), text(proposal.horizon())));
    }
    weights::place(&matrices, proposal.parameters_mut()).map_err(|reason| damaged(WEIGHTS, reason))?;
    Ok(proposal)
}

/// Reads what was written down about the training of the proposal in `folder`.
///
/// # Errors
/// [`SavedError`] if the description is missing, damaged, or says something else.
pub fn notes<Notes: DeserializeOwned>(folder: &Path) -> Result<Notes, SavedError> {
    let path = folder.join(DESCRIPTION);
    let text =
        std::fs::read_to_string(&path).map_err(|source| SavedError::Io { path: path.clone(), source })?;
    let damaged = |reason: toml::de::Error| {
        let reason = reason.message().lines().collect::<Vec<_>>().join(" ");
        SavedError::Damaged { path: path.clone(), reason }
    };
    let Training { training } = toml::from_str(&text).map_err(damaged)?;
    training.try_into().map_err(damaged)
}

/// The part of a description about training.
#[derive(Deserialize)]
struct Training {
    training: toml::Table,
}

/// Holds the saved fingerprint against that of the model given.
fn check_system(folder: &Path, saved: &[Entry], given: &[Entry]) -> Result<(), SavedError> {
    for (found, expected) in saved.iter().zip(given) {
        let scale = found.value.abs().max(expected.value.abs());
        let near = (found.value - expected.value).abs() <= FINGERPRINT_TOLERANCE * scale;
        let same = found.value == expected.value || (scale.is_finite() && near);
        if found.name != expected.name || !same {
            return Err(SavedError::OtherSystem {
                path: folder.into(),
                what: expected.name.clone(),
                found: found.value,
                expected: expected.value,
            });
        }
    }
    if saved.len() != given.len() {
        let reason = format!("the fingerprint has {} entries instead of {}", saved.len(), given.len());
        return Err(SavedError::Damaged { path: folder.join(DESCRIPTION), reason });
    }
    Ok(())
}

/// Room for the last bits, in which processors may differ.
const FINGERPRINT_TOLERANCE: f64 = 1e-9;
