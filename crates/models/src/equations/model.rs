//! What states its equations is a state-space model.

use super::distribution::Distribution;
use super::lanes::Lanes;
use super::sample::{draw_rows, needs_of};
use super::scalar::Scalar;
use super::statement::{Coordinates, Equations};
use super::tiles::rows_of;
use crate::batch::{LANES, Rows, by_widest_vectors, load, with_scratch};
use crate::{ModelError, PartialLikelihood, Simulator, StateSpaceModel, Step, Stream};

/// Adds up the log densities of coordinates at given values.
struct Density<'a, S, V> {
    values: &'a [V],
    sum: S,
}

impl<'a, S: Scalar, V> Density<'a, S, V> {
    fn at(values: &'a [V]) -> Self {
        Density { values, sum: S::from(0.0) }
    }

    /// Takes the next value; where there is none, the sum is NaN.
    #[inline(always)]
    fn next(&mut self) -> Option<&'a V> {
        let next = self.values.split_first();
        match next {
            Some((_, rest)) => self.values = rest,
            None => self.sum = S::from(f64::NAN),
        }
        next.map(|(value, _)| value)
    }

    /// The sum, if there was one distribution for each value.
    #[inline(always)]
    fn finish(self) -> S {
        if self.values.is_empty() { self.sum } else { S::from(f64::NAN) }
    }
}

/// At coordinates of states.
pub(super) struct OfStates<'a, S>(Density<'a, S, S>);

impl<'a, S: Scalar> OfStates<'a, S> {
    pub(super) fn at(values: &'a [S]) -> Self {
        OfStates(Density::at(values))
    }

    pub(super) fn finish(self) -> S {
        self.0.finish()
    }
}

impl<S: Scalar> Coordinates<S> for OfStates<'_, S> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<S>) {
        if let Some(value) = self.0.next() {
            self.0.sum = self.0.sum + distribution.log_density(*value);
        }
    }
}

/// At the entries of a measurement.
pub(super) struct OfMeasurement<'a, S>(Density<'a, S, f64>);

impl<'a, S: Scalar> OfMeasurement<'a, S> {
    pub(super) fn at(values: &'a [f64]) -> Self {
        OfMeasurement(Density::at(values))
    }

    pub(super) fn finish(self) -> S {
        self.0.finish()
    }
}

impl<S: Scalar> Coordinates<S> for OfMeasurement<'_, S> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<S>) {
        if let Some(value) = self.0.next() {
            self.0.sum = self.0.sum + distribution.log_density_of_one(*value);
        }
    }
}

/// At the entries of a measurement that are there: coordinates are independent, so the others integrate to 1.
pub(super) struct OfKnown<'a, S>(Density<'a, S, Option<f64>>);

impl<'a, S: Scalar> OfKnown<'a, S> {
    pub(super) fn at(values: &'a [Option<f64>]) -> Self {
        OfKnown(Density::at(values))
    }

    pub(super) fn finish(self) -> S {
        self.0.finish()
    }
}

impl<S: Scalar> Coordinates<S> for OfKnown<'_, S> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<S>) {
        if let Some(Some(value)) = self.0.next() {
            self.0.sum = self.0.sum + distribution.log_density_of_one(*value);
        }
    }
}

/// Shows the states of up to [`LANES`] particles after another as tiles, and writes a number for each particle.
fn over_tiles(
    width: usize,
    states: Rows<'_>,
    out: &mut [f64],
    mut of_tile: impl FnMut(usize, &[Lanes]) -> Lanes,
) {
    with_scratch(width * LANES, |tile| {
        // Lanes without a particle are computed, too: with numbers that are no danger.
        tile.fill(0.0);
        // All formulas by the widest vectors of the machine, as far as the compiler puts them in line. The numbers are the same by any.
        by_widest_vectors(
            #[inline(always)]
            || {
                for (number, out) in out.chunks_mut(LANES).enumerate() {
                    states.load(number * LANES, tile);
                    let found = of_tile(number * LANES, rows_of(tile));
                    out.copy_from_slice(&found.0[..out.len()]);
                }
            },
        );
    });
}

impl<E: Equations> StateSpaceModel for E {
    fn state_dim(&self) -> usize {
        self.dimensions()[0]
    }

    fn measurement_dim(&self) -> usize {
        self.dimensions()[1]
    }

