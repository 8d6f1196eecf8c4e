//! Backward simulation: Godsill, Doucet and West, Monte Carlo smoothing for nonlinear time series (2004).

use std::ops::ControlFlow;
use std::sync::Mutex;

use motes_models::batch::{Rows, there_is_memory_for, with_scratch};
use motes_models::{Seed, StateSpaceModel};
use rand::RngExt;
use rayon_core::current_num_threads;

use super::error::SmoothingError;
use super::history::{FilterHistory, Generation};
use super::paths::SmoothedPaths;
use crate::parallel::{self, Pieces};

/// As many densities as are looked at before somebody may say to stop, some tenth of a second's work; but each thread draws a path.
const DENSITIES_AT_ONCE: usize = 1 << 24;

/// Draws `paths` trajectories `x_{0:T−1}` given all measurements.
///
/// The last state of each is a particle of the last time, drawn by the weights. Backwards from there, the state at `t` is particle `k` with a probability in
/// proportion to `W_t^k p(x_{t+1} | x_t^k)`. Paths are independent given the filter; a path has a stream of its own, so that any number of threads draws
/// the same.
///
/// It takes time in proportion to `B·T·K`.
///
/// # Errors
/// [`SmoothingError`] if there is nothing to draw, no memory, or no particle from which a path's next state can come.
pub fn backward_simulation(
    model: &(impl StateSpaceModel + ?Sized),
    history: &FilterHistory,
    paths: usize,
    seed: &Seed,
) -> Result<SmoothedPaths, SmoothingError> {
    backward_simulation_while(model, history, paths, seed, |_| ControlFlow::Continue(()))
}

/// [`backward_simulation`], which asks `proceed` now and then, with how many paths are drawn.
///
/// # Errors
/// As there, and [`SmoothingError::Interrupted`] if `proceed` said to stop.
pub fn backward_simulation_while(
    model: &(impl StateSpaceModel + ?Sized),
    history: &FilterHistory,
    paths: usize,
    seed: &Seed,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<SmoothedPaths, SmoothingError> {
    let (times, width) = (history.len(), model.state_dim());
    for (name, count) in
        [("the number of paths", paths), ("the number of times", times), ("the state dimension N", width)]
    {
        if count == 0 {
            return Err(SmoothingError::Nothing { name });
        }
    }
    let numbers = paths.saturating_mul(times).saturating_mul(width);
    if !there_is_memory_for(numbers) {
        return Err(SmoothingError::Memory { numbers });
    }
    let mut states = vec![0.0; numbers];
    let fault = Mutex::new(None);
    let draw = |some: Paths<'_>| {
        for (number, path) in (some.first..).zip(some.states.chunks_exact_mut(some.each)) {
            if let Err(error) = draw_path(model, &history.generations, &seed.nth(number as u64), path) {
                fault.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).get_or_insert(error);
            }
        }
    };
    let particles = history.generations[0].log_weights.len();
    let at_once = (DENSITIES_AT_ONCE / (times * particles)).max(1);
    let at_once = at_once.next_multiple_of(current_num_threads()).min(paths);
    for (number, some) in states.chunks_mut(at_once * times * width).enumerate() {
        let some = Paths { first: number * at_once, each: times * width, states: some };
        let drawn = some.first + some.count();
        parallel::step(paths.saturating_mul(particles), |threads| threads.share(some, 1, &draw));
        let is_over = fault.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).is_some();
        if is_over {
            break;
        }
        if proceed(drawn).is_break() {
            return Err(SmoothingError::Interrupted);
        }
    }
    match fault.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
        None => Ok(SmoothedPaths { states, times, width }),
        Some(error) => Err(error),
    }
}

/// Draws one path, the last state first.
fn draw_path(
    model: &(impl StateSpaceModel + ?Sized),
    generations: &[Generation],
    seed: &Seed,
    path: &mut [f64],
) -> Result<(), SmoothingError> {
    let (mut stream, width) = (seed.stream(), model.state_dim());
    let particles = generations[0].log_weights.len();
    with_scratch(particles * (1 + width), |scratch| {
        let (log_weights, next) = scratch.split_at_mut(particles);
        for (time, generation) in generations.iter().enumerate().rev() {
            if time + 1 == generations.len() {
                log_weights.copy_from_slice(&generation.log_weights);
            } else {
                let state = &path[(time + 1) * width..(time + 2) * width];
                next.chunks_exact_mut(width).for_each(|row| row.copy_from_slice(state));
                let from = Rows::all(&generation.states, width);
                model.log_transitions(time + 1, from, next, log_weights);
                for (log_weight, own) in log_weights.iter_mut().zip(&generation.log_weights) {
                    // A particle without weight is none, whatever its density.
                    *log_weight = if *own == f64::NEG_INFINITY { *own } else { *log_weight + own };
                }
            }
            let chosen = choose(log_weights, stream.random()).ok_or(SmoothingError::NoAncestor { time })?;
            path[time * width..(time + 1) * width]
                .copy_from_slice(&generation.states[chosen * width..(chosen + 1) * width]);
        }
        Ok(())
    })
}

/// The particle that a uniform number in `[0, 1)` falls on; none if all weights are 0 or one is not a number. The weights become their exponentials.
fn choose(log_weights: &mut [f64], uniform: f64) -> Option<usize> {
    let largest = log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY || log_weights.iter().any(|weight| weight.is_nan()) {
        return None;
    }
    let mut total = 0.0;
    for weight in &mut *log_weights {
        *weight = motes_models::elementary::exp(*weight - largest);
        total += *weight;
    }
    let mut left = uniform * total;
    let chosen = log_weights.iter().position(|weight| {
        left -= weight;
        left < 0.0
    });
    // Rounding may leave a little.
    chosen.or_else(|| log_weights.iter().rposition(|weight| *weight > 0.0))
}

/// Consecutive paths.
struct Paths<'a> {
    first: usize,
    each: usize,
    states: &'a mut [f64],
}

impl Pieces for Paths<'_> {
    fn count(&self) -> usize {
        self.states.len() / self.each
    }

    fn split(self, paths: usize) -> (Self, Self) {
        let Paths { first, each, states } = self;
        let (states, later) = states.split_at_mut(paths * each);
        (Paths { first, each, states }, Paths { first: first + paths, each, states: later })
    }
}
