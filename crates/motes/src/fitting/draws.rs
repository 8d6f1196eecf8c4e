//! What a fit found, read for a model.

use std::path::Path;

use super::record::FitRecord;
use crate::error::MotesError;
use crate::model::Model;

/// The files of a folder that say what was found, and with what.
pub(crate) const DRAWS: &str = "draws.csv";
pub(crate) const RECORD: &str = "fit.toml";

/// The columns of draws before the parameters.
pub(crate) const OF_DRAW: [&str; 3] = ["chain", "draw", "log_evidence"];

/// The draws of the parameters of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedDraws {
    /// The names of the `D` parameters.
    pub names: Vec<String>,
    /// The values (`D`) of each draw, all chains one after the other.
    pub values: Vec<Vec<f64>>,
    /// Parameters that were given a value before.
    pub set: Vec<(String, f64)>,
}

impl FittedDraws {
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
        let record: FitRecord = toml::from_str(&read(RECORD)?).map_err(|error| {
            refused(format!("{RECORD}: {}", error.message().lines().next().unwrap_or_default()))
        })?;
        if !record.is_of(model) {
            let reason = format!(
                "it is a fit of {}, or of this model before its file was changed; fit it again",
                record.model
            );
            return Err(refused(reason));
        }
        let text = read(DRAWS)?;
        let mut table = csv::Reader::from_reader(text.as_bytes());
        let wrong = |line: u64, reason: &str| refused(format!("{DRAWS}, line {line}: {reason}"));
        let header = table.headers().map_err(|error| wrong(1, &error.to_string()))?.clone();
        if header.len() <= OF_DRAW.len() || header.iter().zip(OF_DRAW).any(|(found, name)| found != name) {
            return Err(wrong(
                1,
                "it must begin with chain,draw,log_evidence and name a parameter after them",
            ));
        }
        let names: Vec<String> = header.iter().skip(OF_DRAW.len()).map(String::from).collect();
        let mut values = Vec::new();
        for (at, row) in table.records().enumerate() {
            let line = at as u64 + 2;
            let row = row.map_err(|error| wrong(line, &error.to_string()))?;
            let numbers = row.iter().skip(OF_DRAW.len()).map(str::parse::<f64>);
            let numbers =
                numbers.collect::<Result<Vec<f64>, _>>().map_err(|_| wrong(line, "a value is no number"))?;
            if numbers.iter().any(|value| !value.is_finite()) {
                return Err(wrong(line, "a value is not finite"));
            }
            values.push(numbers);
        }
        if values.is_empty() {
            return Err(wrong(2, "there are no draws"));
        }
        Ok(FittedDraws { names, values, set: record.set.into_iter().collect() })
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
        let mean = |at: usize| self.values.iter().map(|values| values[at]).sum::<f64>() / n;
        let means: Vec<f64> = (0..self.names.len()).map(mean).collect();
        Ok(model.with_parameters(&self.named(&means))?)
    }

    /// The model at `count` draws, evenly spread over all of them.
    ///
    /// # Errors
    /// [`MotesError::Model`] if it is no model at one of them.
    pub fn spread(&self, model: &Model, count: usize) -> Result<Vec<Model>, MotesError> {
        let all = self.values.len();
        let places = (0..count).map(|at| (2 * at + 1) * all / (2 * count));
        places.map(|at| Ok(model.with_parameters(&self.draw(at))?)).collect()
    }
}
