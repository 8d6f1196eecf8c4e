//! Counts of which few are expected: the number of probabilities that a uniform number goes beyond.

/// From this mean on counts are drawn by rejection.
pub(super) const MANY: f64 = 50.0;

/// More than so many are never seen where fewer than [`MANY`] are expected: a probability of 1e-60.
pub(super) const MOST: usize = 230;

/// Takes probabilities off uniform numbers as long as something is left, and counts how many. `probability` has those of 0; that of `k` is that of `k − 1` times
/// `ratio(k, 1/k, particle)`.
#[inline(always)]
pub(super) fn count_up<const W: usize>(
    mut rest: [f64; W],
    mut probability: [f64; W],
    ratio: impl Fn(f64, f64, usize) -> f64,
) -> [f64; W] {
    let mut count = [0.0; W];
    for k in 1..=MOST {
        let (k, inverse) = (k as f64, 1.0 / k as f64);
        let mut any = false;
        for i in 0..W {
            // What is below 0 stays there, since no probability is.
            rest[i] -= probability[i];
            let is_beyond = rest[i] >= 0.0;
            count[i] += if is_beyond { 1.0 } else { 0.0 };
            probability[i] *= ratio(k, inverse, i);
            any |= is_beyond;
        }
        if !any {
            break;
        }
    }
    count
}
