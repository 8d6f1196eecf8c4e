//! Weighted quantiles, by sorting the few particles near each.

/// Bins that particles are counted in: enough for few to share one, few enough to stay near.
const BINS: usize = 256;

/// As few particles as are sorted at once.
const FEW: usize = 64;

/// Bins are cut into bins so often. Where particles still share one then, they are sorted.
const DEPTH: usize = 4;

/// For each probability `p` the smallest of `values` that those with a share of at least `p` of the weight do not exceed; NaN where none has weight.
pub(super) fn quantiles(values: &[f64], weights: &[f64], probabilities: &[f64]) -> Vec<f64> {
    // The shares of the whole, which rounding leaves a hair beside 1, that are looked for; then what is found.
    let mut wanted: Vec<QuantileTarget> =
        probabilities.iter().map(|share| QuantileTarget { share: *share, found: f64::NAN }).collect();
    find(values, weights, Whole::Unknown, &mut wanted.iter_mut().collect::<Vec<_>>(), DEPTH);
    wanted.into_iter().map(|wanted| wanted.found).collect()
}

struct QuantileTarget {
    share: f64,
    found: f64,
}

/// How much weight there is in all, and how much of it is of smaller values than those that are looked at.
#[derive(Clone, Copy)]
enum Whole {
    Unknown,
    Known { sum: f64, below: f64 },
}

fn find(values: &[f64], weights: &[f64], whole: Whole, wanted: &mut [&mut QuantileTarget], depth: usize) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    // A particle without weight has no part in it, wherever it is.
    for (value, weight) in values.iter().zip(weights) {
        let counts = *weight > 0.0;
        low = if counts && *value < low { *value } else { low };
        high = if counts && *value > high { *value } else { high };
    }
    let scale = BINS as f64 / (high - low);
    // Of equal values, and of some that are infinite, there is no scale.
    if values.len() <= FEW || depth == 0 || !(scale > 0.0 && scale.is_finite()) {
        return sort(values, weights, whole, wanted);
    }
    let bin_of = |value: f64| (((value - low) * scale) as usize).min(BINS - 1);
    let mut of_bins = [0.0; BINS];
    for (value, weight) in values.iter().zip(weights) {
        of_bins[bin_of(*value)] += weight;
    }
    let (sum, below) = match whole {
        Whole::Unknown => (of_bins.iter().sum(), 0.0),
        Whole::Known { sum, below } => (sum, below),
    };
    let mut asked: Vec<(usize, f64, Vec<&mut QuantileTarget>)> = Vec::with_capacity(wanted.len());
    for wanted in wanted.iter_mut() {
        let (bin, below) = bin_with(&of_bins, below, wanted.share * sum);
        match asked.iter_mut().find(|(other, ..)| *other == bin) {
            Some((.., others)) => others.push(wanted),
            None => asked.push((bin, below, vec![wanted])),
        }
    }
    let mut is_asked = [false; BINS];
    asked.iter().for_each(|(bin, ..)| is_asked[*bin] = true);
    let near: Vec<usize> = (0..values.len()).filter(|at| is_asked[bin_of(values[*at])]).collect();
    for (bin, below, mut wanted) in asked {
        let of_bin = || near.iter().copied().filter(|at| bin_of(values[*at]) == bin);
        let (values, weights): (Vec<f64>, Vec<f64>) = of_bin().map(|at| (values[at], weights[at])).unzip();
        find(&values, &weights, Whole::Known { sum, below }, &mut wanted, depth - 1);
    }
}

/// The first bin up to which so much weight lies, and the weight below it; the last one with weight if there is none.
fn bin_with(of_bins: &[f64; BINS], mut below: f64, target: f64) -> (usize, f64) {
    let mut last = (0, below);
    for (bin, weight) in of_bins.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
        last = (bin, below);
        below += weight;
        if below >= target {
            break;
        }
    }
    last
}

