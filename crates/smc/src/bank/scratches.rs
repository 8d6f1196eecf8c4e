//! Scratch of a proposal, one for each piece of work at the same time.

use std::sync::{Mutex, PoisonError};

/// Scratch that is taken by who begins a piece of work and put back at its end, so that the next allocates nothing.
pub(super) struct Scratches<S>(Mutex<Vec<S>>);

impl<S: Default> Scratches<S> {
    pub(super) fn take(&self) -> S {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(super) fn put(&self, scratch: S) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(scratch);
    }
}

impl<S> Default for Scratches<S> {
    fn default() -> Self {
        Scratches(Mutex::new(Vec::new()))
    }
}

impl<S> Clone for Scratches<S> {
    /// A copy of a bank has scratch of its own.
    fn clone(&self) -> Self {
        Scratches::default()
    }
}
