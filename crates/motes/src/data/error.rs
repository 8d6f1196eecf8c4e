//! What can be wrong with data, in one line that says where and what would be right.

use std::fmt;

use motes_formulas::Impossible;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::timeline::TimelineError;

/// How the rows of data are counted, for errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RowNumbering {
    /// Lines of a file, from 1; the header's is 1.
    Line,
    /// Rows of a table in memory, from 0.
    Row,
}

impl fmt::Display for RowNumbering {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            RowNumbering::Line => "line",
            RowNumbering::Row => "row",
        })
    }
}

/// Where rows of data come from, for errors.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RowSource {
    /// Their file; none of a table in memory.
    pub file: Option<String>,
    /// How they are counted.
    pub counted: RowNumbering,
}

impl RowSource {
    /// Rows of a table in memory.
    pub(crate) fn of_table() -> Self {
        RowSource { file: None, counted: RowNumbering::Row }
    }

    /// Lines of a file.
    pub fn of_file(file: &str) -> Self {
        RowSource { file: Some(file.to_string()), counted: RowNumbering::Line }
    }

    /// A row, with its series where there are several: `data.csv, series b, line 3`.
    pub fn row(&self, series: Option<&str>, line: u64) -> String {
        let file = self.file.iter().map(|file| format!("{file}, "));
        let series = series.iter().map(|series| format!("series {series}, "));
        file.chain(series).chain([format!("{} {line}", self.counted)]).collect()
    }
}

/// Where in data something stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file, or what a table in memory is called.
    pub file: String,
    /// Whether it is a line or a row.
    pub counted: RowNumbering,
    /// The line, or the row.
    pub line: u64,
    /// The column's name; none where it is a row as a whole.
    pub column: Option<String>,
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}, {} {}", self.file, self.counted, self.line)?;
        self.column.iter().try_for_each(|column| write!(formatter, ", column {column}"))
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
        /// What kind of failure it is to the system; none where the text is no CSV.
        kind: Option<std::io::ErrorKind>,
        /// The system's reason.
        reason: String,
    },
    /// There is nothing in them.
    #[error("{file}: there are no rows; a header and a row for each time are needed")]
    Empty {
        /// The file.
        file: String,
    },
    /// A column of a table in memory is longer or shorter than the others.
    #[error("{file}: a column has {found} values where {expected} are needed, one for each row")]
    Lengths {
        /// What the table is called.
        file: String,
        /// Values that are there.
        found: usize,
        /// Values that are needed.
        expected: usize,
    },
    /// The header lacks a measurement.
    #[error("{header}: there is no column {column}, which {role}; there are {found}{hint}")]
    MissingColumn {
        /// Where the header stands.
        header: String,
        /// Its name.
        column: String,
        /// What it is to the model.
        role: &'static str,
        /// The columns that are there.
        found: String,
        /// What may be the matter.
        hint: String,
    },
    /// The column that is carried to results has the name of one of theirs.
    #[error("{header}, column {column}: results have a column of that name; give it another")]
    ColumnOfResults {
        /// Where the header stands.
        header: String,
        /// The name.
        column: String,
    },
    /// The header has a name twice.
    #[error("{header}: there are two columns {column}; names must differ")]
    ColumnTwice {
        /// Where the header stands.
        header: String,
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
    /// A row does not say of which series it is.
    #[error("{place}: the cell is empty; it says which series the row is of")]
    NoSeries {
        /// Where.
        place: Place,
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
    /// A measurement that no state can give.
    #[error("{place}: {impossible}")]
    Impossible {
        /// Where.
        place: Place,
        /// What it is, and what it could be.
        impossible: Box<Impossible>,
    },
    /// A row whose time does not come next, or whose inputs are not there.
    #[error("{place}: {error}")]
    Timeline {
        /// Where.
        place: Place,
        /// What is wrong.
        error: Box<TimelineError>,
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
