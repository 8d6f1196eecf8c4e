//! The operation that left its domain.

use std::fmt;

use thiserror::Error;

use crate::error::in_line;
use crate::support::Digits;

/// An operation of a formula that gave no number, or a distribution's parameter that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
pub struct DomainError {
    /// The model file.
    pub file: String,
    /// The line of the formula, from 1; none of a text that a program wrote.
    pub line: Option<usize>,
    /// The section, as `[transition]`.
    pub section: &'static str,
    /// The coordinate, or the definition: `x`, or `x[3]`.
    pub key: String,
    /// The text of the operation.
    pub text: String,
    /// What it gave.
    pub value: f64,
    /// For a distribution's parameter its name, and what would be right.
    pub parameter: Option<[String; 2]>,
    /// The names in the text with the values that they had.
    pub at: Vec<(String, f64)>,
}

impl fmt::Display for DomainError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DomainError { file, line, section, key, text, value, .. } = self;
        write!(formatter, "{file}{}, {section} {key}: ", in_line(*line))?;
        match &self.parameter {
            None => write!(formatter, "`{text}` is {}", Digits(*value))?,
            Some([name, _]) => write!(formatter, "{name}, `{text}`, is {}", Digits(*value))?,
        }
        let at: Vec<String> =
            self.at.iter().map(|(name, value)| format!("{name} = {}", Digits(*value))).collect();
        // A name alone is its own value.
        if !at.is_empty() && self.at.iter().all(|(name, _)| name != text) {
            write!(formatter, " where {}", at.join(", "))?;
        }
        match &self.parameter {
            Some([_, expected]) => write!(formatter, "; it must be {expected}"),
            None => Ok(()),
        }
    }
}
