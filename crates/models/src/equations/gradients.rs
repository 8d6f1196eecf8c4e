//! The gradients of what a model states, by numbers that carry derivatives.

use super::dual::Dual;
use super::lanes::Lanes;
use super::model::{OfMeasurement, OfStates};
use super::statement::Equations;
use super::tiles::{rows_of, rows_of_mut, with_scalars};
use crate::StateGradients;
use crate::batch::{LANES, load, store, with_scratch};

/// Derivatives along so many directions at a time.
pub(super) const DIRECTIONS: usize = 4;

/// A number with derivatives along [`DIRECTIONS`] directions, for each particle of a tile.
pub(super) type Varied = Dual<Lanes, { DIRECTIONS + 1 }>;

/// Makes `point` of `tile`, with the coordinates from `first` on as directions.
pub(super) fn vary(tile: &[Lanes], first: usize, point: &mut [Varied]) {
    for (coordinate, (varied, value)) in point.iter_mut().zip(tile).enumerate() {
        let direction = coordinate.checked_sub(first).filter(|direction| *direction < DIRECTIONS);
        *varied = match direction {
            Some(direction) => Varied::variable(*value, direction),
            None => Varied::constant(*value),
        };
    }
}

/// Asks `density` for its derivatives along all coordinates of `tile`, some at a time, and writes them into the rows of `slopes`.
///
/// `density` is asked with the point, and with as many scalars for its own use.
fn slopes_of(tile: &[Lanes], slopes: &mut [Lanes], density: impl Fn(&mut [Varied], &mut [Varied]) -> Varied) {
    with_scalars::<Varied, _>(2 * tile.len(), |scalars| {
        let (point, other) = scalars.split_at_mut(tile.len());
        for first in (0..tile.len()).step_by(DIRECTIONS) {
            vary(tile, first, point);
            let found = density(point, other);
            for (slope, derivative) in slopes[first..].iter_mut().zip(found.derivatives()) {
                *slope = *derivative;
            }
        }
    });
}

/// Fills `slopes` (`K×N`) tile by tile from `states` (`K×N`); `of_tile` is shown the first particle, the tile, and the rows to be written.
fn by_tiles(
    n: usize,
    states: &[f64],
    slopes: &mut [f64],
    mut of_tile: impl FnMut(usize, &[Lanes], &mut [Lanes]),
) {
    with_scratch(2 * n * LANES, |tiles| {
        let (tile, found) = tiles.split_at_mut(n * LANES);
        tile.fill(0.0);
        let blocks = states.chunks(n * LANES).zip(slopes.chunks_mut(n * LANES));
        for (number, (states, slopes)) in blocks.enumerate() {
            load(states, n, tile);
            of_tile(number * LANES, rows_of(tile), rows_of_mut(found));
            store(found, n, slopes);
        }
    });
}

impl<E: Equations> StateGradients for E {
    fn initial_gradients(&self, states: &[f64], d_states: &mut [f64]) {
        let [n, _] = self.dimensions();
        by_tiles(n, states, d_states, |_, tile, slopes| {
            slopes_of(tile, slopes, |point, _| {
                let mut density = OfStates::at(point);
                self.initial(&mut density);
                density.finish()
            });
        });
    }

    fn transition_gradients(
        &self,
        time: usize,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        let [n, _] = self.dimensions();
        let rows = |all: &[f64], first: usize, tile: &mut [f64]| {
            load(&all[first * n..((first + LANES) * n).min(all.len())], n, tile);
        };
        with_scratch(n * LANES, |other| {
            other.fill(0.0);
            by_tiles(n, previous, d_previous, |first, tile, slopes| {
                rows(states, first, other);
                let states = rows_of(other);
                slopes_of(tile, slopes, |point, now| {
                    vary(states, n, now);
                    let mut density = OfStates::at(now);
                    self.transition(time, point, &mut density);
                    density.finish()
                });
            });
            other.fill(0.0);
            by_tiles(n, states, d_states, |first, tile, slopes| {
                rows(previous, first, other);
                let previous = rows_of(other);
                slopes_of(tile, slopes, |point, before| {
                    vary(previous, n, before);
                    let mut density = OfStates::at(point);
                    self.transition(time, before, &mut density);
                    density.finish()
                });
            });
        });
    }

    fn likelihood_gradients(&self, time: usize, states: &[f64], measurement: &[f64], d_states: &mut [f64]) {
        let [n, _] = self.dimensions();
        by_tiles(n, states, d_states, |_, tile, slopes| {
            slopes_of(tile, slopes, |point, _| {
                let mut density = OfMeasurement::at(measurement);
                self.measurement(time, point, &mut density);
                density.finish()
            });
        });
    }
}