/// [`find`] by sorting all that have weight.
fn sort(values: &[f64], weights: &[f64], whole: Whole, wanted: &mut [&mut QuantileTarget]) {
    let mut pairs: Vec<(f64, f64)> = values.iter().copied().zip(weights.iter().copied()).collect();
    pairs.retain(|(_, weight)| *weight > 0.0);
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (sum, mut below) = match whole {
        Whole::Unknown => (pairs.iter().map(|(_, weight)| weight).sum(), 0.0),
        Whole::Known { sum, below } => (sum, below),
    };
    for (_, weight) in &mut pairs {
        below += *weight;
        *weight = below;
    }
    for wanted in wanted {
        let at = pairs.partition_point(|(_, cumulative)| *cumulative < wanted.share * sum);
        wanted.found = pairs.get(at.min(pairs.len().saturating_sub(1))).map_or(f64::NAN, |(value, _)| *value);
    }
}

#[cfg(test)]
mod tests {
    use motes_models::{Seed, fill_standard_normal, fill_uniform};

    use super::*;

    const SHARES: [f64; 7] = [0.0, 0.05, 0.5, 0.5, 0.95, 0.9999, 1.0];

    /// By the definition: the first value, in order, up to which there is enough weight. A share may be missed by rounding.
    fn is_quantile(values: &[f64], weights: &[f64], share: f64, found: f64) -> bool {
        let sum: f64 = weights.iter().sum();
        let up_to = |is_counted: &dyn Fn(f64) -> bool| -> f64 {
            values.iter().zip(weights).filter(|(x, _)| is_counted(**x)).map(|(_, weight)| weight).sum()
        };
        let slack = 1e-12 * sum;
        let is_there = values.iter().zip(weights).any(|(x, weight)| *x == found && *weight > 0.0);
        is_there
            && up_to(&|x| x <= found) >= share * sum - slack
            && up_to(&|x| x < found) <= share * sum + slack
    }

    fn check(values: &[f64], weights: &[f64]) {
        for (share, found) in SHARES.into_iter().zip(quantiles(values, weights, &SHARES)) {
            assert!(
                is_quantile(values, weights, share, found),
                "{found} for {share} of {} values",
                values.len()
            );
        }
    }

    #[test]
    fn quantiles_are_those_of_the_definition_whatever_the_values_are() {
        let mut stream = Seed::from_u64(91).stream();
        for count in [1, 2, 63, 64, 65, 300, 5000] {
            let (mut normals, mut weights) = (vec![0.0; count], vec![0.0; count]);
            fill_standard_normal(&mut stream, &mut normals);
            fill_uniform(&mut stream, &mut weights);
            // A third has no weight, some of it far away.
            let kinds: [&dyn Fn(usize, f64) -> f64; 6] = [
                &|_, z| z,
                &|_, z| (20.0 * z).exp(),
                &|_, z| z.round(),
                &|_, _| 3.0,
                &|at, z| if at % 3 == 0 { f64::INFINITY } else { z },
                &|at, z| if at % 5 == 1 { 1e300 * z } else { 1e-300 * z },
            ];
            weights.iter_mut().skip(1).step_by(3).for_each(|weight| *weight *= 1e-9);
            if count > 1 {
                weights.iter_mut().step_by(3).for_each(|weight| *weight = 0.0);
            }
            for kind in kinds {
                let values: Vec<f64> = normals.iter().enumerate().map(|(at, z)| kind(at, *z)).collect();
                if count > 1 || values[0].is_finite() {
                    check(&values, &weights);
                }
            }
        }
    }

    #[test]
    fn without_weight_there_is_none() {
        assert!(quantiles(&[1.0; 100], &[0.0; 100], &[0.5])[0].is_nan());
        assert!(quantiles(&[], &[], &[0.5])[0].is_nan());
        assert_eq!(quantiles(&[7.0, f64::NAN], &[1.0, 0.0], &[0.0, 1.0]), [7.0, 7.0]);
    }
}
