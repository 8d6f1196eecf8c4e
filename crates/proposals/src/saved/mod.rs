//! Trained proposals on disk: weights as safetensors, and beside them a description that people can read.
//!
//! A saved proposal is a folder with `proposal.toml` and `weights.safetensors`. The description says which family it is, its
//! settings and sizes, how it was trained, and for which system. Its first line is a hash of all the rest, weights included:
//! [`load`] refuses what was damaged or changed, and what does not fit the call.

mod description;
mod fingerprint;
mod weights;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use motes_models::{ModelShape, Seed, StateSpaceModel};
use motes_networks::Compute;
use motes_smc::ProposalError;
use serde::Serialize;
use tempfile::TempDir;
use thiserror::Error;

use crate::family::Family;
use description::{Description, Entry};
use fingerprint::fingerprint;

/// The version of the folder's layout and of what its entries mean.
pub const SAVED_FORMAT: u32 = 2;

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
/// The new one is written whole under another name beside `folder`, and only then takes its place. A process that is killed between the two
/// renames of that leaves both beside it, the old one as `.<name>.old-<process>`. Nothing but a saved proposal is ever replaced: other
/// files of the folder stay, under that name (or `old2` and so on, where it is taken).
///
/// # Errors
/// [`SavedError::Io`] if it cannot be written, [`SavedError::Damaged`] if something of it has no form in these files.
pub fn save<F: Family>(
    folder: &Path,
    proposal: &F,
    model: &dyn StateSpaceModel,
    training: &impl Serialize,
) -> Result<(), SavedError> {
    // Without a trailing separator, so that names beside it can be made.
    let folder: PathBuf = folder.components().collect();
    let weights = weights::encode(proposal.parameters())
        .map_err(|reason| SavedError::Damaged { path: folder.join(WEIGHTS), reason })?;
    let description = Description::of(proposal, model, training)
        .map_err(|reason| SavedError::Damaged { path: folder.join(DESCRIPTION), reason })?;
    let files = [(WEIGHTS, weights.as_slice()), (DESCRIPTION, &seal(&description, &weights).into_bytes())];
    // Removed if it does not come to take its place.
    let new = empty_beside(&folder).map_err(|source| SavedError::Io { path: folder.clone(), source })?;
    write(new.path(), files)?;
    replace(new.path(), &folder)?;
    drop(new.keep());
    Ok(())
}

/// An empty folder in the same folder, under a name that nothing else has.
fn empty_beside(folder: &Path) -> std::io::Result<TempDir> {
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent)?;
    let mut builder = tempfile::Builder::new();
    // Open to all whom the user's mask lets in, as any folder that a program creates.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    builder.prefix(".partial-").tempdir_in(parent)
}

/// `.<name>.<what>-<process>` in the same folder.
fn beside(folder: &Path, what: &str) -> PathBuf {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    folder.with_file_name(format!(".{name}.{what}-{}", std::process::id()))
}

fn write(folder: &Path, files: [(&str, &[u8]); 2]) -> Result<(), SavedError> {
    let io = |path: &Path, result: std::io::Result<()>| {
        result.map_err(|source| SavedError::Io { path: path.into(), source })
    };
    for (name, bytes) in files {
        let path = folder.join(name);
        let written = File::create(&path).and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        });
        io(&path, written)?;
    }
    Ok(())
}

/// Puts `new` in the place of `folder`.
fn replace(new: &Path, folder: &Path) -> Result<(), SavedError> {
    let io = |source| SavedError::Io { path: folder.into(), source };
    if !folder.join(DESCRIPTION).exists() {
        // Nothing there, or an empty folder; any other is refused by the operating system.
        return std::fs::rename(new, folder).map_err(io);
    }
    let (mut old, mut number) = (beside(folder, "old"), 1);
    // An earlier one with other files in it may lie there.
    while old.exists() {
        number += 1;
        old = beside(folder, &format!("old{number}"));
    }
    std::fs::rename(folder, &old).map_err(io)?;
    if let Err(error) = std::fs::rename(new, folder) {
        std::fs::rename(&old, folder).map_err(io)?;
        return Err(io(error));
    }
    for name in [DESCRIPTION, WEIGHTS] {
        let _ = std::fs::remove_file(old.join(name));
    }
    // Anything else that lay there stays, under this name.
    let _ = std::fs::remove_dir(&old);
    Ok(())
}

/// The description with a first line that holds the hash of it and of the weights.
fn seal(description: &str, weights: &[u8]) -> String {
    format!("{SEAL}\"{}\"\n{description}", hash(description, weights))
}

const SEAL: &str = "blake3 = ";

fn hash(description: &str, weights: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(description.as_bytes()).update(weights);
    hasher.finalize().to_hex().to_string()
}

/// The description behind a first line that is the hash of it and of the weights.
fn unsealed<'a>(text: &'a str, weights: &[u8]) -> Option<&'a str> {
    let (line, description) = text.split_once('\n')?;
    let is_right = line.strip_prefix(SEAL) == Some(&format!("\"{}\"", hash(description, weights)));
    is_right.then_some(description)
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
    check_system(folder, &saved.system, model)?;
    let matrices = weights::decode(&bytes).map_err(|reason| damaged(WEIGHTS, reason))?;

    // Before anything is allocated by sizes that a file claims.
    let found: usize = matrices.iter().map(|matrix| matrix.values.len()).sum();
    let (shape, horizon) = (ModelShape::of(model), saved.horizon.unwrap_or(0));
    let expected = F::count(&saved.proposal, &shape, horizon);
    if expected != Some(found) {
        let expected = expected.map_or("more than can be counted".into(), |count| count.to_string());
        return Err(unfit("the number of weights", found.to_string(), expected));
    }
    let refused = |source| SavedError::Proposal { path: folder.into(), source };
    let seed = Seed::from_u64(0);
    let mut proposal = F::create(&saved.proposal, &shape, horizon, compute, &seed).map_err(refused)?;
    if proposal.horizon() != saved.horizon {
        let text = |horizon: Option<usize>| horizon.map_or("none".into(), |horizon| horizon.to_string());
        return Err(unfit("the horizon", text(saved.horizon), text(proposal.horizon())));
    }
    weights::place(&matrices, proposal.parameters_mut()).map_err(|reason| damaged(WEIGHTS, reason))?;
    Ok(proposal)
}

/// Holds the saved fingerprint against that of `model`.
fn check_system(folder: &Path, saved: &[Entry], model: &dyn StateSpaceModel) -> Result<(), SavedError> {
    let given = fingerprint(model);
    for (found, expected) in saved.iter().zip(&given) {
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
