//! The folder of one figure in one profile: its lock, its units, its tables.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::error::{StoreError, at};
use super::line::encode;
use super::lines::{Contents, Lines};
use super::merged::{MERGED, replace};
use super::part::{Part, has_no_locks};
use super::record::Record;
use crate::unit::UnitConfig;
use crate::{checkpoint, durable};

/// A results folder, locked for as long as this value lives.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// What this process has finished since it last merged.
    part: Option<Part>,
    _lock: File,
}

impl Store {
    /// Opens or creates the results folder and locks it. The kernel holds the lock, so that it goes when the process does.
    ///
    /// # Errors
    /// [`StoreError::Locked`] if another process has it, [`StoreError::Io`] if it cannot be written.
    pub fn open(folder: &Path) -> Result<Store, StoreError> {
        std::fs::create_dir_all(folder).map_err(at(folder))?;
        let lock = lock(folder)?;
        let checkpoints = checkpoint::folder(folder);
        // What a killed run was writing when it died.
        for folder in [folder, &checkpoints] {
            durable::clear(folder).map_err(at(folder))?;
        }
        Ok(Store { folder: folder.to_path_buf(), part: None, _lock: lock })
    }

    /// The results folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where units that are not whole are set aside.
    pub(crate) fn damaged(&self) -> PathBuf {
        damaged(&self.folder)
    }

    /// Reads every unit, and merges the parts of processes that have ended into `units.jsonl`. What is truncated or changed is set aside.
    ///
    /// # Errors
    /// [`StoreError::Io`] if the folder cannot be read, or a file in it not replaced.
    pub fn read(&mut self) -> Result<Contents, StoreError> {
        Ok(self.merge(&BTreeSet::new())?.contents())
    }

    /// Stores a unit: a line in this process's part, flushed to the disk before this returns. Its checkpoint goes.
    ///
    /// # Errors
    /// [`StoreError::Io`] naming the path, for instance when the disk is full; nothing that was there is harmed.
    pub fn write(&mut self, record: &Record) -> Result<(), StoreError> {
        let part = match &mut self.part {
            Some(part) => part,
            none => none.insert(Part::create(&self.folder).map_err(at(&self.folder))?),
        };
        part.append(&encode(record)).map_err(at(part.path()))?;
        forget_training(&self.folder, &record.config.key())
    }

    /// Removes units, those of them that are there, and their checkpoints.
    ///
    /// # Errors
    /// [`StoreError::Io`] if a file cannot be replaced or removed.
    pub fn remove<'a>(&mut self, units: impl IntoIterator<Item = &'a UnitConfig>) -> Result<(), StoreError> {
        let keys: BTreeSet<String> = units.into_iter().map(UnitConfig::key).collect();
        keys.iter().try_for_each(|key| forget_training(&self.folder, key))?;
        self.merge(&keys).map(drop)
    }

    /// Writes a table or figure into the results folder, whole or not at all.
    ///
    /// # Errors
    /// [`StoreError::Io`] naming the path.
    pub fn write_file(&self, name: &str, contents: &str) -> Result<(), StoreError> {
        let path = self.folder.join(name);
        durable::write(&path, &[contents.as_bytes()]).map_err(at(&path))
    }

    fn merge(&mut self, without: &BTreeSet<String>) -> Result<Lines, StoreError> {
        // Closed, it can be merged like any other.
        self.part = None;
        merge(&self.folder, without)
    }
}

/// Brings `units.jsonl` up to date, without the units of some keys. At every moment each finished unit is in some file.
pub(super) fn merge(folder: &Path, without: &BTreeSet<String>) -> Result<Lines, StoreError> {
    let mut lines = Lines::read(folder)?;
    lines.remove(without);
    let set_aside = lines.set_aside();
    if !set_aside.is_empty() {
        let path = damaged(folder);
        let file = OpenOptions::new().append(true).create(true).open(&path);
        let append = |mut file: File| file.write_all(&set_aside).and_then(|()| file.sync_all());
        file.and_then(append).map_err(at(&path))?;
    }
    if let Some(text) = lines.to_write() {
        replace(folder, lines.merged(), text.as_bytes()).map_err(at(&folder.join(MERGED)))?;
    }
    for path in &lines.superfluous {
        durable::remove(path).map_err(at(path))?;
    }
    Ok(lines)
}

/// Where units that are not whole are set aside.
fn damaged(folder: &Path) -> PathBuf {
    folder.join("units.damaged")
}

