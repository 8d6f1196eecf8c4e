//! The settings of learning potentials.

use serde::Serialize;

use crate::{AdamConfig, TrainError};

/// How potentials are learned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PotentialLearnConfig {
    /// Gradient steps.
    pub steps: usize,
    /// Sequences in a step, which are simulated anew for each.
    pub sequences: usize,
    /// The number of times of a simulated sequence.
    pub horizon: usize,
    /// The share of sequences of which some measurements are missing: one in five.
    pub with_gaps: f64,
    /// The optimiser; its learning rate falls to 0 along half a cosine.
    pub adam: AdamConfig,
    /// The largest Euclidean norm of the gradient of all weights; a longer one is scaled down to it.
    pub clip_norm: f64,
    /// How many steps lie between two looks at validation.
    pub validate_every: usize,
    /// Learning ends after so many seconds, whatever its steps; the number of steps then depends on the machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

impl PotentialLearnConfig {
    /// 1500 steps of 16 sequences of 100 times.
    pub fn new() -> Self {
        PotentialLearnConfig {
            steps: 1500,
            sequences: 16,
            horizon: 100,
            with_gaps: 0.125,
            adam: AdamConfig { learning_rate: 5e-3, ..AdamConfig::paper() },
            clip_norm: 1.0,
            validate_every: 100,
            seconds: None,
        }
    }

    pub(super) fn check(&self) -> Result<(), TrainError> {
        let wrong = |name, value: String, expected| Err(TrainError::Setting { name, value, expected });
        for (name, count) in [
            ("the number of sequences in a step", self.sequences),
            ("the number of times of a sequence", self.horizon),
            ("the number of steps between two validations", self.validate_every),
        ] {
            if count == 0 {
                return wrong(name, "0".into(), "at least 1");
            }
        }
        if !(0.0..=1.0).contains(&self.with_gaps) {
            return wrong("the share of sequences with gaps", self.with_gaps.to_string(), "from 0 to 1");
        }
        if self.clip_norm.is_nan() || self.clip_norm <= 0.0 {
            return wrong("the largest norm of the gradient", self.clip_norm.to_string(), "positive");
        }
        match self.seconds {
            Some(seconds) if !(seconds > 0.0 && seconds.is_finite()) => {
                wrong("the budget in seconds", seconds.to_string(), "positive and finite")
            }
            _ => Ok(()),
        }
    }
}

impl Default for PotentialLearnConfig {
    fn default() -> Self {
        PotentialLearnConfig::new()
    }
}
