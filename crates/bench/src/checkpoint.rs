//! Long trainings put aside now and then, so that a run that is stopped or killed does not lose them.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::durable;
use crate::say::news;

/// How often a training is put aside.
const EVERY: Duration = Duration::from_secs(600);
/// What is not worth being put aside when a run is stopped.
const WORTH: Duration = Duration::from_secs(60);

/// Where the training of the unit with this key lies, in the folder of units.
pub(crate) fn path(units: &Path, key: &str) -> PathBuf {
    units.join(format!("{key}.checkpoint"))
}

/// The training of one unit on disk.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    last: Instant,
}

/// The length of what stands before the bytes of a training: their hash and the seconds that it has taken.
const HEAD: usize = blake3::OUT_LEN + 8;

impl Checkpoint {
    /// That of the unit with this key, in the folder of units.
    pub(crate) fn of(units: &Path, key: &str) -> Self {
        Checkpoint { path: path(units, key), last: Instant::now() }
    }

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
        let wait = if stopping { WORTH } else { EVERY };
        self.last.elapsed() >= wait
    }

    /// Puts a training aside that has taken so many seconds: whole, or what was there before stays.
    pub(crate) fn write(&mut self, seconds: f64, bytes: &[u8]) -> Result<(), String> {
        let seconds = seconds.to_le_bytes();
        let hash = *blake3::Hasher::new().update(&seconds).update(bytes).finalize().as_bytes();
        self.last = Instant::now();
        durable::write(&self.path, &[&hash, &seconds, bytes])
            .map_err(|error| format!("{}: {error}", self.path.display()))
    }
}
