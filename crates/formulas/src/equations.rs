//! Formulas as equations of any scalar.

use std::ops::Range;

use motes_models::Step;
use motes_models::equations::{Coordinates, Equations, Scalar};

use crate::model::Compiled;

/// The formulas of a [`FormulaModel`](crate::FormulaModel).
///
/// All that [`Equations`] are is compiled anew by each crate that uses it of this type: a filter takes the model.
#[derive(Debug, Clone, Copy)]
pub struct FormulaEquations<'a>(pub(crate) &'a Compiled);

impl Equations for FormulaEquations<'_> {
    fn dimensions(&self) -> [usize; 2] {
        [self.0.states, self.0.measurements]
    }

    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
        self.0.initial.push(0.0, &[], state);
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, previous: &[S], state: &mut impl Coordinates<S>) {
        self.0.transition.push(step.time, previous, state);
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>) {
        self.0.measurement.push(step.time, state, measurement);
    }

    fn measurement_along<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        state: &[S],
        along: Range<usize>,
        measurement: &mut impl Coordinates<S>,
    ) {
        self.0.measurement.push_along(step.time, state, along, measurement);
    }
}
