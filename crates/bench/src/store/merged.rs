//! The file of merged units, and how it is replaced: by names and links alone, so that no machine needs another's locks.

use std::io::{ErrorKind, Result};
use std::path::Path;

use super::part;
use crate::durable;

/// The file of merged units.
pub(super) const MERGED: &str = "units.jsonl";

/// Puts `text` in the place of what was `read`.
///
/// At every moment each unit is in some file, also if another process does the same at the same time. What stands there steps aside under
/// the name of a part; it is removed only if it is what was read, all of which is in `text`. If the other one was faster, `text` becomes a
/// part itself, and the next merge has both.
pub(super) fn replace(folder: &Path, read: Option<&[u8]>, text: &[u8]) -> Result<()> {
    let (merged, aside) = (folder.join(MERGED), part::free_path(folder));
    match std::fs::rename(&merged, &aside) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    if !durable::write_new(&merged, text)? {
        durable::write(&part::free_path(folder), &[text])?;
    }
    match std::fs::read(&aside) {
        Ok(found) if Some(found.as_slice()) == read => durable::remove(&aside),
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(folder: &Path) -> Vec<String> {
        let parts = part::parts(folder).unwrap();
        let paths = std::iter::once(folder.join(MERGED)).chain(parts);
        paths.filter_map(|path| std::fs::read_to_string(path).ok()).collect()
    }

    #[test]
    fn what_was_read_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        replace(folder.path(), None, b"a").unwrap();
        assert_eq!(texts(folder.path()), ["a"]);
        replace(folder.path(), Some(b"a"), b"ab").unwrap();
        assert_eq!(texts(folder.path()), ["ab"]);
    }

    #[test]
    fn what_another_process_merged_meanwhile_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        replace(folder.path(), None, b"theirs").unwrap();
        // Read before theirs was there.
        replace(folder.path(), None, b"ours").unwrap();
        assert_eq!(texts(folder.path()), ["ours", "theirs"]);
    }
}
