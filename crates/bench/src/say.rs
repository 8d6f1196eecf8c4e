//! Lines for a person. A reader who has left (a closed pipe) is no reason to stop a run.

use std::io::Write;

/// A result, on standard output.
pub fn result(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// News of a run, on standard error.
pub fn news(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
