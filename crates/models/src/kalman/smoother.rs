//! The fixed-interval smoother of de Jong (1989): exact beliefs given all measurements.

use faer::{Col, Mat};

use super::belief::{Belief, symmetric};
use super::filter::Filtered;
use crate::ModelError;

/// `p(x_t | y_{0:T−1})` at every time.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// One belief for each time.
    pub beliefs: Vec<Belief>,
}

/// Runs backward over the filter's steps: what all later measurements say of `x_t` is a vector `r_t` and a matrix `N_t`, and no covariance is inverted, so that
/// states may have coordinates without noise.
///
/// With `m⁻, P⁻` the prediction, `S` the innovation covariance, `v` the innovation and `G` the gain of a measurement `C x_t + d + w_t`:
///
/// - `r_t = Cᵀ S⁻¹ v + (I − G C)ᵀ A_{t+1}ᵀ r_{t+1}`
/// - `N_t = Cᵀ S⁻¹ C + (I − G C)ᵀ A_{t+1}ᵀ N_{t+1} A_{t+1} (I − G C)`
/// - `mˢ_t = m⁻_t + P⁻_t r_t`, `Pˢ_t = P⁻_t − P⁻_t N_t P⁻_t`
///
/// # Errors
/// [`ModelError::Numerical`] with the time if a belief is not finite.
pub fn smooth(filtered: &Filtered) -> Result<Smoothed, ModelError> {
    let steps = &filtered.steps;
    let n = steps.first().map_or(0, |step| step.predicted.mean.nrows());
    let (mut score, mut information) = (Col::<f64>::zeros(n), Mat::<f64>::zeros(n, n));
    let mut beliefs: Vec<Belief> = Vec::with_capacity(steps.len());
    for (time, step) in steps.iter().enumerate().rev() {
        if let Some(update) = &step.update {
            let kept = update.kept.transpose();
            score = &update.score + kept * &score;
            information = symmetric(&update.information + kept * &information * &update.kept);
        }
        let Belief { mean, covariance } = &step.predicted;
        let smoothed = Belief {
            mean: mean + covariance * &score,
            covariance: symmetric(covariance - covariance * &information * covariance),
        };
        beliefs.push(smoothed.check("smoothing a belief", time)?);
        if let Some(a) = &step.transition {
            score = a.transpose() * &score;
            information = symmetric(a.transpose() * &information * a);
        }
    }
    beliefs.reverse();
    Ok(Smoothed { beliefs })
}
