//! The regression run: the smoke profile on both backends against committed numbers.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, bail, ensure};

use crate::config::{Backend, Plan};
use crate::tables::number;
use crate::{Finished, Interrupt, reproduce};

/// Designed methods have to agree with the expectation to this relative difference.
const DESIGNED_TOLERANCE: f64 = 1e-9;

/// Learned ones to this many times the difference between the two backends.
const BACKEND_FACTOR: f64 = 10.0;

/// panel, method, x, repetition and metric of a value.
type Place = [String; 5];

/// One line of the expectation: the value on each backend.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Expected {
    flex: f64,
    ndarray: f64,
}

/// Runs `plan` on both backends in folders of its own under `scratch`, and holds the results against the file
/// `expectation`; writes that file instead if `update`.
///
/// # Errors
/// If a unit fails or is missing, or a value is farther from the expected one than allowed; every such value is printed.
pub fn regress(
    plan: &Plan,
    expectation: &Path,
    scratch: &Path,
    update: bool,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    let flex = run(plan, Backend::Flex, scratch, interrupt)?;
    let ndarray = run(plan, Backend::Ndarray, scratch, interrupt)?;
    if update {
        return write(expectation, &flex, &ndarray);
    }
    let expected = read(expectation)?;
    let mut wrong = 0;
    for (backend, found, pick) in [
        ("flex", &flex, (|e: &Expected| e.flex) as fn(&Expected) -> f64),
        ("ndarray", &ndarray, |e: &Expected| e.ndarray),
    ] {
        for line in compare(found, &expected, pick) {
            eprintln!("{backend}: {line}");
            wrong += 1;
        }
    }
    ensure!(wrong == 0, "{wrong} values differ from {}", expectation.display());
    println!("regression: {} values on each of two backends are as expected", expected.len());
    Ok(())
}

fn run(
    plan: &Plan,
    backend: Backend,
    scratch: &Path,
    interrupt: &Interrupt,
) -> anyhow::Result<BTreeMap<Place, f64>> {
    let folder = scratch.join(backend.name());
    let plan = Plan { backend, folder: folder.clone(), fresh: true, ..plan.clone() };
    match reproduce(&plan, interrupt)? {
        Finished::Complete { failed: 0 } => {}
        Finished::Complete { failed } => bail!("{failed} units failed on {}", backend.name()),
        Finished::Interrupted => bail!("interrupted"),
    }
    let mut reader = csv::Reader::from_path(folder.join("units.csv"))?;
    reader
        .deserialize()
        .map(|row| {
            let (_, panel, method, x, repetition, metric, value): (
                String,
                String,
                String,
                String,
                String,
                String,
                f64,
            ) = row?;
            Ok(([panel, method, x, repetition, metric], value))
        })
        .collect()
}

fn write(path: &Path, flex: &BTreeMap<Place, f64>, ndarray: &BTreeMap<Place, f64>) -> anyhow::Result<()> {
    let mut writer = csv::Writer::from_path(path).with_context(|| path.display().to_string())?;
    writer.write_record(["panel", "method", "x", "repetition", "metric", "flex", "ndarray"])?;
    for (place, value) in flex {
        let other = ndarray.get(place).with_context(|| format!("{place:?} is missing on ndarray"))?;
        let values = [number(*value), number(*other)];
        writer.write_record(place.iter().chain(&values))?;
    }
    writer.flush()?;
    println!("{} values written to {}", flex.len(), path.display());
    Ok(())
}

fn read(path: &Path) -> anyhow::Result<BTreeMap<Place, Expected>> {
    let mut reader = csv::Reader::from_path(path).with_context(|| path.display().to_string())?;
    reader
        .deserialize()
        .map(|row| {
            let (panel, method, x, repetition, metric, flex, ndarray) = row?;
            Ok(([panel, method, x, repetition, metric], Expected { flex, ndarray }))
        })
        .collect()
}

/// How far a value may be from the expected one, relative to it, by method and metric.
///
/// A single pair of values can agree by chance, so a metric's difference between backends is the largest over the units
/// of its method.
fn tolerances(expected: &BTreeMap<Place, Expected>) -> BTreeMap<(&str, &str), f64> {
    let mut tolerances = BTreeMap::new();
    for ([_, method, _, _, metric], value) in expected {
        let difference = relative(value.flex, value.ndarray);
        let tolerance = tolerances.entry((method.as_str(), metric.as_str())).or_insert(DESIGNED_TOLERANCE);
        *tolerance = tolerance.max(BACKEND_FACTOR * difference);
    }
    tolerances
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// What differs, a line for each value.
fn compare(
    found: &BTreeMap<Place, f64>,
    expected: &BTreeMap<Place, Expected>,
    pick: impl Fn(&Expected) -> f64,
) -> Vec<String> {
    let tolerances = tolerances(expected);
    let mut lines = Vec::new();
    for (place, value) in expected {
        let (tolerance, value) = (tolerances[&(place[1].as_str(), place[4].as_str())], pick(value));
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
            (place("bootstrap", "10"), Expected { flex: 2.0, ndarray: 2.0 }),
            (place("fcnn", "10"), Expected { flex: 3.0, ndarray: 3.0 }),
            (place("fcnn", "20"), Expected { flex: 4.0, ndarray: 4.0004 }),
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
        let count = |bootstrap, fcnn| compare(&found(bootstrap, fcnn), &expectation(), |e| e.flex).len();
        assert_eq!(count(2.0, 3.0), 0);
        assert_eq!(count(2.0 * (1.0 + 1e-10), 3.002), 0);
        assert_eq!(count(2.0 * (1.0 + 1e-8), 3.0), 1);
        assert_eq!(count(2.0, 3.01), 1);
        assert_eq!(count(f64::NAN, f64::NAN), 2);
    }

    #[test]
    fn a_missing_and_an_unexpected_value_are_both_told() {
        let mut found = BTreeMap::from([(place("rnn", "10"), 1.0)]);
        found.extend(expectation().into_iter().skip(1).map(|(place, value)| (place, value.flex)));
        let lines = compare(&found, &expectation(), |e| e.flex);
        assert_eq!(lines, ["N10 bootstrap 10 0 ess is missing", "N10 rnn 10 0 ess was not expected"]);
    }
}
