//! Whether the largest log-weights have an upper end, as where particles have reached the peak of a likelihood.

/// Log-weights that are looked at, from 400 on, and below.
const MANY: usize = 20;
const FEW: usize = 10;
const FROM: usize = 400;

/// The index below which there is an upper end in sight: four dimensions of a peak.
pub(super) const UPPER_END: f64 = -0.5;

/// Whether the largest of these log-weights have an upper end in sight; leaves them in another order.
pub(crate) fn has_upper_end(logs: &mut [f64]) -> bool {
    upper_end_index(logs).is_some_and(|index| index < UPPER_END)
}

/// The index `ξ` of the generalised Pareto distribution that fits the largest log-weights, by moments.
///
/// The excesses of the largest 20 of them (10 of fewer than 400) above the next have mean `m` and variance `v`; `ξ = ½(1 − m²/v)`. Where log-weights are
/// those of a peak that particles have reached in `d` dimensions, they crowd below it, and `ξ = −2/d`. Where the peak is out of reach they have the tail
/// of a Gaussian, and `ξ` is about 0.
///
/// `None` of fewer than 25, or where they are equal.
pub(crate) fn upper_end_index(logs: &mut [f64]) -> Option<f64> {
    let count = if logs.len() >= FROM { MANY } else { FEW };
    if logs.len() < 25 {
        return None;
    }
    let (_, &mut threshold, top) = logs.select_nth_unstable_by(logs.len() - count - 1, f64::total_cmp);
    let n = count as f64;
    let mean = top.iter().map(|log| log - threshold).sum::<f64>() / n;
    let variance = top.iter().map(|log| (log - threshold - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let index = 0.5 * (1.0 - mean * mean / variance);
    index.is_finite().then_some(index)
}
