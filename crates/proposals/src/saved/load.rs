//! Reading a proposal, and refusing what was damaged or does not fit.

use std::path::Path;

use motes_models::{ModelShape, StateSpaceModel};
use motes_networks::Compute;
use serde::de::DeserializeOwned;

use super::error::SavedError;
use super::files::{SavedFiles, notes_of};
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
    SavedFiles::read::<F>(folder)?.proposal(folder, model, shape, compute)
}

/// Reads a proposal of family `F` from `folder` to be trained further, perhaps for another system of the same sizes: one with other parameters.
///
/// As it is it may be a poor proposal for that system. Weights stay right: a filter has the density of whatever it draws from.
///
/// # Errors
/// As [`load`], but that a system is another one only where its states or measurements have other numbers of coordinates.
pub fn load_to_tune<F: Family>(folder: &Path, shape: &ModelShape, compute: Compute) -> Result<F, SavedError> {
    SavedFiles::read::<F>(folder)?.proposal_to_tune(folder, shape, compute)
}

/// Reads what was written down about the training of the proposal of family `F` in `folder`.
///
/// # Errors
/// [`SavedError`] if the description is missing, damaged, or says something else.
pub fn notes<F: Family, Notes: DeserializeOwned>(folder: &Path) -> Result<Notes, SavedError> {
    let path = folder.join(F::FILES[0]);
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|source| SavedError::Io { path: path.clone(), source })?;
    notes_of(&text, &path)
}

/// Whether there is something of family `F` in `folder`.
pub fn holds<F: Family>(folder: &Path) -> bool {
    folder.join(F::FILES[0]).exists()
}
