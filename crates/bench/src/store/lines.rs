//! All lines of a results folder, whatever file they are in, and what of them counts.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::error::{StoreError, at};
use super::line::Line;
use super::record::Record;
use super::{old_layout, part};

/// The file of merged units.
pub(super) const MERGED: &str = "units.jsonl";

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
    /// `units.jsonl` as it is.
    merged: Vec<u8>,
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
    pub(super) fn read(folder: &Path) -> Result<Lines, StoreError> {
        let mut lines = Lines::default();
        for (path, key, bytes) in old_layout::read(folder)? {
            match old_layout::body(&bytes) {
                Some(body) => lines.keep(Line { key: &key, body }),
                None => lines.damaged.push(bytes),
            }
            lines.superfluous.push(path);
        }
        let path = folder.join(MERGED);
        if path.exists() {
            lines.merged = std::fs::read(&path).map_err(at(&path))?;
            let torn = lines.add(&lines.merged.clone());
            lines.damaged.extend(torn);
        }
        for path in part::parts(folder).map_err(at(folder))? {
            let mut file = File::open(&path).map_err(at(&path))?;
            // Asked first: what it writes later is not read either.
            let is_open = part::is_open(&file).map_err(at(&path))?;
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).map_err(at(&path))?;
            let torn = lines.add(&bytes);
            if !is_open {
                lines.torn.extend(torn);
                lines.superfluous.push(path);
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

    fn keep(&mut self, line: Line<'_>) {
        self.units.insert(line.key.to_string(), line.text());
    }

    /// Forgets the units with these keys.
    pub(super) fn remove<'a>(&mut self, keys: impl IntoIterator<Item = &'a String>) {
        keys.into_iter().for_each(|key| drop(self.units.remove(key)));
    }

    /// What `units.jsonl` ought to be, if it is not.
    pub(super) fn to_write(&self) -> Option<String> {
        let text: String = self.units.values().map(String::as_str).collect();
        (text.as_bytes() != self.merged).then_some(text)
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
