//! The defensive mixture: draws of any proposal, made safe by a share of the transition.

use motes_models::batch::with_scratch;
use motes_models::{StateSpaceModel, Stream};
use rand::RngExt;

use super::bootstrap::Transition;
use super::log_add::log_add_all;
use crate::proposal::Conditional;

/// `(1 − α) q(x_t | past, y_t) + α p(x_t | x_{t−1})` of a block of particles, the density of which it states exactly.
pub(crate) struct Defensive<'a, C, M: ?Sized> {
    pub(crate) base: C,
    pub(crate) transition: Transition<'a, M>,
    /// `α`, between 0 and 1.
    pub(crate) weight: f64,
}

impl<C: Conditional, M: StateSpaceModel + ?Sized> Defensive<'_, C, M> {
    /// Draws `states` (`R×N`), from the base or from the transition, and writes `log` of the mixture's density into `mixture` (`R`) and of the
    /// transition's into `transition` (`R`).
    pub(crate) fn draw(
        &mut self,
        streams: &mut [Stream],
        states: &mut [f64],
        mixture: &mut [f64],
        transition: &mut [f64],
    ) {
        let particles = mixture.len();
        let (width, each) = (states.len() / particles.max(1), particles / streams.len().max(1));
        // Both components draw for every particle: their streams then advance by the same amount whatever is chosen.
        // Densities come after the choice, of what was chosen.
        self.base.sample_states(streams, states, mixture);
        with_scratch(states.len(), |safe| {
            self.transition.sample(streams, safe, transition);
            let rows = states.chunks_exact_mut(width.max(1)).zip(safe.chunks_exact(width.max(1)));
            for (row, (state, safe)) in rows.enumerate() {
                if streams[row / each].random::<f64>() < self.weight {
                    state.copy_from_slice(safe);
                }
            }
        });
        self.base.log_density(states, mixture);
        self.transition.log_density(states, transition);
        let (log_base, log_safe) = ((-self.weight).ln_1p(), self.weight.ln());
        log_add_all(mixture, log_base, |row| transition[row], log_safe);
    }
}

#[cfg(test)]
mod tests {
    use faer::mat;
    use motes_models::{Gaussian, LinearGaussian, Seed, Step};

    use super::*;
    use crate::{Context, MinDegeneracy, Proposal};

    #[test]
    fn what_is_drawn_has_the_density_of_the_mixture() {
        let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
        let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]]).unwrap();
        let (count, measurement) = (2000, [1.3]);
        let previous = vec![0.4; count];
        let context = Context::new(Step::of_index(1), Some(&previous), count);
        let mut proposal = MinDegeneracy::new(&model).unwrap();
        let scratch = &mut ();
        let base = proposal.condition_batch(&model, context, &measurement, &mut (), scratch).unwrap();
        let (mut states, mut of_mixture, mut of_transition) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let streams = &mut [Seed::from_u64(3).stream()];
        let mut mixture = Defensive { base, transition: Transition::new(&model, context), weight: 0.25 };
        mixture.draw(streams, &mut states, &mut of_mixture, &mut of_transition);
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
