//! The units in which heads speak: `x = T(x_{t−1}, b + L⁻ᵀ u)`, or `x = g(x_{t−1}, b + L⁻ᵀ u)` where states have no density, for the particles of a tile.

use bytemuck::TransparentWrapper;
use motes_models::batch::{LANES, by_widest_vectors};
use motes_models::equations::triangle::{at, solve_lower, solve_upper, times_upper};
use motes_models::equations::{Lanes, Linearise, NoiseSpace, Scalar, Transport};
use motes_models::{LN_2PI, Step};

use super::base::{Base, Site};
use super::inputs::innovation;

/// Memory of numbers lent as lanes.
///
/// # Panics
/// If they are not whole rows.
pub(super) fn lanes(numbers: &mut [f64]) -> &mut [Lanes] {
    let (rows, rest) = numbers.as_chunks_mut::<LANES>();
    assert!(rest.is_empty(), "a tile has whole rows");
    Lanes::wrap_slice_mut(rows)
}

/// How many numbers there are of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sizes {
    /// `N`, of a state.
    pub(super) states: usize,
    /// Of `v` and `u`: `N`, or `Q` where states have no density.
    pub(super) units: usize,
}

impl Sizes {
    /// How many rows of a tile the units take: `T(0)`, its slopes, `b`, and the triangle of `L`.
    pub(super) fn rows(self) -> usize {
        let Sizes { states, units } = self;
        states + 2 * units + units * (units + 1) / 2
    }

    /// How many rows of scratch finding them takes, for measurements of `m` entries.
    pub(super) fn scratch_rows(self, m: usize) -> usize {
        self.units + m * (self.units + 2)
    }
}

/// The units of a tile, in memory of [`Sizes::rows`] rows.
pub(super) struct Units<'a> {
    /// `T(x_{t−1}, 0)` or `g(x_{t−1}, 0)`, `N`.
    centres: &'a mut [Lanes],
    /// `∂T_i/∂v_i` at 0, `N`.
    slopes: &'a mut [Lanes],
    /// `b`.
    shift: &'a mut [Lanes],
    /// `L`, its lower triangle.
    lower: &'a mut [Lanes],
}

/// What a tile's units are asked of: a model at one step, and the states before.
pub(super) struct Place<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) step: Step<'a>,
    /// `x_{t−1}`, `N × LANES`; none at `t = 0`.
    pub(super) previous: Option<&'a [f64]>,
    /// Whether `T` is affine.
    pub(super) is_affine: bool,
    /// The model in the space of its noise, where states have no density.
    pub(super) noise: Option<&'a dyn NoiseSpace>,
}

impl<'a> Units<'a> {
    /// Those in `memory`.
    pub(super) fn of(memory: &'a mut [f64], sizes: Sizes) -> Self {
        let (centres, rest) = lanes(memory).split_at_mut(sizes.states);
        let (slopes, rest) = rest.split_at_mut(sizes.units);
        let (shift, lower) = rest.split_at_mut(sizes.units);
        Units { centres, slopes, shift, lower }
    }

    /// Finds the units around which `base` places particles for `measurement` (`M`), and writes the inputs of the networks, not yet in standard units.
    pub(super) fn find<M: Linearise + Transport + ?Sized>(
        &mut self,
        place: &Place<'_, M>,
        base: Base,
        measurement: &[Option<Lanes>],
        inputs: &mut [Lanes],
        scratch: &mut [f64],
    ) {
        let Place { model, step, previous, noise, .. } = *place;
        let (n, q, m) = (self.centres.len(), self.shift.len(), measurement.len());
        let (centres, slopes) = (&mut *self.centres, &mut *self.slopes);
        let (pull, rest) = lanes(scratch).split_at_mut(q);
        let (said, rest) = rest.split_at_mut(m);
        let (information, jacobian) = rest.split_at_mut(m);
        let jacobian = &mut jacobian[..m * q];
        match noise {
            None => {
                model.tile_centres(&step, previous, flat_mut(centres), flat_mut(slopes));
                model.tile_scores(
                    &step,
                    flat(centres),
                    measurement,
                    flat_mut(said),
                    flat_mut(information),
                    flat_mut(jacobian),
                );
            }
            Some(noise) => {
                pull.fill(Lanes::from(0.0));
                noise.tile_states(&step, previous, flat(pull), flat_mut(centres));
                // Derivatives are along the noise as they come.
                slopes.fill(Lanes::from(1.0));
                noise.tile_noise_scores(
                    &step,
                    previous,
                    measurement,
                    flat_mut(said),
                    flat_mut(information),
                    flat_mut(jacobian),
                );
            }
        }
        by_widest_vectors(
            #[inline(always)]
            || {
                // Along the noise.
                for row in jacobian.chunks_exact_mut(q) {
                    for (entry, slope) in row.iter_mut().zip(&*slopes) {
                        *entry = *entry * *slope;
                    }
                }
                let (of_states, of_measurement) = inputs.split_at_mut(inputs.len() - 2 * m);
                if let Some(previous) = previous {
                    let (before, predicted) = of_states.split_at_mut(n);
                    flat_mut(before).copy_from_slice(previous);
                    predicted.copy_from_slice(centres);
                }
                let (measured, innovations) = of_measurement.split_at_mut(m);
                for (measured, entry) in measured.iter_mut().zip(measurement) {
                    *measured = entry.unwrap_or(Lanes::from(0.0));
                }
                for (j, found) in innovations.iter_mut().enumerate() {
                    *found = innovation(said[j], information[j], &jacobian[j * q..][..q]);
                }
                let said = Site { slopes: said, information, jacobian };
                base.place(said, self.shift, self.lower, pull);
            },
        );
    }

