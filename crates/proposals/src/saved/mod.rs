//! Trained proposals on disk: weights as safetensors, and beside them a description that people can read.
//!
//! A saved proposal is a folder with `proposal.toml` and `weights.safetensors`. The description says which family it is, its
//! settings and sizes, how it was trained, and for which system: [`load`] checks all of it, and a hash of the weights, and
//! refuses what does not fit.

mod description;
mod fingerprint;
mod weights;

use std::path::{Path, PathBuf};

use motes_models::{Seed, StateSpaceModel};
use motes_smc::ProposalError;
use serde::Serialize;
use thiserror::Error;

use crate::{Compute, Family};
use description::Description;
use fingerprint::fingerprint;

/// The version of the folder's layout and of what its entries mean.
pub const SAVED_FORMAT: u32 = 1;

const DESCRIPTION: &str = "proposal.toml";
const WEIGHTS: &str = "weights.safetensors";

/// Why a proposal could not be saved or loaded.
#[derive(Debug, Error)]
pub enum SavedError {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file is not what [`save`] writes.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The proposal is whole but not the one that was asked for.
    #[error("{}: {what} is {found}; {expected} was expected", path.display())]
    Unfit {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// What the folder has.
        found: String,
        /// What was asked for.
        expected: String,
    },
    /// The proposal was trained for another system.
    #[error(
        "{}: this proposal was trained for another system: {what} is {found} there and {expected} in the model given",
        path.display()
    )]
    OtherSystem {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: String,
        /// The value of the system it was trained for.
        found: f64,
        /// The value of the model given.
        expected: f64,
    },
    /// The family cannot be made from the saved settings.
    #[error("{}: {source}", path.display())]
    Proposal {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: ProposalError,
    },
}

/// Writes `proposal`, trained for `model` with the given settings, into `folder`, replacing a proposal that is there.
///
/// The folder appears whole or not at all: it is written under another name beside it and renamed.
///
/// # Errors
/// [`SavedError::Io`] if it cannot be written, [`SavedError::Proposal`] if the weights cannot be read back from the backend.
pub fn save<F: Family>(
    folder: &Path,
    proposal: &F,
    model: &dyn StateSpaceModel,
    training: &impl Serialize,
) -> Result<(), SavedError> {
    let weights = weights::encode(proposal.parameters())
        .map_err(|source| SavedError::Proposal { path: folder.into(), source })?;
    let description = Description::of(proposal, model, training, &weights)
        .map_err(|reason| SavedError::Damaged { path: folder.join(DESCRIPTION), reason })?;
    let mut partial = folder.as_os_str().to_owned();
    partial.push(format!(".partial-{}", std::process::id()));
    let partial = PathBuf::from(partial);
    let written = write(&partial, &description, &weights).and_then(|()| replace(&partial, folder));
    written.inspect_err(|_| {
        // What could not be finished is of no use; the error that is reported is the first one.
        let _ = std::fs::remove_dir_all(&partial);
    })
}

fn write(folder: &Path, description: &str, weights: &[u8]) -> Result<(), SavedError> {
    let io = |path: &Path, result: std::io::Result<()>| {
        result.map_err(|source| SavedError::Io { path: path.into(), source })
    };
    io(folder, std::fs::create_dir_all(folder))?;
    for (name, bytes) in [(WEIGHTS, weights), (DESCRIPTION, description.as_bytes())] {
        let path = folder.join(name);
        io(&path, std::fs::write(&path, bytes))?;
    }
    Ok(())
}

/// Puts `new` in the place of `folder`; only what [`save`] writes is ever removed.
fn replace(new: &Path, folder: &Path) -> Result<(), SavedError> {
    let io = |source| SavedError::Io { path: folder.into(), source };
    if folder.join(DESCRIPTION).exists() {
        for name in [DESCRIPTION, WEIGHTS] {
            match std::fs::remove_file(folder.join(name)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(io(error)),
                _ => {}
            }
        }
        std::fs::remove_dir(folder).map_err(io)?;
    }
    std::fs::rename(new, folder).map_err(io)
}

/// Reads a proposal of family `F` for `model` from `folder`.
///
/// # Errors
/// [`SavedError`] if a file is missing, damaged or of another version, if the proposal is of another family or was trained for
/// another system, or if its weights do not have the names and shapes of its settings or are not finite.
pub fn load<F: Family>(
    folder: &Path,
    model: &dyn StateSpaceModel,
    compute: Compute,
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
    let saved: Description<F::Config> =
        Description::parse(&text).map_err(|reason| damaged(DESCRIPTION, reason))?;

    let bytes = read(WEIGHTS)?;
    if blake3::hash(&bytes).to_hex().as_str() != saved.weights_blake3 {
        let reason =
            format!("its BLAKE3 hash is not the one in {DESCRIPTION}: it is damaged or of another proposal");
        return Err(damaged(WEIGHTS, reason));
    }
    check_system(folder, &saved.system, model)?;
    let matrices = weights::decode(&bytes).map_err(|reason| damaged(WEIGHTS, reason))?;

    // Before anything is allocated by sizes that a file claims.
    let found: usize = matrices.iter().map(|matrix| matrix.values.len()).sum();
    let sizes = (model.state_dim(), model.measurement_dim());
    let expected = F::count(&saved.proposal, sizes, saved.horizon.unwrap_or(0));
    if expected != Some(found) {
        let expected = expected.map_or("more than can be counted".into(), |count| count.to_string());
        return Err(unfit("the number of weights", found.to_string(), expected));
    }
    let refused = |source| SavedError::Proposal { path: folder.into(), source };
    let seed = Seed::from_u64(0);
    let mut proposal =
        F::create(&saved.proposal, model, saved.horizon.unwrap_or(0), compute, &seed).map_err(refused)?;
    weights::place(&matrices, proposal.parameters_mut()).map_err(|reason| damaged(WEIGHTS, reason))?;
    Ok(proposal)
}

/// Holds the saved fingerprint against that of `model`.
fn check_system(folder: &Path, saved: &[Entry], model: &dyn StateSpaceModel) -> Result<(), SavedError> {
    let given = fingerprint(model);
    for (found, expected) in saved.iter().zip(&given) {
        let scale = found.value.abs().max(expected.value.abs());
        let same = found.value == expected.value
            || (found.value - expected.value).abs() <= FINGERPRINT_TOLERANCE * scale;
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

pub use description::Entry;
