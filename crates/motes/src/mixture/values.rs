//! A coordinate of a mixture, of what is known of it at each draw.

use crate::estimate::Coordinate;
use crate::quantiles::Quantiles;

/// Intervals of equal probability that a distribution is cut into.
const INTERVALS: usize = 40;

/// Intervals are not cut below this width, since their middles would not stay distinct next to 1.
const LEAST: f64 = 1e-12;

/// The outermost interval is at most this share of what lies beyond the outermost quantile that is asked for.
const OUTERMOST: f64 = 0.25;

/// Quantiles that stand for the distribution at a draw, each in the middle of an interval and with the probability of this interval.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    quantiles: Quantiles,
    weights: Vec<f64>,
}

impl Grid {
    /// Intervals of equal probability, those at the ends cut in halves until they lie beyond the quantiles that are asked for.
    pub(super) fn for_quantiles(asked: &[f64]) -> Self {
        let outermost = asked.iter().map(|probability| probability.min(1.0 - probability));
        let least = (OUTERMOST * outermost.fold(0.5, f64::min)).max(LEAST);
        let mut ends: Vec<f64> = (1..INTERVALS).map(|at| at as f64 / INTERVALS as f64).collect();
        let mut end = ends[0];
        while end > least {
            end *= 0.5;
            ends.insert(0, end);
            ends.push(1.0 - end);
        }
        ends.insert(0, 0.0);
        ends.push(1.0);
        let intervals = || ends.windows(2).map(|pair| (0.5 * (pair[0] + pair[1]), pair[1] - pair[0]));
        let middles: Option<Quantiles> = Quantiles::new(intervals().map(|(middle, _)| middle).collect());
        let weights = intervals().map(|(_, width)| width).collect();
        Grid { quantiles: middles.unwrap_or_default(), weights }
    }

    /// The quantiles that a filter at a draw is asked for.
    pub(super) fn quantiles(&self) -> &Quantiles {
        &self.quantiles
    }

    /// The weight of each of them.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }
}

/// The coordinate of the mixture of draws with equal weights, each with the values that stand for it: its mean, the standard deviation of all, and the quantiles of all values,
/// of which each draw's have these `weights`, at these probabilities. A quantile is one of the values, so that of counts it is a count.
pub(super) fn mixed(draws: &[&Coordinate], weights: &[f64], probabilities: &[f64]) -> Coordinate {
    let n = draws.len() as f64;
    let mean = draws.iter().map(|draw| draw.mean).sum::<f64>() / n;
    let of_draw = |draw: &&Coordinate| draw.sd * draw.sd + (draw.mean - mean).powi(2);
    let variance = draws.iter().map(of_draw).sum::<f64>() / n;
    let values = draws.iter().flat_map(|draw| draw.quantiles.iter().copied().zip(weights.iter().copied()));
    Coordinate { mean, sd: variance.sqrt(), quantiles: quantiles(values.collect(), probabilities) }
}

/// Quantiles of weighted values; NaN where there is none, or one is NaN.
pub(super) fn quantiles(mut values: Vec<(f64, f64)>, probabilities: &[f64]) -> Vec<f64> {
    if values.is_empty() || values.iter().any(|(value, _)| value.is_nan()) {
        return vec![f64::NAN; probabilities.len()];
    }
    values.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let total: f64 = values.iter().map(|(_, weight)| weight).sum();
    let mut up_to = 0.0;
    let sums: Vec<f64> = values
        .iter()
        .map(|(_, weight)| {
            up_to += weight;
            up_to
        })
        .collect();
    let quantile = |probability: &f64| {
        let at = sums.partition_point(|sum| *sum < probability * total * (1.0 - 1e-12));
        values[at.min(values.len() - 1)].0
    };
    probabilities.iter().map(quantile).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use motes_models::equations::normal_quantile;

    #[test]
    fn a_mixture_of_equal_distributions_has_their_quantiles() {
        let asked = [0.001, 0.01, 0.05, 0.5, 0.95, 0.999];
        let grid = Grid::for_quantiles(&asked);
        assert!((grid.weights().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let quantiles = grid.quantiles().probabilities().iter().copied().map(normal_quantile).collect();
        let draw = Coordinate { mean: 0.0, sd: 1.0, quantiles };
        let found = mixed(&[&draw, &draw], grid.weights(), &asked);
        for (found, probability) in found.quantiles.iter().zip(asked) {
            let right = normal_quantile(probability);
            assert!((found - right).abs() < 0.25, "{probability}: {found} for {right}");
        }
        // However far out the quantiles that are asked for, each has its weight.
        let far = Grid::for_quantiles(&[1e-300, 1.0 - 1e-16]);
        assert_eq!(far.quantiles().probabilities().len(), far.weights().len());
        // Of counts each quantile is a count.
        let counts = grid.quantiles().probabilities().iter().map(|p| f64::from(u8::from(*p > 0.7)));
        let draw = Coordinate { mean: 0.3, sd: 0.46, quantiles: counts.collect() };
        let found = mixed(&[&draw; 3], grid.weights(), &[0.05, 0.69, 0.72, 0.99]);
        assert_eq!(found.quantiles, [0.0, 0.0, 1.0, 1.0]);
    }
}
