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

    fn inputs(&self) -> &[f64] {
        &self.0.inputs
    }

    fn has_density(&self) -> bool {
        self.0.has_density
    }

    fn depends_on_time(&self) -> bool {
        self.0.transition.depends_on_time() || self.0.measurement.depends_on_time()
    }

    fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        self.0.initial.make(step, &[], draws, state);
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        // Rows before the start end with the parameters of particles.
        let is_start = step.index == 0 && self.0.has_parameters_of_particles();
        let program = if is_start { &self.0.initial } else { &self.0.transition };
        program.make(step, previous, draws, state);
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>) {
        self.0.measurement.push(step, state, measurement);
    }

    fn measurement_along<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        state: &[S],
        along: Range<usize>,
        measurement: &mut impl Coordinates<S>,
    ) {
        self.0.measurement.push_along(step, state, along, measurement);
    }
}
