//! Log-weights as they are written down.

use serde::{Deserialize, Serialize};

use super::sums::Sums;
use super::{BLOCK, LogWeights};

/// All of [`LogWeights`] but what an update computes in.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredWeights {
    log: Vec<f64>,
    normalised: Vec<f64>,
    effective_sample_size: f64,
    equal: bool,
}

impl From<LogWeights> for StoredWeights {
    fn from(weights: LogWeights) -> Self {
        let LogWeights { log, normalised, effective_sample_size, equal, blocks: _ } = weights;
        StoredWeights { log, normalised, effective_sample_size, equal }
    }
}

impl TryFrom<StoredWeights> for LogWeights {
    type Error = String;

    fn try_from(stored: StoredWeights) -> Result<Self, String> {
        let StoredWeights { log, normalised, effective_sample_size, equal } = stored;
        if log.len() != normalised.len() {
            return Err(format!("{} log-weights and {} weights", log.len(), normalised.len()));
        }
        let blocks = vec![Sums::default(); log.len().div_ceil(BLOCK)];
        Ok(LogWeights { log, normalised, effective_sample_size, equal, blocks })
    }
}

impl LogWeights {
    /// Whether they are weights that a filter can go on from: none is negative or NaN, and they sum to 1.
    pub(crate) fn can_be_gone_on_from(&self) -> bool {
        let sum: f64 = self.normalised.iter().sum();
        let are_weights = self.normalised.iter().all(|weight| *weight >= 0.0);
        let are_logs = self.log.iter().all(|log| *log < f64::INFINITY);
        are_weights && are_logs && (sum - 1.0).abs() < 1e-6 && self.effective_sample_size.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_weights_is_refused() {
        let mut weights = LogWeights::uniform(3);
        weights.update(&[0.0, f64::NEG_INFINITY, 1.0]).unwrap();
        assert!(weights.can_be_gone_on_from());
        let again = LogWeights::try_from(StoredWeights::from(weights.clone())).unwrap();
        assert_eq!(again, weights);
        let stored = |log: &[f64], normalised: &[f64]| StoredWeights {
            log: log.to_vec(),
            normalised: normalised.to_vec(),
            effective_sample_size: 1.0,
            equal: false,
        };
        assert!(LogWeights::try_from(stored(&[0.0], &[1.0, 0.0])).is_err());
        for wrong in [[f64::NAN, 1.0], [-0.5, 1.5], [0.5, 0.6]] {
            let weights = LogWeights::try_from(stored(&[0.0, 0.0], &wrong)).unwrap();
            assert!(!weights.can_be_gone_on_from(), "{wrong:?}");
        }
    }
}
