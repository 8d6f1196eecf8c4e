//! Batched equations are a state-space model.

use std::slice::from_mut;

use super::super::distribution::Distribution;
use super::super::lanes::Lanes;
use super::super::model::{OfKnown, OfMeasurement, OfStates};
use super::super::sample::{draw_rows, needs_of};
use super::super::statement::Coordinates;
use super::super::tile_states::TileStates;
use super::super::tiles::rows_of;
use super::super::transport::centres_of;
use super::Batched;
use super::column::{BatchDistribution, push_tile};
use super::memo::{self, Answer, Asked};
use crate::batch::{LANES, Rows, load, store, with_scratch};
use crate::{ModelError, PartialLikelihood, Seed, Simulator, StateSpaceModel, Step, Stream};

/// Transitions whose families are looked at, as for [`Equations`](super::super::Equations).
const PROBES: usize = 8;

impl Batched {
    /// Asks a function.
    fn ask(
        &self,
        asked: Asked,
        step: &Step<'_>,
        rows: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        match asked {
            Asked::Transition => self.equations.transition(step, rows, is_padded),
            Asked::Measurement => self.equations.measurement(step, rows, is_padded),
            Asked::Slopes => self.equations.measurement_slopes(step, rows, is_padded),
        }
    }

    /// What is stated for each row of particles.
    fn of_rows(&self, asked: Asked, step: &Step<'_>, rows: &[f64]) -> Answer {
        memo::of_rows(&self.owner, asked, step, rows, false, || self.ask(asked, step, rows, false))
    }

    /// What is stated for the particles of a tile, and the number of the first of them.
    pub(super) fn of_tile(&self, asked: Asked, step: &Step<'_>, tile: &[f64]) -> (Answer, usize) {
        // Nobody said that this tile would come, or how many of its lanes have a particle.
        memo::of_tile(&self.owner, asked, step, tile, |rows| self.ask(asked, step, rows, true))
    }

    /// What a measurement is scored by.
    pub(super) fn scored_by(&self) -> Asked {
        if self.equations.has_slopes() { Asked::Slopes } else { Asked::Measurement }
    }
}

