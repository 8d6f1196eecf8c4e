//! What a proposal made of transformed noise asks of a model: its transition as a transport of standard normal noise.

use super::distribution::{Distribution, Normal};
use super::lanes::Lanes;
use super::scalar::Scalar;
use super::statement::Draws;
use super::tile_states::TileStates;
use super::tiles::rows_of_mut;
use crate::batch::{LANES, with_scratch};
use crate::gaussian::LN_2PI;
use crate::{StateSpaceModel, Step};

/// A model whose transition is a transport of standard normal noise: `x_t = T(x_{t−1}, v_t)`, coordinate by coordinate and growing with `v_t`.
///
/// `v_t` is standard normal where `x_t` has the distribution `p(x_t | x_{t−1})`, and `p(x_0)` where there is no previous state. A density `q(v)` becomes that of `x_t`
/// as `log q(x_t) = log q(v) − Σ_i log ∂T_i/∂v_i`.
///
/// All arguments are tiles of [`LANES`] particles, coordinates in rows. All is NaN where a coordinate is a count.
pub trait Transport: StateSpaceModel {
    /// Whether `T` is affine in `v`: all coordinates are normal, of `x_0` and of the first few transitions.
    fn is_affine(&self) -> bool;

    /// `T(x_{t−1}, 0)`, the median, into `centres`, and `∂T_i/∂v_i` there into `slopes` (`N × LANES` each).
    fn tile_centres(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        centres: &mut [f64],
        slopes: &mut [f64],
    );

    /// Replaces `v` in `values` by `T(x_{t−1}, v)` (`N × LANES`), and writes `Σ_i log ∂T_i/∂v_i` into `log_slope` (`LANES`).
    fn tile_from_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    );

    /// Replaces `x` in `values` by the `v` with `T(x_{t−1}, v) = x` (`N × LANES`), and writes `Σ_i log ∂T_i/∂v_i` there into `log_slope` (`LANES`).
    ///
    /// At and beyond an end of the range `v` is infinite, and the log slope means nothing.
    fn tile_to_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    );

    /// Replaces `x` in `values` by `∂T_i/∂v_i` at the `v` with `T(x_{t−1}, v) = x` (`N × LANES`), coordinate by coordinate.
    fn tile_slopes(&self, step: &Step<'_>, previous: Option<&[f64]>, values: &mut [f64]);
}

impl Distribution<Lanes> {
    /// `T(v)` and `log T′(v)` of each particle.
    #[inline(always)]
    fn tile_transport(&self, v: Lanes) -> [Lanes; 2] {
        match self.formula(v) {
            Some(found) => found,
            None => self.lane_by_lane(v, |of_lane, v| of_lane.transport(v)),
        }
    }

    /// `T⁻¹(x)` and `log T′` there.
    #[inline(always)]
    fn tile_inverse(&self, x: Lanes) -> [Lanes; 2] {
        let v = self.to_normal(x);
        let log_slope = match self {
            Distribution::Normal(Normal { sd, .. }) => sd.ln(),
            // The density of what is pushed is that of v over the slope.
            _ => v * v * -0.5 - 0.5 * LN_2PI - self.log_density(x),
        };
        [v, log_slope]
    }

    /// What `of` makes of each particle's distribution and number.
    pub(super) fn lane_by_lane(
        &self,
        values: Lanes,
        of: impl Fn(Distribution<f64>, f64) -> [f64; 2],
    ) -> [Lanes; 2] {
        let [mut first, mut second] = [[0.0; LANES]; 2];
        for (lane, (first, second)) in first.iter_mut().zip(&mut second).enumerate() {
            [*first, *second] = of(self.map(|parameter| parameter.0[lane]), values.0[lane]);
        }
        [Lanes(first), Lanes(second)]
    }
}

/// Answers draws with their medians, and keeps the slopes there.
pub(super) struct Centres<'a> {
    slopes: &'a mut [Lanes],
    at: usize,
}

