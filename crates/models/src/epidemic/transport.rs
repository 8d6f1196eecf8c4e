//! An epidemic as what linearised and learned proposals ask of it.

use super::{Epidemic, MEASURED};
use crate::equations::{Draws, Lanes, Linearise, TileStates, moments_of_states, rows_of};
use crate::linear_measurements::tile_scores;
use crate::{Noise, Step};

impl TileStates for Epidemic {
    fn is_affine(&self) -> bool {
        self.config.noise == Noise::Gaussian
    }

    fn draw_states(
        &self,
        _step: &Step<'_>,
        previous: Option<&[f64]>,
        draws: &mut impl Draws<Lanes>,
        states: &mut [Lanes],
    ) {
        let [of_initial, of_states, _] = self.sigmas;
        let (means, sigma) = match previous.map(rows_of) {
            Some(&[s, i, r]) => {
                let [infect, remove] = self.rates;
                let (infected, removed) = (s * i * infect, i * remove);
                ([s - infected, i + infected - removed, r + removed], of_states)
            }
            // A past of another width is none of an epidemic: nothing is drawn, and all becomes NaN.
            Some(_) => return,
            None => (self.config.initial_means.map(Lanes::from), of_initial),
        };
        for (state, mean) in states.iter_mut().zip(means) {
            *state = draws.draw(self.config.noise.around(sigma, mean));
        }
    }
}

impl Linearise for Epidemic {
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
        let rows = MEASURED.map(|column| [(column, 1.0)]);
        let rows = rows.iter().map(<[_; 1]>::as_slice);
        let noise = (self.config.noise, self.sigmas[2]);
        tile_scores(noise, rows, states, measurement, [slopes, information, jacobian]);
    }
}
