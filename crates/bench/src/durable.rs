//! Files that are there whole or not at all.

use std::fs::File;
use std::io::{ErrorKind, Result, Write};
use std::path::Path;

/// What ends the names of files that are being written; a process that is killed may leave some.
const PARTIAL: &str = ".partial";

/// Writes a file of these parts under another name, flushes it to the disk and renames it: what was there before stays until then.
///
/// # Errors
/// What the operating system says, when the disk is full for instance; nothing is left behind then.
pub(crate) fn write(path: &Path, parts: &[&[u8]]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    // Readable for all whom the user's mask lets read, as any file that a program creates.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.suffix(PARTIAL).tempfile_in(folder)?;
    // So that a run that starts now does not take it for one that was left; where there are no locks, nothing else is lost.
    let _ = file.as_file().try_lock();
    parts.iter().try_for_each(|part| file.as_file_mut().write_all(part))?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    // The new name, too, has to reach the disk.
    File::open(folder)?.sync_all()
}

/// Removes what killed processes were writing in a folder, if the folder is there.
pub(crate) fn clear(folder: &Path) -> Result<()> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        entries => entries?,
    };
    for entry in entries {
        let path = entry?.path();
        if path.to_string_lossy().ends_with(PARTIAL) && File::open(&path)?.try_lock().is_ok() {
            remove(&path)?;
        }
    }
    Ok(())
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
