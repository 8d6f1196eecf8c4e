//! Sums of numbers of which the logarithms are known.

use crate::equations::scalar::Scalar;

/// `log(eᵃ + eᵇ)`.
pub(super) fn log_sum<S: Scalar>(a: S, b: S) -> S {
    S::custom(
        [a, b],
        |[a, b]| log_sum_of(a, b),
        |[a, b], sum| if sum == f64::NEG_INFINITY { [0.0; 2] } else { [(a - sum).exp(), (b - sum).exp()] },
    )
}

/// [`log_sum`] of plain numbers.
pub(super) fn log_sum_of(a: f64, b: f64) -> f64 {
    let (large, small) = if a > b { (a, b) } else { (b, a) };
    // Infinite ones have no difference.
    if large.is_infinite() && !small.is_nan() { large } else { large + (small - large).exp().ln_1p() }
}
