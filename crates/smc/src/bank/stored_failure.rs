//! The error of a bank that failed, as it is written down.

use serde::{Deserialize, Serialize};

use crate::error::{ErrorKind, FilterError};

/// A [`FilterError`] that can be read again: whole where it names particles, by which somebody may look for the cause, and else its words.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) enum StoredFailure {
    NotANumber { step: usize, filter: usize, particle: usize, value: f64 },
    State { step: usize, filter: usize, particle: usize, coordinate: usize, value: f64 },
    Collapse { step: usize, filter: usize, ess_before: f64, largest_log_likelihood: f64 },
    Other { kind: ErrorKind, words: String },
}

impl StoredFailure {
    pub(super) fn of(error: &FilterError) -> Self {
        match *error {
            FilterError::NotANumber { step, filter, particle, value } => {
                StoredFailure::NotANumber { step, filter, particle, value }
            }
            FilterError::State { step, filter, particle, coordinate, value } => {
                StoredFailure::State { step, filter, particle, coordinate, value }
            }
            FilterError::Collapse { step, filter, ess_before, largest_log_likelihood } => {
                StoredFailure::Collapse { step, filter, ess_before, largest_log_likelihood }
            }
            _ => StoredFailure::Other { kind: error.kind(), words: error.to_string() },
        }
    }

    /// Whether the particle that it names is one of so many filters of `particles` particles of `width` coordinates.
    pub(super) fn is_within(&self, filters: usize, particles: usize, width: usize) -> bool {
        match *self {
            StoredFailure::NotANumber { filter, particle, .. } => filter < filters && particle < particles,
            StoredFailure::State { filter, particle, coordinate, .. } => {
                filter < filters && particle < particles && coordinate < width
            }
            StoredFailure::Collapse { filter, .. } => filter < filters,
            StoredFailure::Other { .. } => true,
        }
    }
}

impl From<StoredFailure> for FilterError {
    fn from(stored: StoredFailure) -> Self {
        match stored {
            StoredFailure::NotANumber { step, filter, particle, value } => {
                FilterError::NotANumber { step, filter, particle, value }
            }
            StoredFailure::State { step, filter, particle, coordinate, value } => {
                FilterError::State { step, filter, particle, coordinate, value }
            }
            StoredFailure::Collapse { step, filter, ess_before, largest_log_likelihood } => {
                FilterError::Collapse { step, filter, ess_before, largest_log_likelihood }
            }
            StoredFailure::Other { kind, words } => FilterError::Earlier { kind, words },
        }
    }
}
