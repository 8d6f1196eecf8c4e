//! The defensive share of proposals of noise.

use motes_models::equations::Draw;

use super::log_add::log_add_all;

/// `α` where some draw is not normal.
const SHARE: f64 = 0.1;

/// The share `α` of `N(0, I)` that a proposal of the noise of these draws has where nobody says another: 0.1 where some draw is not normal, else 0.
///
/// With it no weight is above `1/α` times the likelihood. A Gaussian of noise may be too narrow where a count is the same for all noise beyond a number, or where states
/// are not linear in their noise.
pub fn noise_share(draws: &[Draw]) -> f64 {
    if draws.iter().all(|draw| *draw == Draw::Normal) { 0.0 } else { SHARE }
}

/// Replaces `r = log q/p` of each draw by its log-weight `log p/q` where `q` is given a share `α` of `p`: `−log((1 − α) eʳ + α)`.
pub fn weigh_with_share(log_ratios: &mut [f64], share: f64) {
    if share == 0.0 {
        return log_ratios.iter_mut().for_each(|ratio| *ratio = -*ratio);
    }
    let (log_proposal, log_share) = ((-share).ln_1p(), share.ln());
    log_add_all(log_ratios, log_proposal, |_| log_share, 0.0);
    log_ratios.iter_mut().for_each(|ratio| *ratio = -*ratio);
}
