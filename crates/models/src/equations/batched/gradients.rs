//! The gradients of batched equations, from derivatives of their parameters.

use super::super::distribution::Distribution;
use super::super::lanes::Lanes;
use super::super::tiles::rows_of_mut;
use super::super::varied::{SIDE, Side, Varied, put};
use super::Batched;
use super::column::BatchDistribution;
use super::memo::BatchQuery;
use crate::batch::{LANES, store, with_scratch};
use crate::{StateGradients, StateSpaceModel, Step};

/// The derivatives of the sum of all coordinates' log densities along each of `n` coordinates, for `K` particles, into `out` (`K×N`): `of` gives a coordinate's
/// distribution and value, with derivatives along one of them, for the few particles from a number on.
fn fill(
    n: usize,
    coordinates: usize,
    out: &mut [f64],
    mut of: impl FnMut(usize, usize, usize) -> (Distribution<Varied<2>>, Varied<2>),
) {
    with_scratch(n * LANES, |tile| {
        for (number, out) in out.chunks_mut(n * LANES).enumerate() {
            let rows = rows_of_mut(tile);
            for lane in (0..LANES).step_by(SIDE) {
                for (along, row) in rows.iter_mut().enumerate() {
                    let mut sum = Side::from(0.0);
                    for coordinate in 0..coordinates {
                        let (distribution, value) = of(number * LANES + lane, along, coordinate);
                        sum = sum + distribution.log_density(value).derivatives()[0];
                    }
                    put(sum, lane, row);
                }
            }
            store(tile, n, out);
        }
    });
}

/// The numbers of a coordinate of a few rows; 0 where there is none.
fn of_rows(rows: &[f64], n: usize, first: usize, coordinate: usize) -> Side {
    let mut found = [0.0; SIDE];
    let there = rows.get(first * n..).unwrap_or_default().chunks_exact(n);
    found.iter_mut().zip(there).for_each(|(found, row)| *found = row[coordinate]);
    Lanes(found)
}

/// `x_i`, whose derivative along itself is 1.
fn variable(value: Side, is_along: bool) -> Varied<2> {
    if is_along { Varied::variable(value, 0) } else { Varied::constant(value) }
}

/// Along the values themselves.
fn along_values(stated: Option<&[BatchDistribution]>, n: usize, states: &[f64], out: &mut [f64]) {
    let Some(stated) = stated.filter(|stated| stated.len() == n) else { return out.fill(f64::NAN) };
    fill(n, n, out, |first, along, coordinate| {
        let distribution = stated[coordinate].side(first, None);
        (distribution, variable(of_rows(states, n, first, coordinate), along == coordinate))
    });
}

impl StateGradients for Batched {
    fn has_gradients(&self) -> bool {
        self.equations.has_slopes()
    }

    fn initial_gradients(&self, _step: &Step<'_>, states: &[f64], d_states: &mut [f64]) {
        along_values(self.equations.initial().as_deref(), self.state_dim(), states, d_states);
    }

    fn transition_gradients(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        let (n, step) = (self.state_dim(), &self.seen(BatchQuery::Transition, step));
        let stated =
            self.equations.has_slopes().then(|| self.equations.transition_slopes(step, previous, false));
        let stated = stated.flatten();
        along_values(stated.as_deref(), n, states, d_states);
        let Some(stated) = stated.filter(|stated| stated.len() == n) else {
            return d_previous.fill(f64::NAN);
        };
        fill(n, n, d_previous, |first, along, coordinate| {
            let value = Varied::constant(of_rows(states, n, first, coordinate));
            (stated[coordinate].side(first, Some(along)), value)
        });
    }

    fn likelihood_gradients(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[f64],
        d_states: &mut [f64],
    ) {
        let (n, step) = (self.state_dim(), &self.seen(BatchQuery::Slopes, step));
        let stated =
            self.equations.has_slopes().then(|| self.equations.measurement_slopes(step, states, false));
        let Some(stated) = stated.flatten().filter(|stated| stated.len() == measurement.len()) else {
            return d_states.fill(f64::NAN);
        };
        fill(n, stated.len(), d_states, |first, along, coordinate| {
            (stated[coordinate].side(first, Some(along)), Varied::from(measurement[coordinate]))
        });
    }
}
