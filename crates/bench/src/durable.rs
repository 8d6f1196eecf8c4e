//! Files that are there whole or not at all.

use std::fs::File;
use std::io::{ErrorKind, Result, Write};
use std::path::Path;

/// What ends the names of files that are being written; a run that was killed may leave some.
pub(crate) const PARTIAL: &str = "partial";

/// Writes a file of these parts under another name, flushes it to the disk and renames it: what was there before stays until then.
///
/// # Errors
/// What the operating system says, when the disk is full for instance; nothing is left behind then.
pub(crate) fn write(path: &Path, parts: &[&[u8]]) -> Result<()> {
    let temporary = path.with_extension(PARTIAL);
    let write = || {
        let mut file = File::create(&temporary)?;
        parts.iter().try_for_each(|part| file.write_all(part))?;
        file.sync_all()?;
        std::fs::rename(&temporary, path)?;
        // The new name, too, has to reach the disk.
        path.parent().map_or(Ok(()), |folder| File::open(folder)?.sync_all())
    };
    write().inspect_err(|_| {
        let _ = std::fs::remove_file(&temporary);
    })
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
