//! Averages of evidence that is given by its logarithms.

/// The logarithm of the average of these, given by their logarithms, and the share that each has of their sum.
pub(super) fn average(logarithms: &[f64]) -> (f64, Vec<f64>) {
    let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = logarithms.iter().map(|logarithm| (logarithm - largest).exp()).collect();
    let total: f64 = weights.iter().sum();
    let shares = weights.iter().map(|weight| weight / total).collect();
    (largest + (total / logarithms.len() as f64).ln(), shares)
}

/// The standard error of the logarithm of the average: at most 1, which is where one has all of the evidence.
pub(super) fn standard_error(logarithms: &[f64]) -> f64 {
    let count = logarithms.len() as f64;
    let (_, shares) = average(logarithms);
    let square: f64 = shares.iter().map(|share| (share * count - 1.0).powi(2)).sum();
    (square / (count * (count - 1.0))).sqrt()
}
