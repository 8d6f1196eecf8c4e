//! Where in a file something stands.

use std::fmt;

/// A place in a model file; what is not known is left out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// The line, from 1, and the column, from 1 in characters.
    pub at: Option<[usize; 2]>,
    /// The section, as `[transition]`.
    pub section: Option<&'static str>,
    /// The key.
    pub key: Option<String>,
}

/// `, line 3`, where the line is of interest to somebody.
pub(crate) fn in_line(line: Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(", line {line}"))
}

impl Place {
    /// The line and column of a byte of a text.
    pub(crate) fn line_and_column(text: &str, byte: usize) -> [usize; 2] {
        let end = text.floor_char_boundary(byte);
        let before = &text[..end];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        // A byte order mark is no column.
        let line = before[start..].trim_start_matches('\u{feff}');
        [before.matches('\n').count() + 1, line.chars().count() + 1]
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some([line, column]) = self.at {
            write!(formatter, ", line {line}, column {column}")?;
        }
        match (self.section, &self.key) {
            (Some(section), Some(key)) => write!(formatter, ", {section} {key}"),
            (Some(section), None) => write!(formatter, ", {section}"),
            (None, Some(key)) => write!(formatter, ", {key}"),
            (None, None) => Ok(()),
        }
    }
}
