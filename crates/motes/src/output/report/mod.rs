//! The report: one HTML file with figures, that needs nothing else.

mod card;
mod error_figure;
mod figures;
mod page;
mod style;

pub use card::{CardReport, card_report};
pub use error_figure::error_figure;

use crate::data::Data;
use crate::estimate::{Estimate, Forecast};
use crate::names::ModelNames;

use figures::{Band, band_figure, line_figure, point_figure};
use page::Page;

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
    page.table(&["", ""], report.summary.iter().map(|(name, value)| vec![name.clone(), value.clone()]));
    page.warnings(report.warnings);
    for (series, name) in report.data.series.iter().enumerate().take(SHOWN_SERIES) {
        if report.data.columns.has_series() {
            page.heading(&format!("Series {name}"));
        }
        series_section(&mut page, report, series)?;
    }
    if report.data.series.len() > SHOWN_SERIES {
        page.note(&format!(
            "{SHOWN_SERIES} of {} series are shown; the table has all of them.",
            report.data.series.len()
        ));
    }
    page.heading("Settings");
    page.table(&["", ""], report.settings.iter().map(|(name, value)| vec![name.clone(), value.clone()]));
    page.command(report.command);
    Ok(page.finish())
}

fn series_section(
    page: &mut Page,
    report: &Report<'_>,
    series: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    let rows = || {
        let all = report.data.rows.iter().zip(report.estimates);
        all.filter(move |(row, _)| row.series == series)
    };
    let length = rows().count();
    let ahead = report.forecasts.get(series).map_or(&[][..], Vec::as_slice);
    let estimates: Vec<&Estimate> =
        rows().map(|(_, estimate)| estimate).chain(ahead.iter().map(|ahead| &ahead.estimate)).collect();
    for (coordinate, name) in report.names.states.iter().enumerate().take(SHOWN_COORDINATES) {
        let of = |figure: &dyn Fn(&crate::estimate::Coordinate) -> f64| -> Vec<f64> {
            estimates.iter().map(|estimate| figure(&estimate.state[coordinate])).collect()
        };
        let band =
            Band { low: of(&|c| c.quantiles[0]), high: of(&|c| c.quantiles[2]), middle: of(&|c| c.mean) };
        let measured = report.names.measurements.iter().position(|measured| measured == name);
        let points: Vec<Option<f64>> = match measured {
            Some(at) => rows().map(|(row, _)| row.measurement[at]).collect(),
            None => vec![],
        };
        page.figure(&band_figure(name, &band, length, &points)?, "");
    }
    if report.names.states.len() > SHOWN_COORDINATES {
        page.note(&format!("{SHOWN_COORDINATES} of {} states are shown.", report.names.states.len()));
    }
    let forecast = if ahead.is_empty() { "" } else { " After the dotted line: forecast." };
    page.note(&format!("Line: mean. Band: from the 5 % to the 95 % quantile.{forecast}"));
    for (at, name) in report.names.measurements.iter().enumerate().take(SHOWN_COORDINATES) {
        let points: Vec<Option<f64>> = rows().map(|(row, _)| row.measurement[at]).collect();
        page.figure(&point_figure(&format!("{name} (measured)"), &points)?, "");
    }
    let of_weights = |figure: fn(&Estimate) -> Option<f64>| -> Option<Vec<f64>> {
        rows().map(|(_, estimate)| figure(estimate)).collect()
    };
    if let Some(sizes) = of_weights(|estimate| estimate.ess) {
        page.figure(&line_figure("effective sample size", &sizes)?, "");
    }
    if let Some(evidence) = of_weights(|estimate| estimate.log_evidence) {
        page.figure(&line_figure("log-evidence of each measurement", &evidence)?, "");
        let mut worst: Vec<usize> = (0..evidence.len()).collect();
        worst.sort_by(|&a, &b| evidence[a].total_cmp(&evidence[b]));
        let cells = worst.into_iter().take(WORST).filter_map(|at| {
            let (row, estimate) = rows().nth(at)?;
            let ess = estimate.ess.map(|ess| format!("{ess:.0}")).unwrap_or_default();
            let label = row.label.clone().unwrap_or_default();
            Some(vec![row.time.to_string(), label, format!("{:.3}", evidence[at]), ess])
        });
        page.note("The measurements that the model expected least:");
        let label = report.data.columns.carried().unwrap_or_default();
        page.table(&["t", label, "log-evidence", "effective sample size"], cells);
    }
    Ok(())
}
