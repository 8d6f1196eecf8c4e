//! The units that one process has finished, in a file that nobody else writes.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

/// What ends the names of part files.
pub(super) const EXTENSION: &str = "part.jsonl";

/// A file that only grows by whole lines. It is locked for as long as this value lives, so that a merge on this machine leaves it in place.
#[derive(Debug)]
pub(super) struct Part {
    path: PathBuf,
    file: File,
    /// The length of its whole lines.
    length: u64,
}

impl Part {
    /// Creates a new part in a folder, named after this process, or with a number where a process of another machine took that name.
    pub(super) fn create(folder: &Path) -> Result<Part> {
        let process = std::process::id();
        for number in 1_u32.. {
            let path = folder.join(format!("units-{process}-{number}.{EXTENSION}"));
            match OpenOptions::new().append(true).create_new(true).open(&path) {
                Ok(file) => {
                    file.lock()?;
                    File::open(folder)?.sync_all()?;
                    return Ok(Part { path, file, length: 0 });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Appends a line and flushes it to the disk. A line that does not fit is taken back.
    pub(super) fn append(&mut self, line: &str) -> Result<()> {
        match self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data()) {
            Ok(()) => {
                self.length += line.len() as u64;
                Ok(())
            }
            Err(error) => {
                // The error that is reported is the first one; a torn line would be found by its hash.
                let _ = self.file.set_len(self.length);
                Err(error)
            }
        }
    }
}

/// The part files of a folder, sorted by name.
pub(super) fn parts(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.to_string_lossy().ends_with(&format!(".{EXTENSION}")) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Whether a process of this machine still writes to the part.
pub(super) fn is_open(part: &File) -> Result<bool> {
    match part.try_lock() {
        Ok(()) => Ok(false),
        Err(std::fs::TryLockError::WouldBlock) => Ok(true),
        Err(std::fs::TryLockError::Error(error)) => Err(error),
    }
}
