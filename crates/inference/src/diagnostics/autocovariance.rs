//! The effective number of draws of chains that remember where they were.

/// Sums of squares between and within chains of `n` draws each.
pub(super) struct Variances {
    /// `W`, the mean of the variances within chains.
    pub(super) within: f64,
    /// `var⁺ = (n − 1)/n · W + B/n`.
    pub(super) total: f64,
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Those of chains of one length, at least two draws each.
pub(super) fn variances(chains: &[Vec<f64>]) -> Variances {
    let n = chains[0].len() as f64;
    let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
    let of_chain = |(chain, mean): (&Vec<f64>, &f64)| {
        chain.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)
    };
    let within = chains.iter().zip(&means).map(of_chain).sum::<f64>() / chains.len() as f64;
    let grand = mean(&means);
    let between_over_n = match means.len() {
        1 => 0.0,
        count => means.iter().map(|mean| (mean - grand).powi(2)).sum::<f64>() / (count as f64 - 1.0),
    };
    Variances { within, total: within * (n - 1.0) / n + between_over_n }
}

/// The effective sample size of chains of one length, by the initial monotone sequence of Geyer (1992); at most `S log₁₀ S` of all `S` draws.
pub(super) fn effective_sample_size(chains: &[Vec<f64>]) -> f64 {
    let (n, count) = (chains[0].len(), (chains.len() * chains[0].len()) as f64);
    let Variances { within, total } = variances(chains);
    // Chains that stand still, or draws that are all the same.
    if total.is_nan() || total <= 0.0 {
        return f64::NAN;
    }
    let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
    let autocovariance = |lag: usize| {
        let of_chain = |(chain, mean): (&Vec<f64>, &f64)| {
            let products = chain[..n - lag].iter().zip(&chain[lag..]).map(|(a, b)| (a - mean) * (b - mean));
            products.sum::<f64>() / n as f64
        };
        chains.iter().zip(&means).map(of_chain).sum::<f64>() / chains.len() as f64
    };
    let correlation = |lag: usize| match lag {
        0 => 1.0,
        _ => 1.0 - (within - autocovariance(lag)) / total,
    };
    let (mut sum, mut least, mut lag) = (0.0, f64::INFINITY, 0);
    while lag + 1 < n {
        let pair = correlation(lag) + correlation(lag + 1);
        if pair < 0.0 || pair.is_nan() {
            break;
        }
        least = least.min(pair);
        sum += least;
        lag += 2;
    }
    let time = (2.0 * sum - 1.0).max(1.0 / count.log10());
    count / time
}
