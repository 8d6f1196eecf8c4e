//! References that are kept in a folder, one file for each sequence: what took hours is not done twice.

use std::path::{Path, PathBuf};

use super::reference::Reference;
use crate::error::MotesError;
use crate::output::Output;

/// The reference of the sequence of that number, if the folder has it.
///
/// # Errors
/// [`MotesError::Output`] if the file cannot be read, [`MotesError::Setting`] if it holds something else.
pub(super) fn read(folder: &Path, number: usize, times: usize) -> Result<Option<Reference>, MotesError> {
    let path = file(folder, number);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(MotesError::Output { file: path.display().to_string(), source }),
    };
    let other = |reason| {
        MotesError::Setting(format!("{}: {reason}; remove it to have it made again", path.display()))
    };
    let reference: Reference = serde_json::from_str(&text).map_err(|error| other(error.to_string()))?;
    if reference.means.len() != times || reference.increments.len() != times {
        return Err(other(format!("it has {} times; there are {times}", reference.means.len())));
    }
    Ok(Some(reference))
}

/// Keeps a reference, whole or not at all.
///
/// # Errors
/// [`MotesError::Output`] if it cannot be written.
pub(super) fn write(folder: &Path, number: usize, reference: &Reference) -> Result<(), MotesError> {
    let path = file(folder, number);
    let text = serde_json::to_string(reference).unwrap_or_default() + "\n";
    std::fs::create_dir_all(folder)
        .and_then(|()| Output::File(path.clone()).write(&text))
        .map_err(|source| MotesError::Output { file: path.display().to_string(), source })
}

fn file(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{number}.json"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_to_the_last_bit_and_what_is_none_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let reference = Reference {
            name: "a filter".into(),
            means: vec![vec![1.0 / 3.0, -2e-300], vec![0.1 + 0.2, 7.0]],
            increments: vec![-1.234_567_890_123_456_7, f64::MIN_POSITIVE],
            log_evidence: -1.3,
            error: Some(0.1),
        };
        assert_eq!(read(folder.path(), 3, 2).unwrap(), None);
        write(folder.path(), 3, &reference).unwrap();
        assert_eq!(read(folder.path(), 3, 2).unwrap(), Some(reference));
        assert_eq!(read(folder.path(), 4, 2).unwrap(), None);
        let said = read(folder.path(), 3, 5).unwrap_err().to_string();
        assert!(
            said.ends_with("3.json: it has 2 times; there are 5; remove it to have it made again"),
            "{said}"
        );
        std::fs::write(folder.path().join("4.json"), "{").unwrap();
        let said = read(folder.path(), 4, 2).unwrap_err().to_string();
        assert!(said.contains("4.json: EOF while parsing") && said.ends_with("made again"), "{said}");
    }
}
