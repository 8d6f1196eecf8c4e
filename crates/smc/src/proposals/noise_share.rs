//! The defensive share of proposals of noise.

use motes_models::equations::Draw;

/// `α` where some draw is not normal.
const SHARE: f64 = 0.1;

/// The share `α` of `N(0, I)` that a proposal of the noise of these draws has where nobody says another: 0.1 where some draw is not normal, else 0.
///
/// With it no weight is above `1/α` times the likelihood. A Gaussian of noise may be too narrow where a count is the same for all noise beyond a number, or where states
/// are not linear in their noise.
pub fn noise_share(draws: &[Draw]) -> f64 {
    if draws.iter().all(|draw| *draw == Draw::Normal) { 0.0 } else { SHARE }
}

/// `−log((1 − α) eʳ + α)`: what `log p/q` is of a draw for which `r = log q/p`, if `q` is given a share `α` of `p`.
pub fn log_weight_with_share(ratio: f64, share: f64) -> f64 {
    if share == 0.0 {
        return -ratio;
    }
    let (a, b) = (ratio + (-share).ln_1p(), share.ln());
    let largest = a.max(b);
    -(largest + ((a - largest).exp() + (b - largest).exp()).ln())
}
