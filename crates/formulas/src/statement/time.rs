//! How the rows of data are spaced in time: `[time]`.

use super::constant::Constants;
use crate::document::{Entry, Found, Table};
use crate::error::{Fault, Problem, Section, nearest};

/// The unit of times that are dates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// Days since the first row of a series.
    Day,
    /// Weeks since the first row of a series.
    Week,
    /// Calendar years: 1950-07-02 is 1950.5.
    Year,
}

/// A time that a file states: a number, or a date.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeLabel {
    /// A number.
    Number(f64),
    /// A date, as it is written.
    Date(String),
}

/// What `[time]` says; where the section is absent, a row is a step: `t = 0, 1, 2, …`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TimeRule {
    /// The column of times; none where rows are 0, 1, 2, ….
    pub column: Option<String>,
    /// The unit of times that are dates; none where they are numbers.
    pub unit: Option<TimeUnit>,
    /// The longest sub-step; none where a step between two rows is one.
    pub step: Option<f64>,
    /// The time of `x_0`; none where it is that of the first row. A number of days or weeks counts from the first row of a series, as `t` does.
    pub start: Option<TimeLabel>,
}

impl TimeRule {
    /// Whether times count from the first row of a series: days and weeks do.
    pub fn counts_from_first_row(&self) -> bool {
        matches!(self.unit, Some(TimeUnit::Day | TimeUnit::Week))
    }

    /// How many equal sub-steps a gap of this length is cut into: `⌈gap/step·(1 − 10⁻⁶)⌉`, at least 1.
    pub fn sub_steps(&self, gap: f64) -> f64 {
        self.step.map_or(1.0, |step| (gap / step * (1.0 - 1e-6)).ceil().max(1.0))
    }
}

const KEYS: [&str; 4] = ["column", "unit", "step", "start"];

/// Reads the section.
pub(super) fn read(table: &Table, constants: Constants<'_>) -> Result<TimeRule, Fault> {
    let mut rule = TimeRule::default();
    for entry in table {
        let refuse = |expected: &str| {
            let (found, expected) = (entry.value.words(), expected.to_string());
            Err(fault(entry, Problem::Value { found, expected }))
        };
        match (entry.key.as_str(), &entry.value.found) {
            ("column", Found::Text { text, .. }) if !text.trim().is_empty() => {
                rule.column = Some(text.trim().to_string());
            }
            ("column", _) => return refuse("the name of a column of the data, in quotes"),
            ("unit", Found::Text { text, .. }) => {
                rule.unit = Some(match text.as_str() {
                    "day" => TimeUnit::Day,
                    "week" => TimeUnit::Week,
                    "year" => TimeUnit::Year,
                    _ => return refuse("\"day\", \"week\" or \"year\", for times that are dates"),
                });
            }
            ("unit", _) => return refuse("\"day\", \"week\" or \"year\", for times that are dates"),
            ("step", _) => {
                let step = constants.value(entry, Section::Time)?;
                if step <= 0.0 {
                    let (what, expected) = ("step".to_string(), "above 0".to_string());
                    return Err(fault(entry, Problem::OutOfRange { what, value: step, expected }));
                }
                rule.step = Some(step);
            }
            ("start", Found::Text { text, .. } | Found::Date(text)) if is_date(text) => {
                rule.start = Some(TimeLabel::Date(text.trim().to_string()));
            }
            ("start", Found::Date(_) | Found::Truth) => return refuse("a number, or a date"),
            ("start", _) => rule.start = Some(TimeLabel::Number(constants.value(entry, Section::Time)?)),
            (key, _) => {
                let advice = match nearest(key, KEYS) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("it has {}", KEYS.join(", ")),
                };
                return Err(Fault::at(entry.key_at, Problem::UnknownKey { name: key.to_string(), advice })
                    .in_section(Section::Time));
            }
        }
    }
    let entry_of = |key: &str| table.iter().find(|entry| entry.key == key);
    let refuse = |entry: &Entry, expected: &str| {
        let (found, expected) = (entry.value.words(), expected.to_string());
        Err(fault(entry, Problem::Value { found, expected }))
    };
    if let (Some(unit), None) = (entry_of("unit"), &rule.column) {
        return refuse(unit, "left out, or the column of the dates named beside it by column = …");
    }
    if let (Some(start), Some(TimeLabel::Date(_)), None) = (entry_of("start"), &rule.start, rule.unit) {
        return refuse(start, "a number; for dates give unit = \"day\", \"week\" or \"year\", too");
    }
    Ok(rule)
}

/// Whether a text begins as dates, months and quarters do: a year, and what parts it from the rest.
fn is_date(text: &str) -> bool {
    let bytes = text.trim().as_bytes();
    bytes.len() > 4 && bytes[..4].iter().all(u8::is_ascii_digit) && b"-/Qq".contains(&bytes[4])
}

fn fault(entry: &Entry, problem: Problem) -> Fault {
    Fault::at(entry.value.at, problem).in_section(Section::Time).of_key(&entry.key)
}
