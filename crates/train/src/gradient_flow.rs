//! How far back in time a gradient reaches.

use serde::Serialize;

use crate::TrainError;

/// How far the derivative of a later term reaches into earlier draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GradientFlow {
    /// All the way to `t = 0`: the exact gradient of the objective.
    #[default]
    Full,
    /// Backpropagation through time is truncated: no derivative crosses from a window into the one before it. With windows of
    /// one time every draw takes its past as given.
    Truncated {
        /// Times in a window; at least 1.
        window: usize,
    },
}

impl GradientFlow {
    /// Whether nothing flows from `time` to the time before it.
    pub(crate) fn ends_at(self, time: usize) -> bool {
        match self {
            GradientFlow::Full => false,
            GradientFlow::Truncated { window } => time.is_multiple_of(window),
        }
    }

    pub(crate) fn check(self) -> Result<(), TrainError> {
        match self {
            GradientFlow::Truncated { window: 0 } => Err(TrainError::Setting {
                name: "the window of a truncated gradient",
                value: "0".into(),
                expected: "at least 1",
            }),
            _ => Ok(()),
        }
    }
}
