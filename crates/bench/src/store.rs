//! The folder of finished units: each written at once or not at all, checked when read, one runner at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::config::Point;
use crate::series::Series;
use crate::{Metric, UnitConfig, checkpoint, durable};

/// What is stored of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its place in the figure.
    pub point: Point,
    /// What determined it.
    pub config: UnitConfig,
    /// The source revision that computed it; more of them, `… then …`, if its training was put aside and taken up by another.
    pub revision: String,
    /// The kind of processor that computed it, likewise, where it was recorded: architecture and vector extensions, which results depend on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processor: Option<String>,
    /// Its metrics, or why it failed.
    pub outcome: Outcome,
    /// What depends on the clock.
    pub timings: Vec<Metric>,
    /// Estimates over time, where the experiment shows them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<Series>,
}

impl Record {
    /// Whether it is what is wanted at a place.
    pub(crate) fn is_of(&self, point: &Point, config: &UnitConfig) -> bool {
        self.point == *point && self.config == *config
    }
}

/// How a unit ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// With these metrics.
    Metrics(Vec<Metric>),
    /// It failed, for this reason.
    Failed(String),
}

/// Why the store cannot be used.
#[derive(Debug, Error)]
pub enum StoreError {
    /// Another runner has the folder.
    #[error("{folder} is in use by another run ({holder}); wait for it, or give another --out", folder = folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// What the lock file says of its holder.
        holder: String,
    },
    /// The figure could not be drawn.
    #[error("figure.svg could not be drawn: {0}")]
    Figure(String),
    /// A trained proposal could not be kept.
    #[error("{0}")]
    Model(String),
    /// A file could not be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

fn at(path: &Path) -> impl FnOnce(std::io::Error) -> StoreError + '_ {
    move |source| StoreError::Io { path: path.to_path_buf(), source }
}

/// A results folder, locked for as long as this value lives.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    _lock: File,
}

/// What the folder of units holds.
#[derive(Debug, Default)]
pub struct Contents {
    /// Units that are whole.
    pub records: Vec<Record>,
    /// Files that were not and have been set aside.
    pub set_aside: Vec<PathBuf>,
    /// Number of files that are whole but not of this version's making; they are left alone.
    pub foreign: usize,
}

const HEAD: &str = "{\"length\":";

impl Store {
    /// Opens or creates the results folder and locks it. The kernel holds the lock, so that it goes when the process does.
    ///
    /// # Errors
    /// [`StoreError::Locked`] if another process has it, [`StoreError::Io`] if it cannot be written.
    pub fn open(folder: &Path) -> Result<Store, StoreError> {
        let units = folder.join("units");
        std::fs::create_dir_all(&units).map_err(at(&units))?;
        let path = folder.join(".lock");
        let mut lock = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(at(&path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                lock.read_to_string(&mut holder).map_err(at(&path))?;
                return Err(StoreError::Locked { folder: folder.into(), holder: holder.trim().into() });
            }
            Err(TryLockError::Error(source)) => return Err(StoreError::Io { path, source }),
        }
        lock.set_len(0).and_then(|()| lock.rewind()).map_err(at(&path))?;
        writeln!(lock, "process {}", std::process::id()).map_err(at(&path))?;
        // What a killed run was writing when it died; nobody else is writing now.
        for entry in std::fs::read_dir(&units).map_err(at(&units))? {
            let path = entry.map_err(at(&units))?.path();
            if path.extension().is_some_and(|extension| extension == durable::PARTIAL) {
                std::fs::remove_file(&path).map_err(at(&path))?;
            }
        }
        Ok(Store { folder: folder.to_path_buf(), _lock: lock })
    }

    /// The results folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The folder of units, and of trainings that are not finished.
    pub(crate) fn units(&self) -> PathBuf {
        self.folder.join("units")
    }

    fn path(&self, key: &str) -> PathBuf {
        self.units().join(format!("{key}.json"))
    }

    /// Reads every unit. A file that is truncated, empty or changed is renamed out of the way and reported.
    ///
    /// # Errors
    /// [`StoreError::Io`] if the folder cannot be read.
    pub fn read(&self) -> Result<Contents, StoreError> {
        let folder = self.folder.join("units");
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(&folder).map_err(at(&folder))? {
            let path = entry.map_err(at(&folder))?.path();
            if path.extension().is_some_and(|extension| extension == "json") {
                paths.push(path);
            }
        }
        paths.sort();
        let mut contents = Contents::default();
        for path in paths {
            let text = std::fs::read(&path).map_err(at(&path))?;
            let key = path.file_stem().and_then(|key| key.to_str()).unwrap_or_default();
            let Some(body) = whole(&text) else {
                let aside = path.with_extension("json.damaged");
                std::fs::rename(&path, &aside).map_err(at(&path))?;
                contents.set_aside.push(aside);
                continue;
            };
            match serde_json::from_str::<Record>(body) {
                Ok(record) if record.config.key() == key => contents.records.push(record),
                _ => contents.foreign += 1,
            }
        }
        Ok(contents)
    }

    /// Stores a unit: written under another name, flushed to the disk, then renamed, so that no partial file ever counts. What was put
    /// aside of its training goes.
    ///
    /// # Errors
    /// [`StoreError::Io`] naming the path, for instance when the disk is full; nothing that was there is harmed.
    pub fn write(&self, record: &Record) -> Result<(), StoreError> {
        let key = record.config.key();
        self.replace(&self.path(&key), encode(record).as_bytes())?;
        self.forget_training(&key)
    }