    /// Replaces `u` by the noise `v = b + L⁻ᵀ u` that it stands for.
    pub(super) fn to_noise(&self, values: &mut [Lanes]) {
        by_widest_vectors(
            #[inline(always)]
            || {
                solve_upper(self.shift.len(), self.lower, values);
                for (value, shift) in values.iter_mut().zip(&*self.shift) {
                    *value = *value + *shift;
                }
            },
        );
    }

    /// Replaces `v` by `u = Lᵀ (v − b)`. It gives `log |det L|`, and `log N(v; 0, I) − log |det L|`: the log-density of `v` with respect to `u`.
    pub(super) fn noise_to_units(&self, values: &mut [Lanes]) -> [Lanes; 2] {
        by_widest_vectors(
            #[inline(always)]
            || {
                let mut of_noise = Lanes::from(-0.5 * LN_2PI * values.len() as f64);
                for (value, shift) in values.iter_mut().zip(&*self.shift) {
                    of_noise = of_noise - *value * *value * 0.5;
                    *value = *value - *shift;
                }
                times_upper(self.shift.len(), self.lower, values);
                let log_determinant = self.log_determinant();
                [log_determinant, of_noise - log_determinant]
            },
        )
    }

    /// Replaces `u` by the state that it stands for, and adds `−log |det ∂x/∂u|` to `log_density` if there is one.
    pub(super) fn to_states<M: Transport + ?Sized>(
        &self,
        place: &Place<'_, M>,
        values: &mut [Lanes],
        log_density: Option<&mut Lanes>,
    ) {
        let is_asked = log_density.is_some();
        self.to_noise(values);
        let mut log_slope = Lanes::from(0.0);
        if place.is_affine {
            for (i, value) in values.iter_mut().enumerate() {
                if is_asked {
                    log_slope = log_slope + self.slopes[i].ln();
                }
                *value = self.centres[i] + self.slopes[i] * *value;
            }
        } else {
            let Place { model, step, previous, .. } = *place;
            model.tile_from_normal(&step, previous, flat_mut(values), &mut log_slope.0);
        }
        if let Some(log_density) = log_density {
            let log_determinant = by_widest_vectors(
                #[inline(always)]
                || self.log_determinant(),
            );
            *log_density = *log_density + log_determinant - log_slope;
        }
    }

    /// Replaces states by their `u`. It gives `log |det ∂u/∂x|`, and the log-density of the transition with respect to `u`.
    ///
    /// Outside of the transition's support the first is −∞, and `u` is 0.
    pub(super) fn to_units<M: Transport + ?Sized>(
        &self,
        place: &Place<'_, M>,
        values: &mut [Lanes],
    ) -> [Lanes; 2] {
        let mut log_slope = Lanes::from(0.0);
        if place.is_affine {
            for (i, value) in values.iter_mut().enumerate() {
                log_slope = log_slope + self.slopes[i].ln();
                *value = (*value - self.centres[i]) / self.slopes[i];
            }
        } else {
            let Place { model, step, previous, .. } = *place;
            model.tile_to_normal(&step, previous, flat_mut(values), &mut log_slope.0);
            for value in values.iter_mut() {
                for (number, log_slope) in value.0.iter_mut().zip(&mut log_slope.0) {
                    if !number.is_finite() {
                        (*number, *log_slope) = (0.0, f64::INFINITY);
                    }
                }
            }
        }
        let [log_determinant, of_noise] = self.noise_to_units(values);
        [log_determinant - log_slope, of_noise]
    }

    /// Replaces `∂f/∂x` in `slopes` by `∂/∂u [f(x) + log N(v; 0, I)] = L⁻¹ (T′ ∘ ∂f/∂x − v)`, at `x` in `states`, which is used up, with its `u` in `units`.
    ///
    /// `log N(v; 0, I)` is the log-density of the transition and `Σ_i log T′_i`, so that no derivative of `T′` is needed.
    pub(super) fn pull_to_units<M: Transport + ?Sized>(
        &self,
        place: &Place<'_, M>,
        states: &mut [Lanes],
        units: &[Lanes],
        slopes: &mut [Lanes],
    ) {
        let n = self.centres.len();
        if place.is_affine {
            states.copy_from_slice(self.slopes);
        } else {
            place.model.tile_slopes(&place.step, place.previous, flat_mut(states));
        }
        by_widest_vectors(
            #[inline(always)]
            || {
                for (slope, transport) in slopes.iter_mut().zip(&*states) {
                    *slope = *slope * *transport;
                }
                // v, in the place of the slopes of the transport.
                states.copy_from_slice(units);
                solve_upper(n, self.lower, states);
                for ((slope, v), shift) in slopes.iter_mut().zip(&*states).zip(&*self.shift) {
                    *slope = *slope - (*v + *shift);
                }
                solve_lower(n, self.lower, slopes);
            },
        );
    }

    /// `Σ_i log L_ii`.
    #[inline(always)]
    pub(super) fn log_determinant(&self) -> Lanes {
        let mut sum = Lanes::from(0.0);
        for i in 0..self.shift.len() {
            sum = sum + self.lower[at(i, i)].ln();
        }
        sum
    }
}

/// Lanes as the numbers that they are.
pub(super) fn flat(lanes: &[Lanes]) -> &[f64] {
    bytemuck::cast_slice(lanes)
}

/// [`flat`] to be written.
pub(super) fn flat_mut(lanes: &mut [Lanes]) -> &mut [f64] {
    bytemuck::cast_slice_mut(lanes)
}

/// `−½ |u|² − (N/2) log 2π`: the density of the base itself.
#[inline(always)]
pub(super) fn log_standard_normal(u: &[Lanes]) -> Lanes {
    let mut sum = Lanes::from(-0.5 * LN_2PI * u.len() as f64);
    for value in u {
        sum = sum - *value * *value * 0.5;
    }
    sum
}
