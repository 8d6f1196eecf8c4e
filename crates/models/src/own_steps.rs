//! Steps that a model draws for itself, many sequences side by side: what proposals are learned from.

use std::ops::Range;
use std::slice::from_mut;

use rand::RngExt;

use crate::batch::{Rows, there_is_memory_for};
use crate::equations::{Linearise, Transport};
use crate::noise_rows::sample_with_noise;
use crate::{ModelError, ModelShape, Seed, Simulator, Step, StepRecord, Stream, check_model};

/// A model that a proposal can be learned for: it draws its own steps, its noise can be transported, and its measurements can be linearised.
///
/// What states its [`Equations`](crate::equations::Equations) is one.
pub trait OwnModel: Simulator + Transport + Linearise {}

impl<M: Simulator + Transport + Linearise + ?Sized> OwnModel for M {}

/// Sequences that a model draws for itself, all at the same time `t`.
///
/// No constructor takes states from elsewhere: what learns from these steps has never seen the truth behind measurements that are to be filtered.
pub struct OwnSteps<'m, M: ?Sized> {
    model: &'m M,
    seed: Seed,
    stream: Stream,
    /// The index of the model's own step that comes next, and at which its sequence ends.
    next: usize,
    end: usize,
    step: StepRecord,
    /// `x_{t−1}` and `x_t`, `S×N`.
    previous: Vec<f64>,
    states: Vec<f64>,
    /// What states without a density are made of, `S×Q`.
    noise: Vec<f64>,
    /// `y_t`, `S×M`.
    measurements: Vec<f64>,
    lost: usize,
    largest_state: f64,
}

/// One time of all sequences.
#[derive(Debug, Clone, Copy)]
pub struct OwnStep<'a> {
    /// The step to `x_t`.
    pub step: Step<'a>,
    /// `x_{t−1}` of each of `S` sequences (`S×N`); none at `t = 0`.
    pub previous: Option<&'a [f64]>,
    /// `x_t`, `S×N`.
    pub states: &'a [f64],
    /// The noise `v_t` that each state is made of (`S×Q`), where states have no density and the noise is known.
    pub noise: Option<&'a [f64]>,
    /// `y_t`, `S×M`.
    pub measurements: &'a [f64],
}

impl<'m, M: Simulator + ?Sized> OwnSteps<'m, M> {
    /// `sequences` sequences before their first step.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] if there are none, if the model has no states or no measurements, or if there is no memory for them.
    pub fn new(model: &'m M, sequences: usize, seed: &Seed) -> Result<Self, ModelError> {
        check_model(model)?;
        let (n, m) = (model.state_dim(), model.measurement_dim());
        let draws = ModelShape::of(model).draws.map_or(0, |[initial, later]| initial.max(later));
        let numbers = sequences.checked_mul(2 * n + m + draws);
        if sequences == 0 || !numbers.is_some_and(there_is_memory_for) {
            return Err(ModelError::Parameter {
                name: "the number of simulated sequences",
                value: sequences.to_string(),
                expected: "at least 1, and as many as there is memory for",
            });
        }
        Ok(OwnSteps {
            model,
            seed: seed.clone(),
            stream: seed.stream(),
            next: 0,
            end: usize::MAX,
            step: StepRecord::default(),
            previous: Vec::new(),
            states: vec![0.0; sequences * n],
            noise: Vec::new(),
            measurements: vec![0.0; sequences * m],
            lost: 0,
            largest_state: f64::INFINITY,
        })
    }

    /// The same sequences, each of which ends where a coordinate of its state becomes larger than this, or smaller than its negative.
    #[must_use]
    pub fn within(self, largest_state: f64) -> Self {
        OwnSteps { largest_state, ..self }
    }

    /// The same sequences in so many rows of one of the model's own sequences, drawn so that each row is as likely to be among them as another, but for those near the
    /// ends ([`StateSpaceModel::own_sequences`](crate::StateSpaceModel::own_sequences)). The states before the window are drawn, too. Where a model has no such sequences,
    /// nothing changes.
    #[must_use]
    pub fn in_window(mut self, rows: usize) -> Self {
        let mut stream = self.seed.child("window").stream();
        let Some(own) = self.drawn_sequence(&mut stream) else { return self };
        let first = own.start + stream.random_range(0..=own.len().saturating_sub(rows));
        (self.next, self.end) = (own.start, own.end.min(first + rows));
        while self.next < first && self.advance().is_some() {}
        self
    }

    /// The same sequences from the beginning of one of the model's own sequences on, drawn likewise.
    #[must_use]
    pub fn at_beginning(mut self) -> Self {
        let mut stream = self.seed.child("window").stream();
        let Some(own) = self.drawn_sequence(&mut stream) else { return self };
        (self.next, self.end) = (own.start, own.end);
        self
    }

