//! Files that are there whole or not at all.

use std::fs::File;
use std::io::{ErrorKind, Result, Write};
use std::path::Path;
use std::time::Duration;

use tempfile::NamedTempFile;

/// What ends the names of files that are being written; a process that is killed may leave some.
const PARTIAL: &str = ".partial";

/// Writes a file of these parts under another name, flushes it to the disk and renames it: what was there before stays until then.
///
/// # Errors
/// What the operating system says, when the disk is full for instance; nothing is left behind then.
pub(crate) fn write(path: &Path, parts: &[&[u8]]) -> Result<()> {
    written(path, parts)?.persist(path).map_err(|error| error.error)?;
    // The new name, too, has to reach the disk.
    File::open(folder_of(path))?.sync_all()
}

/// Writes a file, whole, unless there is one of that name: then nothing is done, and `false` comes back.
///
/// # Errors
/// What the operating system says.
pub(crate) fn write_new(path: &Path, text: &[u8]) -> Result<bool> {
    match written(path, &[text])?.persist_noclobber(path) {
        Ok(_) => File::open(folder_of(path))?.sync_all().map(|()| true),
        Err(error) if error.error.kind() == ErrorKind::AlreadyExists => Ok(false),
        // A file system without links is no network's that several machines merge on.
        Err(error) if matches!(error.error.kind(), ErrorKind::Unsupported | ErrorKind::PermissionDenied) => {
            write(path, &[text]).map(|()| true)
        }
        Err(error) => Err(error.error),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("."))
}

/// The name of this machine, as far as it can be part of a file's name.
pub(crate) fn machine() -> String {
    let name = gethostname::gethostname().to_string_lossy().into_owned();
    name.chars().filter(|letter| letter.is_ascii_alphanumeric() || *letter == '-').collect()
}

/// What the names of files begin with that this machine is writing.
pub(crate) fn prefix() -> String {
    format!(".{}.", machine())
}

/// A file of these parts under another name, flushed to the disk.
fn written(path: &Path, parts: &[&[u8]]) -> Result<NamedTempFile> {
    let prefix = prefix();
    let mut builder = tempfile::Builder::new();
    // Readable for all whom the user's mask lets read, as any file that a program creates.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.prefix(&prefix).suffix(PARTIAL).tempfile_in(folder_of(path))?;
    // So that a run that starts now does not take it for one that was left; where there are no locks, nothing else is lost.
    let _ = file.as_file().try_lock();
    parts.iter().try_for_each(|part| file.as_file_mut().write_all(part))?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// How old a file of another machine is when its writer has surely died: locks do not say so across machines.
const DEAD: Duration = Duration::from_secs(86_400);

/// Removes what killed processes were writing in a folder, if the folder is there.
pub(crate) fn clear(folder: &Path) -> Result<()> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        entries => entries?,
    };
    for entry in entries {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.ends_with(PARTIAL) && is_dead(&path, name.starts_with(&prefix()))? {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Whether nobody writes to a file any more. It may vanish any time, when its writer is done.
fn is_dead(path: &Path, is_of_this_machine: bool) -> Result<bool> {
    // A lock on a network's file system needs a file that may be written.
    let file = match File::options().read(true).write(true).open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        file => file?,
    };
    if is_of_this_machine {
        return Ok(file.try_lock().is_ok());
    }
    Ok(file.metadata()?.modified()?.elapsed().is_ok_and(|age| age > DEAD))
}

/// Removes a file, if it is there.
///
/// # Errors
/// What the operating system says if it is there and cannot be removed.
pub(crate) fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_written_file_may_be_read_by_who_may_read_any_other() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| {
            use std::os::unix::fs::PermissionsExt;
            std::fs::metadata(folder.path().join(name)).unwrap().permissions().mode()
        };
        std::fs::write(folder.path().join("any"), "").unwrap();
        write(&folder.path().join("ours"), &[b"a", b"b"]).unwrap();
        assert_eq!(mode("ours"), mode("any"));
        assert_eq!(std::fs::read(folder.path().join("ours")).unwrap(), b"ab");
    }
}
