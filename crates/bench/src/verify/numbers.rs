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
    pub(super) values: BTreeMap<(String, Place, String), BTreeMap<usize, f64>>,
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
        let was_run = file.exists();
        let values = if was_run { read_units(&file)? } else { Values::new() };
        Ok(Figure { places, was_run, values })
    }

    /// The value of each repetition; none if it was not run.
    pub(super) fn at(&self, method: Method, place: &Place, metric: &str) -> Option<&BTreeMap<usize, f64>> {
        self.values.get(&(method.name().to_string(), place.clone(), metric.to_string()))
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

type Values = BTreeMap<(String, Place, String), BTreeMap<usize, f64>>;

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
