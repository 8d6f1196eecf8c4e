//! A step as formulas see it.

use super::scalar::Scalar;
use super::tiles::with_scalars;
use crate::Step;

impl Step<'_> {
    /// The same step with parameters as other scalars.
    pub fn lift<S: Scalar, R>(&self, work: impl FnOnce(&Step<'_, S>) -> R) -> R {
        let Step { index, time, length, sub_step, sub_steps, inputs, .. } = *self;
        with_scalars::<S, _>(self.parameters.len(), |parameters| {
            let numbers = self.parameters.iter();
            parameters.iter_mut().zip(numbers).for_each(|(scalar, number)| *scalar = S::from(*number));
            work(&Step { index, time, length, sub_step, sub_steps, inputs, parameters })
        })
    }
}
