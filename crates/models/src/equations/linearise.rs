//! What a linearised proposal asks of a model: moments of the transition, and what a measurement says of states near by.

use super::distribution::Distribution;
use super::gradients::{DIRECTIONS, Varied, vary};
use super::lanes::Lanes;
use super::statement::{Coordinates, Equations};
use super::tiles::{rows_of, rows_of_mut, with_scalars};
use crate::StateSpaceModel;
use crate::batch::LANES;

/// A model whose transition has moments, and whose measurement can be linearised in the state: coordinates of both are independent given the past.
///
/// All arguments are tiles of [`LANES`] particles, coordinates in rows.
pub trait Linearise: StateSpaceModel {
    /// Mean and variance of each coordinate of `x_t` given `previous` (`N × LANES`), or of `x_0` where there is none; location and squared
    /// scale where the variance is infinite.
    fn tile_moments(&self, time: usize, previous: Option<&[f64]>, means: &mut [f64], variances: &mut [f64]);

    /// What each entry of `measurement` (`M`, one number for each particle) says at `states` (`N × LANES`) of its location `θ(x_t)`: `slopes` gets `∂ log p(y | θ)/∂θ`, `information` its
    /// Fisher information (`M × LANES` each), and `jacobian` gets `∂θ/∂x_t` (`M × N × LANES`). An entry that is missing says nothing: zeros.
    fn tile_scores(
        &self,
        time: usize,
        states: &[f64],
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    );
}

/// Keeps the moments of each coordinate.
struct Moments<'a> {
    means: &'a mut [Lanes],
    variances: &'a mut [Lanes],
    at: usize,
}

impl Coordinates<Lanes> for Moments<'_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Lanes>) {
        if let (Some(mean), Some(variance)) = (self.means.get_mut(self.at), self.variances.get_mut(self.at)) {
            [*mean, *variance] = distribution.moments();
        }
        self.at += 1;
    }
}

/// Keeps scores, with the derivatives of locations along some coordinates from `first` on.
struct Scores<'a> {
    measurement: &'a [Option<Lanes>],
    first: usize,
    n: usize,
    slopes: &'a mut [Lanes],
    information: &'a mut [Lanes],
    jacobian: &'a mut [Lanes],
    at: usize,
}

impl Coordinates<Varied> for Scores<'_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Varied>) {
        let at = self.at;
        self.at += 1;
        let Some(entry) = self.measurement.get(at) else { return };
        let jacobian = &mut self.jacobian[at * self.n..][self.first..self.n];
        let zero = Lanes([0.0; LANES]);
        let Some(y) = entry else {
            (self.slopes[at], self.information[at]) = (zero, zero);
            jacobian.fill(zero);
            return;
        };
        let score = distribution.score(Varied::constant(*y));
        self.slopes[at] = score.slope.value();
        self.information[at] = score.information.value();
        for (place, derivative) in jacobian.iter_mut().zip(score.location.derivatives()) {
            *place = *derivative;
        }
    }
}

impl<E: Equations> Linearise for E {
    fn tile_moments(&self, time: usize, previous: Option<&[f64]>, means: &mut [f64], variances: &mut [f64]) {
        means.fill(f64::NAN);
        let mut moments = Moments { means: rows_of_mut(means), variances: rows_of_mut(variances), at: 0 };
        match previous {
            None => self.initial(&mut moments),
            Some(previous) => self.transition(time, rows_of(previous), &mut moments),
        }
    }

    fn tile_scores(
        &self,
        time: usize,
        states: &[f64],
        measurement: &[Option<Lanes>],
        slopes: &mut [f64],
        information: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let [n, _] = self.dimensions();
        let (slopes, information, jacobian) =
            (rows_of_mut(slopes), rows_of_mut(information), rows_of_mut(jacobian));
        with_scalars::<Varied, _>(n, |point| {
            for first in (0..n).step_by(DIRECTIONS) {
                vary(rows_of(states), first, point);
                let (slopes, information, jacobian) = (&mut *slopes, &mut *information, &mut *jacobian);
                let mut scores = Scores { measurement, first, n, slopes, information, jacobian, at: 0 };
                self.measurement(time, point, &mut scores);
            }
        });
    }
}
