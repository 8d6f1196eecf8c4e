//! Lists of a file as names, vectors and matrices.

use std::collections::BTreeSet;

use faer::Mat;

use crate::document::{Found, Value};
use crate::error::{Fault, Problem};

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

/// `count` numbers, for what `why` says.
pub(super) fn vector(value: &Value, count: usize, why: &str) -> Result<Vec<f64>, Fault> {
    let Found::List(list) = &value.found else {
        return Err(fault(value, format!("a list of {count} numbers, {why}")));
    };
    let number = |value: &Value| match value.found {
        Found::Number(number, _) if number.is_finite() => Ok(number),
        _ => Err(fault(value, "a finite number".to_string())),
    };
    let numbers: Vec<f64> = list.iter().map(number).collect::<Result<_, Fault>>()?;
    if numbers.len() == count {
        return Ok(numbers);
    }
    let have = if numbers.len() == 1 {
        "there is 1 number".to_string()
    } else {
        format!("there are {} numbers", numbers.len())
    };
    Err(misfit(value, format!("{have}; there must be {count}, {why}")))
}

/// A matrix, row by row.
pub(super) fn matrix(value: &Value, [rows, columns]: [usize; 2], why: &str) -> Result<Mat<f64>, Fault> {
    let Found::List(list) = &value.found else {
        let expected = format!("a list of {rows} rows of {columns} numbers, as in [[1.0, 0.0], [0.0, 1.0]]");
        return Err(fault(value, expected));
    };
    if list.len() != rows {
        let have = if list.len() == 1 {
            "there is 1 row".to_string()
        } else {
            format!("there are {} rows", list.len())
        };
        return Err(misfit(value, format!("{have}; there must be {rows} of {columns} numbers each, {why}")));
    }
    let rows: Vec<Vec<f64>> =
        list.iter().map(|row| vector(row, columns, why)).collect::<Result<_, Fault>>()?;
    Ok(Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}
