//! The Rauch–Tung–Striebel smoother: exact beliefs given all measurements.

use faer::Side;
use faer::prelude::Solve;

use super::belief::{Belief, symmetric};
use super::filter::Filtered;
use crate::{LinearGaussian, ModelError};

/// `p(x_t | y_{0:T−1})` at every time.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// One belief for each time.
    pub beliefs: Vec<Belief>,
}

/// Runs backward over the filter's beliefs.
///
/// `J_t = P_t Aᵀ (P⁻_{t+1})⁻¹`, `mˢ_t = m_t + J_t (mˢ_{t+1} − m⁻_{t+1})`,
/// `Pˢ_t = P_t + J_t (Pˢ_{t+1} − P⁻_{t+1}) J_tᵀ`.
///
/// # Errors
/// [`ModelError::Numerical`] with the time if a predicted covariance cannot be factored, or if a belief is not finite.
pub fn smooth(model: &LinearGaussian, filtered: &Filtered) -> Result<Smoothed, ModelError> {
    let steps = &filtered.steps;
    let mut beliefs: Vec<Belief> = steps.last().map(|step| step.filtered.clone()).into_iter().collect();
    for time in (0..steps.len().saturating_sub(1)).rev() {
        let (now, next) = (&steps[time].filtered, &steps[time + 1].predicted);
        // Beliefs are pushed from the end of time; the last one is always that of time + 1.
        let later = &beliefs[beliefs.len() - 1];
        let factored = next.covariance.llt(Side::Lower).map_err(|error| ModelError::Numerical {
            computation: "factoring a predicted covariance",
            time: time + 1,
            reason: format!("{error:?}"),
        })?;
        let gain = factored.solve(model.transition_matrix() * &now.covariance).transpose().to_owned();
        let mean = &now.mean + &gain * (&later.mean - &next.mean);
        let correction = &gain * (&later.covariance - &next.covariance) * gain.transpose();
        let smoothed = Belief { mean, covariance: symmetric(&now.covariance + correction) };
        beliefs.push(smoothed.check("smoothing a belief", time)?);
    }
    beliefs.reverse();
    Ok(Smoothed { beliefs })
}
