//! Functions as equations, which are called until one of them fails.

use std::sync::Arc;

use motes::models::Step;
use motes::models::equations::{BatchDistribution, BatchEquations, Batched};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use super::distributions::{FunctionCall, columns};
use super::failure::Failure;
use super::stated::Functions;
use super::step::{Steps, parameters};

/// The functions of a model at values of its parameters.
struct FunctionEquations {
    functions: Arc<Functions>,
    failure: Failure,
    /// Whether states may overflow: simulated series then end there.
    may_overflow: bool,
    /// What makes the steps that functions are told of, and the first state; none where they could not be had.
    steps: Option<Steps>,
    initial: Option<Vec<BatchDistribution>>,
    /// Inputs that nobody gave.
    inputs: Vec<f64>,
}

/// Which function is called.
#[derive(Clone, Copy)]
enum Function {
    Transition,
    Measurement,
}

impl FunctionEquations {
    /// Those of a model at these values of its parameters, with its first state.
    fn new(
        functions: Arc<Functions>,
        failure: Failure,
        may_overflow: bool,
        values: &[(String, f64)],
    ) -> Self {
        let found = match failure.ends_calls() {
            true => None,
            // None where the interpreter ends.
            false => Python::try_attach(|py| {
                let parameters = parameters(py, values)?;
                let initial = functions.initial(py, &parameters)?;
                Ok::<_, PyErr>((Steps::new(py, &functions.inputs, &parameters)?, initial))
            }),
        };
        let found = found.and_then(|found| found.map_err(|error| failure.keep(error)).ok());
        let (steps, initial) = found.unzip();
        let inputs = vec![f64::NAN; functions.inputs.len()];
        FunctionEquations { functions, failure, may_overflow, steps, initial, inputs }
    }

    fn call(
        &self,
        function: Function,
        step: &Step<'_>,
        rows: &[f64],
        is_padded: bool,
        with_slopes: bool,
    ) -> Option<Vec<BatchDistribution>> {
        if self.failure.ends_calls() {
            return None;
        }
        let Functions { states, measurements, transition, measurement, slopes, .. } = &*self.functions;
        let steps = self.steps.as_ref()?;
        let (particles, at) = (rows.len() / states.len(), function as usize);
        // An input that is not known makes odd numbers of the best rows.
        let is_padded = is_padded || step.inputs.iter().any(|input| input.is_nan());
        let asked = FunctionCall {
            function: ["transition", "measurement"][at],
            time: Some(step.time),
            names: [states, measurements][at],
            particles,
            is_padded,
            may_overflow: self.may_overflow.then_some(rows),
            of_states: matches!(function, Function::Transition),
            has_density: self.functions.has_density,
        };
        // None where the interpreter ends.
        Python::try_attach(|py| {
            let call = || {
                let array = PyArray1::from_slice(py, rows).reshape([particles, states.len()])?;
                let sloped = slopes.as_ref().filter(|_| with_slopes);
                let called = sloped.map_or([transition, measurement][at], |sloped| &sloped[at]);
                let of_step = steps.step(py, step)?;
                let found = called.bind(py).call1((of_step, array)).inspect_err(|error| {
                    // Python 3.10 has no notes.
                    let note = format!("in {}, t = {}", asked.function, step.time);
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

impl Functions {
    /// The model of these functions with other values of the parameters in `set`, which keeps what one of them raises in `failure`. Where it simulates, series may overflow.
    pub(crate) fn model(
        self: &Arc<Self>,
        failure: &Failure,
        may_overflow: bool,
        set: &[(String, f64)],
    ) -> Result<motes::Model, motes::MotesError> {
        let (functions, kept) = (Arc::clone(self), failure.clone());
        let make = move |values: &[(String, f64)]| {
            Batched::new(FunctionEquations::new(Arc::clone(&functions), kept.clone(), may_overflow, values))
        };
        let model =
            motes::Model::own_with(&self.name, &self.states, &self.measurements, &self.sections, make)?;
        if set.is_empty() { Ok(model) } else { Ok(model.with_parameters(set)?) }
    }
}

impl BatchEquations for FunctionEquations {
    fn dimensions(&self) -> [usize; 2] {
        [self.functions.states.len(), self.functions.measurements.len()]
    }

    fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    fn has_density(&self) -> bool {
        self.functions.has_density
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        self.initial.clone()
    }

    fn transition(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Transition, step, previous, is_padded, false)
    }

    fn measurement(
        &self,
        step: &Step<'_>,
        states: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Measurement, step, states, is_padded, false)
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
        self.call(Function::Transition, step, previous, is_padded, true)
    }

    fn measurement_slopes(
        &self,
        step: &Step<'_>,
        states: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.call(Function::Measurement, step, states, is_padded, true)
    }
}
