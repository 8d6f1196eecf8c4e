//! Why a twisting could not be learned.

use thiserror::Error;

use crate::error::FilterError;
use crate::smoothing::SmoothingError;

/// Why a [`Twisting`](super::Twisting) could not be learned.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TwistingError {
    /// A setting is outside its range.
    #[error("{name} is {value}; it must be {expected}")]
    Setting {
        /// Which setting.
        name: &'static str,
        /// The value found, as text.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A filter failed whose particles it would have been learned from.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// There is no memory for these particles.
    #[error(transparent)]
    Memory(#[from] SmoothingError),
    /// The particles of a time are too much alike for a quadratic, or their densities are not finite.
    #[error("no quadratic can be fitted to the particles of time {time}")]
    Fit {
        /// The time `t`.
        time: usize,
    },
}
