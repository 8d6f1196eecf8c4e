//! A name that formulas do not know, and that is a column of the data.

use std::path::Path;

use motes::formulas::{FileError, Problem};

/// The same error, which says what to do where the name is in the header of the data.
pub(super) fn undeclared(error: FileError, data: Option<&Path>) -> FileError {
    let FileError::Refused { file, place, problem } = error else { return error };
    let is_column = |name: &str| {
        let mut reader = csv::ReaderBuilder::new().from_path(data?).ok()?;
        let header = reader.headers().ok()?;
        header.iter().any(|column| column.trim() == name).then_some(())
    };
    let problem = match *problem {
        Problem::UnknownName { name, .. } if is_column(&name).is_some() => {
            let data = data.map(|path| path.display().to_string()).unwrap_or_default();
            Box::new(Problem::Undeclared { name, data })
        }
        other => Box::new(other),
    };
    FileError::Refused { file, place, problem }
}
