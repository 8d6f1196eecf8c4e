//! Smoothers at draws of the posterior.

use std::ops::ControlFlow;

use super::draw::options_of_draw;
use super::filter::PosteriorEstimates;
use super::values::quantiles;
use crate::data::Data;
use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate};
use crate::model::Model;
use crate::options::FilterOptions;
use crate::smoothing::smooth_until;

/// Smooths `data` with the model at each draw, `paths` trajectories in all and at least one of each, and puts all trajectories together: `p(x_t | y_{0:T−1})` whatever the
/// parameters are. `proceed` is asked with the share of the work that is done.
///
/// # Errors
/// As [`crate::smooth`].
pub fn smooth_draws(
    draws: &[Model],
    data: &Data,
    options: &FilterOptions,
    paths: usize,
    mut proceed: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<PosteriorEstimates, MotesError> {
    let each = paths.div_ceil(draws.len().max(1));
    let n = draws.first().map_or(0, |model| model.states().len());
    let mut rows: Vec<Vec<Vec<f64>>> = vec![vec![Vec::new(); n]; data.rows.len()];
    let mut warnings = data.warnings();
    for (number, model) in draws.iter().enumerate() {
        let options = options_of_draw(options, number);
        let mut proceed = |share: f64| proceed((number as f64 + share) / draws.len() as f64);
        let smoothed = smooth_until(model, data, &options, each, false, &mut proceed)?;
        for (paths, places) in smoothed.paths.iter().zip(data.by_series()) {
            for path in 0..paths.len() {
                for (state, row) in paths.path(path).chunks_exact(n).zip(&places) {
                    rows[*row].iter_mut().zip(state).for_each(|(values, value)| values.push(*value));
                }
            }
        }
        // The same of each draw is said once.
        for warning in smoothed.filtered.warnings {
            if !warnings.contains(&warning) && warnings.len() < MOST_WARNINGS {
                warnings.push(warning);
            }
        }
    }
    let estimate = |row: &Vec<Vec<f64>>| {
        let coordinate = |values: &Vec<f64>| {
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
            let weighted = values.iter().map(|value| (*value, 1.0)).collect();
            let quantiles = quantiles(weighted, options.quantiles.probabilities());
            Coordinate { mean, sd: variance.sqrt(), quantiles }
        };
        Estimate::of_state(row.iter().map(coordinate).collect())
    };
    let estimates = rows.iter().map(estimate).collect();
    Ok(PosteriorEstimates {
        estimates,
        forecasts: vec![vec![]; data.series.len()],
        draws: draws.len(),
        warnings,
    })
}

/// Warnings of smoothers that are passed on.
const MOST_WARNINGS: usize = 5;
