//! The regression run: the smoke profile on every backend against committed numbers.

use std::collections::BTreeMap;
use std::path::Path;

use motes_cli::{Interrupt, result, status};
use motes_proposals::Backend;
use motes_proposals::networks::NetworkError;
use thiserror::Error;

use crate::config::Plan;
use crate::estimate::Estimator;
use crate::reproduce::{RunOutcome, reproduce};
use crate::store::StoreError;
use crate::tables::{MetricRow, number, read_rows};

/// Why the regression run did not pass.
#[derive(Debug, Error)]
pub enum RegressionError {
    /// Values differ from the expected ones.
    #[error("{count} values differ from {file}")]
    Differs {
        /// How many.
        count: usize,
        /// The file with the expected ones.
        file: String,
    },
    /// Units failed.
    #[error("{failed} units failed on {backend}")]
    Failed {
        /// How many.
        failed: usize,
        /// On which backend.
        backend: Backend,
    },
    /// This build lacks a backend.
    #[error(transparent)]
    NotBuilt(#[from] NetworkError),
    /// A signal came.
    #[error("interrupted")]
    Interrupted,
    /// The results could not be stored.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A table could not be read or written.
    #[error("{file}: {source}")]
    File {
        /// The table.
        file: String,
        /// What is wrong.
        source: csv::Error,
    },
}

/// Designed methods have to agree with the expectation to this relative difference.
const DESIGNED_TOLERANCE: f64 = 1e-9;

/// Learned ones to this many times the difference between the backends.
const BACKEND_FACTOR: f64 = 10.0;

/// panel, method, x, repetition and metric of a value.
type Place = [String; 5];

/// One line of the expectation: the value on each of [`Backend::HOST`].
type Expected = [f64; Backend::HOST.len()];

/// What a run found.
type Found = BTreeMap<Place, f64>;

/// Runs `plan` on every backend in folders of its own under `scratch`, and holds the results against the file
/// `expectation`; writes that file instead if `update`.
///
/// # Errors
/// [`RegressionError`] if a unit fails or is missing, or a value is farther from the expected one than allowed; every such
/// value is printed.
pub fn regress(
    plan: &Plan,
    expectation: &Path,
    scratch: &Path,
    update: bool,
    interrupt: &Interrupt,
) -> Result<(), RegressionError> {
    let mut found = Vec::new();
    Backend::HOST.into_iter().try_for_each(Backend::check)?;
    for backend in Backend::HOST {
        found.push(run(plan, backend, scratch, interrupt)?);
    }
    if update {
        return write(expectation, &found);
    }
    let expected = read_expected(expectation)?;
    let mut wrong = 0;
    for (at, (backend, found)) in Backend::HOST.into_iter().zip(&found).enumerate() {
        for line in compare(found, &expected, at) {
            status(&format!("{backend}: {line}"));
            wrong += 1;
        }
    }
    if wrong > 0 {
        return Err(RegressionError::Differs { count: wrong, file: expectation.display().to_string() });
    }
    result(&format!(
        "regression: {} values on each of {} backends are as expected",
        expected.len(),
        Backend::HOST.len()
    ));
    Ok(())
}

fn run(
    plan: &Plan,
    backend: Backend,
    scratch: &Path,
    interrupt: &Interrupt,
) -> Result<Found, RegressionError> {
    let folder = scratch.join(backend.to_string());
    let plan = Plan { backend, folder: folder.clone(), fresh: true, ..plan.clone() };
    match reproduce(&plan, &Estimator::default(), interrupt)? {
        RunOutcome::Complete { failed: 0, .. } => {}
        RunOutcome::Complete { failed, .. } => {
            return Err(RegressionError::Failed { failed, backend });
        }
        RunOutcome::Interrupted => return Err(RegressionError::Interrupted),
    }
    let rows: Vec<MetricRow> = read(&folder.join("units.csv"))?;
    let place = |row: MetricRow| {
        ([row.panel, row.method, row.x.to_string(), row.repetition.to_string(), row.metric], row.value)
    };
    Ok(rows.into_iter().map(place).collect())
}

/// A line of the expectation.
type ExpectedRow = (String, String, String, String, String, f64, f64, f64);

fn read_expected(path: &Path) -> Result<BTreeMap<Place, Expected>, RegressionError> {
    let place = |(panel, method, x, repetition, metric, a, b, c): ExpectedRow| {
        ([panel, method, x, repetition, metric], [a, b, c])
    };
    Ok(read(path)?.into_iter().map(place).collect())
}

fn read<Row: serde::de::DeserializeOwned>(path: &Path) -> Result<Vec<Row>, RegressionError> {
    read_rows(path).map_err(|source| RegressionError::File { file: path.display().to_string(), source })
}

fn write(path: &Path, found: &[Found]) -> Result<(), RegressionError> {
    let fail = |source| RegressionError::File { file: path.display().to_string(), source };
    let mut writer = csv::Writer::from_path(path).map_err(fail)?;
    let header = ["panel", "method", "x", "repetition", "metric"].map(String::from);
    writer
        .write_record(header.into_iter().chain(Backend::HOST.map(|backend| backend.to_string())))
        .map_err(fail)?;
    for place in found[0].keys() {
        // A unit that ran on one backend ran on the others.
        let value = |found: &Found| number(found.get(place).copied().unwrap_or(f64::NAN));
        let values: Vec<String> = found.iter().map(value).collect();
        writer.write_record(place.iter().chain(&values)).map_err(fail)?;
    }
    writer.flush().map_err(|error| fail(error.into()))?;
    result(&format!("{} values written to {}", found[0].len(), path.display()));
    Ok(())
}

/// How far a value may be from the expected one, relative to it, by method and metric.
///
/// A single pair of values can agree by chance, so a metric's difference between backends is the largest over the units
/// of its method.
fn tolerances(expected: &BTreeMap<Place, Expected>) -> BTreeMap<(&str, &str), f64> {
    let mut tolerances = BTreeMap::new();
    for ([_, method, _, _, metric], value) in expected {
        let difference = value.iter().map(|other| relative(value[0], *other)).fold(0.0, f64::max);
        let tolerance = tolerances.entry((method.as_str(), metric.as_str())).or_insert(DESIGNED_TOLERANCE);
        *tolerance = tolerance.max(BACKEND_FACTOR * difference);
    }
    tolerances
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// What differs on a backend, a line for each value.
fn compare(found: &Found, expected: &BTreeMap<Place, Expected>, backend: usize) -> Vec<String> {
    let tolerances = tolerances(expected);
    let mut lines = Vec::new();
    for (place, value) in expected {
        let (tolerance, value) = (tolerances[&(place[1].as_str(), place[4].as_str())], value[backend]);
        match found.get(place) {
            None => lines.push(format!("{} is missing", place.join(" "))),
            Some(&found) if relative(found, value) <= tolerance => {}
            Some(found) => lines.push(format!(
                "{} is {found:?}, expected {value:?} within a relative {tolerance:.1e}",
                place.join(" ")
            )),
        }
    }
    let unexpected = found.keys().filter(|place| !expected.contains_key(*place));
    lines.extend(unexpected.map(|place| format!("{} was not expected", place.join(" "))));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(method: &str, x: &str) -> Place {
        ["N10", method, x, "0", "ess"].map(String::from)
    }

    fn expectation() -> BTreeMap<Place, Expected> {
        BTreeMap::from([
            (place("bootstrap", "10"), [2.0; 3]),
            (place("fcnn", "10"), [3.0; 3]),
            (place("fcnn", "20"), [4.0, 4.0004, 4.0]),
        ])
    }

    #[test]
    fn values_may_differ_by_as_much_as_backends_do_and_no_more() {
        let found = |bootstrap, fcnn| {
            BTreeMap::from([
                (place("bootstrap", "10"), bootstrap),
                (place("fcnn", "10"), fcnn),
                (place("fcnn", "20"), 4.0),
            ])
        };
        let count = |bootstrap, fcnn| compare(&found(bootstrap, fcnn), &expectation(), 0).len();
        assert_eq!(count(2.0, 3.0), 0);
        assert_eq!(count(2.0 * (1.0 + 1e-10), 3.002), 0);
        assert_eq!(count(2.0 * (1.0 + 1e-8), 3.0), 1);
        assert_eq!(count(2.0, 3.01), 1);
        assert_eq!(count(f64::NAN, f64::NAN), 2);
    }

    #[test]
    fn a_missing_and_an_unexpected_value_are_both_told() {
        let mut found = BTreeMap::from([(place("rnn", "10"), 1.0)]);
        found.extend(expectation().into_iter().skip(1).map(|(place, value)| (place, value[0])));
        let lines = compare(&found, &expectation(), 0);
        assert_eq!(lines, ["N10 bootstrap 10 0 ess is missing", "N10 rnn 10 0 ess was not expected"]);
    }
}
