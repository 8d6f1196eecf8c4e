//! What numbers of a program that are the same for all particles depend on.

use motes_models::Step;

/// What numbers that are the same for all particles depend on.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub(super) time: f64,
    pub(super) length: f64,
    pub(super) inputs: &'a [f64],
    pub(super) is_first: bool,
}

impl<'a> Moment<'a> {
    #[inline(always)]
    pub(super) fn of<S>(step: &Step<'a, S>) -> Self {
        Moment { time: step.time, length: step.length, inputs: step.inputs, is_first: step.sub_step == 0 }
    }

    /// All of it, as bits.
    #[inline(always)]
    pub(super) fn bits(&self) -> impl Iterator<Item = u64> {
        let own = [self.time.to_bits(), self.length.to_bits(), u64::from(self.is_first)];
        own.into_iter().chain(self.inputs.iter().map(|input| input.to_bits()))
    }
}
