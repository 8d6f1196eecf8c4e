//! Smoothing by looking back along the paths that a filter's particles descend on.

use std::collections::VecDeque;
use std::ops::Deref;

use motes_models::{StateSpaceModel, Step};

use crate::error::FilterError;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// A filter that remembers the last `L` generations of its particles, and so also estimates `E[x_{t−ℓ} | y_{0:t}]` for each `ℓ ≤ L`.
///
/// Each particle stands for the path that led to it, whose weight is the particle's (Kitagawa's fixed-lag smoother). Paths of many
/// generations share a few ancestors: a lag that is small against the number of particles keeps many of them apart.
/// Memory is `(L + 1)·K·(N + 1)` numbers.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed};
/// use motes_smc::{Bootstrap, FilterSettings, FixedLagSmoother, ParticleFilter};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// let stream = Seed::from_u64(7).stream();
/// let filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(1000), stream)?;
/// let mut smoother = FixedLagSmoother::new(filter, 2);
/// let mut mean = [0.0];
/// for measurement in [[0.3], [1.2], [0.7]] {
///     smoother.step(&measurement)?;
/// }
/// // E[x_0 | y_0, y_1, y_2].
/// smoother.mean(2, &mut mean)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FixedLagSmoother<D: Deref, P: Proposal<D::Target>> {
    filter: ParticleFilter<D, P>,
    lag: usize,
    /// The oldest first; the last is the present.
    generations: VecDeque<Generation>,
    /// Of each particle, its ancestor in the generation that is looked at.
    paths: Vec<usize>,
}

#[derive(Default)]
struct Generation {
    states: Vec<f64>,
    /// The particles of the generation before from which these descend.
    ancestors: Vec<usize>,
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FixedLagSmoother<D, P> {
    /// Looks back `lag` times from each step of `filter` on.
    pub fn new(filter: ParticleFilter<D, P>, lag: usize) -> Self {
        FixedLagSmoother { filter, lag, generations: VecDeque::new(), paths: Vec::new() }
    }

    /// Takes in one measurement (`M` numbers).
    ///
    /// # Errors
    /// As [`ParticleFilter::step`].
    pub fn step(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        self.filter.step(measurement)?;
        self.remember();
        Ok(())
    }

    /// Takes in one measurement (`M` entries), some or all of which may be missing, by a step of its own time, length, inputs and parameters.
    ///
    /// # Errors
    /// As [`ParticleFilter::step_at`].
    pub fn step_at(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        self.filter.step_at(step, measurement)?;
        self.remember();
        Ok(())
    }

    /// Keeps the present generation, in the place of one that is too old.
    fn remember(&mut self) {
        let mut generation = match self.generations.len() > self.lag {
            true => self.generations.pop_front().unwrap_or_default(),
            false => Generation::default(),
        };
        generation.states.clear();
        generation.states.extend_from_slice(self.filter.particles());
        generation.ancestors.clear();
        generation.ancestors.extend_from_slice(self.filter.ancestors());
        self.generations.push_back(generation);
    }

    /// The filter, as it is after the last step.
    pub fn filter(&self) -> &ParticleFilter<D, P> {
        &self.filter
    }

    /// How many times one can look back now: the lag, or fewer while less has happened; `None` before the first step.
    pub fn reach(&self) -> Option<usize> {
        self.generations.len().checked_sub(1)
    }

    /// The estimate of `E[x_{t−back} | y_{0:t}]`, `t` being the time of the last step, into `mean` (`N`).
    ///
    /// # Errors
    /// [`FilterError::Setting`] if `back` is beyond [`FixedLagSmoother::reach`], as everything is before the first step.
    ///
    /// # Panics
    /// If `mean` has not `N` places.
    pub fn mean(&mut self, back: usize, mean: &mut [f64]) -> Result<(), FilterError> {
        let Some(at) = self.reach().and_then(|reach| reach.checked_sub(back)) else {
            return Err(FilterError::Setting {
                name: "how many times a smoother is to look back",
                value: back.to_string(),
                expected: "at most the lag and fewer than the steps taken",
            });
        };
        let particles = self.filter.weights().len();
        self.paths.clear();
        self.paths.extend(0..particles);
        for generation in self.generations.range(at + 1..).rev() {
            self.paths.iter_mut().for_each(|path| *path = generation.ancestors[*path]);
        }
        let width = mean.len();
        let states = &self.generations[at].states;
        assert_eq!(particles * width, states.len(), "the mean has N coordinates");
        mean.fill(0.0);
        let paths = self.filter.weights().normalised().iter().zip(&self.paths);
        for (weight, path) in paths.filter(|(weight, _)| **weight > 0.0) {
            let state = &states[path * width..(path + 1) * width];
            mean.iter_mut().zip(state).for_each(|(mean, value)| *mean += weight * value);
        }
        Ok(())
    }
}
