//! Models in Python functions of many particles at a time.

mod distributions;
mod failure;

use std::sync::Arc;

use motes::models::Step;
use motes::models::equations::{BatchDistribution, BatchEquations, Batched};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use distributions::{FunctionCall, columns};
pub(crate) use failure::Failure;

/// The functions of a model, with the names of its coordinates.
pub(crate) struct Functions {
    name: String,
    states: Vec<String>,
    measurements: Vec<String>,
    /// Without arguments, the same for all particles: what it gave once.
    initial: Vec<BatchDistribution>,
    transition: Py<PyAny>,
    measurement: Py<PyAny>,
    /// The latter two with derivatives: each gives distributions, and the same of their parameters' derivatives.
    slopes: Option<[Py<PyAny>; 2]>,
}

impl Functions {
    /// Those of a model; `initial` are the distributions of its first state.
    pub(crate) fn new(
        py: Python<'_>,
        name: String,
        [states, measurements]: [Vec<String>; 2],
        initial: &Bound<'_, PyAny>,
        [transition, measurement]: [Py<PyAny>; 2],
        slopes: Option<[Py<PyAny>; 2]>,
    ) -> PyResult<Self> {
        let asked = FunctionCall {
            function: "initial",
            time: None,
            names: &states,
            particles: 1,
            is_padded: false,
            may_overflow: None,
            of_states: true,
        };
        let initial = columns(py, &asked, initial, None)?;
        Ok(Functions { name, states, measurements, initial, transition, measurement, slopes })
    }

    /// The model of these functions, which keeps what one of them raises in `failure`. Where it simulates, series may overflow.
    pub(crate) fn model(
        self: &Arc<Self>,
        failure: &Failure,
        may_overflow: bool,
    ) -> Result<motes::Model, motes::MotesError> {
        let called = Called { functions: Arc::clone(self), failure: failure.clone(), may_overflow };
        motes::Model::own(&self.name, &self.states, &self.measurements, Batched::new(called))
    }
}

/// Functions that are called until one of them fails.
struct Called {
    functions: Arc<Functions>,
    failure: Failure,
    /// Whether states may overflow: simulated series then end there.
    may_overflow: bool,
}

/// Which function is called.
#[derive(Clone, Copy)]
enum Function {
    Transition,
    Measurement,
}

impl Called {
    fn call(
        &self,
        function: Function,
        time: usize,
        rows: &[f64],
        is_padded: bool,
        with_slopes: bool,
    ) -> Option<Vec<BatchDistribution>> {
        if self.failure.ends_calls() {
            return None;
        }
        let Functions { states, measurements, transition, measurement, slopes, .. } = &*self.functions;
        let (particles, at) = (rows.len() / states.len(), function as usize);
        let asked = FunctionCall {
            function: ["transition", "measurement"][at],
            time: Some(time),
            names: [states, measurements][at],
            particles,
            is_padded,
            may_overflow: self.may_overflow.then_some(rows),
            of_states: matches!(function, Function::Transition),
        };
        // None where the interpreter ends.
        Python::try_attach(|py| {
            let call = || {
                let array = PyArray1::from_slice(py, rows).reshape([particles, states.len()])?;
                let sloped = slopes.as_ref().filter(|_| with_slopes);
                let called = sloped.map_or([transition, measurement][at], |sloped| &sloped[at]);
                let found = called.bind(py).call1((time, array)).inspect_err(|error| {
                    // Python 3.10 has no notes.
                    let note = format!("in {}, t = {time}", asked.function);
                    let _ = error.value(py).call_method1("add_note", (note,));
                })?;
                if sloped.is_none() {
                    return columns(py, &asked, &found, None);
                }
                let (values, slopes): (Bound<'_, PyAny>, Bound<'_, PyAny>) = found.extract()?;
                columns(py, &asked, &values, Some(&slopes))
            };
            match call() {
                Ok(columns) => Some(columns),
                // Rows that are no particles' may be anywhere: nobody is to hear of what became of them. What JAX compiles fails whatever rows hold.
                Err(_) if is_padded && slopes.is_none() => None,
                Err(error) => {
                    self.failure.keep(error);
                    None
                }
            }
        })?
    }
}

impl BatchEquations for Called {
    fn dimensions(&self) -> [usize; 2] {
        [self.functions.states.len(), self.functions.measurements.len()]
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        Some(self.functions.initial.clone())
    }

    fn transition(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Transition, step.index, previous, is_padded, false)
    }

    fn measurement(
        &self,
        step: &Step<'_>,
        states: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Measurement, step.index, states, is_padded, false)
    }

    fn has_slopes(&self) -> bool {
        self.functions.slopes.is_some()
    }

    fn transition_slopes(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Transition, step.index, previous, is_padded, true)
    }

    fn measurement_slopes(
        &self,
        step: &Step<'_>,
        states: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Measurement, step.index, states, is_padded, true)
    }
}
