//! Sums of numbers that are known by their logarithms.

/// `log(eᵃ + eᵇ)`; −∞ where both are.
#[inline(always)]
pub(crate) fn log_add(a: f64, b: f64) -> f64 {
    let largest = a.max(b);
    match largest == f64::NEG_INFINITY {
        true => largest,
        false => largest + ((a - largest).exp() + (b - largest).exp()).ln(),
    }
}
