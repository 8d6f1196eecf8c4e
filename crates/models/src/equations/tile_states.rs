//! How the states of a tile of particles are made: what transports and moments come from.

use super::distribution::Distribution;
use super::lanes::Lanes;
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

/// Looks whether all coordinates are normal.
struct Families {
    all_normal: bool,
}

impl Draws<f64> for Families {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        self.all_normal &= matches!(distribution, Distribution::Normal { .. });
        distribution.moments()[0]
    }
}

impl<E: Equations> TileStates for E {
    fn is_affine(&self) -> bool {
        let [n, _] = self.dimensions();
        let mut families = Families { all_normal: true };
        // The means of x_0, x_1, …
        let [mut before, mut state] = [vec![0.0; n], vec![0.0; n]];
        self.initial(&self.step_of_index(0), &mut families, &mut state);
        for index in 1..=PROBES {
            std::mem::swap(&mut before, &mut state);
            self.transition(&self.step_of_index(index), &before, &mut families, &mut state);
        }
        families.all_normal
    }

    #[inline(always)]
    fn draw_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        draws: &mut impl Draws<Lanes>,
        states: &mut [Lanes],
    ) {
        step.lift(|step| match previous {
            None => self.initial(step, draws, states),
            Some(previous) => self.transition(step, rows_of(previous), draws, states),
        });
    }
}
