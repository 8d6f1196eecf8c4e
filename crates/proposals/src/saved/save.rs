//! Writing a proposal, whole or not at all.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use motes_models::{ModelShape, StateSpaceModel};
use serde::Serialize;
use tempfile::TempDir;

use super::error::SavedError;
use super::files::SavedFiles;
use crate::amortised::Amortised;
use crate::family::Family;
use crate::potentials::LearnedPotentials;

/// Writes `proposal`, made for `shape` and trained for `model` with the given settings, into `folder`, replacing a proposal that is there.
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
    shape: &ModelShape,
    training: &impl Serialize,
) -> Result<(), SavedError> {
    let folder = without_trailing_separator(folder);
    let saved = SavedFiles::of(proposal, model, shape, training, &folder)?;
    save_files(&folder, &[(F::FILES, &saved)])
}

/// [`save`] of a proposal and of potentials that were learned beside it, together.
///
/// # Errors
/// As [`save`].
pub fn save_both<F: Family, G: Family>(
    folder: &Path,
    (proposal, training): (&F, &impl Serialize),
    (potentials, training_of_potentials): (&G, &impl Serialize),
    model: &dyn StateSpaceModel,
    shape: &ModelShape,
) -> Result<(), SavedError> {
    let folder = without_trailing_separator(folder);
    let saved = SavedFiles::of(proposal, model, shape, training, &folder)?;
    let beside = SavedFiles::of(potentials, model, shape, training_of_potentials, &folder)?;
    save_files(&folder, &[(F::FILES, &saved), (G::FILES, &beside)])
}

/// So that names beside it can be made.
fn without_trailing_separator(folder: &Path) -> PathBuf {
    folder.components().collect()
}

/// Writes files, by the names of their descriptions and weights, into a folder that takes the place of what is there.
fn save_files(folder: &Path, files: &[([&str; 2], &SavedFiles)]) -> Result<(), SavedError> {
    // Removed if it does not come to take its place.
    let new = empty_beside(folder).map_err(|source| SavedError::Io { path: folder.into(), source })?;
    for ([description, weights], saved) in files {
        write(new.path(), weights, &saved.weights)?;
        write(new.path(), description, saved.description.as_bytes())?;
    }
    replace(new.path(), folder)?;
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

fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), SavedError> {
    let path = folder.join(name);
    let written = File::create(&path).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    written.map_err(|source| SavedError::Io { path, source })
}

/// All files that folders of proposals hold.
fn known() -> impl Iterator<Item = &'static str> {
    Amortised::FILES.into_iter().chain(LearnedPotentials::FILES)
}

/// Puts `new` in the place of `folder`.
fn replace(new: &Path, folder: &Path) -> Result<(), SavedError> {
    let io = |source| SavedError::Io { path: folder.into(), source };
    let descriptions = [Amortised::FILES[0], LearnedPotentials::FILES[0]];
    if !descriptions.iter().any(|name| folder.join(name).exists()) {
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
    for name in known() {
        let _ = std::fs::remove_file(old.join(name));
    }
    // Anything else that lay there stays, under this name.
    let _ = std::fs::remove_dir(&old);
    Ok(())
}
