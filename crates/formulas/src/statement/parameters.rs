//! The numbers that formulas know by name.

use crate::document::{Found, Table};
use crate::error::{Fault, Problem, Section, nearest};
use crate::names::is_name;
use crate::tables::reserved;

/// The parameters of a file.
#[derive(Debug)]
pub(super) struct Parameters {
    pub(super) values: Vec<(String, f64)>,
}

impl Parameters {
    /// Reads them, and replaces the values of those that are set from outside; of two such values the last counts.
    pub(super) fn read(table: &Table, overrides: &[(String, f64)]) -> Result<Self, Fault> {
        let mut values = Vec::with_capacity(table.len());
        for entry in table {
            let fault =
                |at, problem| Fault::at(at, problem).in_section(Section::Parameters).of_key(&entry.key);
            if !is_name(&entry.key) {
                return Err(fault(entry.key_at, Problem::BadName(entry.key.clone())));
            }
            if let Some(what) = reserved(&entry.key) {
                return Err(fault(entry.key_at, Problem::Reserved { name: entry.key.clone(), what }));
            }
            match &entry.value.found {
                Found::Number(value, _) if value.is_finite() => values.push((entry.key.clone(), *value)),
                Found::Text { .. } => {
                    let (found, expected) =
                        (entry.value.words(), "a number; formulas stand in [definitions]");
                    let problem = Problem::Value { found, expected: expected.to_string() };
                    return Err(fault(entry.value.at, problem));
                }
                _ => {
                    let (found, expected) = (entry.value.words(), "a finite number".to_string());
                    return Err(fault(entry.value.at, Problem::Value { found, expected }));
                }
            }
        }
        for (name, value) in overrides {
            let Some(place) = values.iter().position(|(known, _)| known == name) else {
                return Err(Fault::new(unknown(name, &values)));
            };
            if !value.is_finite() {
                return Err(Fault::new(Problem::ParameterNotFinite { name: name.clone(), value: *value }));
            }
            values[place].1 = *value;
        }
        Ok(Parameters { values })
    }

    /// The value of a parameter.
    pub(super) fn get(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

fn unknown(name: &str, values: &[(String, f64)]) -> Problem {
    let names: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    let advice = match nearest(name, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names.is_empty() => "the file has no [parameters]".to_string(),
        None => format!("there are {}", names.join(", ")),
    };
    Problem::UnknownParameter { name: name.to_string(), advice }
}
