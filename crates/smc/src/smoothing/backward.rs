//! Backward simulation (Godsill, Doucet and West, Monte Carlo smoothing for nonlinear time series, 2004) by Markov moves of ancestors.

use std::ops::ControlFlow;
use std::sync::Mutex;

use motes_models::batch::there_is_memory_for;
use motes_models::{Seed, StateSpaceModel, Stream};
use rand::RngExt;

use super::by_weight::ByWeight;
use super::distinct::Distinct;
use super::error::SmoothingError;
use super::history::FilterHistory;
use super::moves::{DENSITIES_PER_MOVE, Moves, PATHS_TOGETHER};
use super::paths::SmoothedPaths;
use crate::parallel::{self, Pieces};

/// Blocks of paths that are moved before somebody may say to stop, some tenth of a second's work.
const BLOCKS_AT_ONCE: usize = 1 << 10;

/// Draws `B = paths` trajectories `x_{0:T−1}` given all measurements.
///
/// The last state of each is a particle of the last time, drawn by the weights `W_{T−1}`. Backwards from there, let a path be at particle `j` at `t + 1`. The
/// particle `k` of `t` that it comes from has the distribution
///
/// `π(k) ∝ W_t^k p(x_{t+1}^j | x_t^k)`.
///
/// To draw from it exactly takes `K` densities. Instead, [`DENSITIES_PER_MOVE`] − 1 steps of a Markov chain are taken that has `π` as its stationary
/// distribution. The chain starts at the particle that the filter drew `x_{t+1}^j` from. A step proposes `k' ~ W_t` and accepts it with probability
/// `min{1, p(x_{t+1}^j | x_t^{k'}) / p(x_{t+1}^j | x_t^k)}` (independent Metropolis). The filter's ancestor is a draw of `π` itself, for `K → ∞` and
/// whatever the proposal, so there is nothing to burn in: the steps only make paths that have met part again. Bunch and Godsill, Improved particle
/// approximations to the joint smoothing distribution using Markov chain Monte Carlo (2013), have the method. Dau and Chopin, On backward smoothing
/// algorithms (2023), prove that its error stays bounded over time with one step.
///
/// Where the ancestor itself cannot lead to `x_{t+1}^j`, by the rounding of a density or because draws and densities of a model disagree, the particle is
/// drawn from `π` exactly.
///
/// Where a filter looks ahead ([`LookAhead`](crate::LookAhead)), `W_t^k` has a part of what comes later, which is taken off the density of the transition.
///
/// A model without a density of its transition ([`StateSpaceModel::density`]) has no `π`: paths follow the filter's ancestors, and
/// [`SmoothedPaths::follow_ancestors`] says so. They share ancestors soon, so that early states rest on few particles.
///
/// Given the filter, paths are independent. Consecutive ones of a fixed number share a stream, so that any number of threads draws the same. It takes
/// `B·T` times [`DENSITIES_PER_MOVE`] densities and `B·T·N` numbers.
///
/// # Errors
/// [`SmoothingError`] if there is nothing to draw, no memory, the history is that of another model, or there is no particle from which a path's next state
/// can come.
pub fn backward_simulation(
    model: &(impl StateSpaceModel + ?Sized),
    history: &FilterHistory,
    paths: usize,
    seed: &Seed,
) -> Result<SmoothedPaths, SmoothingError> {
    backward_simulation_while(model, history, paths, seed, |_| ControlFlow::Continue(()))
}