    /// Removes a unit, if it is there, and what was put aside of its training.
    ///
    /// # Errors
    /// [`StoreError::Io`] if it is there and cannot be removed.
    pub fn remove(&self, config: &UnitConfig) -> Result<(), StoreError> {
        let key = config.key();
        self.forget_training(&key)?;
        let path = self.path(&key);
        durable::remove(&path).map_err(at(&path))
    }

    fn forget_training(&self, key: &str) -> Result<(), StoreError> {
        let path = checkpoint::path(&self.units(), key);
        durable::remove(&path).map_err(at(&path))
    }

    /// Writes a table or figure into the results folder, whole or not at all.
    ///
    /// # Errors
    /// [`StoreError::Io`] naming the path.
    pub fn write_file(&self, name: &str, contents: &str) -> Result<(), StoreError> {
        self.replace(&self.folder.join(name), contents.as_bytes())
    }

    fn replace(&self, path: &Path, contents: &[u8]) -> Result<(), StoreError> {
        durable::write(path, &[contents]).map_err(at(path))
    }
}

/// `{"length":L,"blake3":"…","unit":BODY}` with the length and hash of BODY.
fn encode(record: &Record) -> String {
    let body = serde_json::to_string(record).expect("a record has only string keys and finite numbers");
    let hash = blake3::hash(body.as_bytes()).to_hex();
    format!("{HEAD}{},\"blake3\":\"{hash}\",\"unit\":{body}}}\n", body.len())
}

/// The unit in a file whose length and checksum are right.
fn whole(bytes: &[u8]) -> Option<&str> {
    let text = std::str::from_utf8(bytes).ok()?;
    let rest = text.strip_prefix(HEAD)?;
    let (length, rest) = rest.split_once(",\"blake3\":\"")?;
    let (hash, rest) = rest.split_once("\",\"unit\":")?;
    let body = rest.strip_suffix("}\n")?;
    let is_whole =
        length.parse() == Ok(body.len()) && blake3::hash(body.as_bytes()).to_hex().as_str() == hash;
    is_whole.then_some(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Method;
    use crate::unit::tests::{on_graph, unit};

    fn record() -> Record {
        Record {
            point: Point { panel: "N10".into(), x: 20, method: Method::Bootstrap, repetition: 0 },
            config: unit(10, 12, 20),
            revision: "0123".into(),
            processor: Some("x86_64 avx2 fma".into()),
            outcome: Outcome::Metrics(vec![Metric::new("ess", 0.1 + 0.2)]),
            timings: vec![],
            series: None,
        }
    }

    #[test]
    fn every_damaged_byte_is_noticed() {
        let text = encode(&record());
        let body = whole(text.as_bytes()).unwrap();
        assert_eq!(serde_json::from_str::<Record>(body).unwrap(), record());
        let _: serde_json::Value = serde_json::from_str(&text).unwrap();
        for at in 0..text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[at] ^= 1;
            assert_eq!(whole(&bytes), None, "a flip in byte {at} went unnoticed");
            assert_eq!(whole(&text.as_bytes()[..at]), None, "a file of {at} bytes was taken for whole");
        }
    }

    #[test]
    fn a_damaged_unit_is_set_aside_and_a_folder_has_one_owner() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        store.write(&record()).unwrap();
        assert_eq!(store.read().unwrap().records, [record()]);

        let error = Store::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains(&format!("process {}", std::process::id())), "{error}");

        std::fs::write(store.path(&record().config.key()), "").unwrap();
        let contents = store.read().unwrap();
        assert!(contents.records.is_empty() && contents.set_aside.len() == 1);
        assert!(store.read().unwrap().set_aside.is_empty());
    }

    #[test]
    fn a_whole_unit_of_another_version_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let body = r#"{"point":{},"config":{"format":99}}"#;
        let hash = blake3::hash(body.as_bytes()).to_hex();
        let text = format!("{HEAD}{},\"blake3\":\"{hash}\",\"unit\":{body}}}\n", body.len());
        std::fs::write(store.path("00"), &text).unwrap();
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.set_aside.len(), contents.foreign), (0, 0, 1));
        assert_eq!(std::fs::read_to_string(store.path("00")).unwrap(), text);
    }

    #[test]
    fn numbers_are_read_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let mut awkward = record();
        // A parser that rounds twice takes the first of these for its neighbour.
        on_graph(&mut awkward.config).snr_db = 0.9522444552911937;
        awkward.outcome =
            Outcome::Metrics(vec![Metric::new("ess", 5.0e-324), Metric::new("loss", 1.0 / 3.0)]);
        store.write(&awkward).unwrap();
        assert_eq!(store.read().unwrap().records, [awkward]);
    }

    #[test]
    fn what_was_put_aside_of_a_training_goes_with_its_unit() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let path = store.units().join(format!("{}.checkpoint", record().config.key()));
        let put_aside = || std::fs::write(&path, "half of it").unwrap();
        put_aside();
        assert!(store.read().unwrap().set_aside.is_empty() && path.exists());
        store.write(&record()).unwrap();
        assert!(!path.exists());
        put_aside();
        store.remove(&record().config).unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn what_a_killed_run_left_half_written_is_cleared_away() {
        let folder = tempfile::tempdir().unwrap();
        drop(Store::open(folder.path()).unwrap());
        let partial = folder.path().join("units/0123.partial");
        std::fs::write(&partial, "half").unwrap();
        drop(Store::open(folder.path()).unwrap());
        assert!(!partial.exists());
    }
}
