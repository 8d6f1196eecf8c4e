//! What a bank shows between two steps.

use std::ops::Deref;

use motes_models::{StateSpaceModel, Step, Stream};

use super::filter_bank::FilterBank;
use crate::diagnosis::{WeightDiagnosis, tail_length, tail_within, upper_end_of_sorted};
use crate::error::FilterError;
use crate::proposal::Proposal;
use crate::weights::LogWeights;

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// `B`, the number of filters.
    pub fn filters(&self) -> usize {
        self.streams.len()
    }

    /// What each filter draws from.
    pub(crate) fn streams(&self) -> &[Stream] {
        &self.streams
    }

    /// How many steps have been taken.
    pub fn time(&self) -> usize {
        self.time
    }

    /// The last step that was taken, or failed.
    pub fn last_step(&self) -> Step<'_> {
        self.last.step()
    }

    /// The particles of one filter, row-major `K×N`, as they are before resampling.
    ///
    /// # Panics
    /// If there is no such filter.
    pub fn particles(&self, filter: usize) -> &[f64] {
        let values = self.settings.particles * self.model.state_dim();
        &self.states[filter * values..(filter + 1) * values]
    }

    /// The particles of one filter a step before, row-major `K×N`, as they were before resampling; `None` where there was no step before.
    /// [`FilterBank::ancestors`] says which of them each of the present ones descends from.
    ///
    /// In a bank that has failed they are the `x_{t−1}` of the step that failed, and the ancestors are those of that step: where an error names particle
    /// `k` of filter `b`, its `x_{t−1}` is row `ancestors[b·K + k] − b·K` here.
    ///
    /// # Panics
    /// If there is no such filter.
    pub fn previous_particles(&self, filter: usize) -> Option<&[f64]> {
        let values = self.settings.particles * self.model.state_dim();
        let previous = &self.previous[filter * values..(filter + 1) * values];
        (self.time + usize::from(self.failure.is_some()) > 1).then_some(previous)
    }

    /// The error that this bank failed with, if it has: every later step returns it.
    pub fn failure(&self) -> Option<&FilterError> {
        self.failure.as_ref()
    }

    /// The weights of one filter's particles.
    ///
    /// # Panics
    /// If there is no such filter.
    pub fn weights(&self, filter: usize) -> &LogWeights {
        &self.weights[filter]
    }

    /// For each particle of the whole bank (`B·K`), the row it descends from in the step before; itself where its
    /// filter did not resample.
    pub fn ancestors(&self) -> &[usize] {
        &self.ancestors
    }

    /// What the weights of all particles of the bank (`B·K`) have of later measurements, into `out`; whether they have something.
    pub(crate) fn log_look_ahead(&self, out: &mut [f64]) -> bool {
        let index = self.time.saturating_sub(1);
        self.proposal.log_look_ahead(&*self.model, index, &self.states, out)
    }

    /// Whether a filter drew ancestors in the last step; if not, weights go on from the step before.
    ///
    /// # Panics
    /// If there is no such filter.
    pub fn resampled(&self, filter: usize) -> bool {
        self.resampled[filter]
    }

    /// What every particle of the bank carries beside its state.
    pub fn memory(&self) -> &P::Memory {
        &self.memory
    }

    /// What the weights of the last step say about how far they can be trusted.
    ///
    /// The tail index is that of `W_{t−1} p(y|x) p(x|x') / q`, of all filters together; it takes a pass over all of them. Filters that collapsed have no
    /// effective particles and no part in the index.
    pub fn diagnosis(&self) -> WeightDiagnosis {
        let is_there = |filter: usize| self.log_evidence[filter] > f64::NEG_INFINITY;
        let mut logs = Vec::with_capacity(self.ancestors.len());
        for (filter, (weights, outcome)) in self.weights.iter().zip(&self.outcomes).enumerate() {
            if let Some(increment) = outcome.increment.as_ref().ok().filter(|_| is_there(filter)) {
                logs.extend(weights.log().iter().map(|log| log + increment));
            }
        }
        let sizes = self.weights.iter().enumerate().map(|(filter, weights)| match is_there(filter) {
            true => weights.effective_sample_size(),
            false => 0.0,
        });
        let effective_sample_size = sizes.sum::<f64>() / self.weights.len() as f64;
        let tail = tail_within(&mut logs);
        let sorted = tail_length(logs.len());
        WeightDiagnosis {
            time: self.time.saturating_sub(1),
            particles: self.settings.particles,
            effective_sample_size,
            pareto_k: tail.map(|tail| tail.index),
            tail_weights: tail.map_or(0, |tail| tail.weights),
            upper_end: upper_end_of_sorted(&mut logs, sorted),
        }
    }

    /// The estimate of `log p(y_{0:t})` by one filter; its exponential is unbiased.
    ///
    /// # Panics
    /// If there is no such filter.
    pub fn log_evidence(&self, filter: usize) -> f64 {
        self.log_evidence[filter]
    }

    /// One filter's estimate of `E[x_t | y_{0:t}]`, `Σ_k W_k x_k`, into `mean` (`N`).
    ///
    /// # Panics
    /// If there is no such filter or `mean` has not `N` places.
    pub fn mean(&self, filter: usize, mean: &mut [f64]) {
        assert_eq!(mean.len(), self.model.state_dim(), "the mean has N coordinates");
        self.weights[filter].mean(self.particles(filter), mean);
    }

    /// Quantiles of one coordinate of `x_t` given `y_{0:t}` as one filter estimates them: for each probability `p` the smallest value that
    /// particles with a weight of at least `p` together do not exceed.
    ///
    /// # Panics
    /// If there is no such filter or coordinate, or a probability is not between 0 and 1.
    pub fn quantiles(&self, filter: usize, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        let width = self.model.state_dim();
        assert!(coordinate < width, "a state has {width} coordinates");
        let values = self.particles(filter).iter().skip(coordinate).step_by(width);
        self.weights[filter].quantiles(values.copied(), probabilities)
    }
}
