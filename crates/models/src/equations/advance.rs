//! How a state is made in a step: its parts one after another.

use super::scalar::Scalar;
use super::statement::{Draws, Equations};
use super::tiles::with_scalars;
use crate::Step;

/// Makes `x_t` (`N`) of `x_{t−1}` (`N`) by all sub-steps of a step, of which there may be none, or `x_0` where there is no previous state.
#[inline(always)]
pub(super) fn make_state<S: Scalar>(
    model: &(impl Equations + ?Sized),
    step: &Step<'_, S>,
    previous: Option<&[S]>,
    draws: &mut impl Draws<S>,
    state: &mut [S],
) {
    let inputs = model.inputs().len();
    let Some(previous) = previous else {
        return model.initial(&step.part(0, inputs), draws, state);
    };
    if step.sub_steps == 0 {
        return state.copy_from_slice(previous);
    }
    // The state between two sub-steps, if there is one.
    let between = if step.sub_steps > 1 { state.len() } else { 0 };
    with_scalars::<S, _>(between, |between| {
        for sub_step in 0..step.sub_steps {
            let before = match sub_step {
                0 => previous,
                _ => {
                    between.copy_from_slice(state);
                    &*between
                }
            };
            model.transition(&step.part(sub_step, inputs), before, draws, state);
        }
    });
}
