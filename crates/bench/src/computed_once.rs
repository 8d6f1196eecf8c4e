//! What several units need and one of them computes, while the others wait.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::unit_error::UnitError;

/// Results by their keys.
pub(crate) struct ComputedOnce<T> {
    known: Mutex<HashMap<String, Slot<T>>>,
}

/// Filled by the first that needs it, while others that need the same wait.
type Slot<T> = Arc<OnceLock<Result<T, UnitError>>>;

impl<T> Default for ComputedOnce<T> {
    fn default() -> Self {
        ComputedOnce { known: Mutex::default() }
    }
}

impl<T: Clone> ComputedOnce<T> {
    /// The result of this key. One that was interrupted, or could not be kept, is forgotten: another time it may be had.
    pub(crate) fn of(
        &self,
        key: &str,
        compute: impl FnOnce() -> Result<T, UnitError>,
    ) -> Result<T, UnitError> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = known().entry(key.into()).or_default().clone();
        let found = slot.get_or_init(compute).clone();
        if matches!(found, Err(UnitError::Interrupted | UnitError::NotKept(_))) {
            known().remove(key);
        }
        found
    }
}
