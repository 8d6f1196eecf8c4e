//! What every command says: results where they belong, and what a person should know.

use motes::output::Output;
use motes::{Columns, MotesError, Warning};
use motes_cli::status;

/// Writes a result.
pub(super) fn write(output: &Output, text: &str) -> Result<(), MotesError> {
    output.write(text).map_err(|source| MotesError::Output { file: output.name(), source })
}

/// Says which columns are not used.
pub(super) fn say_ignored(columns: &Columns, quiet: bool) {
    if !quiet && !columns.ignored.is_empty() {
        status(&format!("motes: columns that are not used: {}", columns.ignored.join(", ")));
    }
}

/// Says what cannot be trusted; the exit status that follows.
pub(super) fn warn(warnings: &[Warning], quiet: bool, strict: bool) -> u8 {
    if !quiet {
        warnings.iter().for_each(|warning| status(&format!("motes: warning: {warning}")));
    }
    u8::from(strict && !warnings.is_empty())
}
