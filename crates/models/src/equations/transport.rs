//! What a learned proposal asks of a model: its transition as a transport of standard normal noise.

use super::distribution::Distribution;
use super::lanes::Lanes;
use super::scalar::Scalar;
use super::statement::{Coordinates, Equations};
use super::tails::log_normal_density;
use super::tiles::{rows_of, rows_of_mut, with_scalars};
use crate::StateSpaceModel;
use crate::batch::LANES;

/// A model whose transition is a transport of standard normal noise: `x_t = T(x_{t−1}, v_t)`, coordinate by coordinate, and `x_0 = T(v_0)`.
///
/// `T_i = F_i⁻¹ ∘ Φ` with the distribution function `F_i` of the coordinate. It is `mean + sd·v` where that is normal, and stays inside of the
/// range where there is one. All arguments are tiles of [`LANES`] particles, coordinates in rows.
pub trait Transport: StateSpaceModel {
    /// Whether `T` is affine in `v`, at every time: each coordinate of the state is normal.
    fn is_affine(&self) -> bool;

    /// `T(x_{t−1}, 0)`, the median, into `centres`, and `∂T_i/∂v_i` at `v = 0` into `slopes` (`N × LANES` each); of `x_0` where there is no `previous`
    /// (`N × LANES`).
    fn tile_centres(&self, time: usize, previous: Option<&[f64]>, centres: &mut [f64], slopes: &mut [f64]);

    /// Replaces `v` by `T(x_{t−1}, v)` in `values` (`N × LANES`), and writes `Σ_i log ∂T_i/∂v_i` there into `log_slope` (`LANES`).
    fn tile_from_normal(
        &self,
        time: usize,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    );

    /// Replaces `x` by the `v` with `T(x_{t−1}, v) = x` in `values` (`N × LANES`), and writes `Σ_i log ∂T_i/∂v_i` there into `log_slope` (`LANES`). Outside of
    /// the range `v` is infinite, and the slope means nothing.
    fn tile_to_normal(
        &self,
        time: usize,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    );
}

/// The distribution of one particle.
fn of_lane(distribution: &Distribution<Lanes>, lane: usize) -> Distribution<f64> {
    distribution.map(|parameter| parameter.0[lane])
}

/// Median and slope of each coordinate.
struct Centres<'a> {
    centres: &'a mut [Lanes],
    slopes: &'a mut [Lanes],
    at: usize,
}

impl Coordinates<Lanes> for Centres<'_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Lanes>) {
        let at = self.at;
        self.at += 1;
        let (Some(centre), Some(slope)) = (self.centres.get_mut(at), self.slopes.get_mut(at)) else { return };
        if let Distribution::Normal { mean, sd } = distribution {
            (*centre, *slope) = (mean, sd);
            return;
        }
        for lane in 0..LANES {
            let one = of_lane(&distribution, lane);
            let median = one.from_normal(0.0);
            centre.0[lane] = median;
            slope.0[lane] = (log_normal_density(0.0) - one.log_density(median)).exp();
        }
    }
}

/// Which way values are transported.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    FromNormal,
    ToNormal,
}

/// Transports each coordinate.
struct Transported<'a> {
    values: &'a mut [Lanes],
    log_slope: Lanes,
    way: Way,
    at: usize,
}

impl Coordinates<Lanes> for Transported<'_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Lanes>) {
        let at = self.at;
        self.at += 1;
        let Some(value) = self.values.get_mut(at) else { return };
        if let Distribution::Normal { mean, sd } = distribution {
            *value = match self.way {
                Way::FromNormal => mean + sd * *value,
                Way::ToNormal => (*value - mean) / sd,
            };
            self.log_slope = self.log_slope + sd.ln();
            return;
        }
        for (lane, value) in value.0.iter_mut().enumerate() {
            let one = of_lane(&distribution, lane);
            let (v, x) = match self.way {
                Way::FromNormal => (*value, one.from_normal(*value)),
                Way::ToNormal => (one.to_normal(*value), *value),
            };
            self.log_slope.0[lane] += log_normal_density(v) - one.log_density(x);
            *value = if self.way == Way::FromNormal { x } else { v };
        }
    }
}

/// Looks whether each coordinate is normal.
struct Families {
    are_normal: bool,
}

impl Coordinates<f64> for Families {
    fn push(&mut self, distribution: Distribution<f64>) {
        self.are_normal &= distribution.is_normal();
    }
}

/// Which family a coordinate has may depend on the time: so many are looked at.
const TIMES: usize = 4;

fn transport<E: Equations>(
    model: &E,
    time: usize,
    previous: Option<&[f64]>,
    values: &mut [f64],
    log_slope: &mut [f64],
    way: Way,
) {
    let values = rows_of_mut(values);
    let mut transported = Transported { values, log_slope: Lanes::from(0.0), way, at: 0 };
    match previous {
        None => model.initial(&mut transported),
        Some(previous) => model.transition(time, rows_of(previous), &mut transported),
    }
    log_slope.copy_from_slice(&transported.log_slope.0);
}

impl<E: Equations> Transport for E {
    fn is_affine(&self) -> bool {
        let [n, _] = self.dimensions();
        let mut families = Families { are_normal: true };
        self.initial(&mut families);
        with_scalars::<f64, _>(n, |state| {
            state.fill(0.0);
            (1..=TIMES).for_each(|time| self.transition(time, state, &mut families));
        });
        families.are_normal
    }

    fn tile_centres(&self, time: usize, previous: Option<&[f64]>, centres: &mut [f64], slopes: &mut [f64]) {
        centres.fill(f64::NAN);
        let mut found = Centres { centres: rows_of_mut(centres), slopes: rows_of_mut(slopes), at: 0 };
        match previous {
            None => self.initial(&mut found),
            Some(previous) => self.transition(time, rows_of(previous), &mut found),
        }
    }

    fn tile_from_normal(
        &self,
        time: usize,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        transport(self, time, previous, values, log_slope, Way::FromNormal);
    }

    fn tile_to_normal(
        &self,
        time: usize,
        previous: Option<&[f64]>,
        values: &mut [f64],
        log_slope: &mut [f64],
    ) {
        transport(self, time, previous, values, log_slope, Way::ToNormal);
    }
}
