//! A step as formulas see it.

use super::scalar::Scalar;
use super::tiles::with_scalars;
use crate::Step;

impl Step<'_> {
    /// The same step with inputs and parameters as other scalars.
    pub fn lift<S: Scalar, R>(&self, work: impl FnOnce(&Step<'_, S>) -> R) -> R {
        let Step { index, time, length, .. } = *self;
        let inputs = self.inputs.len();
        with_scalars::<S, _>(inputs + self.parameters.len(), |scalars| {
            let numbers = self.inputs.iter().chain(self.parameters);
            scalars.iter_mut().zip(numbers).for_each(|(scalar, number)| *scalar = S::from(*number));
            let (inputs, parameters) = scalars.split_at(inputs);
            work(&Step { index, time, length, inputs, parameters })
        })
    }
}
