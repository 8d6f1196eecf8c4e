//! Batched equations are a state-space model.

use std::rc::Rc;
use std::slice::from_mut;

use super::super::distribution::Distribution;
use super::super::lanes::Lanes;
use super::super::marginals::Marginals;
use super::super::model::{Likelihood, Replay};
use super::super::sample::{draw_measurements, draw_states, needs_of_draws, needs_of_measurement};
use super::super::statement::{Coordinates, Draws};
use super::super::tile_states::TileStates;
use super::super::tiles::{rows_of, rows_of_mut};
use super::super::transport::centres_of;
use super::Batched;
use super::column::{BatchDistribution, draw_tile, push_tile};
use super::memo::{self, Answer, BatchQuery};
use crate::batch::{LANES, Rows, load, store, with_scratch};
use crate::marginal::by_draws;
use crate::{Marginal, ModelError, Seed, Simulator, StateSpaceModel, Step, Stream, TransitionDensity};

/// Transitions whose families are looked at, as for [`Equations`](super::super::Equations).
const PROBES: usize = 8;

impl Batched {
    /// Asks a function.
    fn ask(
        &self,
        asked: BatchQuery,
        step: &Step<'_>,
        rows: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        match asked {
            BatchQuery::Transition => self.equations.transition(step, rows, is_padded),
            BatchQuery::Measurement => self.equations.measurement(step, rows, is_padded),
            BatchQuery::Slopes => self.equations.measurement_slopes(step, rows, is_padded),
        }
    }

    /// What a function sees of a step: a transition its only part, unless it is one already, and a measurement the end.
    pub(super) fn seen<'a>(&self, asked: BatchQuery, step: &Step<'a>) -> Step<'a> {
        let inputs = self.equations.inputs().len();
        match asked {
            BatchQuery::Transition if step.inputs.len() != inputs => step.part(0, inputs),
            BatchQuery::Transition => *step,
            BatchQuery::Measurement | BatchQuery::Slopes => step.end(inputs),
        }
    }

    /// What is stated for each row of particles.
    fn of_rows(&self, asked: BatchQuery, step: &Step<'_>, rows: &[f64]) -> Answer {
        let step = &self.seen(asked, step);
        memo::of_rows(&self.owner, asked, step, rows, false, || self.ask(asked, step, rows, false))
    }

    /// What is stated for each row of `x_t`, or for `x_0` where there are no rows before, in a step of one part.
    fn of_states(&self, step: &Step<'_>, previous: Option<Rows<'_>>) -> Answer {
        match previous {
            None => self.equations.initial().map(Rc::new),
            Some(previous) => {
                previous.with_contiguous(|previous| self.of_rows(BatchQuery::Transition, step, previous))
            }
        }
    }

    /// What is stated for the particles of a tile, and the number of the first of them.
    pub(super) fn of_tile(&self, asked: BatchQuery, step: &Step<'_>, tile: &[f64]) -> (Answer, usize) {
        let step = &self.seen(asked, step);
        // Nobody said that this tile would come, or how many of its lanes have a particle.
        memo::of_tile(&self.owner, asked, step, tile, |rows| self.ask(asked, step, rows, true))
    }

    /// Draws states of which this is stated.
    fn draw(&self, stated: Option<&[BatchDistribution]>, streams: &mut [Stream], states: &mut [f64]) {
        let Some(stated) = stated else { return states.fill(f64::NAN) };
        let n = self.state_dim();
        let needs = needs_of_draws(n, |counter, _| {
            let drawn = stated.iter().filter(|distribution| distribution.is_drawn());
            drawn.for_each(|distribution| counter.push(distribution.first()));
        });
        draw_states(needs, (n, None), streams, states, |first, _, draws, rows| {
            draw_tile(stated, first, draws, rows);
        });
    }

    /// What a measurement is scored by.
    pub(super) fn scored_by(&self) -> BatchQuery {
        if self.equations.has_slopes() { BatchQuery::Slopes } else { BatchQuery::Measurement }
    }
}

/// A log density of each particle, tile by tile; NaN where nothing is stated.
fn weigh(
    stated: Option<&[BatchDistribution]>,
    out: &mut [f64],
    mut of_tile: impl FnMut(&[BatchDistribution], usize) -> Lanes,
) {
    let Some(stated) = stated else { return out.fill(f64::NAN) };
    for (number, out) in out.chunks_mut(LANES).enumerate() {
        out.copy_from_slice(&of_tile(stated, number * LANES).0[..out.len()]);
    }
}

impl StateSpaceModel for Batched {
    fn state_dim(&self) -> usize {
        self.equations.dimensions()[0]
    }

    fn measurement_dim(&self) -> usize {
        self.equations.dimensions()[1]
    }

    fn input_dim(&self) -> usize {
        self.equations.inputs().len()
    }

