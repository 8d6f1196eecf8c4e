//! Checkpoints of long trainings, so that a run that is stopped or killed does not lose them.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::durable;
use crate::provenance::Provenance;
use motes_cli::status;

/// How often a training is checkpointed.
const EVERY: Duration = Duration::from_secs(600);
/// What is not worth a checkpoint when a run is stopped.
const WORTH: Duration = Duration::from_secs(60);

/// What ends the names of checkpoints.
pub(crate) const EXTENSION: &str = "checkpoint";

/// Where the checkpoints of a results folder lie.
pub(crate) fn folder(results: &Path) -> PathBuf {
    results.join("checkpoints")
}

/// That of the unit with this key, in the folder of checkpoints.
pub(crate) fn path(checkpoints: &Path, key: &str) -> PathBuf {
    checkpoints.join(format!("{key}.{EXTENSION}"))
}

/// Where checkpoints lie, and what computes the trainings.
#[derive(Debug, Clone)]
pub(crate) struct Checkpoints {
    /// Their folder.
    pub(crate) folder: PathBuf,
    pub(crate) provenance: Provenance,
}

impl Checkpoints {
    /// That of the unit with this key.
    pub(crate) fn of(&self, key: &str) -> Checkpoint {
        let provenance = self.provenance.clone();
        Checkpoint { path: path(&self.folder, key), provenance, last: Instant::now() }
    }
}

/// The training of one unit on disk.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    provenance: Provenance,
    last: Instant,
}

/// A training as it was when its checkpoint was written.
#[derive(Debug, PartialEq)]
pub(crate) struct Saved {
    /// The seconds that it had taken.
    pub(crate) seconds: f64,
    /// What computed its parts, one after the other.
    pub(crate) provenances: Vec<Provenance>,
    /// What `motes_train` wrote of it.
    pub(crate) training: Vec<u8>,
}

/// A line before the bytes of a training.
#[derive(Serialize, Deserialize)]
struct Head {
    seconds: f64,
    provenances: Vec<Provenance>,
}

impl Checkpoint {
    /// The training, if it has a checkpoint. A damaged file is as good as none, and said to be.
    pub(crate) fn read(&self) -> Option<Saved> {
        let bytes = match std::fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
            Err(error) => {
                status(&format!("{}: {error}; its training begins anew", self.path.display()));
                return None;
            }
        };
        let found = whole(&bytes);
        if found.is_none() {
            status(&format!("{} is damaged; its training begins anew", self.path.display()));
        }
        found
    }

    /// Whether it is time for a checkpoint: every ten minutes, and when the run is being stopped.
    pub(crate) fn is_due(&self, stopping: bool) -> bool {
        let wait = if stopping { WORTH } else { EVERY };
        self.last.elapsed() >= wait
    }

    /// Writes the checkpoint of a training that was begun by `earlier` and has taken so many seconds: whole, or what was there before stays.
    pub(crate) fn write(
        &mut self,
        seconds: f64,
        earlier: &[Provenance],
        training: &[u8],
    ) -> Result<(), String> {
        let mut provenances = earlier.to_vec();
        provenances.push(self.provenance.clone());
        provenances.dedup();
        let mut head =
            serde_json::to_vec(&Head { seconds, provenances }).map_err(|error| error.to_string())?;
        head.push(b'\n');
        let hash = *blake3::Hasher::new().update(&head).update(training).finalize().as_bytes();
        self.last = Instant::now();
        std::fs::create_dir_all(self.path.parent().unwrap_or(Path::new(".")))
            .and_then(|()| durable::write(&self.path, &[&hash, &head, training]))
            .map_err(|error| format!("{}: {error}", self.path.display()))
    }
}

/// What was written, if it is all there: a hash, the head in a line, the training.
fn whole(bytes: &[u8]) -> Option<Saved> {
    let (hash, rest) = bytes.split_first_chunk::<{ blake3::OUT_LEN }>()?;
    if blake3::hash(rest).as_bytes() != hash {
        return None;
    }
    let end = rest.iter().position(|byte| *byte == b'\n')?;
    let Head { seconds, provenances } = serde_json::from_slice(&rest[..end]).ok()?;
    Some(Saved { seconds, provenances, training: rest[end + 1..].to_vec() })
}
