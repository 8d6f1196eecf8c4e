//! Drawing series from a model.

use std::ops::ControlFlow;

use motes_models::batch::there_is_memory_for;
use motes_models::{ModelError, Seed, Stream, Trajectory, simulate_while as draw};

use crate::error::MotesError;
use crate::model::{Kind, Model};

/// Series of states and measurements that a model drew.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// One after another.
    pub series: Vec<Trajectory>,
}

/// Draws `series` series of `steps` times each. One series is the same whatever others there are. `proceed` is asked after each series, and now and then within
/// one, with how many are done.
///
/// # Errors
/// [`MotesError::Simulation`] where states overflow, with how many series do; [`MotesError::Setting`] if there is no memory for them;
/// [`MotesError::Interrupted`] if `proceed` said to stop.
pub fn simulate(
    model: &Model,
    steps: usize,
    series: usize,
    seed: u64,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    simulate_until(model, steps, series, seed, &mut proceed)
}

/// Refuses a model whose measurements have densities, but cannot be drawn.
///
/// # Errors
/// [`MotesError::Simulation`] names the line.
pub(crate) fn check_draws(model: &Model) -> Result<(), MotesError> {
    let Some(formulas) = model.formulas() else { return Ok(()) };
    formulas.can_be_simulated().map_err(|error| MotesError::Simulation(error.to_string()))
}

/// [`simulate`], compiled once whatever asks.
fn simulate_until(
    model: &Model,
    steps: usize,
    series: usize,
    seed: u64,
    proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    check_draws(model)?;
    let width = model.states().len() + model.measurements().len();
    let numbers = steps.checked_mul(series).and_then(|times| times.checked_mul(width));
    // Each number is text of some twenty letters later on.
    if !numbers.and_then(|numbers| numbers.checked_mul(4)).is_some_and(there_is_memory_for) {
        let reason =
            format!("{series} series of {steps} times are more than there is memory for; take fewer");
        return Err(MotesError::Setting(reason));
    }
    let seed = Seed::from_u64(seed).child("simulate");
    let (mut drawn, mut first, mut failures) = (Vec::new(), None, 0);
    for number in 0..series {
        let mut stream = seed.nth(number as u64).stream();
        let found = draw_one(model, steps, &mut stream, &mut || proceed(number));
        match found {
            Ok(Some(trajectory)) => drawn.push(trajectory),
            Ok(None) => return Err(MotesError::Interrupted),
            Err(ModelError::Numerical { time, .. }) => {
                failures += 1;
                first.get_or_insert((number, time));
            }
            Err(error) => return Err(error.into()),
        }
        if proceed(number + 1).is_break() {
            return Err(MotesError::Interrupted);
        }
    }
    match first {
        None => Ok(Simulated { series: drawn }),
        Some((number, time)) => Err(MotesError::Simulation(format!(
            "{failures} of {series} series run to numbers that are not finite, series {number} at t = {time}; take fewer steps, or look at \
             the transition's noise and at formulas that grow"
        ))),
    }
}

/// Draws `series` series of `steps` times; those that run to numbers that are not finite are left out.
///
/// # Errors
/// [`MotesError::Simulation`] if none is left.
pub(crate) fn simulate_some(
    model: &Model,
    steps: usize,
    series: usize,
    seed: &Seed,
) -> Result<Simulated, MotesError> {
    let draw = |number: usize| {
        let mut stream = seed.nth(number as u64).stream();
        draw_one(model, steps, &mut stream, &mut || ControlFlow::Continue(()))
    };
    let drawn: Vec<Trajectory> = (0..series).filter_map(|number| draw(number).ok().flatten()).collect();
    match drawn.is_empty() {
        true => Err(MotesError::Simulation(format!(
            "all of {series} series of {steps} times run to numbers that are not finite; take fewer steps, or look at the transition's noise"
        ))),
        false => Ok(Simulated { series: drawn }),
    }
}

/// A series, or none where `proceed` said to stop.
fn draw_one(
    model: &Model,
    steps: usize,
    stream: &mut Stream,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<Trajectory>, ModelError> {
    match model.kind() {
        Kind::Learnable(learnable) => draw(learnable, steps, stream, proceed),
        Kind::LinearGaussian(linear) => draw(linear, steps, stream, proceed),
    }
}
