//! Filters at draws of the posterior.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use motes_smc::Predictive;

use super::values::{AtDraw, mixed, of_quantiles, probabilities};
use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate, Forecast};
use crate::filtering::of_series;
use crate::forecasting::rows_ahead;
use crate::model::Model;
use crate::options::FilterOptions;
use crate::warning::Warning;

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

/// What a filter at one draw says of a row: each coordinate.
type RowAtDraw = Vec<AtDraw>;

/// What a filter at one draw predicts of a row after a series: each coordinate of the state, and each entry of the measurement.
struct AheadAtDraw {
    time: f64,
    label: Option<String>,
    state: RowAtDraw,
    measurement: RowAtDraw,
}

/// What filters at one draw say: of each row of the data, and of those that are predicted after each series.
struct DrawEstimates {
    rows: Vec<RowAtDraw>,
    ahead: Vec<Vec<AheadAtDraw>>,
    /// What is to be said of forecasts.
    warnings: Vec<Warning>,
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
    let all = of_all(draws, 0, &|number, model| at_draw(model, number, data, options, &proceed));
    let all = all.into_iter().collect::<Result<Vec<DrawEstimates>, MotesError>>()?;
    let state = |rows: &[&RowAtDraw]| {
        let n = rows.first().map_or(0, |row| row.len());
        let of = |at: usize| mixed(&rows.iter().map(|row| &row[at]).collect::<Vec<&AtDraw>>());
        (0..n).map(of).collect::<Vec<Coordinate>>()
    };
    let estimates = (0..data.rows.len()).map(|row| {
        Estimate::of_state(state(&all.iter().map(|draw| &draw.rows[row]).collect::<Vec<&RowAtDraw>>()))
    });
    let ahead = |series: usize| {
        let first = all.first().map_or(&[][..], |draw| draw.ahead[series].as_slice());
        let forecast = |(row, first): (usize, &AheadAtDraw)| {
            let rows: Vec<&AheadAtDraw> = all.iter().map(|draw| &draw.ahead[series][row]).collect();
            let states: Vec<&RowAtDraw> = rows.iter().map(|row| &row.state).collect();
            let entries: Vec<&RowAtDraw> = rows.iter().map(|row| &row.measurement).collect();
            let of_entry = |Coordinate { mean, sd, quantiles }| Predictive { mean, sd, quantiles, pit: None };
            let predictive = state(&entries).into_iter().map(of_entry).collect();
            let estimate = Estimate { predictive, ..Estimate::of_state(state(&states)) };
            Forecast { time: first.time, label: first.label.clone(), estimate }
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
            .collect(),
    })
}

/// What `work` makes of each, on all threads.
fn of_all<R: Send>(draws: &[Model], first: usize, work: &(impl Fn(usize, &Model) -> R + Sync)) -> Vec<R> {
    match draws {
        [] => vec![],
        [one] => vec![work(first, one)],
        _ => {
            let half = draws.len() / 2;
            let (mut done, rest) = rayon_core::join(
                || of_all(&draws[..half], first, work),
                || of_all(&draws[half..], first + half, work),
            );
            done.extend(rest);
            done
        }
    }
}

fn at_draw(
    model: &Model,
    number: usize,
    data: &Data,
    options: &FilterOptions,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<DrawEstimates, MotesError> {
    let probabilities = probabilities();
    let seed = options.seed.wrapping_add((number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let options = FilterOptions { check: false, predictive: false, seed, ..options.clone() };
    let coordinates = |running: &Running<'_>, estimate: &Estimate| {
        let of = |(at, of): (usize, &Coordinate)| AtDraw {
            mean: of.mean,
            sd: of.sd,
            values: running.quantiles(at, &probabilities),
        };
        estimate.state.iter().enumerate().map(of).collect::<RowAtDraw>()
    };
    let (mut rows, mut ahead, mut warnings) = (vec![Vec::new(); data.rows.len()], Vec::new(), Vec::new());
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut running = Running::new(model, &options, series)?;
        for at in places {
            let row = &data.rows[at];
            let estimate = running
                .step_by(&row.steps, &row.measurement)
                .map_err(|error| of_series(name, error.at_row(data.counted, row.line)))?;
            rows[at] = coordinates(&running, &estimate);
            if proceed().is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        let (mut of_series_ahead, mut clock) = (Vec::new(), data.clocks[series].clone());
        for row in rows_ahead(&options, name) {
            let forecast = running.predict_by(&mut clock, row).map_err(|error| of_series(name, error))?;
            let state = coordinates(&running, &forecast.estimate);
            let of_entry =
                |of: &Predictive| AtDraw { mean: of.mean, sd: of.sd, values: of_quantiles(of.quantiles) };
            let measurement = forecast.estimate.predictive.iter().map(of_entry).collect();
            let (time, label) = (forecast.time, forecast.label);
            of_series_ahead.push(AheadAtDraw { time, label, state, measurement });
        }
        ahead.push(of_series_ahead);
        warnings.extend(running.forecast_warning(name));
    }
    Ok(DrawEstimates { rows, ahead, warnings })
}
