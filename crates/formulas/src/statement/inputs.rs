//! Known numbers that formulas may use: `[inputs]`.

use super::constant::Constants;
use crate::document::{Entry, Found, Table};
use crate::error::{Fault, Problem, Section, nearest};

/// Which of the known values of an input a step uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// The last one: of a step between two rows, that of the row at its start.
    Hold,
    /// The next one: of a step between two rows, that of the row that it leads to.
    Next,
    /// At each time the straight line between the last and the next one.
    Linear,
}

/// Where the values of an input come from.
#[derive(Debug, Clone, PartialEq)]
pub enum InputSource {
    /// A column of the data.
    Column(String),
    /// A column of a CSV file of its own, whose path is relative to the model file.
    File {
        /// The path.
        path: String,
        /// The column.
        column: String,
    },
    /// What a column of the data had some rows before the row that a step leads to, in steps and measurements alike.
    Lag {
        /// The column, which may be a measurement.
        column: String,
        /// How many rows before, at least 1.
        rows: usize,
        /// The value at rows that have none so many before them.
        first: Option<f64>,
    },
}

/// What `[inputs]` says of an input.
#[derive(Debug, Clone, PartialEq)]
pub struct InputRule {
    /// Its name in formulas.
    pub name: String,
    /// Where it comes from.
    pub source: InputSource,
    /// Which of the known values a step uses; in a measurement it is the value at the row itself.
    pub between: Between,
    /// How long before a time its value is looked up, in units of time; only of files.
    pub lag: f64,
    /// Whether the first and last values of a file hold beyond its ends.
    pub holds_beyond: bool,
    /// The value in the step from `start` to the first row, where a column has none.
    pub first: Option<f64>,
    /// Whether it is drawn in simulations where no data are given.
    pub is_simulated: bool,
}

/// The rule of an input, and the formula that it is simulated by.
pub(super) struct Read<'t> {
    pub(super) rule: InputRule,
    pub(super) simulate: Option<&'t Entry>,
}

const KEYS: [&str; 8] = ["column", "file", "between", "lag", "rows", "first", "beyond", "simulate"];
const BETWEEN: &str = "\"hold\", \"next\" or \"linear\"";

/// Reads an input.
pub(super) fn read<'t>(entry: &'t Entry, constants: Constants<'_>) -> Result<Read<'t>, Fault> {
    let plain = InputRule {
        name: entry.key.clone(),
        source: InputSource::Column(entry.key.clone()),
        between: Between::Hold,
        lag: 0.0,
        holds_beyond: false,
        first: None,
        is_simulated: false,
    };
    match &entry.value.found {
        Found::Text { text, .. } => {
            let between = between(text).ok_or_else(|| wrong(entry, entry, BETWEEN))?;
            Ok(Read { rule: InputRule { between, ..plain }, simulate: None })
        }
        Found::Table(table) => of_table(entry, table, plain, constants),
        _ => Err(wrong(
            entry,
            entry,
            &format!("{BETWEEN}, or a table as {{ file = \"…\", between = \"linear\" }}"),
        )),
    }
}

fn of_table<'t>(
    input: &'t Entry,
    table: &'t Table,
    plain: InputRule,
    constants: Constants<'_>,
) -> Result<Read<'t>, Fault> {
    let (mut rule, mut simulate) = (plain, None);
    let (mut column, mut file, mut rows, mut between_rows) = (None, None, None, None);
    for entry in table {
        let text = |expected: &str| match &entry.value.found {
            Found::Text { text, .. } if !text.trim().is_empty() => Ok(text.trim().to_string()),
            _ => Err(wrong(input, entry, expected)),
        };
        match entry.key.as_str() {
            "column" => column = Some(text("the name of a column, in quotes")?),
            "file" => file = Some(text("the path of a CSV file, in quotes")?),
            "between" => {
                let found = between(&text(BETWEEN)?).ok_or_else(|| wrong(input, entry, BETWEEN))?;
                between_rows = Some(found);
            }
            "lag" => rule.lag = constants.value(entry, Section::Inputs)?,
            "first" => rule.first = Some(constants.value(entry, Section::Inputs)?),
            "rows" => {
                let found = constants.value(entry, Section::Inputs)?;
                let is_count = found.fract() == 0.0 && (1.0..=MOST_ROWS).contains(&found);
                let expected = "a whole number of rows, from 1 to 10000";
                rows = Some(is_count.then_some(found as usize).ok_or_else(|| wrong(input, entry, expected))?);
            }
            "beyond" if text("\"hold\"")? == "hold" => rule.holds_beyond = true,
            "beyond" => return Err(wrong(input, entry, "\"hold\"")),
            "simulate" => simulate = Some(entry),
            key => {
                let advice = match nearest(key, KEYS) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("an input has {}", KEYS.join(", ")),
                };
                let problem = Problem::UnknownKey { name: key.to_string(), advice };
                return Err(Fault::at(entry.key_at, problem).in_section(Section::Inputs).of_key(&input.key));
            }
        }
    }
    let has = |key: &str| table.iter().find(|entry| entry.key == key);
    let apart = |key: &'static str, from: &'static str| {
        has(key).map_or(Ok(()), |entry| {
            let problem = Problem::InputKey { key, needs: from };
            Err(Fault::at(entry.key_at, problem).in_section(Section::Inputs).of_key(&input.key))
        })
    };
    let name = || column.clone().unwrap_or_else(|| input.key.clone());
    rule.source = match (file, rows) {
        (Some(_), Some(_)) => {
            return apart("rows", "an input from a column of the data").map(|()| Read { rule, simulate });
        }
        (Some(path), None) => {
            ["first", "simulate"]
                .into_iter()
                .try_for_each(|key| apart(key, "an input from a column of the data"))?;
            if between_rows.is_none() {
                let example = "between = \"linear\", \"hold\" or \"next\"";
                let problem = Problem::Missing { name: "between", example };
                return Err(fault(input, problem));
            }
            InputSource::File { path, column: name() }
        }
        (None, rows) => {
            ["lag", "beyond"].into_iter().try_for_each(|key| apart(key, "an input from a file"))?;
            match rows {
                None => InputSource::Column(name()),
                Some(rows) => {
                    let without = "an input without `rows`";
                    ["between", "simulate"].into_iter().try_for_each(|key| apart(key, without))?;
                    InputSource::Lag { column: name(), rows, first: rule.first }
                }
            }
        }
    };
    rule.between = between_rows.unwrap_or(Between::Hold);
    rule.is_simulated = simulate.is_some();
    Ok(Read { rule, simulate })
}

/// How many rows an input can lie behind.
const MOST_ROWS: f64 = 10_000.0;

fn between(text: &str) -> Option<Between> {
    match text {
        "hold" => Some(Between::Hold),
        "next" => Some(Between::Next),
        "linear" => Some(Between::Linear),
        _ => None,
    }
}

/// The fault of a value of an input that is another than expected.
fn wrong(input: &Entry, entry: &Entry, expected: &str) -> Fault {
    let (found, expected) = (entry.value.words(), expected.to_string());
    Fault::at(entry.value.at, Problem::Value { found, expected })
        .in_section(Section::Inputs)
        .of_key(&input.key)
}

fn fault(input: &Entry, problem: Problem) -> Fault {
    Fault::at(input.value.at, problem).in_section(Section::Inputs).of_key(&input.key)
}
