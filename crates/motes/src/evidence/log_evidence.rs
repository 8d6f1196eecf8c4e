//! The log-evidence of data and nothing else: what who tries many parameters asks for.

use std::ops::ControlFlow;

use motes_smc::FilterError;

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::FilterOptions;
use crate::warning::Warning;

/// What filters say of data but for states.
#[derive(Debug, Clone, PartialEq)]
pub struct LogEvidence {
    /// The estimate of `log p(y)` of all series; −∞ where no particle explains a measurement.
    pub value: f64,
    /// Where that was, with row and series.
    pub impossible: Option<Warning>,
}

/// The estimate of `log p(y)` of all series of `data`, as [`filter`](crate::filter) has it and to the same last bit, without estimates, forecasts and a second
/// opinion. `proceed` is asked after each row, with how many rows are done.
///
/// Where no particle explains a measurement, the estimate of the evidence is 0, and its logarithm −∞. That is no error: a search over parameters goes on
/// elsewhere, and an estimate of 0 is as unbiased as any other, which is what particle MCMC needs.
///
/// ```
/// use motes::{Data, FilterOptions, Model, log_evidence};
/// use std::ops::ControlFlow;
///
/// let text = "[parameters]\nw = 1\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"uniform(x - w, x + w)\"\n";
/// let evidence = |w: f64| -> Result<f64, Box<dyn std::error::Error>> {
///     let model = Model::parse(text, "walk", &[("w".into(), w)])?;
///     let data = Data::read("y\n0\n30\n".as_bytes(), "y.csv", &model)?;
///     Ok(log_evidence(&model, &data, &FilterOptions::default(), |_| ControlFlow::Continue(()))?.value)
/// };
/// assert!(evidence(40.0)?.is_finite());
/// assert_eq!(evidence(0.1)?, f64::NEG_INFINITY);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`filter`](crate::filter), but for measurements that no particle explains.
pub fn log_evidence(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<LogEvidence, MotesError> {
    log_evidence_until(model, data, options, &mut proceed)
}

/// [`log_evidence`], compiled once whatever asks.
fn log_evidence_until(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<LogEvidence, MotesError> {
    let options = FilterOptions { check: false, predictive: false, forecast: 0, ..options.clone() };
    let (mut per_series, mut done) = (Vec::new(), 0);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name);
        let mut running = Running::new(model, &options, series)?;
        for &at in &places {
            let row = &data.rows[at];
            if let Err(error) = running.advance_by(&row.steps, &row.measurement) {
                if !matches!(running.filter.failure(), Some(FilterError::Collapse { .. })) {
                    return Err(error.at_row(&data.source, name.map(String::as_str), row.line));
                }
                let at = data.source.row(None, row.line);
                let text = format!("{at}, {error}; the log-evidence is −∞");
                let impossible = Some(Warning { series: name.cloned(), text });
                return Ok(LogEvidence { value: f64::NEG_INFINITY, impossible });
            }
            done += 1;
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        per_series.push(running.log_evidence());
    }
    Ok(LogEvidence { value: per_series.iter().sum(), impossible: None })
}
