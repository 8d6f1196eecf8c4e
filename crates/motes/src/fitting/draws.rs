//! What a fit found, read for a model.

use std::path::Path;

use super::record::{FitRecord, MAXIMUM_METHOD};
use crate::error::MotesError;
use crate::model::Model;
use crate::priors::nearest_value;

/// The files of a folder that say what was found, and with what.
pub(crate) const DRAWS: &str = "draws.csv";
pub(crate) const MAXIMUM: &str = "maximum.csv";

/// The figures of all parameters.
pub(crate) const SUMMARY: &str = "summary.json";

/// The columns of draws before the parameters.
pub(crate) const OF_DRAW: [&str; 3] = ["chain", "draw", "log_evidence"];

/// The columns of a maximum.
pub(crate) const OF_MAXIMUM: [&str; 4] = ["parameter", "estimate", "low", "high"];

/// The draws of the parameters of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct FitParameters {
    /// The names of the `D` parameters.
    pub names: Vec<String>,
    /// The values (`D`) of each draw, all chains one after the other.
    pub values: Vec<Vec<f64>>,
    /// Parameters that were given a value before.
    pub set: Vec<(String, f64)>,
    /// Whether it is the maximum of the likelihood, as the only draw.
    pub is_maximum: bool,
}

impl FitParameters {
    /// Those in a folder of a fit.
    ///
    /// # Errors
    /// [`MotesError::Fit`] if there is no fit in it, it is one of another model, or the draws are not as they were written.
    pub fn load(folder: &Path, model: &Model) -> Result<Self, MotesError> {
        let refused = |reason: String| MotesError::Fit { folder: folder.display().to_string(), reason };
        let read = |name: &str| {
            std::fs::read_to_string(folder.join(name)).map_err(|error| match error.kind() {
                std::io::ErrorKind::NotFound => {
                    refused(format!("there is no {name} in it; motes fit writes such folders with -o"))
                }
                _ => refused(format!("{name}: {error}")),
            })
        };
        let record = FitRecord::load(folder)?;
        if !record.is_of(model) {
            let reason = format!(
                "it is a fit of {}, or of this model before its file was changed; fit it again",
                record.model
            );
            return Err(refused(reason));
        }
        let is_maximum = record.method == MAXIMUM_METHOD;
        let name = if is_maximum { MAXIMUM } else { DRAWS };
        let wrong = |line: u64, reason: &str| refused(format!("{name}, line {line}: {reason}"));
        let text = read(name)?;
        // A file that was cut off may end in the middle of a number.
        if !text.ends_with('\n') {
            return Err(refused(format!(
                "{name}: its last line does not end: the file was cut off; fit it again"
            )));
        }
        let (names, values) = match is_maximum {
            true => maximum(&text, &wrong)?,
            false => draws(&text, &wrong)?,
        };
        Ok(FitParameters { names, values, set: record.set.into_iter().collect(), is_maximum })
    }

    /// Parameters by their names: those of a draw, and those that were given.
    fn named(&self, values: &[f64]) -> Vec<(String, f64)> {
        let drawn = self.names.iter().cloned().zip(values.iter().copied());
        drawn.chain(self.set.iter().cloned()).collect()
    }

    /// The number of draws.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none, which is never so of a folder.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The parameters by their names at a draw.
    pub fn draw(&self, at: usize) -> Vec<(String, f64)> {
        self.named(&self.values[at])
    }

    /// The model at the mean of all draws.
    ///
    /// # Errors
    /// [`MotesError::Model`] if it is no model there.
    pub fn at_mean(&self, model: &Model) -> Result<Model, MotesError> {
        let n = self.values.len() as f64;
        let mean = |at: usize| {
            let mean = self.values.iter().map(|values| values[at]).sum::<f64>() / n;
            nearest_value(model, &self.names[at], mean)
        };
        let means: Vec<f64> = (0..self.names.len()).map(mean).collect();
        Ok(model.with_parameters(&self.named(&means))?)
    }

    /// The model at `count` draws at the most, evenly spread over all of them.
    ///
    /// # Errors
    /// [`MotesError::Model`] if it is no model at one of them.
    pub fn spread(&self, model: &Model, count: usize) -> Result<Vec<Model>, MotesError> {
        let all = self.values.len();
        let count = count.min(all);
        let places = (0..count).map(|at| (2 * at + 1) * all / (2 * count));
        places.map(|at| Ok(model.with_parameters(&self.draw(at))?)).collect()
    }
}

/// How something in a line is wrong.
type Wrong<'a> = &'a dyn Fn(u64, &str) -> MotesError;

/// Names and values of parameters.
type Values = (Vec<String>, Vec<Vec<f64>>);

/// The rows of a table whose header begins with these columns, as texts, and the header.
fn rows(
    text: &str,
    begins: &[&str],
    wrong: Wrong<'_>,
) -> Result<(Vec<String>, Vec<Vec<String>>), MotesError> {
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let header = table.headers().map_err(|error| wrong(1, &error.to_string()))?.clone();
    if header.len() < begins.len() || header.iter().zip(begins).any(|(found, name)| found != *name) {
        return Err(wrong(1, &format!("it must begin with {}", begins.join(","))));
    }
    let texts = |row: &csv::StringRecord| row.iter().map(String::from).collect::<Vec<String>>();
    let mut found = Vec::new();
    for (at, row) in table.records().enumerate() {
        found.push(texts(&row.map_err(|error| wrong(at as u64 + 2, &error.to_string()))?));
    }
    if found.is_empty() {
        return Err(wrong(2, "there is nothing in it"));
    }
    Ok((texts(&header), found))
}

fn number(text: &str, line: u64, wrong: Wrong<'_>) -> Result<f64, MotesError> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| wrong(line, &format!("{text:?} is no finite number")))
}

fn draws(text: &str, wrong: Wrong<'_>) -> Result<Values, MotesError> {
    let (header, rows) = rows(text, &OF_DRAW, wrong)?;
    let names = header.into_iter().skip(OF_DRAW.len()).collect();
    // Chains are as long as each other, one after the other.
    let of_first = rows.iter().take_while(|row| row[0] == rows[0][0]).count();
    if !rows.len().is_multiple_of(of_first) {
        return Err(wrong(
            rows.len() as u64 + 1,
            "the last chain has fewer draws than the first one: the file was cut off; fit it again",
        ));
    }
    let numbers = rows.iter().enumerate().map(|(at, row)| {
        row.iter().skip(OF_DRAW.len()).map(|text| number(text, at as u64 + 2, wrong)).collect()
    });
    Ok((names, numbers.collect::<Result<_, _>>()?))
}

fn maximum(text: &str, wrong: Wrong<'_>) -> Result<Values, MotesError> {
    let (_, rows) = rows(text, &OF_MAXIMUM, wrong)?;
    let names = rows.iter().map(|row| row[0].clone()).collect();
    let numbers = rows.iter().enumerate().map(|(at, row)| number(&row[1], at as u64 + 2, wrong));
    Ok((names, vec![numbers.collect::<Result<_, _>>()?]))
}
