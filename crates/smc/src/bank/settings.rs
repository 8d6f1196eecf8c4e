//! The settings of a filter.

use motes_models::batch::there_is_memory_for;
use serde::{Deserialize, Serialize};

use crate::error::FilterError;
use crate::resampling::{ResampleWhen, Resampling};

/// The settings of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FilterSettings {
    /// `K`, particles in each filter; at least 1.
    pub particles: usize,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// When they are drawn.
    pub resample_when: ResampleWhen,
    /// `α`, the transition's share in a defensive mixture `(1 − α) q + α p(x_t | x_{t−1})` that particles are drawn from instead of
    /// from the proposal `q`. Where none is given there is no such mixture, but for a proposal of noise that has a share of its own
    /// ([`noise_share`](crate::noise_share)), which 0 takes away.
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

    /// Checks the settings of `filters` filters of states of width `n`: how many particles they have together, and how many coordinates.
    pub(super) fn check_bank(
        &self,
        filters: usize,
        n: usize,
        memory: usize,
    ) -> Result<(usize, usize), FilterError> {
        self.check()?;
        if filters == 0 {
            return Err(FilterError::Setting {
                name: "the number of filters in a bank",
                value: "0".into(),
                expected: "at least 1",
            });
        }
        let rows = filters.checked_mul(self.particles);
        let values = rows.and_then(|rows| rows.checked_mul(n)).filter(|values| *values > 0);
        match rows.zip(values).filter(|(rows, values)| can_be_stored(*rows, *values, memory)) {
            Some(sizes) => Ok(sizes),
            None => Err(FilterError::Setting {
                name: "the number of values in a bank, filters × particles × N",
                value: format!("{filters} × {} × {n}", self.particles),
                expected: "at least 1 and as many as there is memory for",
            }),
        }
    }

    fn check(&self) -> Result<(), FilterError> {
        if self.particles == 0 {
            return Err(FilterError::Setting {
                name: "the number of particles K",
                value: "0".into(),
                expected: "at least 1",
            });
        }
        match self.defensive_weight {
            Some(weight) if !(0.0..1.0).contains(&weight) => Err(FilterError::Setting {
                name: "the transition's weight in a defensive mixture",
                value: weight.to_string(),
                expected: "from 0 to below 1",
            }),
            _ => self.resample_when.check(),
        }
    }
}

/// Whether there is memory for states now and before, for the seven numbers that a bank keeps of each particle beside them, and for what a
/// proposal does.
fn can_be_stored(rows: usize, values: usize, memory: usize) -> bool {
    let beside = memory.checked_add(7).and_then(|numbers| rows.checked_mul(numbers));
    let numbers = values.checked_mul(2).zip(beside).and_then(|(a, b)| a.checked_add(b));
    numbers.is_some_and(there_is_memory_for)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_there_is_memory_for_is_refused() {
        assert_eq!(FilterSettings::new(10).check_bank(3, 2, 0), Ok((30, 60)));
        let said = FilterSettings::new(1 << 50).check_bank(1, 1, 0).unwrap_err().to_string();
        assert_eq!(
            said,
            "the number of values in a bank, filters × particles × N is 1 × 1125899906842624 × 1; it must be at least 1 and as many as \
             there is memory for"
        );
        assert!(
            FilterSettings::new(10).check_bank(3, 2, 1 << 50).is_err(),
            "a proposal may need more than states do"
        );
    }
}
