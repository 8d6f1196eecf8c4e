//! Filters at draws of the posterior.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use motes_inference::map_on_threads;
use motes_smc::{Predictive, WeightReport};

use super::draw::options_of_draw;
use super::values::{Grid, mixed};
use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate, Forecast};
use crate::filtered::Filtered;
use crate::filtering::{measured, of_series};
use crate::model::Model;
use crate::options::FilterOptions;
use crate::rows_ahead::{check_ahead, rows_ahead};
use crate::tally::{SeriesTally, Tally};
use crate::warning::Warning;

/// Filters in doubt at a smaller share of the draws change little of what is averaged over them.
const FEW: f64 = 0.5;

/// States given data alone, parameters drawn from their posterior.
#[derive(Debug, Clone, PartialEq)]
pub struct PosteriorEstimates {
    /// The estimate of each row of the data, in their order; it has no effective sample size and no evidence.
    pub estimates: Vec<Estimate>,
    /// What is predicted after the last measurement of each series.
    pub forecasts: Vec<Vec<Forecast>>,
    /// The number of draws.
    pub draws: usize,
    /// Reasons not to trust the estimates.
    pub warnings: Vec<Warning>,
}

impl PosteriorEstimates {
    /// The same as what one filter of so many series made of data: an average has no log-evidence, which is NaN here, and no weights.
    pub fn into_filtered(self, series: usize) -> Filtered {
        Filtered {
            estimates: self.estimates,
            forecasts: self.forecasts,
            log_evidence_per_series: vec![f64::NAN; series],
            standard_error_per_series: vec![None; series],
            exact_log_evidence_per_series: vec![None; series],
            weights: WeightReport::default(),
            least_ess: None,
            warnings: self.warnings,
            opinions: vec![None; series],
            particles: vec![],
        }
    }
}

/// What a filter at one draw says of a row of the data, or of one that is predicted: each coordinate of the state, and each entry of the measurement, where it is expected, with the quantiles of a
/// grid.
#[derive(Default)]
struct EstimateAtDraw {
    state: Vec<Coordinate>,
    expected: Vec<Predictive>,
}

/// What it predicts of a row after a series.
struct AheadAtDraw {
    time: f64,
    label: Option<String>,
    is_given: bool,
    estimate: EstimateAtDraw,
}

/// What filters at one draw say: of each row of the data, and of those that are predicted after each series.
struct DrawEstimates {
    rows: Vec<EstimateAtDraw>,
    ahead: Vec<Vec<AheadAtDraw>>,
    /// What is to be said of forecasts.
    warnings: Vec<Warning>,
    /// Reasons not to trust the filter.
    doubts: Vec<Warning>,
}

/// Filters `data` with the model at each draw ([`FitParameters::spread`](crate::FitParameters::spread)), and mixes what they say: `p(x_t | y_{0:t})` with parameters
/// drawn from `p(θ | y_{0:T−1})`, all of the data that were fitted. `proceed` is asked after each row, with how many rows of all draws are done.
///
/// # Errors
/// As [`crate::filter`].
pub fn filter_draws(
    draws: &[Model],
    data: &Data,
    options: &FilterOptions,
    proceed: &(dyn Fn(usize) -> ControlFlow<()> + Sync),
) -> Result<PosteriorEstimates, MotesError> {
    let done = AtomicUsize::new(0);
    let proceed = || proceed(done.fetch_add(1, Ordering::Relaxed) + 1);
    let grid = Grid::for_quantiles(options.quantiles.probabilities());
    let at_grid = FilterOptions { quantiles: grid.quantiles().clone(), ..options.clone() };
    let all = map_on_threads(draws, |number, model| at_draw(model, number, data, &at_grid, &proceed));
    let all = all.into_iter().collect::<Result<Vec<DrawEstimates>, MotesError>>()?;
    let probabilities = options.quantiles.probabilities();
    let estimates = (0..data.rows.len()).map(|row| {
        let draws: Vec<&EstimateAtDraw> = all.iter().map(|draw| &draw.rows[row]).collect();
        over_draws(&draws, &grid, probabilities)
    });
    let ahead = |series: usize| {
        let first = all.first().map_or(&[][..], |draw| draw.ahead[series].as_slice());
        let forecast = |(row, first): (usize, &AheadAtDraw)| {
            let rows = all.iter().map(|draw| &draw.ahead[series][row].estimate);
            let estimate = over_draws(&rows.collect::<Vec<&EstimateAtDraw>>(), &grid, probabilities);
            Forecast { time: first.time, label: first.label.clone(), is_given: first.is_given, estimate }
        };
        first.iter().enumerate().map(forecast).collect()
    };
    Ok(PosteriorEstimates {
        estimates: estimates.collect(),
        forecasts: (0..data.series.len()).map(ahead).collect(),
        draws: draws.len(),
        // Those of forecasts are the same at all draws.
        warnings: data
            .warnings()
            .into_iter()
            .chain(all.first().into_iter().flat_map(|draw| draw.warnings.clone()))
            .chain(of_doubts(&all))
            .collect(),
    })
}

