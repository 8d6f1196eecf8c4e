//! The numbers of finished runs, as claims ask for them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::VerifyError;
use crate::config::Method;
use crate::metrics::{median, standard_deviation};

/// Where a number stands in a figure.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) panel: String,
    pub(super) x: usize,
}

/// All numbers of one figure, and which points the whole figure has.
#[derive(Debug, Clone, Default)]
pub(super) struct Figure {
    pub(super) places: Vec<Place>,
    /// Whether anything of it was run.
    pub(super) was_run: bool,
    /// By method, panel, x and metric: the value of each repetition.
    pub(super) values: Values,
    /// By method, panel and x: the repetitions that failed.
    pub(super) failed: BTreeMap<(String, Place), Vec<usize>>,
}

fn units_file(folder: &Path, figure: &str, profile: &str) -> PathBuf {
    folder.join(figure).join(profile).join("units.csv")
}

/// The most thorough profile in which any of `figures` was run: figures are only compared within one profile.
pub(super) fn best_profile(folder: &Path, figures: &[&str]) -> Option<&'static str> {
    let any = |profile: &&str| figures.iter().any(|figure| units_file(folder, figure, profile).exists());
    ["paper", "quick", "smoke"].into_iter().find(any)
}

impl Figure {
    /// Reads the runs of a figure in a profile.
    pub(super) fn read(
        folder: &Path,
        figure: &str,
        profile: &str,
        places: Vec<Place>,
    ) -> Result<Figure, VerifyError> {
        let file = units_file(folder, figure, profile);
        if !file.exists() {
            return Ok(Figure { places, ..Figure::default() });
        }
        let mut figure = Figure { places, was_run: true, values: read_units(&file)?, ..Figure::default() };
        let failures = file.with_file_name("failures.csv");
        if failures.exists() {
            figure.failed = read_failures(&failures)?;
        }
        figure.count_failures();
        Ok(figure)
    }

    /// A repetition that failed counts as one with an infinite error in every metric of its point: it is never below
    /// another, and never dropped.
    fn count_failures(&mut self) {
        for ((method, place, _), values) in &mut self.values {
            for repetition in self.failed.get(&(method.clone(), place.clone())).into_iter().flatten() {
                values.insert(*repetition, f64::INFINITY);
            }
        }
    }

    /// The value of each repetition; none if fewer were run here than elsewhere in the figure.
    pub(super) fn at(&self, method: Method, place: &Place, metric: &str) -> Option<&BTreeMap<usize, f64>> {
        let repetitions = self.values.values().map(BTreeMap::len).max()?;
        let values = self.values.get(&(method.name().to_string(), place.clone(), metric.to_string()))?;
        (values.len() == repetitions).then_some(values)
    }

    /// The median over repetitions.
    pub(super) fn median(&self, method: Method, place: &Place, metric: &str) -> Option<f64> {
        Some(median(self.at(method, place, metric)?.values().copied().collect()))
    }

    /// The standard deviation over repetitions.
    pub(super) fn deviation(&self, method: Method, place: &Place, metric: &str) -> Option<f64> {
        let values: Vec<f64> = self.at(method, place, metric)?.values().copied().collect();
        Some(standard_deviation(&values))
    }

    /// `log(method / other)` of each repetition that both have.
    pub(super) fn log_ratios(
        &self,
        method: Method,
        other: Method,
        place: &Place,
        metric: &str,
    ) -> Option<Vec<f64>> {
        let (values, others) = (self.at(method, place, metric)?, self.at(other, place, metric)?);
        let ratios: Vec<f64> = values
            .iter()
            .filter_map(|(repetition, value)| Some((value / others.get(repetition)?).ln()))
            .collect();
        (!ratios.is_empty()).then_some(ratios)
    }

    /// The panels, in order.
    pub(super) fn panels(&self) -> Vec<&str> {
        let mut panels: Vec<&str> = Vec::new();
        for place in &self.places {
            if !panels.contains(&place.panel.as_str()) {
                panels.push(&place.panel);
            }
        }
        panels
    }

    /// The points of one panel.
    pub(super) fn of_panel<'a>(&'a self, panel: &'a str) -> impl Iterator<Item = &'a Place> {
        self.places.iter().filter(move |place| place.panel == panel)
    }
}

/// figure, panel, method, x, repetition, metric, value.
type Line = (String, String, String, usize, usize, String, f64);

pub(super) type Values = BTreeMap<(String, Place, String), BTreeMap<usize, f64>>;

/// figure, panel, method, x, repetition, reason.
type FailureLine = (String, String, String, usize, usize, String);

fn read_failures(path: &PathBuf) -> Result<BTreeMap<(String, Place), Vec<usize>>, VerifyError> {
    let fail = |source| VerifyError::Table { path: path.clone(), source };
    let mut failed: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    let mut reader = csv::Reader::from_path(path).map_err(fail)?;
    for line in reader.deserialize() {
        let (_, panel, method, x, repetition, _): FailureLine = line.map_err(fail)?;
        failed.entry((method, Place { panel, x })).or_default().push(repetition);
    }
    Ok(failed)
}

fn read_units(path: &PathBuf) -> Result<Values, VerifyError> {
    let fail = |source| VerifyError::Table { path: path.clone(), source };
    let mut values = Values::new();
    let mut reader = csv::Reader::from_path(path).map_err(fail)?;
    for line in reader.deserialize() {
        let (_, panel, method, x, repetition, metric, value): Line = line.map_err(fail)?;
        values.entry((method, Place { panel, x }, metric)).or_default().insert(repetition, value);
    }
    Ok(values)
}
