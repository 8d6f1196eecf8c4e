//! What states its equations is a state-space model.

use std::slice::from_mut;

use super::advance::make_state;
use super::distribution::Distribution;
use super::lanes::Lanes;
use super::marginals::Marginals;
use super::noise_space::NoiseSpace;
use super::sample::{draw_measurements, draw_states, needs_of_draws, needs_of_measurement};
use super::scalar::Scalar;
use super::statement::{Coordinates, Draws, Equations};
use super::tiles::{rows_of, rows_of_mut};
use super::wrapped::Wrapped;
use crate::batch::{LANES, Rows, by_widest_vectors, load, with_scratch};
use crate::marginal::by_draws;
use crate::{Marginal, ModelError, Simulator, StateSpaceModel, Step, Stream, TransitionDensity};

/// Answers draws with given values, and adds up their log densities; NaN where there are more or fewer draws than values.
#[derive(Debug)]
pub struct Replay<'a, S> {
    values: &'a [S],
    sum: S,
}

impl<'a, S: Scalar> Replay<'a, S> {
    /// Before the first draw.
    #[inline(always)]
    pub fn of(values: &'a [S]) -> Self {
        Replay { values, sum: S::from(0.0) }
    }

    /// The sum; NaN where values are left.
    #[inline(always)]
    pub fn finish(self) -> S {
        if self.values.is_empty() { self.sum } else { S::from(f64::NAN) }
    }
}

impl<S: Scalar> Draws<S> for Replay<'_, S> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<S>) -> S {
        let Some((value, rest)) = self.values.split_first() else {
            self.sum = S::from(f64::NAN);
            return self.sum;
        };
        self.values = rest;
        self.sum = self.sum + distribution.log_density(*value);
        *value
    }
}

/// Adds up the log densities of the entries of a measurement, numbers or what may be missing: they are independent, so those that are integrate to 1. NaN where another
/// number of entries is stated.
pub(super) struct Likelihood<'a, S, Y> {
    entries: &'a [Y],
    sum: S,
}

impl<'a, S: Scalar, Y> Likelihood<'a, S, Y> {
    #[inline(always)]
    pub(super) fn of(entries: &'a [Y]) -> Self {
        Likelihood { entries, sum: S::from(0.0) }
    }

    #[inline(always)]
    pub(super) fn finish(self) -> S {
        if self.entries.is_empty() { self.sum } else { S::from(f64::NAN) }
    }
}

impl<S: Scalar, Y: Copy + Into<Option<f64>>> Coordinates<S> for Likelihood<'_, S, Y> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<S>) {
        match self.entries.split_first() {
            None => self.sum = S::from(f64::NAN),
            Some((entry, rest)) => {
                self.entries = rest;
                if let Some(value) = (*entry).into() {
                    self.sum = self.sum + distribution.log_density_of_one(value);
                }
            }
        }
    }

    #[inline(never)]
    fn push_wrapped(&mut self, wrapped: &Wrapped<'_, S>) {
        let Some((entry, rest)) = self.entries.split_first() else {
            self.sum = S::from(f64::NAN);
            return;
        };
        self.entries = rest;
        if let Some(value) = (*entry).into() {
            self.sum = self.sum + wrapped.log_density(S::from(value));
        }
    }
}

/// Shows up to [`LANES`] rows after another as tiles, and writes a number for each row.
fn over_tiles(
    width: usize,
    rows: Rows<'_>,
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
                    rows.load(number * LANES, tile);
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

    fn input_dim(&self) -> usize {
        self.inputs().len()
    }

    fn step_of_index(&self, index: usize) -> Step<'_> {
        Step { inputs: self.inputs(), parameters: self.parameters(), ..Step::of_index(index) }
    }

    fn sample_states(
        &self,
        step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        let [n, _] = self.dimensions();
        if states.is_empty() {
            return;
        }
        let before = previous.map(|rows| rows.row(0));
        let needs = needs_of_draws(n, |draws, state| make_state(self, step, before, draws, state));
        step.lift(|step| {
            draw_states(
                needs,
                (n, previous),
                streams,
                states,
                #[inline(always)]
                |_, before, draws, state| {
                    make_state(self, step, previous.map(|_| before), draws, state);
                },
            );
        });
    }

    fn log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        let [n, _] = self.dimensions();
        step.end(self.inputs().len()).lift(|step| {
            over_tiles(
                n,
                Rows::all(states, n),
                out,
                #[inline(always)]
                |_, tile| {
                    let mut likelihood = Likelihood::of(measurement);
                    self.measurement(step, tile, &mut likelihood);
                    likelihood.finish()
                },
            )
        });
        Ok(())
    }

    /// By plain numbers, and not by a tile of which one lane is asked for.
    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> Result<f64, ModelError> {
        let mut likelihood = Likelihood::of(measurement);
        self.measurement(&step.end(self.inputs().len()), state, &mut likelihood);
        Ok(likelihood.finish())
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        self.has_density().then_some(self)
    }

    fn noise_space(&self) -> Option<&dyn NoiseSpace> {
        Some(self)
    }

    fn check(&self) -> Result<(), ModelError> {
        super::check::check(self)
    }
}

impl<E: Equations> TransitionDensity for E {
    /// By plain numbers, and not by a tile of which one lane is asked for.
    fn log_density(&self, step: &Step<'_>, previous: Option<&[f64]>, state: &[f64]) -> f64 {
        with_scratch(state.len(), |unused| {
            let mut replay = Replay::of(state);
            make_state(self, step, previous, &mut replay, unused);
            replay.finish()
        })
    }

    fn log_densities(&self, step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        let [n, _] = self.dimensions();
        step.lift(|step| {
            with_scratch(2 * n * LANES, |scratch| {
                let (now, unused) = scratch.split_at_mut(n * LANES);
                now.fill(0.0);
                match previous {
                    None => over_tiles(
                        n,
                        Rows::all(states, n),
                        out,
                        #[inline(always)]
                        |_, now| {
                            let mut replay = Replay::of(now);
                            make_state(self, step, None, &mut replay, rows_of_mut(unused));
                            replay.finish()
                        },
                    ),
                    Some(previous) => over_tiles(
                        n,
                        previous,
                        out,
                        #[inline(always)]
                        |first, previous| {
                            let last = (first + LANES).min(states.len() / n);
                            load(&states[first * n..last * n], n, now);
                            let mut replay = Replay::of(rows_of(now));
                            let unused = rows_of_mut(unused);
                            make_state(self, step, Some(previous), &mut replay, unused);
                            replay.finish()
                        },
                    ),
                }
            })
        });
    }
}

impl<E: Equations> Simulator for E {
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        let [n, m] = self.dimensions();
        let states = Rows::all(states, n);
        if states.is_empty() {
            return;
        }
        let end = step.end(self.inputs().len());
        let needs = needs_of_measurement(|sink| self.measurement(&end, states.row(0), sink));
        end.lift(|step| {
            draw_measurements(needs, m, Some((n, states)), streams, out, |_, state, sink| {
                self.measurement(step, state, sink);
            });
        });
    }

    /// By plain numbers: it is asked for once a row of data.
    fn marginals(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        stream: &mut Stream,
        out: &mut [Marginal],
    ) {
        let [n, m] = self.dimensions();
        let end = step.end(self.inputs().len());
        by_draws(measurement, out, |drawn| self.sample_measurements(step, states, from_mut(stream), drawn));
        for (state, out) in states.chunks_exact(n).zip(out.chunks_exact_mut(m)) {
            self.measurement(&end, state, &mut Marginals::of(measurement, out));
        }
    }
}
