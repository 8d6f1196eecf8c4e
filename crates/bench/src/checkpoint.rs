//! Long trainings put aside now and then, so that a run that is stopped or killed does not lose them.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::say::news;

/// How often a training is put aside: it takes seconds for the largest.
const EVERY: Duration = Duration::from_secs(600);
/// What is not worth being put aside when a run is stopped.
const WORTH: Duration = Duration::from_secs(60);

/// Where trainings that are not finished lie, a file for each unit.
#[derive(Debug, Clone)]
pub(crate) struct Checkpoints {
    folder: PathBuf,
    every: Duration,
    worth: Duration,
}

impl Checkpoints {
    /// In the given folder, which is there.
    pub(crate) fn in_folder(folder: PathBuf) -> Self {
        Checkpoints { folder, every: EVERY, worth: WORTH }
    }

    /// That of a unit.
    pub(crate) fn of(&self, key: &str) -> Checkpoint {
        let path = self.folder.join(format!("{key}.checkpoint"));
        Checkpoint { path, every: self.every, worth: self.worth, last: Instant::now() }
    }
}

/// The training of one unit on disk.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    every: Duration,
    worth: Duration,
    last: Instant,
}

/// The length of what stands before the bytes of a training: their hash and the seconds that it has taken.
const HEAD: usize = blake3::OUT_LEN + 8;

impl Checkpoint {
    /// The seconds that the training had taken and its bytes, if one was put aside; a damaged file is as good as none, and said to be.
    pub(crate) fn read(&self) -> Option<(f64, Vec<u8>)> {
        let mut bytes = match std::fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
            Err(error) => {
                news(&format!("{}: {error}; its training begins anew", self.path.display()));
                return None;
            }
        };
        let seconds = bytes.get(blake3::OUT_LEN..HEAD).and_then(|seconds| seconds.as_array().copied());
        let is_whole = |rest: &[u8]| blake3::hash(rest).as_bytes().as_slice() == &bytes[..blake3::OUT_LEN];
        match seconds {
            Some(seconds) if is_whole(&bytes[blake3::OUT_LEN..]) => {
                bytes.drain(..HEAD);
                Some((f64::from_le_bytes(seconds), bytes))
            }
            _ => {
                news(&format!("{} is damaged; its training begins anew", self.path.display()));
                None
            }
        }
    }

    /// Whether it is time to put the training aside: every ten minutes, and when the run is being stopped.
    pub(crate) fn is_due(&self, stopping: bool) -> bool {
        let wait = if stopping { self.worth } else { self.every };
        self.last.elapsed() >= wait
    }

    /// Puts a training aside that has taken so many seconds: whole, or what was there before stays.
    pub(crate) fn write(&mut self, seconds: f64, bytes: &[u8]) -> Result<(), String> {
        let mut head = blake3::Hasher::new();
        head.update(&seconds.to_le_bytes()).update(bytes);
        // Store::open clears away what a killed run left under such a name.
        let temporary = self.path.with_extension("checkpoint.partial");
        let write = || {
            let mut file = File::create(&temporary)?;
            file.write_all(head.finalize().as_bytes())?;
            file.write_all(&seconds.to_le_bytes())?;
            file.write_all(bytes)?;
            file.sync_all()?;
            std::fs::rename(&temporary, &self.path)
        };
        self.last = Instant::now();
        write().map_err(|error: std::io::Error| {
            let _ = std::fs::remove_file(&temporary);
            format!("{}: {error}", self.path.display())
        })
    }
}

/// Removes what was put aside of a unit, if anything was.
pub(crate) fn forget(folder: &Path, key: &str) -> std::io::Result<()> {
    match std::fs::remove_file(folder.join(format!("{key}.checkpoint"))) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
