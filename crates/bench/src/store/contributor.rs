//! A results folder as one of many processes fills it, on whatever machines: nothing is locked, and nothing is trusted but whole units.

use std::path::{Path, PathBuf};

use super::error::{StoreError, at};
use super::folder::forget_training;
use super::line::encode;
use super::lines::{Contents, Lines};
use super::part;
use super::record::Record;
use crate::durable;

/// A results folder that this process shares with others.
#[derive(Debug)]
pub struct Contributor {
    folder: PathBuf,
}

impl Contributor {
    /// Joins those who fill a folder, which is created if it is not there.
    ///
    /// # Errors
    /// [`StoreError::Io`] if it cannot be created.
    pub fn join(folder: &Path) -> Result<Contributor, StoreError> {
        std::fs::create_dir_all(folder).map_err(at(folder))?;
        Ok(Contributor { folder: folder.to_path_buf() })
    }

    /// Reads every unit that is whole, and changes nothing.
    ///
    /// # Errors
    /// [`StoreError::Io`] if the folder cannot be read.
    pub fn read(&self) -> Result<Contents, StoreError> {
        Ok(Lines::read(&self.folder)?.contents())
    }

    /// Stores a unit as a part of its own, which appears whole by its name. Whoever finished the same unit has left the same one there; the
    /// later of two replaces the earlier. The unit's checkpoint goes.
    ///
    /// # Errors
    /// [`StoreError::Io`] naming the path.
    pub fn write(&self, record: &Record) -> Result<(), StoreError> {
        let key = record.config.key();
        let path = part::of_unit(&self.folder, &key);
        durable::write(&path, &[encode(record).as_bytes()]).map_err(at(&path))?;
        forget_training(&self.folder, &key)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Store;
    use super::super::folder::merge;
    use super::super::record::tests::record;
    use super::*;
    use crate::config::Point;

    fn nth(repetition: usize) -> Record {
        let record = record();
        let point = Point { repetition, ..record.point.clone() };
        let config = crate::unit::UnitConfig { repetition, ..record.config.clone() };
        Record { point, config, ..record }
    }

    #[test]
    fn two_that_do_the_same_unit_leave_one() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other] = [0, 1].map(|_| Contributor::join(folder.path()).unwrap());
        one.write(&nth(0)).unwrap();
        other.write(&nth(0)).unwrap();
        other.write(&nth(1)).unwrap();
        assert_eq!(one.read().unwrap().records.len(), 2);
        let mut store = Store::open(folder.path()).unwrap();
        assert_eq!(store.read().unwrap().records.len(), 2);
        assert!(part::parts(folder.path()).unwrap().is_empty());
        // After the merge it is done once more.
        one.write(&nth(1)).unwrap();
        assert_eq!(one.read().unwrap().records.len(), 2);
        assert_eq!(store.read().unwrap().records.len(), 2);
    }

    /// Some write and several merge, all at once and without locks: no unit is lost, and no reader ever misses one that was there.
    #[test]
    fn many_write_and_merge_at_once_and_nothing_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let (path, count) = (folder.path(), 40);
        std::thread::scope(|scope| {
            for writer in 0..2 {
                scope.spawn(move || {
                    let contributor = Contributor::join(path).unwrap();
                    for number in 0..count {
                        contributor.write(&nth(writer * count + number)).unwrap();
                        let there = contributor.read().unwrap().records.len();
                        assert!(there > number, "{there} units where this thread alone wrote {}", number + 1);
                    }
                });
            }
            for _ in 0..2 {
                scope.spawn(move || {
                    for _ in 0..count {
                        merge(path, &Default::default()).unwrap();
                    }
                });
            }
        });
        let mut store = Store::open(path).unwrap();
        let contents = store.read().unwrap();
        assert_eq!((contents.records.len(), contents.damaged, contents.torn), (2 * count, 0, 0));
    }
}