    /// One of the model's own sequences, longer ones more often.
    fn drawn_sequence(&self, stream: &mut Stream) -> Option<Range<usize>> {
        let own = self.model.own_sequences();
        let at = stream.random_range(0..own.last()?.end);
        // They lie one behind the other from 0 on.
        own.iter().find(|own| at < own.end).cloned()
    }

    /// How many sequences ended because a state or a measurement was not a finite number, or a state too large.
    pub fn lost(&self) -> usize {
        self.lost
    }

    /// Draws the next time of all sequences that go on; none if no sequence is left, or the window ends.
    pub fn advance(&mut self) -> Option<OwnStep<'_>> {
        let (n, m) = (self.model.state_dim(), self.model.measurement_dim());
        if self.next == self.end || self.states.is_empty() {
            return None;
        }
        self.step.keep(&self.model.step_of_index(self.next));
        let step = self.step.step();
        let is_start = step.index == 0;
        let stream = from_mut(&mut self.stream);
        if !is_start {
            std::mem::swap(&mut self.previous, &mut self.states);
            self.states.resize(self.previous.len(), 0.0);
        }
        let previous = (!is_start).then(|| Rows::all(&self.previous, n));
        let noise_space = self.model.noise_without_density();
        let q = noise_space.map_or(0, |model| model.draws(&step).len());
        match noise_space {
            None => self.model.sample_states(&step, previous, stream, &mut self.states),
            Some(model) => {
                self.noise.resize(self.states.len() / n * q, 0.0);
                sample_with_noise(
                    model,
                    n,
                    &step,
                    previous,
                    &mut stream[0],
                    &mut self.noise,
                    &mut self.states,
                );
            }
        }
        self.model.sample_measurements(&step, &self.states, stream, &mut self.measurements);
        let mut row = 0;
        while row * n < self.states.len() {
            let (state, measurement) = (&self.states[row * n..][..n], &self.measurements[row * m..][..m]);
            let is_within = state.iter().all(|x| x.is_finite() && x.abs() <= self.largest_state);
            if is_within && measurement.iter().copied().all(f64::is_finite) {
                row += 1;
                continue;
            }
            self.lost += 1;
            // The last one takes its place.
            remove_row(&mut self.states, n, row);
            remove_row(&mut self.noise, q, row);
            remove_row(&mut self.measurements, m, row);
            if !is_start {
                remove_row(&mut self.previous, n, row);
            }
        }
        if self.states.is_empty() {
            return None;
        }
        self.next += 1;
        let previous = (!is_start).then_some(self.previous.as_slice());
        let noise = noise_space.map(|_| self.noise.as_slice());
        Some(OwnStep { step, previous, states: &self.states, noise, measurements: &self.measurements })
    }
}

/// Removes a row of `width` numbers; the last one takes its place.
fn remove_row(rows: &mut Vec<f64>, width: usize, row: usize) {
    let last = rows.len() - width;
    rows.copy_within(last.., row * width);
    rows.truncate(last);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Step;
    use crate::equations::{Coordinates, Draws, Equations, Scalar, normal};

    /// A walk whose steps double: it leaves the numbers after a thousand times, at times that depend on where it began.
    struct Runaway;

    impl Equations for Runaway {
        fn dimensions(&self) -> [usize; 2] {
            [1, 1]
        }

        fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
            state[0] = draws.draw(normal(0.0, 1e300));
        }

        fn transition<S: Scalar>(
            &self,
            _: &Step<'_, S>,
            x: &[S],
            draws: &mut impl Draws<S>,
            state: &mut [S],
        ) {
            state[0] = draws.draw(normal(x[0] * 2.0, 1.0));
        }

        fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
            measurement.push(normal(x[0], 1.0));
        }
    }

    #[test]
    fn a_sequence_that_overflows_ends_and_the_others_go_on() {
        let mut steps = OwnSteps::new(&Runaway, 50, &Seed::from_u64(1)).unwrap();
        let mut counts = Vec::new();
        while let Some(step) = steps.advance() {
            assert!(step.states.iter().chain(step.measurements).all(|value| value.is_finite()));
            // Each state still stands beside the one that it was drawn from.
            if let Some(previous) = step.previous {
                assert!(
                    previous.iter().zip(step.states).all(|(before, now)| (now / before - 2.0).abs() < 1e-9)
                );
            }
            counts.push(step.states.len());
        }
        assert_eq!((counts[0], steps.lost()), (50, 50));
        assert!(
            counts.windows(2).all(|pair| pair[1] <= pair[0])
                && counts.iter().any(|count| (1..50).contains(count))
        );
    }

    #[test]
    fn no_sequences_are_refused() {
        assert!(OwnSteps::new(&Runaway, 0, &Seed::from_u64(1)).is_err());
    }
}
