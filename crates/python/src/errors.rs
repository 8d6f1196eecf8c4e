//! Errors as Python has them: the one line of the command, with arguments named as Python names them.

use motes::MotesError;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyValueError};

/// `ValueError` for bad input, `OSError` where a file cannot be read or written.
pub(crate) fn to_python(error: impl Into<MotesError>) -> PyErr {
    let error = error.into();
    let line = in_python(&error.to_string());
    match error {
        MotesError::Interrupted => PyKeyboardInterrupt::new_err(()),
        error if error.exit_status() == 3 => PyOSError::new_err(line),
        _ => PyValueError::new_err(line),
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
