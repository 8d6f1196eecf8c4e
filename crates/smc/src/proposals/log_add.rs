//! Sums of numbers that are known by their logarithms.

use motes_models::batch::{LANES, by_widest_vectors};
use motes_models::equations::{Lanes, Scalar};

/// What is smaller by this much in the logarithm adds nothing to a sum. Exponentials of less are slow.
pub(crate) const NEGLIGIBLE: f64 = -699.0;

/// `log(eᵃ + eᵇ)`; −∞ where both are.
#[inline(always)]
pub(crate) fn log_add(a: f64, b: f64) -> f64 {
    let largest = a.max(b);
    match largest == f64::NEG_INFINITY {
        true => largest,
        false => largest + ((a - largest).exp() + (b - largest).exp()).ln(),
    }
}

/// Replaces each `a` by `log(eᵃ⁺ᵘ + eᵇ⁺ᵛ)` for the `b` of its place, in vector instructions; −∞ where both are, and NaN where one is.
pub(crate) fn log_add_all(a: &mut [f64], u: f64, b: impl Fn(usize) -> f64, v: f64) {
    by_widest_vectors(
        #[inline(always)]
        || {
            for (number, a) in a.chunks_mut(LANES).enumerate() {
                let (mut largest, mut gap) = (Lanes([0.0; LANES]), Lanes([0.0; LANES]));
                for (lane, a) in a.iter().enumerate() {
                    let (a, b) = (a + u, b(number * LANES + lane) + v);
                    let less = -(a - b).abs();
                    largest.0[lane] = if a > b { a } else { b };
                    // Both infinite, too: their difference is no number.
                    gap.0[lane] = if less > NEGLIGIBLE { less } else { NEGLIGIBLE };
                    largest.0[lane] = if a.is_nan() { a } else { largest.0[lane] };
                }
                let Lanes(sum) = largest + (gap.exp() + 1.0).ln();
                a.copy_from_slice(&sum[..a.len()]);
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn side_by_side_as_one_by_one() {
        let numbers = [-f64::INFINITY, -1e300, -800.0, -1.5, 0.0, 3.0, 800.0];
        for first in numbers {
            let mut sums = numbers.repeat(6);
            log_add_all(&mut sums, 0.25, |_| first, -0.5);
            for (sum, second) in sums.iter().zip(numbers.iter().cycle()) {
                let expected = log_add(second + 0.25, first - 0.5);
                assert!(
                    *sum == expected || (sum - expected).abs() < 1e-15 * expected.abs().max(1.0),
                    "{sum} {expected}"
                );
            }
        }
        for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN)] {
            let mut sum = [a];
            log_add_all(&mut sum, 0.0, |_| b, 0.0);
            assert!(sum[0].is_nan(), "{a}, {b}");
        }
    }
}
