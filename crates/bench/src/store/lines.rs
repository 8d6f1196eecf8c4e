//! All lines of a results folder, whatever file they are in, and what of them counts.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::error::{StoreError, at};
use super::line::Line;
use super::merged::MERGED;
use super::part;
use super::record::Record;

/// How often a folder is read again until no file came or went meanwhile.
const CALM_ATTEMPTS: usize = 20;
/// How often while files vanish before they are read, ...
const MOST_ATTEMPTS: usize = 1000;
/// ... and how long after the last time.
const PAUSE: Duration = Duration::from_millis(10);

/// Whether a file is gone, or was replaced by another machine while it was read: "stale file handle".
fn has_gone(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::NotFound | ErrorKind::StaleNetworkFileHandle)
}

/// What the folder of units holds.
#[derive(Debug, Default)]
pub struct Contents {
    /// Units that are whole, sorted by key.
    pub records: Vec<Record>,
    /// Number of units that were not whole and have been set aside.
    pub damaged: usize,
    /// Number of lines that a process was writing when it was killed, set aside too.
    pub torn: usize,
    /// Number of units that are whole but not of this version's making; they are left alone.
    pub foreign: usize,
}

/// Every unit of a folder as text, and the files that a merge makes superfluous.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// `units.jsonl` as it is, if it is there.
    merged: Option<Vec<u8>>,
    /// By key. The newest line of a unit counts.
    units: BTreeMap<String, String>,
    /// What is not whole, with its newlines.
    damaged: Vec<Vec<u8>>,
    /// What is not whole because its writer was killed.
    torn: Vec<Vec<u8>>,
    /// Files whose units all are here.
    pub(super) superfluous: Vec<PathBuf>,
}

impl Lines {
    /// Reads all files of a folder. Parts that are still being written to are read as far as they are whole, and stay.
    ///
    /// Another process may merge meanwhile: then files that were listed are gone, and their units lie in one that was not.
    pub(super) fn read(folder: &Path) -> Result<Lines, StoreError> {
        let mut attempt = 0;
        loop {
            attempt += 1;
            let before = files(folder)?;
            let lines = match Lines::read_files(folder, &before) {
                Err(StoreError::Io { source, .. }) if has_gone(&source) && attempt < MOST_ATTEMPTS => {
                    std::thread::sleep(PAUSE);
                    continue;
                }
                lines => lines?,
            };
            let after = files(folder)?;
            let nothing_left = || before.iter().all(|path| after.contains(path));
            // Where new parts appear all the time it is enough that none went.
            if before == after || (attempt > CALM_ATTEMPTS && nothing_left()) {
                return Ok(lines);
            }
        }
    }

    fn read_files(folder: &Path, paths: &[PathBuf]) -> Result<Lines, StoreError> {
        let (mut lines, merged) = (Lines::default(), folder.join(MERGED));
        for path in paths {
            if *path == merged {
                let bytes = std::fs::read(path).map_err(at(path))?;
                let torn = lines.add(&bytes);
                lines.damaged.extend(torn);
                lines.merged = Some(bytes);
                continue;
            }
            // Asked first: what it writes later is not read either.
            let is_open = part::is_open(path);
            let bytes = std::fs::read(path).map_err(at(path))?;
            let torn = lines.add(&bytes);
            if !is_open {
                lines.torn.extend(torn);
                lines.superfluous.push(path.clone());
            }
        }
        Ok(lines)
    }

    /// Adds the lines of a file; what comes back stands at its end and is not whole.
    fn add(&mut self, bytes: &[u8]) -> Option<Vec<u8>> {
        for chunk in bytes.split_inclusive(|byte| *byte == b'\n') {
            let (text, has_ended) = match chunk.strip_suffix(b"\n") {
                Some(text) => (text, true),
                None => (chunk, false),
            };
            match Line::parse(text) {
                Some(line) => self.keep(line),
                None if has_ended => self.damaged.push(chunk.to_vec()),
                None => return Some(chunk.to_vec()),
            }
        }
        None
    }

    /// Of two lines of a unit the newer counts; but what one machine could not do is no reason to forget what another did.
    fn keep(&mut self, line: Line<'_>) {
        let is_failure = |text: &str| text.contains(r#""outcome":{"failed":"#);
        let known = self.units.get(line.key);
        if known.is_none_or(|known| is_failure(known) || !is_failure(line.body)) {
            self.units.insert(line.key.to_string(), line.text());
        }
    }

    /// Forgets the units with these keys.
    pub(super) fn remove<'a>(&mut self, keys: impl IntoIterator<Item = &'a String>) {
        keys.into_iter().for_each(|key| drop(self.units.remove(key)));
    }

    /// What `units.jsonl` ought to be, if it is not.
    pub(super) fn to_write(&self) -> Option<String> {
        let text: String = self.units.values().map(String::as_str).collect();
        let found = self.merged.as_deref().unwrap_or_default();
        (text.as_bytes() != found).then_some(text)
    }

    /// `units.jsonl` as it was read, if it was there.
    pub(super) fn merged(&self) -> Option<&[u8]> {
        self.merged.as_deref()
    }

    /// All that is not whole, each in a line of its own.
    pub(super) fn set_aside(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for line in self.damaged.iter().chain(&self.torn) {
            bytes.extend_from_slice(line.strip_suffix(b"\n").unwrap_or(line));
            bytes.push(b'\n');
        }
        bytes
    }

    pub(super) fn contents(&self) -> Contents {
        let lines = self.units.values().filter_map(|text| Line::parse(text.trim_end().as_bytes()));
        let records: Vec<Record> = lines.filter_map(Line::record).collect();
        Contents {
            foreign: self.units.len() - records.len(),
            records,
            damaged: self.damaged.len(),
            torn: self.torn.len(),
        }
    }
}

/// The files with units of a folder: the merged one first, so that newer lines count, then the parts by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let merged = folder.join(MERGED);
    let there = merged.try_exists().map_err(at(&merged))?.then_some(merged);
    let parts = part::parts(folder).map_err(at(folder))?;
    Ok(there.into_iter().chain(parts).collect())
}
