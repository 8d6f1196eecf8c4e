//! A coordinate of a mixture, of what is known of it at each draw.

use motes_models::equations::normal_quantile;

use crate::estimate::Coordinate;
use crate::quantiles::PROBABILITIES;

/// The quantiles of each draw that stand for its distribution: in the middles of intervals of equal probability.
const POINTS: usize = 40;

/// Their probabilities.
pub(super) fn probabilities() -> Vec<f64> {
    (0..POINTS).map(|at| (at as f64 + 0.5) / POINTS as f64).collect()
}

/// Values of equal weight of a distribution of which the quantiles at 5, 50 and 95 % are known: in between, and beyond, they go on as those of normal distributions.
pub(super) fn of_quantiles(quantiles: &[f64]) -> Vec<f64> {
    let &[low, middle, high] = quantiles else { return vec![f64::NAN; POINTS] };
    let end = normal_quantile(PROBABILITIES[2]);
    let at = |probability: f64| {
        let z = normal_quantile(probability) / end;
        middle + z.abs() * if z < 0.0 { low - middle } else { high - middle }
    };
    probabilities().into_iter().map(at).collect()
}

/// A coordinate at one draw.
#[derive(Debug, Clone)]
pub(super) struct AtDraw {
    pub(super) mean: f64,
    pub(super) sd: f64,
    /// Values of equal weight.
    pub(super) values: Vec<f64>,
}

/// The coordinate of the mixture of draws with equal weights: its mean, the standard deviation of all, and the quantiles of all values at these
/// probabilities.
pub(super) fn mixed(draws: &[&AtDraw], probabilities: &[f64]) -> Coordinate {
    let n = draws.len() as f64;
    let mean = draws.iter().map(|draw| draw.mean).sum::<f64>() / n;
    let of_draw = |draw: &&AtDraw| draw.sd * draw.sd + (draw.mean - mean).powi(2);
    let variance = draws.iter().map(of_draw).sum::<f64>() / n;
    let mut values: Vec<f64> = draws.iter().flat_map(|draw| draw.values.iter().copied()).collect();
    // As many values of each draw: they have equal weights.
    values.sort_by(f64::total_cmp);
    let quantile = |probability: f64| {
        let at = probability * values.len() as f64 - 0.5;
        let below = at.floor().max(0.0) as usize;
        let above = (below + 1).min(values.len() - 1);
        values[below] + (at - below as f64).clamp(0.0, 1.0) * (values[above] - values[below])
    };
    let quantiles = match values.is_empty() || values.iter().any(|value| value.is_nan()) {
        true => vec![f64::NAN; probabilities.len()],
        false => probabilities.iter().copied().map(quantile).collect(),
    };
    Coordinate { mean, sd: variance.sqrt(), quantiles }
}
