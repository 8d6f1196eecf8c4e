//! Lines for a person. A reader who has left (a closed pipe) is no reason to stop a run.

use std::io::Write;

/// A result, on standard output.
pub fn result(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// What a program is doing, or why it stops, on standard error.
pub fn status(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
