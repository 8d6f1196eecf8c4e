//! Estimates of states as a page: figures over time, warnings, settings.

use motes_smc::Predictive;

use crate::data::{Data, Row};
use crate::estimate::{Coordinate, Estimate, Forecast};
use crate::names::ModelNames;
use crate::quantiles::Quantiles;

use super::axis::TimeAxis;
use super::figures::{Band, band_figure, input_figure, line_figure};
use super::histogram::histogram;
use super::page::Page;
use super::style::Drawn;

/// What a report is about.
pub struct Report<'a> {
    /// What was done: `Filter` or `Smoother`.
    pub title: &'a str,
    /// The model and its coordinates.
    pub names: &'a ModelNames,
    /// The data.
    pub data: &'a Data,
    /// The estimate of each row of the data.
    pub estimates: &'a [Estimate],
    /// The quantiles that they have.
    pub quantiles: &'a Quantiles,
    /// What is predicted after each series.
    pub forecasts: &'a [Vec<Forecast>],
    /// Figures of the whole run, a name and a value each.
    pub summary: &'a [(String, String)],
    /// Settings, a name and a value each.
    pub settings: &'a [(String, String)],
    /// Reasons not to trust the estimates.
    pub warnings: &'a [String],
    /// The command that made the report.
    pub command: &'a str,
}

/// Series, and coordinates of each, that are shown.
const SHOWN_SERIES: usize = 10;
const SHOWN_COORDINATES: usize = 12;

/// Steps with the least evidence that are named.
const WORST: usize = 5;

/// The report as HTML.
///
/// # Errors
/// What the drawing library says.
pub fn report(report: &Report<'_>) -> Result<String, Box<dyn std::error::Error>> {
    let mut page = Page::new(&format!("{} of {}", report.title, report.names.model));
    page.pairs(report.summary);
    page.warnings(report.warnings);
    all_series(&mut page, report)?;
    page.heading("Settings");
    page.pairs(report.settings);
    page.command(report.command);
    Ok(page.finish())
}

/// The figures of each series, as far as there is room.
///
/// # Errors
/// What the drawing library says.
pub(super) fn all_series(page: &mut Page, report: &Report<'_>) -> Drawn<()> {
    for (series, name) in report.data.series.iter().enumerate().take(SHOWN_SERIES) {
        if report.data.columns.has_series() {
            page.heading(&format!("Series {name}"));
        }
        series_section(page, report, series)?;
    }
    if report.data.series.len() > SHOWN_SERIES {
        page.note(&format!(
            "{SHOWN_SERIES} of {} series are shown; the table has all of them.",
            report.data.series.len()
        ));
    }
    Ok(())
}

/// What is drawn of a series.
struct Series<'a> {
    report: &'a Report<'a>,
    rows: Vec<(&'a Row, &'a Estimate)>,
    /// What each row is called, as far as there are labels.
    labels: Vec<Option<&'a str>>,
    ahead: &'a [Forecast],
    axis: TimeAxis,
}

impl<'a> Series<'a> {
    fn new(report: &'a Report<'a>, series: usize) -> Self {
        let data = report.data;
        let all = data.rows.iter().zip(report.estimates).enumerate();
        let of_series = all.filter(|(_, (row, _))| row.series == series);
        let label = |(at, (row, _)): &(usize, (&'a Row, &'a Estimate))| {
            row.label.as_deref().or_else(|| data.index.as_ref()?.get(*at).map(String::as_str))
        };
        let (labels, rows): (Vec<_>, Vec<_>) = of_series.map(|of| (label(&of), of.1)).unzip();
        let times: Vec<f64> = rows.iter().map(|(row, _)| row.time).collect();
        let ahead = report.forecasts.get(series).map_or(&[][..], Vec::as_slice);
        let axis = TimeAxis::of(&times, &labels, Some(label_column(report)), ahead);
        Series { report, rows, labels, ahead, axis }
    }