impl Draws<Lanes> for Centres<'_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        let [centre, slope] = match distribution {
            Distribution::Normal(Normal { mean, sd }) => [mean, sd],
            _ => {
                let [centre, log_slope] = distribution.tile_transport(Lanes::from(0.0));
                [centre, log_slope.exp()]
            }
        };
        if let Some(place) = self.slopes.get_mut(self.at) {
            *place = slope;
        }
        self.at += 1;
        centre
    }
}

/// The median of each coordinate that `draw` draws, and the slope there; NaN for those that it leaves out.
pub(super) fn centres_of(
    draw: impl FnOnce(&mut Centres<'_>, &mut [Lanes]),
    centres: &mut [f64],
    slopes: &mut [f64],
) {
    centres.fill(f64::NAN);
    slopes.fill(f64::NAN);
    draw(&mut Centres { slopes: rows_of_mut(slopes), at: 0 }, rows_of_mut(centres));
}

/// What a draw is, what replaces the number of its coordinate, and a log slope.
struct Replacement {
    drawn: Lanes,
    value: Lanes,
    log_slope: Lanes,
}

/// Replaces the number of each coordinate, and adds up log slopes; `of` is asked for all of it.
struct Replaced<'a, F> {
    rows: &'a mut [Lanes],
    log_slope: Lanes,
    of: F,
}

impl<F: Fn(&Distribution<Lanes>, Lanes) -> Replacement> Draws<Lanes> for Replaced<'_, F> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        match std::mem::take(&mut self.rows) {
            [] => {
                self.log_slope = Lanes::from(f64::NAN);
                self.log_slope
            }
            [row, rest @ ..] => {
                let Replacement { drawn, value, log_slope } = (self.of)(&distribution, *row);
                *row = value;
                self.log_slope = self.log_slope + log_slope;
                self.rows = rest;
                drawn
            }
        }
    }
}

/// Replaces `values` by what `of` makes of each coordinate's distribution and number; NaN where another number of coordinates is drawn than there is.
#[inline(always)]
fn replace(
    model: &impl TileStates,
    step: &Step<'_>,
    previous: Option<&[f64]>,
    values: &mut [f64],
    log_slope: &mut [f64],
    of: impl Fn(&Distribution<Lanes>, Lanes) -> Replacement,
) {
    with_scratch(values.len(), |unused| {
        let mut replaced = Replaced { rows: rows_of_mut(values), log_slope: Lanes::from(0.0), of };
        model.draw_states(step, previous, &mut replaced, rows_of_mut(unused));
        let is_whole = replaced.rows.is_empty();
        replaced.rows.fill(Lanes::from(f64::NAN));
        let sum = if is_whole { replaced.log_slope } else { Lanes::from(f64::NAN) };
        log_slope.copy_from_slice(&sum.0[..log_slope.len()]);
    });
}

impl<M: TileStates + StateSpaceModel> Transport for M {
    fn is_affine(&self) -> bool {
        TileStates::is_affine(self)
    }

    fn tile_centres(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        centres: &mut [f64],
        slopes: &mut [f64],
    ) {
        centres_of(|draws, states| self.draw_states(step, previous, draws, states), centres, slopes);
    }

    fn tile_from_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        replace(self, step, previous, values, log_slope, |distribution, v| {
            let [drawn, log_slope] = distribution.tile_transport(v);
            Replacement { drawn, value: drawn, log_slope }
        });
    }

    fn tile_to_normal(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        replace(self, step, previous, values, log_slope, |distribution, drawn| {
            let [value, log_slope] = distribution.tile_inverse(drawn);
            Replacement { drawn, value, log_slope }
        });
    }

    fn tile_slopes(&self, step: &Step<'_>, previous: Option<&[f64]>, values: &mut [f64]) {
        let mut unused = [0.0; LANES];
        replace(self, step, previous, values, &mut unused, |distribution, drawn| {
            let [_, log_slope] = distribution.tile_inverse(drawn);
            Replacement { drawn, value: log_slope.exp(), log_slope }
        });
    }
}
