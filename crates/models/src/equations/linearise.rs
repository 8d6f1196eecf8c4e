//! What a linearised proposal asks of a model: moments of the transition, and what a measurement says of states near by.

use super::distribution::Distribution;
use super::family::Score;
use super::lanes::Lanes;
use super::statement::{Coordinates, Draws, Equations};
use super::tile_states::TileStates;
use super::tiles::{rows_of, rows_of_mut, with_scalars};
use super::varied::{SIDE, Side, Varied, put, side, vary};
use super::wrapped::Wrapped;
use crate::batch::{LANES, by_widest_vectors};
use crate::{StateSpaceModel, Step};

/// A model whose transition has moments, and whose measurement can be linearised in the state: coordinates of both are independent given the past.
///
/// All arguments are tiles of [`LANES`] particles, coordinates in rows.
pub trait Linearise: StateSpaceModel {
    /// Mean and variance of each coordinate of `x_t` given `previous` (`N × LANES`), or of `x_0` where there is none; location and squared
    /// scale where the variance is infinite. Of a model without a density of states the variances are those of the first `N` draws.
    fn tile_moments(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        means: &mut [f64],
        variances: &mut [f64],
    );

    /// What each entry of `measurement` (`M`, one number for each particle) says at `states` (`N × LANES`) of its location `θ(x_t)`: `slopes` gets `∂ log p(y | θ)/∂θ`, `information` its
    /// Fisher information (`M × LANES` each), and `jacobian` gets `∂θ/∂x_t` (`M × N × LANES`). An entry that is missing says nothing: zeros.
    fn tile_scores(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    );
}

/// Answers draws with their means, and keeps their variances.
struct Moments<'a> {
    variances: &'a mut [Lanes],
    at: usize,
}

impl Draws<Lanes> for Moments<'_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        let [mean, variance] = distribution.moments();
        if let Some(place) = self.variances.get_mut(self.at) {
            *place = variance;
        }
        self.at += 1;
        mean
    }
}

/// Keeps the scores of particles from `lane` on, with the derivatives of locations along some coordinates from `first` on.
pub(super) struct Scores<'a> {
    pub(super) measurement: &'a [Option<Lanes>],
    pub(super) lane: usize,
    pub(super) first: usize,
    pub(super) n: usize,
    pub(super) slopes: &'a mut [Lanes],
    pub(super) information: &'a mut [Lanes],
    pub(super) jacobian: &'a mut [Lanes],
    pub(super) at: usize,
}

impl Scores<'_> {
    /// Keeps what the next entry says.
    #[inline(always)]
    fn keep<const E: usize>(&mut self, of: impl FnOnce(Varied<E>) -> Score<Varied<E>>) {
        let (at, lane) = (self.at, self.lane);
        self.at += 1;
        let Some(entry) = self.measurement.get(at) else { return };
        let jacobian = &mut self.jacobian[at * self.n..][self.first..self.n];
        let zero = Side::from(0.0);
        let Some(y) = entry else {
            put(zero, lane, &mut self.slopes[at]);
            put(zero, lane, &mut self.information[at]);
            jacobian.iter_mut().for_each(|place| put(zero, lane, place));
            return;
        };
        let score = of(Varied::constant(side(y, lane)));
        put(score.slope.value(), lane, &mut self.slopes[at]);
        put(score.information.value(), lane, &mut self.information[at]);
        for (place, derivative) in jacobian.iter_mut().zip(score.location.derivatives()) {
            put(*derivative, lane, place);
        }
    }
}

impl<const E: usize> Coordinates<Varied<E>> for Scores<'_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Varied<E>>) {
        self.keep(|y| distribution.score(y));
    }

    #[inline(never)]
    fn push_wrapped(&mut self, wrapped: &Wrapped<'_, Varied<E>>) {
        self.keep(|y| wrapped.score(y));
    }

    /// Its slope and information were found along the first coordinates; along these it does not change.
    #[inline(always)]
    fn pass_over(&mut self) {
        let row = self.at * self.n;
        self.at += 1;
        let Some(jacobian) = self.jacobian.get_mut(row + self.first..row + self.n) else { return };
        jacobian.iter_mut().take(E - 1).for_each(|place| put(Side::from(0.0), self.lane, place));
    }
}

/// What [`Linearise::tile_scores`] asks for.
struct ScoreQuery<'a, M> {
    model: &'a M,
    step: &'a Step<'a>,
    states: &'a [Lanes],
    measurement: &'a [Option<Lanes>],
    slopes: &'a mut [Lanes],
    information: &'a mut [Lanes],
    jacobian: &'a mut [Lanes],
}

impl<M: Equations> ScoreQuery<'_, M> {
    /// Finds it along `E − 1` coordinates at a time.
    fn along<const E: usize>(&mut self) {
        let ScoreQuery { model, step, states, measurement, slopes, information, jacobian } = self;
        let n = states.len();
        step.lift(|step| {
            with_scalars::<Varied<E>, _>(n, |point| {
                by_widest_vectors(
                    #[inline(always)]
                    || {
                        for lane in (0..LANES).step_by(SIDE) {
                            for first in (0..n).step_by(E - 1) {
                                vary(states, lane, first, point);
                                let (slopes, information, jacobian) =
                                    (&mut **slopes, &mut **information, &mut **jacobian);
                                let mut scores = Scores {
                                    measurement,
                                    lane,
                                    first,
                                    n,
                                    slopes,
                                    information,
                                    jacobian,
                                    at: 0,
                                };
                                // Along the first ones all are asked for, with their slopes and information.
                                let along = if first == 0 { 0..n } else { first..(first + E - 1).min(n) };
                                model.measurement_along(step, &*point, along, &mut scores);
                            }
                        }
                    },
                );
            })
        });
    }
}

/// Mean and variance of each coordinate that a model draws; NaN for those that it leaves out.
pub(crate) fn moments_of_states(
    model: &impl TileStates,
    step: &Step<'_>,
    previous: Option<&[f64]>,
    means: &mut [f64],
    variances: &mut [f64],
) {
    means.fill(f64::NAN);
    let mut moments = Moments { variances: rows_of_mut(variances), at: 0 };
    model.draw_states(step, previous, &mut moments, rows_of_mut(means));
}

impl<E: Equations> Linearise for E {
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
        let mut asked = ScoreQuery {
            model: self,
            step: &step.end(self.inputs().len()),
            states: rows_of(states),
            measurement,
            slopes: rows_of_mut(slopes),
            information: rows_of_mut(information),
            jacobian: rows_of_mut(jacobian),
        };
        match asked.states.len() {
            0 => {}
            1 => asked.along::<2>(),
            _ => asked.along::<3>(),
        }
    }
}
