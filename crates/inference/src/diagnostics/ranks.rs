//! Draws by their ranks.

use motes_models::equations::normal_quantile;

/// The normal scores of all draws of all chains, `Φ⁻¹((r − 3/8)/(S + 1/4))` with `r` the rank among all `S`, the mean one of ties.
pub(super) fn normal_scores(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (chain, draws) in chains.iter().enumerate() {
        order.extend(draws.iter().enumerate().map(|(at, value)| (*value, chain, at)));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = order.len() as f64;
    let mut scores: Vec<Vec<f64>> = chains.iter().map(|draws| vec![0.0; draws.len()]).collect();
    let mut before = 0;
    for ties in order.chunk_by(|a, b| a.0 == b.0) {
        let rank = before as f64 + (ties.len() as f64 + 1.0) / 2.0;
        let score = normal_quantile((rank - 0.375) / (count + 0.25));
        ties.iter().for_each(|(_, chain, at)| scores[*chain][*at] = score);
        before += ties.len();
    }
    scores
}

/// The distances of all draws from the median of all.
pub(super) fn folded(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let median = quantile(&sorted(chains), 0.5);
    chains.iter().map(|draws| draws.iter().map(|value| (value - median).abs()).collect()).collect()
}

/// All draws in order.
pub(super) fn sorted(chains: &[Vec<f64>]) -> Vec<f64> {
    let mut all: Vec<f64> = chains.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    all
}

/// A quantile of sorted numbers, linear between them.
pub(super) fn quantile(sorted: &[f64], probability: f64) -> f64 {
    let at = probability * (sorted.len() - 1) as f64;
    let (below, share) = (at.floor() as usize, at.fract());
    match sorted.get(below + 1) {
        Some(above) if share > 0.0 => sorted[below] + share * (above - sorted[below]),
        _ => sorted[below],
    }
}