/// What is said where filters at some of the draws are not to be trusted: at how many, and why the first.
fn of_doubts(draws: &[DrawEstimates]) -> Option<Warning> {
    let in_doubt: Vec<&Warning> = draws.iter().filter_map(|draw| draw.doubts.first()).collect();
    let first = *in_doubt.first()?;
    let text = format!(
        "at {} of {} draws of the parameters the filter is not to be trusted; the first: {}",
        in_doubt.len(),
        draws.len(),
        first.text
    );
    (in_doubt.len() as f64 >= FEW * draws.len() as f64)
        .then(|| Warning { series: first.series.clone(), text })
}

/// A row over all draws, of equal weights, with quantiles at these probabilities.
fn over_draws(draws: &[&EstimateAtDraw], grid: &Grid, probabilities: &[f64]) -> Estimate {
    let coordinate = |at: usize| {
        let of_draws: Vec<&Coordinate> = draws.iter().map(|draw| &draw.state[at]).collect();
        mixed(&of_draws, grid.weights(), probabilities)
    };
    let entry = |at: usize| {
        let of_draws: Vec<&Predictive> = draws.iter().map(|draw| &draw.expected[at]).collect();
        let expected: Vec<Coordinate> = of_draws
            .iter()
            .map(|of| Coordinate { mean: of.mean, sd: of.sd, quantiles: of.quantiles.clone() })
            .collect();
        let Coordinate { mean, sd, quantiles } =
            mixed(&expected.iter().collect::<Vec<&Coordinate>>(), grid.weights(), probabilities);
        // The distribution function of a mixture is the mean of those that are mixed.
        let pit = of_draws.iter().map(|of| of.pit).sum::<Option<f64>>();
        Predictive { mean, sd, quantiles, pit: pit.map(|sum| sum / of_draws.len() as f64) }
    };
    let (n, m) = draws.first().map_or((0, 0), |draw| (draw.state.len(), draw.expected.len()));
    Estimate {
        predictive: (0..m).map(entry).collect(),
        ..Estimate::of_state((0..n).map(coordinate).collect())
    }
}

fn at_draw(
    model: &Model,
    number: usize,
    data: &Data,
    options: &FilterOptions,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<DrawEstimates, MotesError> {
    let options = options_of_draw(options, number);
    let at_draw =
        |estimate: Estimate| EstimateAtDraw { state: estimate.state, expected: estimate.predictive };
    check_ahead(&options, data)?;
    let mut rows: Vec<EstimateAtDraw> = data.rows.iter().map(|_| EstimateAtDraw::default()).collect();
    let (mut ahead, mut warnings) = (Vec::new(), Vec::new());
    let mut tally = Tally::new(vec![]);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut running = Running::new(model, &options, series)?;
        let mut of_this = SeriesTally::new(model, &options);
        for &at in &places {
            let row = &data.rows[at];
            let (estimate, diagnosis) = running
                .step_and_diagnose(&row.steps, &row.measurement)
                .map_err(|error| error.at_row(&data.source, name, row.line))?;
            tally.step(&mut of_this, &row.steps, &row.measurement, diagnosis.as_ref());
            rows[at] = at_draw(estimate);
            if proceed().is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        let before = data.steps_before(series);
        let at = |step: usize| measured(model, data, places[step.saturating_sub(before)]);
        tally.end_series(name, &of_this, &running, at);
        let (mut of_series_ahead, mut clock) = (Vec::new(), data.clocks[series].clone());
        for row in rows_ahead(&options, name, places.len())? {
            let forecast = running.predict_by(&mut clock, row).map_err(|error| of_series(name, error))?;
            let Forecast { time, label, is_given, estimate } = forecast;
            of_series_ahead.push(AheadAtDraw { time, label, is_given, estimate: at_draw(estimate) });
        }
        ahead.push(of_series_ahead);
        warnings.extend(running.forecast_warning(name));
    }
    let doubts = tally.into_filtered(vec![], vec![]).warnings;
    Ok(DrawEstimates { rows, ahead, warnings, doubts })
}
