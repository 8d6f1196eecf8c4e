//! How the states of a tile of particles are made: what transports and moments come from.

use super::advance::make_state;
use super::lanes::Lanes;
use super::noise_space::{Draw, NoiseSpace};
use super::statement::{Draws, Equations};
use super::tiles::rows_of;
use crate::{StateSpaceModel, Step};

/// A model that makes the states of a tile of particles of draws, one for each coordinate and in order.
pub(crate) trait TileStates {
    /// Whether all coordinates are normal, of `x_0` and of later states.
    fn is_affine(&self) -> bool;

    /// Makes `x_t` given `previous` (`N × LANES`), or `x_0` where there is none, into `states` (`N`).
    fn draw_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        draws: &mut impl Draws<Lanes>,
        states: &mut [Lanes],
    );
}

/// Transitions whose families are looked at: they may depend on the time, never on states.
const PROBES: usize = 8;

impl<E: Equations> TileStates for E {
    fn is_affine(&self) -> bool {
        let is_normal = |index| {
            let draws = self.draws(&self.step_of_index(index));
            draws.iter().all(|draw| *draw == Draw::Normal)
        };
        (0..=PROBES).all(is_normal)
    }

    #[inline(always)]
    fn draw_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        draws: &mut impl Draws<Lanes>,
        states: &mut [Lanes],
    ) {
        step.lift(|step| make_state(self, step, previous.map(rows_of), draws, states));
    }
}
