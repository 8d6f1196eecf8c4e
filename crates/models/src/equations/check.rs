//! Whether equations are what they say of themselves.

use super::advance::make_state;
use super::distribution::Distribution;
use super::statement::{Draws, Equations};
use crate::batch::Rows;
use crate::{ModelError, Seed, StateSpaceModel, Step};

/// Steps that are looked at: how many draws there are may depend on the time, never on states.
const PROBES: usize = 8;

/// Keeps how many draws there are, and answers each with a number of its own.
#[derive(Default)]
struct Probe {
    drawn: Vec<f64>,
    first: f64,
}

impl Draws<f64> for Probe {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        let [mean, variance] = distribution.moments();
        let value = match distribution.is_discrete() {
            true => mean.round(),
            // Numbers that no coordinate has by chance.
            false => mean + variance.sqrt() * (self.first + 0.137 * self.drawn.len() as f64),
        };
        self.drawn.push(value);
        value
    }
}

/// Makes a state of numbered draws: the draws and the state, which is NaN where the equations leave a coordinate out.
fn made(model: &impl Equations, step: &Step<'_>, previous: Option<&[f64]>, first: f64) -> [Vec<f64>; 2] {
    let [n, _] = model.dimensions();
    let (mut draws, mut state) = (Probe { first, ..Probe::default() }, vec![f64::NAN; n]);
    make_state(model, step, previous, &mut draws, &mut state);
    [draws.drawn, state]
}

/// Whether a state is its draws, but for what is no number.
fn are_same(draws: &[f64], state: &[f64]) -> bool {
    draws.len() == state.len() && draws.iter().zip(state).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

/// Looks at the first steps of a model from states that are likely, drawn from a stream of its own.
///
/// # Errors
/// [`ModelError::Parameter`] if how many draws there are depends on the state, or if there is no density where the model says that there is one.
pub(super) fn check(model: &(impl Equations + StateSpaceModel)) -> Result<(), ModelError> {
    let refuse = |name, value: String, expected| Err(ModelError::Parameter { name, value, expected });
    let [n, _] = model.dimensions();
    let mut streams = [Seed::from_u64(0).child("check of equations").stream()];
    let mut states = [vec![0.0; n], vec![0.0; n]];
    for index in 0..PROBES {
        let step = model.step_of_index(index);
        let before = states.clone();
        let previous = |which: usize| (index > 0).then_some(before[which].as_slice());
        let of_states = [0, 1].map(|which| made(model, &step, previous(which), which as f64));
        let [[draws, state], [others, _]] = &of_states;
        if draws.len() != others.len() {
            let found = format!("{} and {} at step {index}", draws.len(), others.len());
            return refuse("the number of draws of a step", found, "the same whatever the state is");
        }
        if model.has_density() && !are_same(draws, state) {
            let found = format!("{} draws for {n} coordinates at step {index}", draws.len());
            let expected = "each coordinate the next draw, or `has_density` that is false";
            return refuse("the state", found, expected);
        }
        for (which, state) in states.iter_mut().enumerate() {
            model.sample_states(&step, previous(which).map(|row| Rows::all(row, n)), &mut streams, state);
        }
    }
    Ok(())
}