    /// Estimates of all rows, and of what is predicted behind them.
    fn estimates(&self) -> impl Iterator<Item = &'a Estimate> {
        let ahead = self.ahead.iter().map(|ahead| &ahead.estimate);
        self.rows.iter().map(|(_, estimate)| *estimate).chain(ahead)
    }

    /// What was measured.
    fn measured(&self, entry: usize) -> Vec<Option<f64>> {
        self.rows.iter().map(|(row, _)| row.measurement[entry]).collect()
    }

    /// A state, with what was measured of it if that has its name.
    fn state(&self, coordinate: usize, name: &str) -> Drawn<String> {
        let of = |figure: &dyn Fn(&Coordinate) -> f64| -> Vec<f64> {
            self.estimates().map(|estimate| figure(&estimate.state[coordinate])).collect()
        };
        let band = Band {
            low: of(&|c| low(&c.quantiles)),
            high: of(&|c| high(&c.quantiles)),
            middle: of(&|c| c.mean),
        };
        let measured = self.report.names.measurements.iter().position(|measured| measured == name);
        band_figure(name, &self.axis, &band, &measured.map_or(vec![], |entry| self.measured(entry)))
    }

    /// A measurement, with what was expected of it, one step ahead or in forecasts.
    fn measurement(&self, entry: usize, name: &str) -> Drawn<String> {
        let of = |figure: &dyn Fn(&Predictive) -> f64| -> Vec<f64> {
            let of_row = |estimate: &Estimate| estimate.predictive.get(entry).map_or(f64::NAN, figure);
            self.estimates().map(of_row).collect()
        };
        let band = Band {
            low: of(&|p| low(&p.quantiles)),
            high: of(&|p| high(&p.quantiles)),
            middle: of(&|p| p.mean),
        };
        band_figure(&format!("{name} (measured)"), &self.axis, &band, &self.measured(entry))
    }

    /// A figure of the weights, where there are any.
    fn of_weights(&self, figure: fn(&Estimate) -> Option<f64>) -> Option<Vec<f64>> {
        self.rows.iter().map(|(_, estimate)| figure(estimate)).collect()
    }
}

/// The lowest quantile.
fn low(quantiles: &[f64]) -> f64 {
    quantiles.first().copied().unwrap_or(f64::NAN)
}

/// The highest quantile.
fn high(quantiles: &[f64]) -> f64 {
    quantiles.last().copied().unwrap_or(f64::NAN)
}

/// What the column of labels is called.
fn label_column<'a>(report: &Report<'a>) -> &'a str {
    let index = report.data.index.as_ref().map(|_| "date");
    report.data.columns.carried().or(index).unwrap_or_default()
}

fn series_section(page: &mut Page, report: &Report<'_>, number: usize) -> Drawn<()> {
    let series = Series::new(report, number);
    let (names, axis) = (report.names, &series.axis);
    for (coordinate, name) in names.states.iter().enumerate().take(SHOWN_COORDINATES) {
        page.figure(&series.state(coordinate, name)?, "");
    }
    if names.states.len() > SHOWN_COORDINATES {
        page.note(&format!("{SHOWN_COORDINATES} of {} states are shown.", names.states.len()));
    }
    let forecast = if series.ahead.is_empty() { "" } else { " After the dotted line: forecast." };
    let band = report.quantiles.range().map(|range| format!(" Band: {range}.")).unwrap_or_default();
    page.note(&format!("Line: mean.{band}{forecast}"));
    for (at, name) in report.data.columns.input_names().iter().enumerate().take(SHOWN_COORDINATES) {
        // A measurement that is an input has a figure of its own.
        if !names.measurements.iter().any(|measured| measured == name) {
            let values: Vec<Option<f64>> = series.rows.iter().map(|(row, _)| row.inputs[at]).collect();
            page.figure(&input_figure(&format!("{name} (input)"), axis, &values)?, "");
        }
    }
    for input in names.file_inputs.iter().take(SHOWN_COORDINATES) {
        let values: Vec<Option<f64>> = series.rows.iter().map(|(row, _)| input.value(&row.steps)).collect();
        page.figure(&input_figure(&format!("{} (input)", input.name), axis, &values)?, "");
    }
    for (entry, name) in names.measurements.iter().enumerate().take(SHOWN_COORDINATES) {
        page.figure(&series.measurement(entry, name)?, "");
    }
    if report.estimates.iter().any(|estimate| !estimate.predictive.is_empty()) {
        page.note("Line and band of a measurement: what was expected of it before it was used.");
        for (entry, name) in names.measurements.iter().enumerate().take(SHOWN_COORDINATES) {
            let places = series.rows.iter().filter_map(|(_, estimate)| estimate.predictive.get(entry)?.pit);
            page.figure(&histogram(&format!("{name}: place among what was expected (pit)"), places)?, "");
        }
        page.note("Places are spread evenly, as the dotted line, where the model is right.");
    }
    if let Some(sizes) = series.of_weights(|estimate| estimate.ess) {
        page.figure(&line_figure("effective sample size", axis, &sizes)?, "");
    }
    if let Some(evidence) = series.of_weights(|estimate| estimate.log_evidence) {
        page.figure(&line_figure("log-evidence of each measurement", axis, &evidence)?, "");
        let mut worst: Vec<usize> = (0..evidence.len()).collect();
        worst.sort_by(|&a, &b| evidence[a].total_cmp(&evidence[b]));
        let cells = worst.into_iter().take(WORST).map(|at| {
            let (row, estimate) = series.rows[at];
            let ess = estimate.ess.map(|ess| format!("{ess:.0}")).unwrap_or_default();
            let label = series.labels[at].unwrap_or_default().to_string();
            vec![row.time.to_string(), label, format!("{:.3}", evidence[at]), ess]
        });
        page.note("The measurements that the model expected least:");
        page.table(&["t", label_column(report), "log-evidence", "effective sample size"], cells);
    }
    Ok(())
}
