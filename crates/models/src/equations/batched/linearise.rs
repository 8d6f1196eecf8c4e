//! Batched equations linearised: moments, and what a measurement says of states near by.

use super::super::lanes::Lanes;
use super::super::linearise::{Linearise, moments_of_states};
use super::super::tiles::rows_of_mut;
use super::super::varied::{SIDE, Varied, put, side};
use super::Batched;
use super::memo::BatchQuery;
use crate::batch::LANES;
use crate::{StateSpaceModel, Step};

impl Linearise for Batched {
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
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let n = self.state_dim();
        slopes.fill(0.0);
        information.fill(0.0);
        jacobian.fill(0.0);
        let (slopes, information, jacobian) =
            (rows_of_mut(slopes), rows_of_mut(information), rows_of_mut(jacobian));
        let is_known = |at: usize| measurement.get(at).copied().flatten();
        let asked = self.scored_by();
        let (stated, first) = self.of_tile(asked, step, states);
        for (at, one) in stated.iter().flat_map(|stated| stated.iter()).enumerate() {
            let Some(y) = is_known(at) else { continue };
            let score = one.tile(first).score(y);
            (slopes[at], information[at]) = (score.slope, score.information);
            if asked != BatchQuery::Slopes {
                continue;
            }
            for lane in (0..LANES).step_by(SIDE) {
                for along in 0..n {
                    let score = one.side(first + lane, Some(along)).score(Varied::constant(side(&y, lane)));
                    put(score.location.derivatives()[0], lane, &mut jacobian[at * n + along]);
                }
            }
        }
    }
}
