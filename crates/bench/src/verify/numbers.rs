//! The numbers of finished runs, as claims ask for them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::error::VerifyError;
use crate::config::Method;
use crate::statistics::{median, standard_deviation};
use crate::tables::{FailureRow, MetricRow, read_rows};

/// What a claim on an error is judged on: the paper's average over runs, and a single run.
pub(super) const METRICS: [&str; 2] = ["nmse_final", "nmse_final_single"];

/// What a claim on the epidemic is judged on: the error of each state.
pub(super) const STATES: [&str; 3] = ["mse_S", "mse_I", "mse_R"];

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
    /// A point with fewer repetitions was not run: all that the most complete point has, or [`ENOUGH`] in a comparison.
    pub(super) needed: usize,
}

/// The fewest repetitions of which a sign test can tell anything at 5%: ½⁵ < 0.05.
pub(super) const ENOUGH: usize = 5;

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
        let mut values = read_units(&file)?;
        let failures = file.with_file_name("failures.csv");
        if failures.exists() {
            count_failures(&mut values, read_failures(&failures)?);
        }
        Ok(Figure::of(places, values))
    }

    /// A figure of which these values are known.
    pub(super) fn of(places: Vec<Place>, values: Values) -> Figure {
        let needed = values.values().map(BTreeMap::len).max().unwrap_or(0);
        Figure { places, was_run: true, values, needed }
    }

    /// `methods` alone, each with the repetitions that all of them have at all points of a panel where they were run: what is compared is paired.
    pub(super) fn comparing(&self, methods: &[Method]) -> Figure {
        let needed = self.needed.min(ENOUGH);
        let mut values = self.values.clone();
        values.retain(|(name, ..), repetitions| {
            methods.iter().any(|method| method.name() == name) && repetitions.len() >= needed
        });
        let mut common: BTreeMap<(String, String), BTreeSet<usize>> = BTreeMap::new();
        for ((_, place, metric), repetitions) in &values {
            let of_panel = common.entry((place.panel.clone(), metric.clone()));
            let of_panel = of_panel.or_insert_with(|| repetitions.keys().copied().collect());
            of_panel.retain(|repetition| repetitions.contains_key(repetition));
        }
        for ((_, place, metric), repetitions) in &mut values {
            let of_panel = &common[&(place.panel.clone(), metric.clone())];
            repetitions.retain(|repetition, _| of_panel.contains(repetition));
        }
        Figure { values, needed, ..self.clone() }
    }

    /// How many repetitions a panel has of what is compared.
    pub(super) fn compared(&self, panel: &str, metric: &str) -> usize {
        let of_panel = self.values.iter().filter(|((_, place, of), _)| place.panel == panel && of == metric);
        of_panel.map(|(_, repetitions)| repetitions.len()).max().unwrap_or(0)
    }

    /// The value of each repetition; none if fewer were run here than are needed.
    pub(super) fn at(&self, method: Method, place: &Place, metric: &str) -> Option<&BTreeMap<usize, f64>> {
        let values = self.values.get(&(method.name().to_string(), place.clone(), metric.to_string()))?;
        (values.len() >= self.needed).then_some(values)
    }

    /// The median over repetitions.
    pub(super) fn median(&self, method: Method, place: &Place, metric: &str) -> Option<f64> {
        Some(median(self.at(method, place, metric)?.values().copied().collect()))
    }

    /// The standard deviation over repetitions; infinite if one of them failed.
    pub(super) fn deviation(&self, method: Method, place: &Place, metric: &str) -> Option<f64> {
        let values: Vec<f64> = self.at(method, place, metric)?.values().copied().collect();
        let failed = values.iter().any(|value| value.is_infinite());
        Some(if failed { f64::INFINITY } else { standard_deviation(&values) })
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
            .filter_map(|(repetition, value)| Some(ratio(*value, *others.get(repetition)?).ln()))
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

/// `error / other`, which is infinite wherever the first of them is, and 1 of equal ones.
pub(super) fn ratio(error: f64, other: f64) -> f64 {
    match error {
        f64::INFINITY => f64::INFINITY,
        _ if error == other => 1.0,
        _ => error / other,
    }
}

/// By method, place and metric: the value of each repetition.
pub(super) type Values = BTreeMap<(String, Place, String), BTreeMap<usize, f64>>;

/// Method, place and repetition of each unit that failed.
type Failures = Vec<(String, Place, usize)>;

/// A repetition that failed counts as one with an infinite error in every metric: it is never below another, and never
/// dropped.
fn count_failures(values: &mut Values, failures: Failures) {
    // If no unit succeeded, nothing else says what they would have had.
    let judged = METRICS.into_iter().chain(STATES).map(str::to_string);
    let metrics: BTreeSet<String> =
        values.keys().map(|(_, _, metric)| metric.clone()).chain(judged).collect();
    for (method, place, repetition) in failures {
        for metric in &metrics {
            let key = (method.clone(), place.clone(), metric.clone());
            values.entry(key).or_default().insert(repetition, f64::INFINITY);
        }
    }
}

fn read_failures(path: &Path) -> Result<Failures, VerifyError> {
    let rows = read_rows(path).map_err(|source| VerifyError::Table { path: path.to_path_buf(), source })?;
    let place = |row: FailureRow| (row.method, Place { panel: row.panel, x: row.x }, row.repetition);
    Ok(rows.into_iter().map(place).collect())
}

fn read_units(path: &Path) -> Result<Values, VerifyError> {
    let rows = read_rows(path).map_err(|source| VerifyError::Table { path: path.to_path_buf(), source })?;
    let mut values = Values::new();
    for MetricRow { panel, method, x, repetition, metric, value, .. } in rows {
        values.entry((method, Place { panel, x }, metric)).or_default().insert(repetition, value);
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_that_failed_are_infinite_errors_also_where_none_succeeded() {
        let place = Place { panel: "N10".into(), x: 10 };
        let key = |method: &str| (method.to_string(), place.clone(), "nmse_final".to_string());
        let mut values = Values::from([(key("bootstrap"), BTreeMap::from([(0, 1.0), (1, 2.0)]))]);
        let failures = [0, 1].map(|repetition| ("psi".to_string(), place.clone(), repetition));
        count_failures(&mut values, failures.into());
        let figure = Figure::of(vec![place.clone()], values);
        assert_eq!(figure.median(Method::Psi, &place, "nmse_final"), Some(f64::INFINITY));
        assert_eq!(figure.median(Method::Bootstrap, &place, "nmse_final"), Some(1.5));
        assert_eq!(figure.median(Method::Fcnn, &place, "nmse_final"), None);
    }

    #[test]
    fn comparisons_are_over_the_repetitions_that_all_have() {
        let place = Place { panel: "N10".into(), x: 10 };
        let key = |method: &str| (method.to_string(), place.clone(), "nmse_final".to_string());
        let of = |values: std::ops::Range<usize>| -> BTreeMap<usize, f64> {
            values.map(|repetition| (repetition, repetition as f64)).collect()
        };
        let values = [(key("fcnn"), of(0..20)), (key("gnn"), of(2..8)), (key("rnn"), of(0..4))];
        let figure = Figure::of(vec![place.clone()], values.into());
        let median = |figure: &Figure, method| figure.median(method, &place, "nmse_final");
        assert_eq!([Method::Fcnn, Method::Gnn].map(|method| median(&figure, method)), [Some(9.5), None]);
        let both = figure.comparing(&[Method::Fcnn, Method::Gnn, Method::Rnn]);
        assert_eq!([Method::Fcnn, Method::Gnn].map(|method| median(&both, method)), [Some(4.5); 2]);
        assert_eq!(both.compared("N10", "nmse_final"), 6);
        assert_eq!(median(&both, Method::Rnn), None, "four repetitions cannot tell");
        assert_eq!(median(&figure.comparing(&[Method::Fcnn]), Method::Fcnn), Some(9.5));
    }

    #[test]
    fn a_figure_in_which_all_failed_was_run_and_nothing_is_below_in_it() {
        let place = Place { panel: "N10".into(), x: 10 };
        let mut values = Values::new();
        let failures = ["psi", "min-degeneracy"].map(|method| (method.to_string(), place.clone(), 0));
        count_failures(&mut values, failures.into());
        let figure = Figure::of(vec![place.clone()], values);
        let ratios = figure.log_ratios(Method::Psi, Method::MinDegeneracy, &place, "nmse_final");
        assert_eq!(ratios, Some(vec![f64::INFINITY]));
        assert_eq!(figure.deviation(Method::Psi, &place, "nmse_final"), Some(f64::INFINITY));
    }

    #[test]
    fn repetitions_in_which_both_failed_are_not_below() {
        let place = Place { panel: "N10".into(), x: 10 };
        let key = |method: &str| (method.to_string(), place.clone(), "nmse_final".to_string());
        let both = f64::INFINITY;
        let of = |errors: [f64; 3]| (0..).zip(errors).collect::<BTreeMap<usize, f64>>();
        let values =
            Values::from([(key("psi"), of([both, 0.9, 1.1])), (key("min-degeneracy"), of([both, 1.0, 1.0]))]);
        let figure = Figure::of(vec![place.clone()], values);
        let ratios = figure.log_ratios(Method::Psi, Method::MinDegeneracy, &place, "nmse_final").unwrap();
        assert!(median(ratios) > 0.0);
    }
}
