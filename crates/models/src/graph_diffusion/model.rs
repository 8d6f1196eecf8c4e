//! A graph-diffusion system as a state-space model: draws, densities, gradients and moments.

use faer::{Mat, MatRef};

use super::batches;
use super::system::GraphDiffusion;
use crate::batch::{Rows, draw_rows, draw_single_rows};
use crate::{
    AdditiveGaussian, Gaussian, GraphModel, ModelError, Noise, Propagator, Simulator, StateGradients,
    StateSpaceModel, Step, Stream, SystemGraph, TransitionDensity,
};

impl StateSpaceModel for GraphDiffusion {
    fn state_dim(&self) -> usize {
        self.adjacency.nrows()
    }

    fn measurement_dim(&self) -> usize {
        self.measure.len()
    }

    fn sample_states(
        &self,
        _step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        let n = self.state_dim();
        if draw_single_rows(streams, n, states, |row, stream, state| {
            let Some(previous) = previous else { return self.initial.sample(stream, state) };
            for (i, value) in state.iter_mut().enumerate() {
                *value = self.diffused(i, previous.row(row)) + self.noise.sample(self.state_sigma, stream);
            }
        }) {
            return;
        }
        match previous {
            None => self.initial.samples(streams, states),
            Some(previous) => batches::sample_transitions(self, previous, streams, states),
        }
    }

    /// Entries are independent, so those that are there keep their densities.
    fn log_likelihoods(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        if measurement.iter().all(Option::is_some) {
            batches::log_likelihoods(self, states, measurement.iter().flatten(), out);
            return Ok(());
        }
        for (state, out) in states.chunks_exact(self.state_dim()).zip(out) {
            let residuals = measurement.iter().enumerate();
            let residuals =
                residuals.filter_map(|(i, value)| Some((*value)? - self.measure.row_times(i, state)));
            *out = self.noise.log_density_of_all(self.measurement_sigma, residuals);
        }
        Ok(())
    }

    fn log_likelihood(
        &self,
        _step: &Step<'_>,
        state: &[f64],
        measurement: &[f64],
    ) -> Result<f64, ModelError> {
        let residuals =
            measurement.iter().enumerate().map(|(i, value)| value - self.measure.row_times(i, state));
        Ok(self.noise.log_density_of_all(self.measurement_sigma, residuals))
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        Some(self)
    }

    fn propagator(&self) -> Option<&dyn Propagator> {
        Some(self)
    }
}

impl TransitionDensity for GraphDiffusion {
    fn log_density(&self, _step: &Step<'_>, previous: Option<&[f64]>, state: &[f64]) -> f64 {
        let Some(previous) = previous else { return self.initial.log_density(state) };
        let residuals = state.iter().enumerate().map(|(i, value)| value - self.diffused(i, previous));
        self.noise.log_density_of_all(self.state_sigma, residuals)
    }

    fn log_densities(&self, _step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        match previous {
            None => self.initial.log_densities(states, out),
            Some(previous) => batches::log_transitions(self, previous, states, out),
        }
    }
}

impl Propagator for GraphDiffusion {
    fn propagate(
        &self,
        step: &Step<'_>,
        previous: Rows<'_>,
        measurement: &[f64],
        streams: &mut [Stream],
        states: &mut [f64],
        log_likelihoods: &mut [f64],
    ) {
        if log_likelihoods.len() > streams.len() {
            return batches::propagate(self, previous, measurement, streams, states, log_likelihoods);
        }
        self.sample_states(step, Some(previous), streams, states);
        batches::log_likelihoods(self, states, measurement.iter(), log_likelihoods);
    }
}

/// `S = A`, and a measurement goes with weight 1 to each node that is in it: `Cᵀ` rescaled to ones.
impl GraphModel for GraphDiffusion {
    fn graph(&self) -> SystemGraph {
        let c = self.measurement_matrix.as_ref();
        let adapter = Mat::from_fn(c.ncols(), c.nrows(), |i, j| if c[(j, i)] != 0.0 { 1.0 } else { 0.0 });
        SystemGraph { shift: self.adjacency.clone(), adapter }
    }
}

impl Simulator for GraphDiffusion {
    fn sample_measurements(&self, _step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        let n = self.state_dim();
        draw_rows(streams, self.measurement_dim(), out, |row, stream, measurement| {
            let state = &states[row * n..(row + 1) * n];
            for (i, value) in measurement.iter_mut().enumerate() {
                *value = self.measure.row_times(i, state) + self.noise.sample(self.measurement_sigma, stream);
            }
        });
    }
}

impl StateGradients for GraphDiffusion {
    fn initial_gradients(&self, _step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        let n = self.state_dim();
        for (state, d_state) in states.chunks_exact(n).zip(d_states.chunks_exact_mut(n)) {
            self.initial.gradient(|j| state[j] - self.initial.mean()[j], d_state);
        }
    }

    fn transition_gradients(
        &self,
        _step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        let n = self.state_dim();
        d_previous.fill(0.0);
        for (row, previous) in previous.chunks_exact(n).enumerate() {
            let at = row * n..(row + 1) * n;
            for i in 0..n {
                let flow = self.diffuse.row_times(i, previous);
                let residual = states[at.start + i] - self.drift.apply(flow);
                let slope = self.noise.gradient(self.state_sigma, residual);
                d_states[at.start + i] = slope;
                let back = -slope * self.drift.slope(flow);
                for &(j, value) in self.diffuse.row(i) {
                    d_previous[at.start + j] += back * value;
                }
            }
        }
    }

    fn likelihood_gradients(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        let n = self.state_dim();
        d_states.fill(0.0);
        for (state, d_state) in states.chunks_exact(n).zip(d_states.chunks_exact_mut(n)) {
            for (i, value) in measurement.iter().enumerate() {
                let residual = value - self.measure.row_times(i, state);
                let slope = self.noise.gradient(self.measurement_sigma, residual);
                for &(j, entry) in self.measure.row(i) {
                    d_state[j] -= slope * entry;
                }
            }
        }
    }
}

impl AdditiveGaussian for GraphDiffusion {
    fn initial(&self) -> &Gaussian {
        &self.initial
    }

    fn transition_means(&self, _step: &Step<'_>, previous: &[f64], means: &mut [f64]) {
        batches::transition_means(self, previous, means);
    }

    fn tile_transition_means(
        &self,
        _step: &Step<'_>,
        previous: &[f64],
        _particles: usize,
        means: &mut [f64],
    ) {
        batches::drifted(self, previous, means);
    }

    fn is_gaussian(&self) -> bool {
        self.noise == Noise::Gaussian
    }

    fn transition_covariance(&self) -> MatRef<'_, f64> {
        self.state_covariance.as_ref()
    }

    fn measurement_matrix(&self) -> MatRef<'_, f64> {
        self.measurement_matrix.as_ref()
    }

    fn measurement_covariance(&self) -> MatRef<'_, f64> {
        self.measurement_covariance.as_ref()
    }
}
