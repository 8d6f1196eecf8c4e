//! A model in the space of its noise: states as a map of standard normal numbers, and what a measurement says of these.

mod by_sub_steps;
mod guided;
mod linearised;
mod of_equations;
mod scores;
mod sites;

use super::lanes::Lanes;
use crate::Step;
pub use guided::Guide;

/// A model whose states are made of standard normal noise: `x_t = g(x_{t−1}, v_t)` with `v_t ~ N(0, I_Q)`, one number for each draw.
///
/// A proposal of `v_t` is weighed by its own density against that of `v_t`, so the density of `x_t` is not needed: states may have coordinates without noise, share
/// draws, and be counts.
///
/// Tiles have [`LANES`](crate::batch::LANES) particles, coordinates in rows.
pub trait NoiseSpace: Sync {
    /// The `Q` draws of a step, in order; they are the same from any state. Where no time passes there are none.
    fn draws(&self, step: &Step<'_>) -> Vec<Draw>;

    /// Whether two steps are alike: all that is asked here of one has the same answer in the other, so that a tile may hold states of both.
    fn are_alike(&self, one: &Step<'_>, other: &Step<'_>) -> bool;

    /// `g(x_{t−1}, v_t)` of `noise` (`Q × LANES`) into `states` (`N × LANES`), or `x_0` where there is no previous state.
    fn tile_states(&self, step: &Step<'_>, previous: Option<&[f64]>, noise: &[f64], states: &mut [f64]);

    /// Draws `v_t` from a Gaussian, and makes `states` (`N × LANES`) of it: `g(x_{t−1}, v_t)`, or `x_0` where there is no previous state. `noise` (`Q × LANES`) holds
    /// standard normal numbers, and is used up.
    ///
    /// It returns `log q − log p` of what was drawn: densities of `v_i` for a continuous draw, probabilities for a count, each given the draws before it. The probability
    /// of a count `n` is the mass of the `v_i` between its ends, which may be nearly those of the transport; later draws are conditioned on the most likely of these.
    fn tile_guided_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        guide: Guide<'_>,
        noise: &mut [f64],
        states: &mut [f64],
    ) -> Lanes;

    /// What each entry of `measurement` (`M`, one number for each particle) says of `v` near 0, where draws are taken to be `mean + sd·v`: `slopes` gets
    /// `∂ log p(y | θ)/∂θ` of its location `θ(g(x_{t−1}, v))`, `information` its Fisher information (`M × LANES` each), and `jacobian` gets `∂θ/∂v` (`M × Q × LANES`). An
    /// entry that is missing says nothing: zeros.
    fn tile_noise_scores(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    );

    /// `g(x_{t−1}, v_t)` of the first `particles` of a tile into `states` (`N × LANES`), and its derivatives into `jacobian`: along the noise (`N × Q × LANES`), along the
    /// noise and then along the previous state (`N × (Q + N) × LANES`), or none (empty). Other lanes are left as they were.
    ///
    /// A count is taken to be `mean + sd·v` here, so that there are derivatives.
    fn tile_linearised(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        noise: &[f64],
        particles: usize,
        states: &mut [f64],
        jacobian: &mut [f64],
    );

    /// What a measurement (`M`, one number for each particle) says at the `states` (`N × LANES`) of the first `particles` of a tile: `slopes` gets the score
    /// `∂ log p(y | x)/∂x` (`N × LANES`), and `roots` gets `R` (`2M × N × LANES`), of which `Rᵀ R` is the Fisher information of `x` by locations and scales. What is missing, or not
    /// finite, says nothing. Other lanes are left as they were.
    fn tile_sites(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        particles: usize,
        slopes: &mut [f64],
        roots: &mut [f64],
    );
}

/// What a draw is, seen from its noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Draw {
    /// A normal number: affine in its noise.
    Normal,
    /// Another continuous number.
    Continuous,
    /// A count: the same in an interval of its noise.
    Count,
}