/// Draws what is stated; NaN where nothing is.
fn draw(stated: Option<&[BatchDistribution]>, width: usize, streams: &mut [Stream], out: &mut [f64]) {
    let Some(stated) = stated else { return out.fill(f64::NAN) };
    let needs = needs_of(|counter| stated.iter().for_each(|distribution| counter.push(distribution.first())));
    draw_rows(needs, width, None, 0, streams, out, |first, _, drawn| push_tile(stated, first, drawn));
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

/// [`weigh`] states (`K×N`).
fn weigh_states(stated: Option<&[BatchDistribution]>, n: usize, states: &[f64], out: &mut [f64]) {
    with_scratch(n * LANES, |tile| {
        tile.fill(0.0);
        weigh(stated, out, |stated, first| {
            let last = (first + LANES).min(states.len() / n);
            load(&states[first * n..last * n], n, tile);
            let mut density = OfStates::at(rows_of(tile));
            push_tile(stated, first, &mut density);
            density.finish()
        });
    });
}

impl StateSpaceModel for Batched {
    fn state_dim(&self) -> usize {
        self.equations.dimensions()[0]
    }

    fn measurement_dim(&self) -> usize {
        self.equations.dimensions()[1]
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        self.sample_initials(from_mut(stream), state);
    }

    fn sample_transition(&self, step: &Step<'_>, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        self.sample_transitions(step, Rows::all(previous, previous.len()), from_mut(stream), state);
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.log_initials(state, &mut out);
        out[0]
    }

    fn log_transition(&self, step: &Step<'_>, previous: &[f64], state: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.log_transitions(step, Rows::all(previous, previous.len()), state, &mut out);
        out[0]
    }

    fn log_likelihood(&self, step: &Step<'_>, state: &[f64], measurement: &[f64]) -> f64 {
        let mut out = [f64::NAN];
        self.log_likelihoods(step, state, measurement, &mut out);
        out[0]
    }

    fn sample_initials(&self, streams: &mut [Stream], states: &mut [f64]) {
        draw(self.equations.initial().as_deref(), self.state_dim(), streams, states);
    }

    fn sample_transitions(
        &self,
        step: &Step<'_>,
        previous: Rows<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        if previous.is_empty() {
            return;
        }
        let stated = previous.with_contiguous(|previous| self.of_rows(Asked::Transition, step, previous));
        draw(stated.as_ref().map(|stated| &stated[..]), self.state_dim(), streams, states);
    }

    fn log_initials(&self, states: &[f64], out: &mut [f64]) {
        weigh_states(self.equations.initial().as_deref(), self.state_dim(), states, out);
    }

    fn log_transitions(&self, step: &Step<'_>, previous: Rows<'_>, states: &[f64], out: &mut [f64]) {
        if out.is_empty() {
            return;
        }
        let stated = previous.with_contiguous(|previous| self.of_rows(Asked::Transition, step, previous));
        weigh_states(stated.as_ref().map(|stated| &stated[..]), self.state_dim(), states, out);
    }

    fn log_likelihoods(&self, step: &Step<'_>, states: &[f64], measurement: &[f64], out: &mut [f64]) {
        if out.is_empty() {
            return;
        }
        let stated = self.of_rows(Asked::Measurement, step, states);
        weigh(stated.as_ref().map(|stated| &stated[..]), out, |stated, first| {
            let mut density = OfMeasurement::at(measurement);
            push_tile(stated, first, &mut density);
            density.finish()
        });
    }

    fn foresee(&self, step: &Step<'_>, previous: Rows<'_>) {
        let n = self.state_dim();
        let stated = previous.with_contiguous(|rows| {
            let ask = || self.ask(Asked::Transition, step, rows, false);
            memo::of_rows(&self.owner, Asked::Transition, step, rows, true, ask)
        });
        let Some(stated) = stated else { return };
        // Where the measurement will be looked at first.
        let particles = previous.len();
        with_scratch(particles * n, |centres| {
            with_scratch(2 * n * LANES, |tiles| {
                let (tile, slopes) = tiles.split_at_mut(n * LANES);
                for (number, centres) in centres.chunks_mut(n * LANES).enumerate() {
                    centres_of(|sink| push_tile(&stated, number * LANES, sink), tile, slopes);
                    store(tile, n, centres);
                }
            });
            // No particle is there.
            let asked = self.scored_by();
            memo::of_rows(&self.owner, asked, step, centres, true, || self.ask(asked, step, centres, true));
        });
    }
}

impl Simulator for Batched {
    fn sample_measurement(
        &self,
        step: &Step<'_>,
        state: &[f64],
        stream: &mut Stream,
        measurement: &mut [f64],
    ) {
        self.sample_measurements(step, state, from_mut(stream), measurement);
    }

    fn sample_measurements(&self, step: &Step<'_>, states: &[f64], streams: &mut [Stream], out: &mut [f64]) {
        if out.is_empty() {
            return;
        }
        let stated = self.of_rows(Asked::Measurement, step, states);
        draw(stated.as_ref().map(|stated| &stated[..]), self.measurement_dim(), streams, out);
    }
}

impl PartialLikelihood for Batched {
    fn partial_log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        if out.is_empty() {
            return Ok(());
        }
        let stated = self.of_rows(Asked::Measurement, step, states);
        weigh(stated.as_ref().map(|stated| &stated[..]), out, |stated, first| {
            let mut density = OfKnown::at(measurement);
            push_tile(stated, first, &mut density);
            density.finish()
        });
        Ok(())
    }
}

impl TileStates for Batched {
    fn is_affine(&self) -> bool {
        *self.is_affine.get_or_init(|| {
            let are_normal = |stated: &[BatchDistribution]| {
                stated.iter().all(|one| matches!(one.first(), Distribution::Normal { .. }))
            };
            // A state that is likely, from a stream of its own.
            let mut state = vec![0.0; self.state_dim()];
            self.sample_initial(&mut Seed::from_u64(0).child("transport").stream(), &mut state);
            // Some functions end with the data: what they do not say is not looked at.
            let mut transitions = (1..=PROBES)
                .filter_map(|index| self.equations.transition(&Step::of_index(index), &state, true));
            self.equations.initial().is_some_and(|stated| are_normal(&stated))
                && transitions.all(|stated| are_normal(&stated))
        })
    }

    fn push_states(&self, step: &Step<'_>, previous: Option<&[f64]>, states: &mut impl Coordinates<Lanes>) {
        match previous {
            None => {
                let stated = self.equations.initial().unwrap_or_default();
                push_tile(&stated, 0, states);
            }
            Some(previous) => {
                let (stated, first) = self.of_tile(Asked::Transition, step, previous);
                if let Some(stated) = stated {
                    push_tile(&stated, first, states);
                }
            }
        }
    }
}