    fn step_of_index(&self, index: usize) -> Step<'_> {
        Step { inputs: self.inputs(), parameters: self.parameters(), ..Step::of_index(index) }
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        self.sample_initials(std::slice::from_mut(stream), state);
    }

    fn sample_transition(&self, step: &Step<'_>, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        let previous = Rows::all(previous, previous.len());
        self.sample_transitions(step, previous, std::slice::from_mut(stream), state);
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        let mut density = OfStates::at(state);
        self.initial(&mut density);
        density.finish()
    }

    fn log_transition(&self, step: &Step<'_>, previous: &[f64], state: &[f64]) -> f64 {
        let mut density = OfStates::at(state);
        self.transition(step, previous, &mut density);
        density.finish()
    }

    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> f64 {
        let mut density = OfMeasurement::at(measurement);
        self.measurement(step, state, &mut density);
        density.finish()
    }

    fn sample_initials(&self, streams: &mut [Stream], states: &mut [f64]) {
        let [n, _] = self.dimensions();
        let needs = needs_of(|counter| self.initial(counter));
        draw_rows(
            needs,
            n,
            None,
            0,
            streams,
            states,
            #[inline(always)]
            |_, _, drawn| self.initial(drawn),
        );
    }

    fn sample_transitions(
        &self,
        step: &Step<'_>,
        previous: Rows<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        let [n, _] = self.dimensions();
        if previous.is_empty() {
            return;
        }
        let needs = needs_of(|counter| self.transition(step, previous.row(0), counter));
        step.lift(|step| {
            draw_rows(
                needs,
                n,
                Some(previous),
                n,
                streams,
                states,
                #[inline(always)]
                |_, previous, drawn| {
                    self.transition(step, previous, drawn);
                },
            );
        });
    }

    fn log_initials(&self, states: &[f64], out: &mut [f64]) {
        let [n, _] = self.dimensions();
        over_tiles(
            n,
            Rows::all(states, n),
            out,
            #[inline(always)]
            |_, tile| {
                let mut density = OfStates::at(tile);
                self.initial(&mut density);
                density.finish()
            },
        );
    }

    fn log_transitions(&self, step: &Step<'_>, previous: Rows<'_>, states: &[f64], out: &mut [f64]) {
        let [n, _] = self.dimensions();
        step.lift(|step| {
            with_scratch(n * LANES, |now| {
                now.fill(0.0);
                over_tiles(
                    n,
                    previous,
                    out,
                    #[inline(always)]
                    |first, previous| {
                        let last = (first + LANES).min(states.len() / n);
                        load(&states[first * n..last * n], n, now);
                        let mut density = OfStates::at(rows_of(now));
                        self.transition(step, previous, &mut density);
                        density.finish()
                    },
                );
            })
        });
    }

    fn log_likelihoods(&self, step: &Step<'_>, states: &[f64], measurement: &[f64], out: &mut [f64]) {
        let [n, _] = self.dimensions();
        step.lift(|step| {
            over_tiles(
                n,
                Rows::all(states, n),
                out,
                #[inline(always)]
                |_, tile| {
                    let mut density = OfMeasurement::at(measurement);
                    self.measurement(step, tile, &mut density);
                    density.finish()
                },
            )
        });
    }
}

impl<E: Equations> Simulator for E {
    fn sample_measurement(
        &self,
        step: &Step<'_>,
        state: &[f64],
        stream: &mut Stream,
        measurement: &mut [f64],
    ) {
        let [n, m] = self.dimensions();
        let needs = needs_of(|counter| self.measurement(step, state, counter));
        let streams = std::slice::from_mut(stream);
        step.lift(|step| {
            draw_rows(needs, m, Some(Rows::all(state, n)), n, streams, measurement, |_, state, drawn| {
                self.measurement(step, state, drawn);
            });
        });
    }

    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        let [n, m] = self.dimensions();
        let states = Rows::all(states, n);
        if states.is_empty() {
            return;
        }
        let needs = needs_of(|counter| self.measurement(step, states.row(0), counter));
        step.lift(|step| {
            draw_rows(needs, m, Some(states), n, streams, out, |_, state, drawn| {
                self.measurement(step, state, drawn);
            });
        });
    }
}

impl<E: Equations> PartialLikelihood for E {
    fn partial_log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        let [n, _] = self.dimensions();
        step.lift(|step| {
            over_tiles(
                n,
                Rows::all(states, n),
                out,
                #[inline(always)]
                |_, tile| {
                    let mut density = OfKnown::at(measurement);
                    self.measurement(step, tile, &mut density);
                    density.finish()
                },
            )
        });
        Ok(())
    }
}
