//! What can be wrong with data, in one line that says where and what would be right.

use std::fmt;

use thiserror::Error;

/// Where in a file something stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: String,
    /// The line, from 1; the header's is 1.
    pub line: u64,
    /// The column's name.
    pub column: String,
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}, line {}, column {}", self.file, self.line, self.column)
    }
}

/// Why data cannot be used.
#[derive(Debug, Error)]
pub enum DataError {
    /// They could not be read.
    #[error("{file}: {reason}")]
    Read {
        /// The file.
        file: String,
        /// The system's reason.
        reason: String,
    },
    /// There is nothing in them.
    #[error("{file}: there are no rows; a header and a row for each time are needed")]
    Empty {
        /// The file.
        file: String,
    },
    /// The header lacks a measurement.
    #[error("{file}, line 1: there is no column {column}, which the model measures; there are {found}{hint}")]
    MissingColumn {
        /// The file.
        file: String,
        /// The measurement's name.
        column: String,
        /// The columns that are there.
        found: String,
        /// What may be the matter.
        hint: String,
    },
    /// The header has a name twice.
    #[error("{file}, line 1: there are two columns {column}; names must differ")]
    ColumnTwice {
        /// The file.
        file: String,
        /// The name.
        column: String,
    },
    /// A row has more or fewer cells than the header.
    #[error("{file}, line {line}: the row has {found} cells, the header {expected}{hint}")]
    Ragged {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// Cells in the row.
        found: usize,
        /// Columns of the header.
        expected: usize,
        /// What may be the matter.
        hint: String,
    },
    /// A blank line in a file of one column, where it could be a missing measurement or none.
    #[error("{file}, line {line}: the line is blank; write NA where a measurement is missing")]
    Blank {
        /// The file.
        file: String,
        /// The line.
        line: u64,
    },
    /// A cell is no number.
    #[error("{place}: {value} {problem}")]
    Cell {
        /// Where.
        place: Place,
        /// What stands there.
        value: String,
        /// What is the matter with it.
        problem: &'static str,
    },
    /// Text that is not UTF-8.
    #[error("{file}, line {line}: this is not UTF-8 text; save the file in that encoding")]
    NotUtf8 {
        /// The file.
        file: String,
        /// The line.
        line: u64,
    },
    /// Times that do not count.
    #[error(
        "{place}: {value}, where {expected} is next; t counts 0, 1, 2, … in each series, and a time without measurement has empty cells"
    )]
    Time {
        /// Where.
        place: Place,
        /// What stands there.
        value: String,
        /// What should.
        expected: usize,
    },
}

impl DataError {
    /// Whether input failed: the data themselves may be fine.
    pub fn is_io(&self) -> bool {
        matches!(self, DataError::Read { .. })
    }
}
