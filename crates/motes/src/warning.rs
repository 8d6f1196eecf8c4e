//! Reasons not to trust a result.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A reason not to trust a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Warning {
    /// The series that it is about; none where there is one without a name.
    pub series: Option<String>,
    /// What the matter is.
    pub text: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.series {
            Some(series) => write!(formatter, "series {series}: {}", self.text),
            None => formatter.write_str(&self.text),
        }
    }
}
