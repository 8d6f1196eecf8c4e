//! A fit as a page.

use super::estimates::{Report, all_series};
use super::page::Page;
use super::posterior_figures::{marginal_figure, pair_figure, rank_figure, trace_figure};
use super::style::Drawn;
use crate::fitting::PosteriorFit;
use crate::output::fit::{fit_figures, fit_summary};
use crate::output::table::Table;

/// Parameters and pairs of them that are shown.
const SHOWN: usize = 12;
const SHOWN_PAIRS: usize = 6;

/// Pairs whose correlation is smaller are not worth a figure, where others are shown.
const CORRELATED: f64 = 0.2;

/// What a page of a fit shows.
pub struct FitReport<'a> {
    /// The model's name.
    pub model: &'a str,
    /// What was found.
    pub fitted: &'a PosteriorFit,
    /// The data, filtered over the posterior, with what was expected of measurements where that was asked for.
    pub states: Option<Report<'a>>,
    /// Settings, a name and a value each.
    pub settings: &'a [(String, String)],
    /// The command that made the report.
    pub command: &'a str,
}

/// The fit as HTML: its table, the posterior of each parameter beside its prior, its chains, and the pairs that go together.
///
/// # Errors
/// What the drawing library says.
pub fn fit_report(report: &FitReport<'_>) -> Result<String, Box<dyn std::error::Error>> {
    let fitted = report.fitted;
    let mut page = Page::new(&format!("Parameters of {}", report.model));
    page.pairs(&fit_summary(fitted));
    let warnings: Vec<String> = fitted.warnings.iter().map(ToString::to_string).collect();
    page.warnings(&warnings);
    page.heading("Posterior");
    let Table { header, rows: cells } = fit_figures(fitted);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(&header, cells.into_iter());
    page.note("Bars: draws of the posterior. Line: the prior, where it can be seen beside it. Right: the draws of each chain.");
    let chains: Vec<Vec<Vec<f64>>> = (0..fitted.names.len()).map(|at| fitted.of_parameter(at)).collect();
    let pooled: Vec<Vec<f64>> = chains.iter().map(|chains| chains.concat()).collect();
    for (at, name) in fitted.names.iter().enumerate().take(SHOWN) {
        let prior = fitted.prior_quantiles.get(at).map_or(&[][..], Vec::as_slice);
        page.figure(&(marginal_figure(name, &pooled[at], prior)? + &trace_figure(name, &chains[at])?), "");
    }
    if fitted.names.len() > SHOWN {
        page.note(&format!(
            "{SHOWN} of {} parameters are shown; draws.csv has all of them.",
            fitted.names.len()
        ));
    }
    let pairs = pairs(&pooled);
    if !pairs.is_empty() {
        page.heading("Parameters that go together");
    }
    for (i, j, correlation) in pairs {
        let names = [fitted.names[i].as_str(), fitted.names[j].as_str()];
        page.figure(&pair_figure(names, &pooled[i], &pooled[j])?, &format!("Correlation {correlation:.2}."));
    }
    page.heading("Chains beside each other");
    let shown: Vec<usize> = (0..fitted.names.len().min(SHOWN)).collect();
    for beside in shown.chunks(2) {
        let figures = beside.iter().map(|at| rank_figure(&fitted.names[*at], &chains[*at]));
        page.figure(&figures.collect::<Drawn<String>>()?, "");
    }
    page.note("How many draws of each chain lie in each twentieth of all draws in order: where chains agree, they keep near the dotted line.");
    if let Some(states) = &report.states {
        page.heading("States and measurements over the posterior");
        all_series(&mut page, states)?;
    }
    page.heading("Settings");
    page.pairs(report.settings);
    page.command(report.command);
    Ok(page.finish())
}

/// The pairs of parameters with the largest correlations, and these.
fn pairs(draws: &[Vec<f64>]) -> Vec<(usize, usize, f64)> {
    let all = (0..draws.len()).flat_map(|i| (i + 1..draws.len()).map(move |j| (i, j)));
    let mut found: Vec<(usize, usize, f64)> =
        all.map(|(i, j)| (i, j, correlation(&draws[i], &draws[j]))).collect();
    found.retain(|pair| pair.2.abs() >= CORRELATED);
    found.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    found.truncate(SHOWN_PAIRS);
    found
}

fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (of_x, of_y) = (mean(x), mean(y));
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| x.iter().zip(y).map(|(x, y)| of(x - of_x, y - of_y)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}
