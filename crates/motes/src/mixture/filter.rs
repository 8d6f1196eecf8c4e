//! Filters at draws of the posterior.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::values::{AtDraw, mixed, probabilities};
use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::{Estimate, Forecast};
use crate::filtering::{of_series, rows_ahead};
use crate::model::Model;
use crate::options::FilterOptions;
use crate::warning::Warning;

/// States given data alone, parameters drawn from their posterior.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixed {
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

/// What filters at one draw say: of each row of the data, and of those that are predicted after each series, with their times.
struct DrawEstimates {
    rows: Vec<RowAtDraw>,
    ahead: Vec<Vec<(f64, RowAtDraw)>>,
}

/// Filters `data` with the model at each draw ([`FittedDraws::spread`](crate::FittedDraws::spread)), and mixes what they say: `p(x_t | y_{0:t})` with parameters
/// drawn from `p(θ | y_{0:T−1})`, all of the data that were fitted. `proceed` is asked after each row, with how many rows of all draws are done.
///
/// # Errors
/// As [`crate::filter`].
pub fn filter_draws(
    draws: &[Model],
    data: &Data,
    options: &FilterOptions,
    proceed: &(dyn Fn(usize) -> ControlFlow<()> + Sync),
) -> Result<Mixed, MotesError> {
    let done = AtomicUsize::new(0);
    let proceed = || proceed(done.fetch_add(1, Ordering::Relaxed) + 1);
    let all = of_all(draws, 0, &|number, model| at_draw(model, number, data, options, &proceed));
    let all = all.into_iter().collect::<Result<Vec<DrawEstimates>, MotesError>>()?;
    let state = |rows: &[&RowAtDraw]| {
        let n = rows.first().map_or(0, |row| row.len());
        let of = |at: usize| mixed(&rows.iter().map(|row| &row[at]).collect::<Vec<&AtDraw>>());
        Estimate { state: (0..n).map(of).collect(), ess: None, log_evidence: None }
    };
    let estimates = (0..data.rows.len())
        .map(|row| state(&all.iter().map(|draw| &draw.rows[row]).collect::<Vec<&RowAtDraw>>()));
    let ahead = |series: usize| {
        let count = all.first().map_or(0, |draw| draw.ahead[series].len());
        let forecast = |row: usize| {
            let rows: Vec<&RowAtDraw> = all.iter().map(|draw| &draw.ahead[series][row].1).collect();
            Forecast { time: all[0].ahead[series][row].0, estimate: state(&rows) }
        };
        (0..count).map(forecast).collect()
    };
    Ok(Mixed {
        estimates: estimates.collect(),
        forecasts: (0..data.series.len()).map(ahead).collect(),
        draws: draws.len(),
        warnings: data.warnings(),
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
    let options = FilterOptions { check: false, seed, ..options.clone() };
    let coordinates = |running: &Running<'_>, estimate: &Estimate| {
        let of = |(at, of): (usize, &crate::estimate::Coordinate)| AtDraw {
            mean: of.mean,
            sd: of.sd,
            values: running.quantiles(at, &probabilities),
        };
        estimate.state.iter().enumerate().map(of).collect::<RowAtDraw>()
    };
    let (mut rows, mut ahead) = (vec![Vec::new(); data.rows.len()], Vec::new());
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
            of_series_ahead.push((forecast.time, coordinates(&running, &forecast.estimate)));
        }
        ahead.push(of_series_ahead);
    }
    Ok(DrawEstimates { rows, ahead })
}
