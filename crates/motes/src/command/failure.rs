//! Why the command ends without a result.

use std::fmt;

use motes::MotesError;

/// One line for a person, and an exit status.
#[derive(Debug)]
pub(super) struct Failure {
    exit_status: u8,
    line: String,
    is_interrupt: bool,
}

impl Failure {
    pub(super) fn new(exit_status: u8, line: impl fmt::Display) -> Self {
        Failure { exit_status, line: line.to_string(), is_interrupt: false }
    }

    /// It was asked to stop; the line says what is left.
    pub(super) fn stopped(line: impl fmt::Display) -> Self {
        Failure { exit_status: 1, line: line.to_string(), is_interrupt: true }
    }

    pub(super) fn exit_status(&self) -> u8 {
        self.exit_status
    }

    pub(super) fn is_interrupt(&self) -> bool {
        self.is_interrupt
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.line)
    }
}

impl<E: Into<MotesError>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        match error {
            MotesError::Interrupted => Failure::stopped("stopped; no file was written"),
            error => Failure::new(error.exit_status(), error),
        }
    }
}
