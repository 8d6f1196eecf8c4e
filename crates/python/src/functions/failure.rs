//! How a call ends early: by what a function of its model raises, or because somebody pressed Ctrl-C.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};

use motes::MotesError;
use pyo3::prelude::*;

use crate::errors::to_python;
use crate::work::Stop;

/// The first exception of a call's functions, if there is one, and whether the call is to stop. Clones say the same.
#[derive(Clone, Default)]
pub(crate) struct Failure {
    first: Arc<Mutex<Option<PyErr>>>,
    pub(crate) stop: Stop,
}

impl Failure {
    fn first(&self) -> std::sync::MutexGuard<'_, Option<PyErr>> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether no function is to be called any more.
    pub(super) fn ends_calls(&self) -> bool {
        self.stop.is_asked() || self.first().is_some()
    }

    /// Keeps the first exception.
    pub(super) fn keep(&self, error: PyErr) {
        self.first().get_or_insert(error);
    }

    /// Whether work is to go on.
    pub(crate) fn asked(&self) -> ControlFlow<()> {
        if self.ends_calls() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// What came of work: what a function raised, before all else.
    pub(crate) fn or<T>(&self, result: Result<T, MotesError>) -> PyResult<T> {
        match self.first().take() {
            Some(error) => Err(error),
            None => result.map_err(to_python),
        }
    }
}
