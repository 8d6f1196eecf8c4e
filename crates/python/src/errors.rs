//! Errors as Python has them: the one line of the command, with arguments named as Python names them.

use std::io::ErrorKind;

use motes::MotesError;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyValueError};

/// `ValueError` for bad input, and the kind of `OSError` that Python itself has where a file cannot be read or written.
pub(crate) fn to_python(error: impl Into<MotesError>) -> PyErr {
    let error = error.into();
    let line = in_python(&error.to_string());
    if let Some((file, number)) = error.io().and_then(|(file, kind)| Some((file, number_of(kind)?))) {
        let reason = line.strip_prefix(file).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(&line);
        // Python chooses `FileNotFoundError` and others by the number.
        return PyOSError::new_err((number, reason.to_string(), file.to_string()));
    }
    match error {
        MotesError::Interrupted => PyKeyboardInterrupt::new_err(()),
        error if error.exit_status() == 3 => PyOSError::new_err(line),
        _ => PyValueError::new_err(line),
    }
}

/// The number that systems have for a failure, where Python has a class for it.
fn number_of(kind: ErrorKind) -> Option<i32> {
    match kind {
        ErrorKind::NotFound => Some(2),
        ErrorKind::PermissionDenied => Some(13),
        ErrorKind::AlreadyExists => Some(17),
        ErrorKind::NotADirectory => Some(20),
        ErrorKind::IsADirectory => Some(21),
        _ => None,
    }
}

/// A line of the command with its options as arguments: `--proposal optimal` is `proposal optimal`.
pub(crate) fn in_python(line: &str) -> String {
    let line = line.strip_prefix("--").unwrap_or(line);
    line.replace(" --", " ")
}

/// `argument: value; what would be right`.
pub(crate) fn refused(argument: &str, value: impl std::fmt::Display, expected: &str) -> PyErr {
    PyValueError::new_err(format!("{argument}: {value}; it must be {expected}"))
}
