//! One of a few integers, in proportion to shares.

use rand::RngExt;

use crate::Stream;
use crate::equations::family::Score;
use crate::equations::scalar::Scalar;

/// By how much shares may differ from 1 in sum.
const MOST_OFF: f64 = 1e-6;

/// The sum of all shares; NaN where it is not 1, or a share is negative.
fn total<S: Scalar>(shares: &[S]) -> S {
    let mut total = S::from(0.0);
    let mut least = S::from(0.0);
    for share in shares {
        total = total + *share;
        least = least.min(*share);
    }
    let nothing = S::from(f64::NAN);
    let right = ((total - 1.0).abs() - MOST_OFF).where_positive(nothing, total);
    (-least).where_positive(nothing, right)
}

/// `log p(y)`: of 0, 1, … the share of that number; −∞ elsewhere, NaN where the shares are none.
pub(super) fn log_density<S: Scalar>(shares: &[S], y: S) -> S {
    let total = total(shares);
    let mut found = S::from(f64::NEG_INFINITY) + total * 0.0;
    for (number, share) in shares.iter().enumerate() {
        found = (y - number as f64).abs().where_positive(found, (*share / total).ln());
    }
    found
}

/// Mean and variance as those of a normal number.
pub(super) fn score<S: Scalar>(shares: &[S], y: S) -> Score<S> {
    let total = total(shares);
    let (mut mean, mut square) = (S::from(0.0), S::from(0.0));
    for (number, share) in shares.iter().enumerate() {
        let (share, number) = (*share / total, number as f64);
        mean = mean + share * number;
        square = square + share * (number * number);
    }
    let information = S::from(1.0) / (square - mean * mean);
    Score { location: mean, slope: (y - mean) * information, information }
}

/// A draw; NaN where the shares are none.
pub(super) fn sample<S>(shares: &[S], of: &impl Fn(&S) -> f64, stream: &mut Stream) -> f64 {
    let all: f64 = shares.iter().map(of).sum();
    let is_wrong = (all - 1.0).abs() > MOST_OFF || all.is_nan() || shares.iter().any(|share| of(share) < 0.0);
    let reached = stream.random::<f64>() * all;
    if is_wrong {
        return f64::NAN;
    }
    let mut below = 0.0;
    let beyond = |share: &S| {
        below += of(share);
        below <= reached
    };
    // The last one with a share takes what rounding leaves.
    let number = shares.iter().map(beyond).take_while(|is_beyond| *is_beyond).count();
    let last = shares.iter().rposition(|share| of(share) > 0.0).unwrap_or(0);
    number.min(last) as f64
}