/// Removes the checkpoint of the unit with this key: the unit is finished, or unwanted.
pub(super) fn forget_training(folder: &Path, key: &str) -> Result<(), StoreError> {
    let path = checkpoint::path(&checkpoint::folder(folder), key);
    durable::remove(&path).map_err(at(&path))
}

fn lock(folder: &Path) -> Result<File, StoreError> {
    let path = folder.join(".lock");
    let mut lock = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(&path)
        .map_err(at(&path))?;
    let mut locked = lock.try_lock();
    for _ in 0..LOCK_ATTEMPTS {
        if !matches!(locked, Err(TryLockError::WouldBlock)) || !is_of_a_dead_process(&path) {
            break;
        }
        std::thread::sleep(LOCK_PAUSE);
        locked = lock.try_lock();
    }
    match locked {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let mut holder = String::new();
            lock.read_to_string(&mut holder).map_err(at(&path))?;
            return Err(StoreError::Locked { folder: folder.into(), holder: holder.trim().into() });
        }
        // Merging harms nobody where a file system has no locks.
        Err(TryLockError::Error(error)) if has_no_locks(&error) => {}
        Err(TryLockError::Error(source)) => return Err(StoreError::Io { path, source }),
    }
    lock.set_len(0).and_then(|()| lock.rewind()).map_err(at(&path))?;
    writeln!(lock, "process {}", std::process::id()).map_err(at(&path))?;
    Ok(lock)
}

/// Whether the process that the lock file names is gone: killed while it started another, it leaves the lock to that one for a moment.
fn is_of_a_dead_process(lock: &Path) -> bool {
    let holder = std::fs::read_to_string(lock).unwrap_or_default();
    let Some(process) = holder.trim().strip_prefix("process ") else { return false };
    Path::new("/proc/self").exists() && !Path::new("/proc").join(process).exists()
}

/// How often a folder whose holder is gone is tried again, ...
const LOCK_ATTEMPTS: usize = 25;
/// ... and how long after the last time.
const LOCK_PAUSE: Duration = Duration::from_millis(20);

#[cfg(test)]
mod tests {
    use super::super::line::Line;
    use super::super::part::parts;
    use super::super::record::Outcome;
    use super::super::record::tests::record;
    use super::*;
    use crate::metric::Metric;
    use crate::unit::tests::on_graph;

    fn opened() -> (tempfile::TempDir, Store) {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        (folder, store)
    }

    /// A unit of another repetition.
    fn nth(repetition: usize) -> Record {
        let mut record = record();
        (record.point.repetition, record.config.repetition) = (repetition, repetition);
        record
    }

    fn sorted(mut records: Vec<Record>) -> Vec<Record> {
        records.sort_by_key(|record| record.config.key());
        records
    }

