//! Smoothing all series of some data by backward simulation.

use std::ops::ControlFlow;

use motes_models::Seed;
use motes_smc::{FilterHistory, SmoothedPaths, SmoothingError, WeightReport};

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate, PROBABILITIES};
use crate::filtering::{Filtered, of_opinion, of_proposal, of_series};
use crate::model::Model;
use crate::options::FilterOptions;
use crate::warning::Warning;

/// What smoothers made of data.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// The estimate of each row of the data given all rows of its series, in their order.
    pub estimates: Vec<Estimate>,
    /// The trajectories of each series.
    pub paths: Vec<SmoothedPaths>,
    /// What the filters said on the way, without their estimates.
    pub filtered: Filtered,
}

/// Filters each series of `data` and draws `paths` trajectories of it backwards; `proceed` is asked after each row, and now and then while they
/// are drawn, with how many rows are done.
///
/// # Errors
/// As [`crate::filter`]; [`MotesError::Setting`] if what filters were cannot be kept.
pub fn smooth(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    paths: usize,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Smoothed, MotesError> {
    smooth_until(model, data, options, paths, &mut proceed)
}

/// [`smooth`], compiled once whatever asks.
fn smooth_until(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    paths: usize,
    proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Smoothed, MotesError> {
    let mut estimates: Vec<Option<Estimate>> = vec![None; data.rows.len()];
    let (mut drawn, mut log_evidence_per_series, mut opinions) = (vec![], vec![], vec![]);
    let mut warnings: Vec<Warning> = of_proposal(options).into_iter().chain(data.warnings()).collect();
    let (mut weights, mut least_ess, mut done) = (WeightReport::default(), f64::INFINITY, 0);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then(|| name.clone());
        let mut running = Running::new(model, options, series)?;
        let (mut report, mut history) = (WeightReport::default(), FilterHistory::new());
        for &at in &places {
            let advanced = running.advance(&data.rows[at].measurement);
            advanced.map_err(|error| {
                of_series(name.as_deref(), error.at_row(data.counted, data.rows[at].line))
            })?;
            running.record(&mut history)?;
            let diagnosis = running.diagnosis();
            report.add(&diagnosis);
            weights.add(&diagnosis);
            least_ess = least_ess.min(running.effective_sample_size());
            done += 1;
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        let seed = Seed::from_u64(options.seed).child("smooth").nth(series as u64);
        let verdict = running.verdict();
        let label = |time: usize| places.get(time).and_then(|at| data.rows[*at].label.as_deref());
        warnings.extend(of_opinion(name.as_deref(), verdict, label));
        opinions.push(verdict);
        let found = running.backward(&history, paths, &seed, &mut || proceed(done))?;
        for (time, at) in places.into_iter().enumerate() {
            estimates[at] = Some(estimate(&found, time, model.states().len()));
        }
        log_evidence_per_series.push(running.log_evidence());
        warnings.extend(
            report.warnings().map(|warning| Warning { series: name.clone(), text: warning.to_string() }),
        );
        drawn.push(found);
    }
    let estimates = estimates.into_iter().flatten().collect();
    let filtered = Filtered {
        estimates: vec![],
        forecasts: vec![],
        log_evidence_per_series,
        weights,
        least_ess,
        warnings,
        opinions,
    };
    Ok(Smoothed { estimates, paths: drawn, filtered })
}

/// What trajectories say of one time.
fn estimate(paths: &SmoothedPaths, time: usize, n: usize) -> Estimate {
    let of_coordinate = |coordinate| {
        let quantiles = paths.quantiles(time, coordinate, &PROBABILITIES);
        Coordinate {
            mean: paths.mean(time, coordinate),
            sd: paths.standard_deviation(time, coordinate),
            quantiles: [quantiles[0], quantiles[1], quantiles[2]],
        }
    };
    Estimate { state: (0..n).map(of_coordinate).collect(), ess: None, log_evidence: None }
}

impl From<SmoothingError> for MotesError {
    fn from(error: SmoothingError) -> Self {
        match error {
            SmoothingError::Interrupted => MotesError::Interrupted,
            error => MotesError::Setting(error.to_string()),
        }
    }
}
