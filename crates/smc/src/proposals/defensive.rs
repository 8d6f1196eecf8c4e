//! The defensive mixture: draws of any proposal, made safe by a share of the transition.

use motes_models::{StateSpaceModel, Stream};
use rand::RngExt;

use super::bootstrap::Transition;
use crate::Conditional;

/// Draws from `(1 − α) q(x_t | past, y_t) + α p(x_t | x_{t−1})`, the density of which it states exactly.
#[derive(Debug, Clone)]
pub(crate) struct Defensive {
    /// `α`.
    weight: f64,
    /// What the transition draws.
    states: Vec<f64>,
}

/// Where log-densities of `R` drawn states are written.
pub(crate) struct Densities<'a> {
    /// Of what they are drawn from.
    pub(crate) proposal: &'a mut [f64],
    /// Of the transition.
    pub(crate) transition: &'a mut [f64],
}

impl Defensive {
    /// A mixture with this share of the transition, between 0 and 1.
    pub(crate) fn new(weight: f64) -> Self {
        Defensive { weight, states: Vec::new() }
    }

    /// Draws `states` (`R×N`), from `base` or from the transition.
    pub(crate) fn draw<M: StateSpaceModel + ?Sized>(
        &mut self,
        base: &mut impl Conditional,
        transition: &mut Transition<'_, M>,
        streams: &mut [Stream],
        states: &mut [f64],
        densities: Densities<'_>,
    ) {
        let width = transition.model.state_dim();
        self.states.resize(states.len(), 0.0);
        // Both components draw for every particle: their streams then advance by the same amount whatever is
        // chosen, and a bank stays one batch.
        base.sample(streams, states, densities.proposal);
        transition.sample(streams, &mut self.states, densities.transition);
        let block = transition.past.particles / streams.len().max(1);
        let rows = states.chunks_exact_mut(width).zip(self.states.chunks_exact(width));
        for (row, (state, safe)) in rows.enumerate() {
            if streams[row / block].random::<f64>() < self.weight {
                state.copy_from_slice(safe);
            }
        }
        base.log_density(states, densities.proposal);
        transition.log_density(states, densities.transition);
        let (log_base, log_safe) = ((-self.weight).ln_1p(), self.weight.ln());
        for (base, safe) in densities.proposal.iter_mut().zip(&*densities.transition) {
            let (a, b) = (*base + log_base, safe + log_safe);
            let largest = a.max(b);
            if largest > f64::NEG_INFINITY {
                *base = largest + ((a - largest).exp() + (b - largest).exp()).ln();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::mat;
    use motes_models::{Gaussian, LinearGaussian, Seed};

    use super::*;
    use crate::{MinDegeneracy, Past, Proposal};

    #[test]
    fn what_is_drawn_has_the_density_of_the_mixture() {
        let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
        let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]]).unwrap();
        let (count, measurement) = (2000, [1.3]);
        let previous = vec![0.4; count];
        let past = Past { time: 1, previous: Some(&previous), measurement: &measurement, particles: count };
        let mut proposal = MinDegeneracy::new(&model).unwrap();
        let mut base = proposal.condition(&model, past, &mut ()).unwrap();
        let mut transition = Transition { model: &model, past };
        let (mut states, mut of_mixture, mut of_transition) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let densities = Densities { proposal: &mut of_mixture, transition: &mut of_transition };
        let streams = &mut [Seed::from_u64(3).stream()];
        Defensive::new(0.25).draw(&mut base, &mut transition, streams, &mut states, densities);
        let normal = |x: f64, mean: f64, variance: f64| {
            (-0.5 * (x - mean) * (x - mean) / variance).exp() / (std::f64::consts::TAU * variance).sqrt()
        };
        let mut sum = 0.0;
        for (at, &x) in states.iter().enumerate() {
            // The optimum halves the distance between prediction and measurement, with half the variance.
            let (optimal, safe) = (normal(x, 0.5 * (0.36 + 1.3), 0.5), normal(x, 0.36, 1.0));
            let expected = 0.75 * optimal + 0.25 * safe;
            assert!((of_mixture[at].exp() / expected - 1.0).abs() < 1e-12, "at {x}");
            assert!((of_transition[at].exp() / safe - 1.0).abs() < 1e-12, "at {x}");
            sum += x;
        }
        // And the draws are its own: mean 0.75·0.83 + 0.25·0.36, variance 0.625 + 0.75·0.25·0.47².
        let (mean, deviation) = (0.7125, (0.625_f64 + 0.1875 * 0.47 * 0.47).sqrt());
        let z = (sum / count as f64 - mean) / (deviation / (count as f64).sqrt());
        assert!(z.abs() < 4.0, "z = {z}");
    }
}
