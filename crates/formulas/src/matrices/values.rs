//! Lists of a file as names, vectors and matrices.

use std::collections::BTreeSet;

use faer::Mat;

use crate::document::{Found, Value};
use crate::error::{Fault, Problem, Section};
use crate::statement::Constants;

/// The fault of a value that is something else.
fn fault(value: &Value, expected: String) -> Fault {
    Fault::at(value.at, Problem::Value { found: value.words(), expected })
}

/// The fault of numbers that are there, but not the right ones.
fn misfit(value: &Value, reason: String) -> Fault {
    Fault::at(value.at, Problem::Matrix(reason))
}

/// Names of coordinates, as headers of data have them.
pub(super) fn names(value: &Value) -> Result<Vec<String>, Fault> {
    let expected = "a list of names, as in [\"position\", \"speed\"]";
    let Found::List(list) = &value.found else { return Err(fault(value, expected.to_string())) };
    if list.is_empty() {
        return Err(misfit(value, "the list is empty; there must be at least one name".to_string()));
    }
    let mut seen = BTreeSet::new();
    let mut names = Vec::with_capacity(list.len());
    for value in list {
        let Found::Text { text, .. } = &value.found else {
            return Err(fault(value, "a name in quotes".to_string()));
        };
        if text.trim().is_empty() || text.contains(|c: char| c.is_control() || ",\"".contains(c)) {
            return Err(fault(value, "a name without commas and quotes".to_string()));
        }
        if matches!(text.as_str(), "series" | "t") {
            let what =
                if text == "t" { "the column of times" } else { "the column that tells sequences apart" };
            return Err(Fault::at(value.at, Problem::Reserved { name: text.clone(), what }));
        }
        if !seen.insert(text) {
            return Err(misfit(value, format!("the name \"{text}\" is there twice; each must differ")));
        }
        names.push(text.clone());
    }
    Ok(names)
}

/// So many things: `1 row`, `2 rows`.
pub(super) fn count(number: usize, thing: &str) -> String {
    if number == 1 { format!("1 {thing}") } else { format!("{number} {thing}s") }
}

/// Reads numbers: each is written as one, or as a formula of parameters in quotes.
#[derive(Clone, Copy)]
pub(super) struct Entries<'a> {
    /// Why there must be so many.
    pub(super) why: &'a str,
    pub(super) constants: Constants<'a>,
}

impl Entries<'_> {
    /// `length` numbers.
    pub(super) fn vector(&self, value: &Value, length: usize) -> Result<Vec<f64>, Fault> {
        let why = self.why;
        let Found::List(list) = &value.found else {
            return Err(fault(value, format!("a list of {}, {why}", count(length, "number"))));
        };
        let numbers: Vec<f64> = list.iter().map(|value| self.number(value)).collect::<Result<_, Fault>>()?;
        if numbers.len() == length {
            return Ok(numbers);
        }
        let found = count(numbers.len(), "number");
        Err(misfit(value, format!("it has {found}; it must have {length}, {why}")))
    }

    /// A matrix, row by row.
    pub(super) fn matrix(&self, value: &Value, [rows, columns]: [usize; 2]) -> Result<Mat<f64>, Fault> {
        let (why, size) = (self.why, format!("{} of {}", count(rows, "row"), count(columns, "number")));
        let Found::List(list) = &value.found else {
            return Err(fault(value, format!("a list of {size}, {why}; rows are lists")));
        };
        if list.len() != rows {
            return Err(misfit(
                value,
                format!("it has {}; it must have {size}, {why}", count(list.len(), "row")),
            ));
        }
        let rows: Vec<Vec<f64>> =
            list.iter().map(|row| self.vector(row, columns)).collect::<Result<_, Fault>>()?;
        Ok(Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]))
    }

    fn number(&self, value: &Value) -> Result<f64, Fault> {
        match &value.found {
            Found::Number(number, _) if number.is_finite() => Ok(*number),
            Found::Text { .. } => self.constants.number(value, Section::Parameters).map_err(|found| {
                let Problem::UnknownName { name, .. } = *found.problem else { return found };
                let advice = "an entry is a number, or a formula of numbers and of [parameters]".to_string();
                Fault { problem: Box::new(Problem::UnknownName { name, advice }), ..found }
            }),
            _ => Err(fault(value, "a finite number, or a formula of parameters in quotes".to_string())),
        }
    }
}
