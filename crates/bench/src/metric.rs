//! A number with its name.

use serde::{Deserialize, Serialize};

/// A number with its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// The name, as in the tables.
    pub name: String,
    /// The value; finite.
    pub value: f64,
}

impl Metric {
    pub(crate) fn new(name: &str, value: f64) -> Self {
        Metric { name: name.into(), value }
    }
}
