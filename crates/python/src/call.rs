//! A model for one call.

use std::sync::Arc;

use pyo3::prelude::*;

use crate::functions::{Failure, Functions};

/// What a model is made of.
#[derive(Clone)]
pub(crate) enum Made {
    /// A text that errors call so; whether a program wrote it.
    Text {
        called: String,
        is_generated: bool,
    },
    Functions(Arc<Functions>),
}

/// A model for one call, and what its functions raise meanwhile.
pub(crate) struct ForCall {
    pub(crate) model: Arc<motes::Model>,
    pub(crate) failure: Failure,
    /// Whether only one thread at a time can ask it, the one with Python's lock.
    asks_python: bool,
}

impl ForCall {
    /// A model for one call, which simulates series that may overflow or does not: what functions raise in one call is no other's affair. `set` are parameters with other values.
    pub(crate) fn new(
        model: &Arc<motes::Model>,
        made: &Made,
        set: &[(String, f64)],
        simulates: bool,
    ) -> PyResult<Self> {
        let failure = Failure::default();
        let (model, asks_python) = match made {
            Made::Text { .. } => (Arc::clone(model), false),
            Made::Functions(functions) => {
                let model = failure.or(functions.model(&failure, simulates, set))?;
                (Arc::new(model), true)
            }
        };
        Ok(ForCall { model, failure, asks_python })
    }

    /// The threads of a filter, where nobody asked for a number: more than one would wait for each other where Python is asked.
    pub(crate) fn threads(&self, asked: Option<usize>) -> Option<usize> {
        asked.or(self.asks_python.then_some(1))
    }
}
