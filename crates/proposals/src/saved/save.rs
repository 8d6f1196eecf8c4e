//! Writing a proposal, whole or not at all.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use motes_models::{ModelShape, StateSpaceModel};
use serde::Serialize;
use tempfile::TempDir;

use super::description::DESCRIPTION;
use super::error::SavedError;
use super::files::SavedFiles;
use super::weights::WEIGHTS;
use crate::family::Family;

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
    // Without a trailing separator, so that names beside it can be made.
    let folder: PathBuf = folder.components().collect();
    let SavedFiles { description, weights } = SavedFiles::of(proposal, model, shape, training, &folder)?;
    let files = [(WEIGHTS, weights.as_slice()), (DESCRIPTION, description.as_bytes())];
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
