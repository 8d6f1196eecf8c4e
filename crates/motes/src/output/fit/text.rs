//! A fit for a person.

use crate::fitting::PosteriorFit;
use crate::output::table::{Table, markdown};

/// Four significant digits, or powers of ten where nobody could read so many zeros.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let before = size.log10().floor() as i32;
    format!("{value:.*}", (3 - before).max(0) as usize)
}

/// The posterior of each parameter: mean, standard deviation, quantiles, and how far they can be trusted.
pub fn fit_text(fitted: &PosteriorFit) -> String {
    markdown(&fit_figures(fitted))
}

/// The same as cells.
pub(in crate::output) fn fit_figures(fitted: &PosteriorFit) -> Table {
    let header = ["", "mean", "sd", "5 %", "50 %", "95 %", "R̂", "ESS bulk", "ESS tail", "error of mean"];
    let rows = fitted.names.iter().zip(&fitted.parameters).map(|(name, summary)| {
        let of = [summary.mean, summary.sd, summary.q05, summary.q50, summary.q95].map(digits);
        let sizes = [summary.ess_bulk, summary.ess_tail].map(|size| format!("{size:.0}"));
        let mut cells = vec![name.clone()];
        cells.extend(of);
        cells.push(format!("{:.3}", summary.rhat));
        cells.extend(sizes);
        cells.push(digits(summary.mcse));
        cells
    });
    Table { header: header.map(String::from).to_vec(), rows: rows.collect() }
}

/// The figures of the whole fit, a name and a value each.
pub fn fit_summary(fitted: &PosteriorFit) -> Vec<(String, String)> {
    let error = |error: f64| if error == 0.0 { ", exact".to_string() } else { format!(" ± {error:.3}") };
    let mut figures = vec![
        ("draws", format!("{} of each of {} chains", fitted.draws(), fitted.chains.len())),
        (
            "log-likelihood at the mean",
            format!("{:.3}{}", fitted.log_likelihood, error(fitted.log_likelihood_error)),
        ),
    ];
    if let Some(marginal) = fitted.marginal_likelihood {
        let text = format!("{:.3} ± {:.3}", marginal.log, marginal.standard_error);
        figures.push(("log marginal likelihood", text));
    }
    let [walk, independent] = fitted.acceptance.map(|share| format!("{:.0} %", 100.0 * share));
    figures.push(("moves made", format!("{walk} of the walk, {independent} of independent ones")));
    figures.push(("likelihood", likelihood(fitted)));
    figures.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// How the likelihood was had.
fn likelihood(fitted: &PosteriorFit) -> String {
    if fitted.proposal == "exact" {
        return "exact".into();
    }
    let variance = match fitted.variance.is_finite() {
        true => format!(", variance of its logarithm {:.2}", fitted.variance),
        false => String::new(),
    };
    format!("{} particles, {}{variance}", fitted.particles, fitted.proposal)
}
