//! The settings of a filter.

use crate::{FilterError, ResampleWhen, Resampling};

/// The settings of a filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterSettings {
    /// `K`, particles in each filter; at least 1.
    pub particles: usize,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// When they are drawn.
    pub resample_when: ResampleWhen,
    /// `α`, the transition's share in a defensive mixture `(1 − α) q + α p(x_t | x_{t−1})` that particles are drawn from instead of
    /// from the proposal `q`; none without such a mixture.
    ///
    /// The transition weighs at most `p(y_t | x_t)/α` against it, so the weights are bounded wherever the likelihood is, however
    /// badly `q` covers the target (Hesterberg 1995).
    pub defensive_weight: Option<f64>,
}

impl FilterSettings {
    /// `K` particles, multinomial resampling when `K_eff < K/3`, no mixture: the paper's filter.
    pub fn new(particles: usize) -> Self {
        FilterSettings {
            particles,
            resampling: Resampling::Multinomial,
            resample_when: ResampleWhen::PAPER,
            defensive_weight: None,
        }
    }

    pub(super) fn check(&self) -> Result<(), FilterError> {
        if self.particles == 0 {
            return Err(FilterError::Setting {
                name: "the number of particles K",
                value: "0".into(),
                expected: "at least 1",
            });
        }
        match self.defensive_weight {
            Some(weight) if !(weight > 0.0 && weight < 1.0) => Err(FilterError::Setting {
                name: "the transition's weight in a defensive mixture",
                value: weight.to_string(),
                expected: "between 0 and 1, both excluded",
            }),
            _ => self.resample_when.check(),
        }
    }
}
