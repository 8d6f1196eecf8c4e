//! Formulas as equations of any scalar.

use std::ops::Range;

use motes_models::Step;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar};

use crate::model::{FormulaModel, Programs};

/// The formulas of a [`FormulaModel`](crate::FormulaModel).
///
/// All that [`Equations`] are is compiled anew by each crate that uses it of this type: a filter takes the model.
#[derive(Debug, Clone, Copy)]
pub struct FormulaEquations<'a>(&'a Programs);

impl FormulaModel {
    /// The formulas, for any scalar.
    pub fn equations(&self) -> FormulaEquations<'_> {
        FormulaEquations(&self.0)
    }
}

impl Equations for FormulaEquations<'_> {
    fn dimensions(&self) -> [usize; 2] {
        [self.0.states, self.0.measurements]
    }

    fn has_density(&self) -> bool {
        self.0.has_density
    }

    fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        self.0.initial.make([step.time, step.length], &[], draws, state);
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        self.0.transition.make([step.time, step.length], previous, draws, state);
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>) {
        self.0.measurement.push([step.time, step.length], state, measurement);
    }

    fn measurement_along<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        state: &[S],
        along: Range<usize>,
        measurement: &mut impl Coordinates<S>,
    ) {
        self.0.measurement.push_along([step.time, step.length], state, along, measurement);
    }
}
