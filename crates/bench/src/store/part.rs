//! The units that one process has finished, in a file that nobody else writes.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::durable;

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
    /// Creates a new part in a folder.
    pub(super) fn create(folder: &Path) -> Result<Part> {
        loop {
            let path = free_path(folder);
            match OpenOptions::new().append(true).create_new(true).open(&path) {
                Ok(file) => {
                    match file.lock() {
                        Err(error) if !has_no_locks(&error) => return Err(error),
                        _ => {}
                    }
                    File::open(folder)?.sync_all()?;
                    return Ok(Part { path, file, length: 0 });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
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

/// A part that nobody else writes: named after this machine and process, with a number.
pub(super) fn free_path(folder: &Path) -> PathBuf {
    static NUMBER: AtomicUsize = AtomicUsize::new(1);
    let (machine, process) = (durable::machine(), std::process::id());
    // Machines may share a name, and containers the numbers of processes.
    let moment = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.subsec_nanos());
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("units-{machine}-{process}-{moment:x}-{number}.{EXTENSION}"));
        if !path.exists() {
            return path;
        }
    }
}

/// The part of one unit.
pub(super) fn of_unit(folder: &Path, key: &str) -> PathBuf {
    folder.join(format!("units-{key}.{EXTENSION}"))
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

/// Whether a process may still write to the part. One of a unit appeared whole. Of another only a lock says that nobody does, and a lock of a
/// network's file system needs a file that may be written. Where it cannot be told, the part is left in place, and read all the same.
pub(super) fn is_open(path: &Path) -> bool {
    if is_of_unit(path) {
        return false;
    }
    let part = OpenOptions::new().read(true).write(true).open(path);
    !part.is_ok_and(|part| part.try_lock().is_ok())
}

/// Whether a part's name is that of a unit: a key, which is hexadecimal.
fn is_of_unit(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let key = name.strip_prefix("units-").and_then(|rest| rest.strip_suffix(&format!(".{EXTENSION}")));
    key.is_some_and(|key| key.len() == 32 && key.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

/// Whether that is what a file system says that has no locks, as some on networks have none.
pub(super) fn has_no_locks(error: &std::io::Error) -> bool {
    /// "No locks available".
    const ENOLCK: i32 = 37;
    error.kind() == ErrorKind::Unsupported || error.raw_os_error() == Some(ENOLCK)
}
