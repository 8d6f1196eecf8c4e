//! Bounds of probabilities, which spare logarithms of factorials.

/// Bounds of `log p(k)/p(m)` of binomial counts, and of those of Poisson, which are their limit, at a distance from the mode, up to half of the variance less 1: the squeeze of Kachitvichyanukul and Schmeiser (Communications of the ACM 31, 1988).
#[inline(always)]
pub(super) fn squeeze(away: f64, variance: f64) -> [f64; 2] {
    let inverse = 1.0 / variance;
    let middle = -0.5 * away * away * inverse;
    let width = away * inverse * ((away * (away * (1.0 / 3.0) + 0.625) + 1.0 / 6.0) * inverse + 0.5);
    [middle - width, middle + width]
}
