//! The functions of a model, as they were stated.

use motes::models::equations::BatchDistribution;
use pyo3::prelude::*;

use super::distributions::{FunctionCall, columns};

/// The functions of a model, with the names of its coordinates, and what it has beside them.
pub(crate) struct Functions {
    pub(super) name: String,
    pub(super) states: Vec<String>,
    pub(super) measurements: Vec<String>,
    /// The names of the inputs of a step, in order.
    pub(super) inputs: Vec<String>,
    /// Times, inputs, parameters and the column of series, as a model file has them.
    pub(super) sections: String,
    /// Whether all coordinates of states are drawn and none is a count.
    pub(super) has_density: bool,
    initial: Initial,
    pub(super) transition: Py<PyAny>,
    pub(super) measurement: Py<PyAny>,
    /// The latter two with derivatives: each gives distributions, and the same of their parameters' derivatives.
    pub(super) slopes: Option<[Py<PyAny>; 2]>,
}

/// The distributions of `x_0`, the same for all particles.
enum Initial {
    /// What they are.
    Given(Vec<BatchDistribution>),
    /// A function of parameters.
    Function(Py<PyAny>),
}

/// What Python says of a model beside its functions.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Frame {
    states: Vec<String>,
    measurements: Vec<String>,
    inputs: Vec<String>,
    sections: String,
    density: bool,
}

impl Functions {
    /// Those of a model; `initial` are the distributions of its first state, or a function of parameters that gives these.
    pub(crate) fn new(
        py: Python<'_>,
        name: String,
        frame: Frame,
        initial: &Bound<'_, PyAny>,
        [transition, measurement]: [Py<PyAny>; 2],
        slopes: Option<[Py<PyAny>; 2]>,
    ) -> PyResult<Self> {
        let Frame { states, measurements, inputs, sections, density: has_density } = frame;
        let initial = match initial.is_callable() {
            true => Initial::Function(initial.clone().unbind()),
            false => {
                Initial::Given(columns(py, &FunctionCall::of_initial(&states, has_density), initial, None)?)
            }
        };
        Ok(Functions {
            name,
            states,
            measurements,
            inputs,
            sections,
            has_density,
            initial,
            transition,
            measurement,
            slopes,
        })
    }

    /// The distributions of the first state at these parameters.
    pub(super) fn initial(&self, py: Python<'_>, parameters: &Py<PyAny>) -> PyResult<Vec<BatchDistribution>> {
        match &self.initial {
            Initial::Given(stated) => Ok(stated.clone()),
            Initial::Function(function) => {
                let found = function.bind(py).call1((parameters,))?;
                columns(py, &FunctionCall::of_initial(&self.states, self.has_density), &found, None)
            }
        }
    }
}