/// [`backward_simulation`], which asks `proceed` now and then, with at how many of the `T` times all paths are drawn.
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
    history.check(width)?;
    // Besides its states, a path has the number of a particle and its share of a stream.
    let numbers = paths.saturating_mul(times.saturating_mul(width).saturating_add(4));
    if !there_is_memory_for(numbers) {
        return Err(SmoothingError::Memory { numbers });
    }
    let mut states = vec![0.0; paths * times * width];
    let mut particles = vec![0; paths];
    let mut streams = seed.streams(paths.div_ceil(PATHS_TOGETHER));
    let density = model.density();
    let (mut weights, mut distinct, mut distinct_particles) = (vec![], Distinct::default(), vec![0; times]);
    for (time, generation) in history.generations.iter().enumerate().rev() {
        weights.clear();
        weights.extend_from_slice(&generation.log_weights);
        let by_weight = ByWeight::new(&mut weights).ok_or(SmoothingError::NoAncestor { time })?;
        let next = history.generations.get(time + 1);
        // Where no time passes, a state is its ancestor.
        let moved = next.filter(|next| next.step.step().sub_steps > 0);
        let moves = moved.zip(density).map(|(next, density)| Moves {
            density,
            width,
            time,
            generation,
            by_weight,
            next,
        });
        let fault = Mutex::new(None);
        let work = |blocks: Blocks<'_>| {
            blocks.each(|stream, particles, paths| {
                match (&moves, next) {
                    (None, None) => {
                        particles.iter_mut().for_each(|at| *at = by_weight.draw(stream.random()));
                    }
                    (None, Some(next)) => particles.iter_mut().for_each(|at| *at = next.ancestors[*at]),
                    (Some(moves), _) => {
                        if let Err(error) = moves.take(particles, stream) {
                            fault
                                .lock()
                                .unwrap_or_else(|poisoned| poisoned.into_inner())
                                .get_or_insert(error);
                        }
                    }
                }
                for (particle, path) in particles.iter().zip(paths.chunks_exact_mut(times * width)) {
                    path[time * width..][..width].copy_from_slice(generation.state(*particle, width));
                }
            });
        };
        let mut rest = Blocks {
            each: times * width,
            streams: &mut streams,
            particles: &mut particles,
            states: &mut states,
        };
        while rest.count() > 0 {
            let (some, later) = rest.split_at(BLOCKS_AT_ONCE);
            parallel::step(some.densities(), |threads| threads.share(some, 1, &work));
            rest = later;
            let is_last = rest.count() == 0;
            if proceed(times - time - usize::from(!is_last)).is_break() {
                return Err(SmoothingError::Interrupted);
            }
        }
        if let Some(error) = fault.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
            return Err(error);
        }
        distinct_particles[time] = distinct.count(&particles, generation.log_weights.len());
    }
    let follow_ancestors = density.is_none();
    Ok(SmoothedPaths { states, times, width, distinct_particles, follow_ancestors })
}

/// Consecutive blocks of paths, each of [`PATHS_TOGETHER`] but perhaps the last.
struct Blocks<'a> {
    /// The numbers of a path, `T·N`.
    each: usize,
    /// One for each block.
    streams: &'a mut [Stream],
    /// The particle that each path was last drawn to.
    particles: &'a mut [usize],
    states: &'a mut [f64],
}

impl Blocks<'_> {
    /// The first `blocks`, if there are so many, and the others.
    fn split_at(self, blocks: usize) -> (Self, Self) {
        let blocks = blocks.min(self.count());
        self.split(blocks)
    }

    /// About as many densities as all of them ask for.
    fn densities(&self) -> usize {
        self.particles.len().saturating_mul(DENSITIES_PER_MOVE)
    }

    /// Shows each block's stream, particles and states to `work`.
    fn each(self, mut work: impl FnMut(&mut Stream, &mut [usize], &mut [f64])) {
        let particles = self.particles.chunks_mut(PATHS_TOGETHER);
        let states = self.states.chunks_mut(PATHS_TOGETHER * self.each);
        for ((stream, particles), states) in self.streams.iter_mut().zip(particles).zip(states) {
            work(stream, particles, states);
        }
    }
}

impl Pieces for Blocks<'_> {
    fn count(&self) -> usize {
        self.streams.len()
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let Blocks { each, streams, particles, states } = self;
        let paths = (blocks * PATHS_TOGETHER).min(particles.len());
        let (streams, later_streams) = streams.split_at_mut(blocks);
        let (particles, later_particles) = particles.split_at_mut(paths);
        let (states, later_states) = states.split_at_mut(paths * each);
        (
            Blocks { each, streams, particles, states },
            Blocks { each, streams: later_streams, particles: later_particles, states: later_states },
        )
    }
}
