//! Formulas as equations of any scalar.

use std::ops::Range;

use motes_models::Step;
use motes_models::equations::{Coordinates, Distribution, Draws, Equations, Scalar};

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

/// Draws the coordinates of a state in order, each from the distribution that its line states.
struct InOrder<'a, D, I> {
    draws: &'a mut D,
    state: I,
}

impl<'s, S: 's, D: Draws<S>, I: Iterator<Item = &'s mut S>> Coordinates<S> for InOrder<'_, D, I> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<S>) {
        let drawn = self.draws.draw(distribution);
        if let Some(coordinate) = self.state.next() {
            *coordinate = drawn;
        }
    }
}

impl Equations for FormulaEquations<'_> {
    fn dimensions(&self) -> [usize; 2] {
        [self.0.states, self.0.measurements]
    }

    fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        self.0.initial.push(step.time, &[], &mut InOrder { draws, state: state.iter_mut() });
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        self.0.transition.push(step.time, previous, &mut InOrder { draws, state: state.iter_mut() });
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
