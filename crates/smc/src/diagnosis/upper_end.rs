//! Whether the largest log-weights have an upper end, as where particles have reached the peak of a likelihood.

/// Log-weights that are looked at, from 400 on, and below.
const MANY: usize = 20;
const FEW: usize = 10;
const FROM: usize = 400;

/// The index below which there is an upper end in sight: four dimensions of a peak.
pub(super) const UPPER_END: f64 = -0.5;

/// How many of so many log-weights are looked at; none of fewer than 25.
fn count(weights: usize) -> Option<usize> {
    match weights {
        0..25 => None,
        25..FROM => Some(FEW),
        _ => Some(MANY),
    }
}

/// Whether the largest of these log-weights have an upper end in sight; leaves them in another order.
pub(crate) fn has_upper_end(logs: &mut [f64]) -> bool {
    upper_end_within(logs).is_some_and(|index| index < UPPER_END)
}

/// The index `ξ` of the generalised Pareto distribution that fits the largest log-weights, by moments; leaves them in another order.
///
/// The excesses of the largest 20 of them (10 of fewer than 400) above the next have mean `m` and variance `v`; `ξ = ½(1 − m²/v)`. Where log-weights are
/// those of a peak that particles have reached in `d` dimensions, they crowd below it, and `ξ = −2/d`. Where the peak is out of reach they have the tail
/// of a Gaussian, and `ξ` is about 0.
///
/// `None` of fewer than 25, or where they are equal.
pub(crate) fn upper_end_within(logs: &mut [f64]) -> Option<f64> {
    let from = logs.len() - count(logs.len())? - 1;
    logs.select_nth_unstable_by(from, f64::total_cmp);
    of_largest(&logs[from..])
}

/// The same of log-weights whose largest `sorted` ones are at the end, in order.
pub(crate) fn upper_end_of_sorted(logs: &mut [f64], sorted: usize) -> Option<f64> {
    let largest = count(logs.len())? + 1;
    match largest <= sorted {
        true => of_largest(&logs[logs.len() - largest..]),
        false => upper_end_within(logs),
    }
}

/// The index of log-weights of which the first is the least.
fn of_largest(largest: &[f64]) -> Option<f64> {
    let (threshold, n) = (largest[0], (largest.len() - 1) as f64);
    let excesses = || largest[1..].iter().map(|log| log - threshold);
    let mean = excesses().sum::<f64>() / n;
    let variance = excesses().map(|excess| (excess - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let index = 0.5 * (1.0 - mean * mean / variance);
    index.is_finite().then_some(index)
}

#[cfg(test)]
mod tests {
    use motes_models::{Seed, fill_standard_normal};

    use super::*;

    /// The mean index over repetitions of so many log-weights `−½ Σ (x − y)²/r²` of standard normal particles in `d` dimensions.
    fn mean_index(d: usize, y: f64, r: f64) -> f64 {
        const RUNS: u64 = 200;
        let mut x = vec![0.0; 1000 * d];
        let of_run = |run: u64| {
            fill_standard_normal(&mut Seed::from_u64(62).nth(run).stream(), &mut x);
            let log = |row: &[f64]| row.iter().map(|x| -0.5 * ((x - y) / r).powi(2)).sum();
            let mut logs: Vec<f64> = x.chunks_exact(d).map(log).collect();
            upper_end_within(&mut logs).unwrap()
        };
        (0..RUNS).map(of_run).sum::<f64>() / RUNS as f64
    }

    #[test]
    fn a_peak_that_particles_have_reached_has_an_end_and_one_out_of_reach_has_none() {
        // −2/d, to the bias of 20 excesses.
        assert!((-2.6..-1.4).contains(&mean_index(1, 0.3, 0.1)), "{}", mean_index(1, 0.3, 0.1));
        assert!((-1.3..-0.7).contains(&mean_index(2, 0.3, 0.1)), "{}", mean_index(2, 0.3, 0.1));
        assert!((-0.35..0.1).contains(&mean_index(1, 10.0, 1.0)), "{}", mean_index(1, 10.0, 1.0));
    }

    #[test]
    fn sorted_or_not_the_index_is_the_same() {
        let mut logs: Vec<f64> = (0..500).map(|i| -f64::from(i * 37 % 500).powf(1.3)).collect();
        let index = upper_end_within(&mut logs.clone());
        logs.sort_by(f64::total_cmp);
        let sorted = upper_end_of_sorted(&mut logs, 500);
        assert!(index.zip(sorted).is_some_and(|(index, sorted)| (index - sorted).abs() < 1e-12));
        assert_eq!((upper_end_within(&mut [0.0; 24]), upper_end_within(&mut [1.0; 100])), (None, None));
    }
}
