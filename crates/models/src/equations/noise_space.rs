//! A model in the space of its noise: states as a map of standard normal numbers, and what a measurement says of these.

mod guided;
mod scores;

use super::distribution::Distribution;
use super::lanes::Lanes;
use super::statement::{Draws, Equations};
use super::tiles::{rows_of, rows_of_mut};
use crate::batch::{LANES, by_widest_vectors};
use crate::{StateSpaceModel, Step};
pub use guided::Guide;
use guided::Guided;
use scores::NoiseScores;

/// A model whose states are made of standard normal noise: `x_t = g(x_{t−1}, v_t)` with `v_t ~ N(0, I_Q)`, one number for each draw.
///
/// A proposal of `v_t` is weighed by its own density against that of `v_t`, so the density of `x_t` is not needed: states may have coordinates without noise, share
/// draws, and be counts.
///
/// Tiles have [`LANES`] particles, coordinates in rows.
pub trait NoiseSpace: StateSpaceModel {
    /// The `Q` draws of a step, in order; they are the same from any state.
    fn draws(&self, step: &Step<'_>) -> Vec<Draw>;

    /// `g(x_{t−1}, v_t)` of `noise` (`Q × LANES`) into `states` (`N × LANES`), or `x_0` where there is no previous state.
    fn tile_states(&self, step: &Step<'_>, previous: Option<&[f64]>, noise: &[f64], states: &mut [f64]);

    /// Draws `v_t` from a Gaussian, and makes `states` (`N × LANES`) of it: `g(x_{t−1}, v_t)`, or `x_0` where there is no previous state. `noise` (`Q × LANES`) holds
    /// standard normal numbers, and is used up.
    ///
    /// It returns `log q − log p` of what was drawn: densities of `v_i` for a continuous draw, probabilities for a count, each given the draws before it. The probability
    /// of a count `n` is the mass of the `v_i` that are transported to it; later draws are conditioned on the most likely of these.
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

impl Distribution<Lanes> {
    /// What the noise of each particle is transported to.
    #[inline(always)]
    fn tile_from_normal(&self, v: Lanes) -> Lanes {
        match self.formula(v) {
            Some([value, _]) => value,
            None => {
                let mut lanes = [0.0; LANES];
                for (lane, value) in lanes.iter_mut().enumerate() {
                    *value = self.map(|parameter| parameter.0[lane]).from_normal(v.0[lane]);
                }
                Lanes(lanes)
            }
        }
    }
}

/// Keeps what each draw is, and answers with its mean.
struct DrawList(Vec<Draw>);

impl Draws<f64> for DrawList {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        self.0.push(match distribution {
            Distribution::Normal { .. } => Draw::Normal,
            _ if distribution.is_discrete() => Draw::Count,
            _ => Draw::Continuous,
        });
        distribution.moments()[0]
    }
}

/// Answers each draw with what its noise is transported to; NaN where there are more draws than noise.
struct Transported<'a> {
    noise: &'a [Lanes],
}

impl Draws<Lanes> for Transported<'_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        let Some((v, rest)) = self.noise.split_first() else { return Lanes::from(f64::NAN) };
        self.noise = rest;
        distribution.tile_from_normal(*v)
    }
}

impl<M: Equations> NoiseSpace for M {
    fn draws(&self, step: &Step<'_>) -> Vec<Draw> {
        let [n, _] = self.dimensions();
        let (mut list, mut state) = (DrawList(Vec::new()), vec![0.0; n]);
        self.initial(&self.step_of_index(0), &mut list, &mut state);
        if step.index > 0 {
            let previous = state.clone();
            list.0.clear();
            self.transition(step, &previous, &mut list, &mut state);
        }
        list.0
    }

    fn tile_states(&self, step: &Step<'_>, previous: Option<&[f64]>, noise: &[f64], states: &mut [f64]) {
        let mut transported = Transported { noise: rows_of(noise) };
        let states = rows_of_mut(states);
        by_widest_vectors(
            #[inline(always)]
            || {
                step.lift(|step| match previous {
                    None => self.initial(step, &mut transported, states),
                    Some(previous) => self.transition(step, rows_of(previous), &mut transported, states),
                });
            },
        );
        // A number that no draw took is as wrong as one that is missing.
        if !transported.noise.is_empty() {
            states.fill(Lanes::from(f64::NAN));
        }
    }

    fn tile_guided_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        guide: Guide<'_>,
        noise: &mut [f64],
        states: &mut [f64],
    ) -> Lanes {
        let mut guided = Guided::new(guide, rows_of_mut(noise));
        let states = rows_of_mut(states);
        by_widest_vectors(
            #[inline(always)]
            || {
                step.lift(|step| match previous {
                    None => self.initial(step, &mut guided, states),
                    Some(previous) => self.transition(step, rows_of(previous), &mut guided, states),
                });
            },
        );
        guided.log_ratio()
    }

    fn tile_noise_scores(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let draws = jacobian.len() / (measurement.len() * LANES).max(1);
        let mut scores = NoiseScores {
            model: self,
            step,
            previous: previous.map(rows_of),
            draws,
            measurement,
            slopes: rows_of_mut(slopes),
            information: rows_of_mut(information),
            jacobian: rows_of_mut(jacobian),
        };
        match draws {
            0 => {}
            1 => scores.along::<2>(),
            _ => scores.along::<5>(),
        }
    }
}
