//! A graph-diffusion system as what linearised and learned proposals ask of it.

use super::batches::drifted;
use super::system::GraphDiffusion;
use crate::batch::with_scratch;
use crate::equations::{Draws, Lanes, Linearise, TileStates, moments_of_states, rows_of};
use crate::linear_measurements::tile_scores;
use crate::{Noise, StateSpaceModel, Step};

impl TileStates for GraphDiffusion {
    fn is_affine(&self) -> bool {
        self.noise == Noise::Gaussian
    }

    fn draw_states(
        &self,
        _step: &Step<'_>,
        previous: Option<&[f64]>,
        draws: &mut impl Draws<Lanes>,
        states: &mut [Lanes],
    ) {
        let Some(previous) = previous else {
            // Its covariance is the identity.
            for (state, mean) in states.iter_mut().zip(self.initial.mean()) {
                *state = draws.draw(Noise::Gaussian.around(1.0, Lanes::from(*mean)));
            }
            return;
        };
        with_scratch(previous.len(), |flow| {
            drifted(self, previous, flow);
            for (state, flow) in states.iter_mut().zip(rows_of(flow)) {
                *state = draws.draw(self.noise.around(self.state_sigma, *flow));
            }
        });
    }
}

impl Linearise for GraphDiffusion {
    fn tile_moments(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        means: &mut [f64],
        variances: &mut [f64],
    ) {
        moments_of_states(self, step, previous, means, variances);
    }

    fn tile_scores(
        &self,
        _step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let rows = (0..self.measurement_dim()).map(|row| self.measure.row(row));
        let noise = (self.noise, self.measurement_sigma);
        tile_scores(noise, rows, states, measurement, [slopes, information, jacobian]);
    }
}
