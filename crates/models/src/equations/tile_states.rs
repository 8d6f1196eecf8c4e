//! How the states of a tile of particles are distributed: what transports and moments are made from.

use super::distribution::Distribution;
use super::lanes::Lanes;
use super::statement::{Coordinates, Equations};
use super::tiles::rows_of;
use crate::{Seed, StateSpaceModel, Step};

/// A model that says how the coordinates of each particle's state are distributed, independently of each other given the past.
pub(crate) trait TileStates {
    /// Whether all coordinates are normal, of `x_0` and of later states.
    fn is_affine(&self) -> bool;

    /// Pushes the distribution of each coordinate of `x_t` given `previous` (`N × LANES`), or of `x_0` where there is none.
    fn push_states(&self, step: &Step<'_>, previous: Option<&[f64]>, states: &mut impl Coordinates<Lanes>);
}

/// Transitions whose families are looked at: they may depend on the time, never on states.
const PROBES: usize = 8;

/// Looks whether all coordinates are normal.
struct Families {
    all_normal: bool,
}

impl Coordinates<f64> for Families {
    fn push(&mut self, distribution: Distribution<f64>) {
        self.all_normal &= matches!(distribution, Distribution::Normal { .. });
    }
}

impl<E: Equations> TileStates for E {
    fn is_affine(&self) -> bool {
        let [n, _] = self.dimensions();
        let mut families = Families { all_normal: true };
        self.initial(&mut families);
        // A state that is likely, from a stream of its own.
        let mut state = vec![0.0; n];
        self.sample_initial(&mut Seed::from_u64(0).child("transport").stream(), &mut state);
        (1..=PROBES).for_each(|index| self.transition(&self.step_of_index(index), &state, &mut families));
        families.all_normal
    }

    #[inline(always)]
    fn push_states(&self, step: &Step<'_>, previous: Option<&[f64]>, states: &mut impl Coordinates<Lanes>) {
        match previous {
            None => self.initial(states),
            Some(previous) => step.lift(|step| self.transition(step, rows_of(previous), states)),
        }
    }
}
