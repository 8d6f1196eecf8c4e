//! What a function of a model raised.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};

use motes::MotesError;
use pyo3::prelude::*;

use crate::errors::to_python;
use crate::work::Stop;

/// The first exception of a call's functions, if there is one.
#[derive(Clone, Default)]
pub(crate) struct Failure(Arc<Mutex<Option<PyErr>>>);

impl Failure {
    pub(crate) fn is_there(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Keeps the first exception.
    pub(super) fn keep(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// Whether work is to go on.
    pub(crate) fn asked(&self, stop: &Stop) -> ControlFlow<()> {
        if self.is_there() { ControlFlow::Break(()) } else { stop.asked() }
    }

    /// What came of work: what a function raised, before all else.
    pub(crate) fn or<T>(&self, result: Result<T, MotesError>) -> PyResult<T> {
        match self.0.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => result.map_err(to_python),
        }
    }
}
