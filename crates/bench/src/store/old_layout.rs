//! Results folders with a file for each unit, `units/<key>.json`, as earlier versions wrote them.

use std::path::{Path, PathBuf};

use super::error::{StoreError, at};

/// Where units and checkpoints lay.
pub(super) fn folder(results: &Path) -> PathBuf {
    results.join("units")
}

/// Path, key and bytes of each unit, sorted.
pub(super) fn read(results: &Path) -> Result<Vec<(PathBuf, String, Vec<u8>)>, StoreError> {
    let mut found = Vec::new();
    for path in files(results, "json")? {
        let key = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).map_err(at(&path))?;
        found.push((path, key, bytes));
    }
    Ok(found)
}

/// The files with this ending, sorted; none where there is no such folder.
pub(super) fn files(results: &Path, extension: &str) -> Result<Vec<PathBuf>, StoreError> {
    let folder = folder(results);
    let mut paths = Vec::new();
    if folder.is_dir() {
        for entry in std::fs::read_dir(&folder).map_err(at(&folder))? {
            let path = entry.map_err(at(&folder))?.path();
            if path.extension().is_some_and(|found| found == extension) {
                paths.push(path);
            }
        }
    }
    paths.sort();
    Ok(paths)
}

/// The unit in a file `{"length":L,"blake3":"H","unit":BODY}` whose length and hash of BODY are right.
pub(super) fn body(bytes: &[u8]) -> Option<&str> {
    let rest = std::str::from_utf8(bytes).ok()?.strip_prefix("{\"length\":")?;
    let (length, rest) = rest.split_once(",\"blake3\":\"")?;
    let (hash, rest) = rest.split_once("\",\"unit\":")?;
    let body = rest.strip_suffix("}\n")?;
    let is_whole =
        length.parse() == Ok(body.len()) && blake3::hash(body.as_bytes()).to_hex().as_str() == hash;
    is_whole.then_some(body)
}