    #[test]
    fn a_folder_has_one_owner() {
        let (folder, _store) = opened();
        let error = Store::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains(&format!("process {}", std::process::id())), "{error}");
    }

    #[test]
    fn parts_are_merged_into_one_sorted_file() {
        let (folder, mut store) = opened();
        for repetition in [2, 0, 1] {
            store.write(&nth(repetition)).unwrap();
        }
        assert_eq!(parts(folder.path()).unwrap().len(), 1);
        assert_eq!(store.read().unwrap().records, sorted((0..3).map(nth).collect()));
        assert!(parts(folder.path()).unwrap().is_empty());
        let text = std::fs::read_to_string(folder.path().join(MERGED)).unwrap();
        assert!(text.lines().is_sorted() && text.lines().count() == 3);
        // Nothing new: the file is left as it is.
        let written = std::fs::metadata(folder.path().join(MERGED)).unwrap().modified().unwrap();
        store.read().unwrap();
        assert_eq!(std::fs::metadata(folder.path().join(MERGED)).unwrap().modified().unwrap(), written);
    }

    #[test]
    fn the_part_of_a_process_at_work_is_read_and_stays() {
        let (folder, mut store) = opened();
        let mut other = Part::create(folder.path()).unwrap();
        other.append(&encode(&nth(0))).unwrap();
        store.write(&nth(1)).unwrap();
        // Both found the same: one of them counts.
        store.write(&nth(0)).unwrap();
        assert_eq!(store.read().unwrap().records, sorted(vec![nth(0), nth(1)]));
        assert_eq!(parts(folder.path()).unwrap(), [other.path()]);
        // It is writing.
        let mut file = OpenOptions::new().append(true).open(other.path()).unwrap();
        file.write_all(&encode(&nth(2)).as_bytes()[..50]).unwrap();
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.torn, contents.damaged), (2, 0, 0));
        // It was killed.
        drop(other);
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.torn, contents.damaged), (2, 1, 0));
        assert!(parts(folder.path()).unwrap().is_empty());
        assert_eq!(store.read().unwrap().torn, 0);
        assert_eq!(
            std::fs::read(store.damaged()).unwrap(),
            [&encode(&nth(2)).as_bytes()[..50], b"\n"].concat()
        );
    }

    #[test]
    fn a_line_that_lacks_its_newline_alone_is_whole() {
        let (folder, mut store) = opened();
        std::fs::write(folder.path().join("units-1-1.part.jsonl"), encode(&record()).trim_end()).unwrap();
        let contents = store.read().unwrap();
        assert_eq!((contents.records, contents.torn), (vec![record()], 0));
    }

    #[test]
    fn damaged_lines_are_set_aside_and_take_no_other_with_them() {
        let (folder, mut store) = opened();
        let path = folder.path().join(MERGED);
        let lines: Vec<String> = (0..4).map(|repetition| encode(&nth(repetition))).collect();
        let (flipped, cut) = (lines[1].replacen("bootstrap", "bootstrop", 1), lines[3].split_at(90).0);
        std::fs::write(&path, [&lines[0], &flipped, &lines[2], cut].concat()).unwrap();
        let contents = store.read().unwrap();
        assert_eq!(contents.records, sorted(vec![nth(0), nth(2)]));
        assert_eq!((contents.damaged, contents.torn), (2, 0));
        assert_eq!(std::fs::read_to_string(store.damaged()).unwrap(), format!("{flipped}{cut}\n"));
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.damaged), (2, 0));
        // No text at all.
        std::fs::write(&path, [0xff; 100]).unwrap();
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.damaged), (0, 1));
    }

    #[test]
    fn a_whole_unit_of_another_version_is_left_alone() {
        let (folder, mut store) = opened();
        let text = Line { key: "00", body: r#"{"point":{},"config":{"format":99}}"# }.text();
        std::fs::write(folder.path().join(MERGED), &text).unwrap();
        store.write(&record()).unwrap();
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.damaged, contents.foreign), (1, 0, 1));
        let merged = std::fs::read_to_string(folder.path().join(MERGED)).unwrap();
        assert!(merged.starts_with(&text), "{merged}");
    }

    #[test]
    fn numbers_are_read_back_to_the_last_bit() {
        let (_folder, mut store) = opened();
        let mut awkward = record();
        // A parser that rounds twice takes the first of these for its neighbour.
        on_graph(&mut awkward.config).snr_db = 0.9522444552911937;
        awkward.outcome =
            Outcome::Metrics(vec![Metric::new("ess", 5.0e-324), Metric::new("loss", 1.0 / 3.0)]);
        store.write(&awkward).unwrap();
        assert_eq!(store.read().unwrap().records, [awkward]);
    }

    #[test]
    fn a_checkpoint_goes_with_its_unit() {
        let (folder, mut store) = opened();
        let path = checkpoint::path(&checkpoint::folder(folder.path()), &record().config.key());
        std::fs::create_dir(checkpoint::folder(folder.path())).unwrap();
        let write_checkpoint = || std::fs::write(&path, "half of it").unwrap();
        write_checkpoint();
        assert!(store.read().unwrap().damaged == 0 && path.exists());
        store.write(&record()).unwrap();
        assert!(!path.exists());
        write_checkpoint();
        store.remove([&record().config]).unwrap();
        assert!(!path.exists() && store.read().unwrap().records.is_empty());
    }

    #[test]
    fn what_a_killed_run_left_half_written_is_cleared_away() {
        let folder = tempfile::tempdir().unwrap();
        drop(Store::open(folder.path()).unwrap());
        let named = |name: &str| folder.path().join(durable::prefix() + name);
        let (partial, written) = (named("0123.partial"), named("0124.partial"));
        let elsewhere = folder.path().join(".another-machine-0125.partial");
        std::fs::write(&partial, "half").unwrap();
        std::fs::write(&elsewhere, "half").unwrap();
        // Another process is at it.
        let other = File::create(&written).unwrap();
        other.lock().unwrap();
        drop(Store::open(folder.path()).unwrap());
        assert!(!partial.exists() && written.exists() && elsewhere.exists());
        let two_days = std::time::SystemTime::now() - Duration::from_secs(2 * 86_400);
        File::options().append(true).open(&elsewhere).unwrap().set_modified(two_days).unwrap();
        drop(Store::open(folder.path()).unwrap());
        assert!(!elsewhere.exists());
    }
}