    fn step_of_index(&self, index: usize) -> Step<'_> {
        Step { inputs: self.equations.inputs(), ..Step::of_index(index) }
    }

    fn sample_states(
        &self,
        step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        if states.is_empty() {
            return;
        }
        let Some(previous) = previous else {
            let stated = self.equations.initial();
            return self.draw(stated.as_deref(), streams, states);
        };
        previous.with_contiguous(|rows| states.copy_from_slice(rows));
        let inputs = self.equations.inputs().len();
        for sub_step in 0..step.sub_steps {
            let stated = self.of_rows(BatchQuery::Transition, &step.part(sub_step, inputs), states);
            self.draw(stated.as_ref().map(|stated| &stated[..]), streams, states);
        }
    }

    fn log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        if out.is_empty() {
            return Ok(());
        }
        let stated = self.of_rows(BatchQuery::Measurement, step, states);
        weigh(stated.as_ref().map(|stated| &stated[..]), out, |stated, first| {
            let mut likelihood = Likelihood::of(measurement);
            push_tile(stated, first, &mut likelihood);
            likelihood.finish()
        });
        Ok(())
    }

    fn density(&self) -> Option<&dyn TransitionDensity> {
        self.equations.has_density().then_some(self)
    }

    fn foresee(&self, step: &Step<'_>, previous: Rows<'_>) {
        if step.sub_steps != 1 || self.density().is_none() {
            return;
        }
        let n = self.state_dim();
        let stated = previous.with_contiguous(|rows| {
            let step = &self.seen(BatchQuery::Transition, step);
            let ask = || self.ask(BatchQuery::Transition, step, rows, false);
            memo::of_rows(&self.owner, BatchQuery::Transition, step, rows, true, ask)
        });
        let Some(stated) = stated else { return };
        // Where the measurement will be looked at first.
        let particles = previous.len();
        with_scratch(particles * n, |centres| {
            with_scratch(2 * n * LANES, |tiles| {
                let (tile, slopes) = tiles.split_at_mut(n * LANES);
                for (number, centres) in centres.chunks_mut(n * LANES).enumerate() {
                    centres_of(|draws, rows| draw_tile(&stated, number * LANES, draws, rows), tile, slopes);
                    store(tile, n, centres);
                }
            });
            // No particle is there.
            let asked = self.scored_by();
            let step = &self.seen(asked, step);
            memo::of_rows(&self.owner, asked, step, centres, true, || self.ask(asked, step, centres, true));
        });
    }
}

impl TransitionDensity for Batched {
    fn log_densities(&self, step: &Step<'_>, previous: Option<Rows<'_>>, states: &[f64], out: &mut [f64]) {
        if out.is_empty() {
            return;
        }
        let (n, stated) = (self.state_dim(), self.of_states(step, previous));
        with_scratch(2 * n * LANES, |scratch| {
            let (tile, unused) = scratch.split_at_mut(n * LANES);
            tile.fill(0.0);
            weigh(stated.as_ref().map(|stated| &stated[..]), out, |stated, first| {
                let last = (first + LANES).min(states.len() / n);
                load(&states[first * n..last * n], n, tile);
                let mut replay = Replay::of(rows_of(tile));
                draw_tile(stated, first, &mut replay, rows_of_mut(unused));
                replay.finish()
            });
        });
    }
}

impl Simulator for Batched {
    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        if out.is_empty() {
            return;
        }
        let Some(stated) = self.of_rows(BatchQuery::Measurement, step, states) else {
            return out.fill(f64::NAN);
        };
        let needs = needs_of_measurement(|counter| {
            stated.iter().for_each(|distribution| counter.push(distribution.first()))
        });
        draw_measurements(needs, self.measurement_dim(), None, streams, out, |first, _, entries| {
            push_tile(&stated, first, entries);
        });
    }

    fn marginals(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        stream: &mut Stream,
        out: &mut [Marginal],
    ) {
        by_draws(measurement, out, |drawn| self.sample_measurements(step, states, from_mut(stream), drawn));
        let Some(stated) = self.of_rows(BatchQuery::Measurement, step, states) else { return };
        for (row, out) in out.chunks_exact_mut(self.measurement_dim()).enumerate() {
            let mut marginals = Marginals::of(measurement, out);
            stated.iter().for_each(|distribution| marginals.push(distribution.row(row)));
        }
    }
}

impl TileStates for Batched {
    fn is_affine(&self) -> bool {
        *self.is_affine.get_or_init(|| {
            let are_normal = |stated: &[BatchDistribution]| {
                stated.iter().all(|one| matches!(one.first(), Distribution::Normal(_)))
            };
            if !self.equations.has_density() {
                return false;
            }
            // A state that is likely, from a stream of its own.
            let mut state = vec![0.0; self.state_dim()];
            let stream = &mut Seed::from_u64(0).child("transport").stream();
            self.sample_states(&self.step_of_index(0), None, from_mut(stream), &mut state);
            // Some functions end with the data: what they do not say is not looked at.
            let mut transitions = (1..=PROBES)
                .filter_map(|index| self.equations.transition(&self.step_of_index(index), &state, true));
            self.equations.initial().is_some_and(|stated| are_normal(&stated))
                && transitions.all(|stated| are_normal(&stated))
        })
    }

    fn draw_states(
        &self,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        draws: &mut impl Draws<Lanes>,
        states: &mut [Lanes],
    ) {
        let (stated, first) = match previous {
            None => (self.equations.initial().map(Rc::new), 0),
            // No time passes.
            Some(previous) if step.sub_steps == 0 => return states.copy_from_slice(rows_of(previous)),
            Some(previous) => self.of_tile(BatchQuery::Transition, step, previous),
        };
        if let Some(stated) = stated {
            draw_tile(&stated, first, draws, states);
        }
    }
}
