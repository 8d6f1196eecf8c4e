//! The settings of learning once.

use serde::Serialize;

use super::objective::LearnObjective;
use crate::dropout::check_dropout;
use crate::penalty::check_penalty;
use crate::{AdamConfig, TrainError};

/// How a proposal is learned once.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LearnConfig {
    /// What is maximised.
    #[serde(skip_serializing_if = "LearnObjective::is_inclusive")]
    pub objective: LearnObjective,
    /// Whether the proposal was learned before: its inputs then keep their standards, whatever the model.
    #[serde(skip_serializing_if = "is_false")]
    pub continues: bool,
    /// Gradient steps.
    pub steps: usize,
    /// Rows `(x_{t−1}, x_t, y_t)` in a step.
    pub rows: usize,
    /// The number of times of a simulated sequence.
    pub horizon: usize,
    /// A sequence ends where a coordinate of its state becomes larger than this, or smaller than its negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_state: Option<f64>,
    /// Sequences that are simulated side by side; their rows are shuffled before they are used, each of them once.
    pub sequences: usize,
    /// A share of the transition that is mixed in while learning: no row that the proposal finds impossible then outweighs all others.
    pub floor: f64,
    /// The optimiser; its learning rate falls to 0 along half a cosine.
    pub adam: AdamConfig,
    /// The largest Euclidean norm of the gradient of all weights; a longer one is scaled down to it.
    pub clip_norm: f64,
    /// How many steps lie between two looks at validation.
    pub validate_every: usize,
    /// Training ends where after so many steps nothing was better than the proposal that came in; it does not if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patience: Option<usize>,
    /// Training ends after so many seconds, whatever its steps; the number of steps then depends on the machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// `λ`: a penalty of `λ/2 Σ w²` over the weights is added to the loss.
    #[serde(skip_serializing_if = "is_zero")]
    pub weight_penalty: f64,
    /// `p`: the probability that a step leaves out a hidden unit.
    #[serde(skip_serializing_if = "is_zero")]
    pub dropout: f64,
}

/// Whether a switch is off, where it is not written.
fn is_false(switch: &bool) -> bool {
    !switch
}

/// Whether a setting is at its default, at which it is not written.
fn is_zero(setting: &f64) -> bool {
    *setting == 0.0
}

impl LearnConfig {
    /// 3000 steps of 800 rows, from sequences of 100 times.
    pub fn new() -> Self {
        LearnConfig {
            objective: LearnObjective::Inclusive,
            continues: false,
            steps: 3000,
            rows: 800,
            horizon: 100,
            largest_state: None,
            sequences: 256,
            floor: 0.02,
            adam: AdamConfig { learning_rate: 3e-3, ..AdamConfig::paper() },
            clip_norm: 5.0,
            validate_every: 200,
            patience: None,
            seconds: None,
            weight_penalty: 0.0,
            dropout: 0.0,
        }
    }

    pub(super) fn check(&self) -> Result<(), TrainError> {
        let wrong = |name, value: String, expected| Err(TrainError::Setting { name, value, expected });
        for (name, count) in [
            ("the number of steps", self.steps),
            ("the number of rows in a step", self.rows),
            ("the number of drawn sequences", self.sequences),
            ("the number of steps between two validations", self.validate_every),
        ] {
            if count == 0 {
                return wrong(name, "0".into(), "at least 1");
            }
        }
        if self.patience == Some(0) {
            return wrong("the patience", "0".into(), "at least 1 step");
        }
        if self.horizon < 2 {
            return wrong("the number of times of a sequence", self.horizon.to_string(), "at least 2");
        }
        if !(0.0..1.0).contains(&self.floor) {
            return wrong("the floor", self.floor.to_string(), "at least 0 and below 1");
        }
        if self.clip_norm.is_nan() || self.clip_norm <= 0.0 {
            return wrong("the largest norm of the gradient", self.clip_norm.to_string(), "positive");
        }
        if let Some(largest) = self.largest_state
            && (largest.is_nan() || largest <= 0.0)
        {
            return wrong("the largest state of a sequence", largest.to_string(), "positive");
        }
        check_penalty(self.weight_penalty)?;
        check_dropout(self.dropout)?;
        match self.seconds {
            Some(seconds) if !(seconds > 0.0 && seconds.is_finite()) => {
                wrong("the budget in seconds", seconds.to_string(), "positive and finite")
            }
            _ => Ok(()),
        }
    }
}

impl Default for LearnConfig {
    fn default() -> Self {
        LearnConfig::new()
    }
}
