//! Steps of a bank: ancestors, draws, weights, evidence.

use std::ops::Deref;

use motes_models::batch::Rows;
use motes_models::{Measurements, ModelError, PartialLikelihood, PartialMeasurements, StateSpaceModel};

use super::FilterBank;
use crate::blocks::{Filters, Outcome, Step};
use crate::proposals::{Densities, Transition};
use crate::workers::Workers;
use crate::{Conditional, FilterError, ParticleMemory, Past, Proposal, WeightFault};

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Advances every filter by one measurement (`M` numbers): resample where due, draw, weigh.
    ///
    /// # Errors
    /// [`FilterError::Model`] if the measurement has the wrong width or is not finite (nothing has changed then).
    /// Otherwise the bank has failed, all of its filters together: every later step returns the same error, and particles and
    /// weights mean nothing any more.
    pub fn step(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        self.check_width(measurement.len())?;
        if let Some(column) = measurement.iter().position(|value| !value.is_finite()) {
            let value = measurement[column];
            return Err(ModelError::NotFinite { row: self.time, column, value }.into());
        }
        self.attempt(|bank| {
            if !bank.advance_by_rows(measurement)? {
                bank.resample();
                bank.draw(measurement)?;
                bank.weigh();
            }
            bank.take_outcomes(|model, time, states, out| {
                model.log_likelihoods(time, states, measurement, out)
            })
        })
    }

    /// Advances every filter by one time at which nothing was measured: particles are drawn from the transition, weights and
    /// evidence stay. A proposal's memory, which only measurements advance, follows its particle.
    ///
    /// # Errors
    /// As [`FilterBank::step`].
    pub fn step_without_measurement(&mut self) -> Result<(), FilterError> {
        self.attempt(|bank| {
            bank.propagate(|_, _, _, out| {
                out.fill(0.0);
                Ok(())
            })
        })
    }

    /// Takes in all measurements, one step after the other, and shows the bank to `observe` after each.
    ///
    /// The same as as many calls of [`FilterBank::step`], but [threads](FilterBank::with_threads) stay awake between steps. With several
    /// of them all of this happens on one of theirs, `observe` too.
    ///
    /// # Errors
    /// As [`FilterBank::step`]; measurements after one that led to an error are not looked at.
    pub fn run(
        &mut self,
        measurements: &Measurements,
        observe: impl FnMut(&Self) + Send,
    ) -> Result<(), FilterError>
    where
        Self: Send,
    {
        self.over(measurements.rows(), Self::step, observe)
    }

    /// Takes a step with each row and shows the bank to `observe` after it, on threads that stay awake.
    fn over<Row: Send>(
        &mut self,
        mut rows: impl Iterator<Item = Row> + Send,
        mut step: impl FnMut(&mut Self, Row) -> Result<(), FilterError> + Send,
        mut observe: impl FnMut(&Self) + Send,
    ) -> Result<(), FilterError>
    where
        Self: Send,
    {
        let workers = self.workers.clone();
        workers.together(|| {
            rows.try_for_each(|row| {
                step(self, row)?;
                observe(self);
                Ok(())
            })
        })
    }

    /// Whether the bank can take another step of a measurement with so many entries.
    fn check_width(&self, width: usize) -> Result<(), FilterError> {
        let expected = self.model.measurement_dim();
        match &self.failure {
            Some(failure) => Err(failure.clone()),
            None if width != expected => Err(ModelError::MeasurementWidth { width, expected }.into()),
            None => Ok(()),
        }
    }

    /// Does what a step does; the bank has failed if that fails.
    fn attempt(
        &mut self,
        advance: impl FnOnce(&mut Self) -> Result<(), FilterError>,
    ) -> Result<(), FilterError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if self.time == 0 {
            // The first step that resamples needs more than this one.
            Workers::reserve(self.scratch());
        }
        advance(self).inspect_err(|failure| self.failure = Some(failure.clone()))?;
        self.time += 1;
        Ok(())
    }

    /// Draws every particle from the transition and weighs it by a likelihood.
    fn propagate(
        &mut self,
        likelihoods: impl Fn(&D::Target, usize, &[f64], &mut [f64]) -> Result<(), ModelError>,
    ) -> Result<(), FilterError> {
        self.resample();
        let past = Past {
            time: self.time,
            previous: (self.time > 0).then_some(self.previous.as_slice()),
            measurement: &[],
            particles: self.increments.len(),
        };
        Transition { model: &*self.model, past }.sample(&mut self.streams, &mut self.states, &mut []);
        likelihoods(&self.model, self.time, &self.states, &mut self.increments)?;
        self.weigh();
        self.take_outcomes(|model, time, states, out| {
            // It did not fail for all of these states.
            let _ = likelihoods(model, time, states, out);
        })
    }

    /// Resamples, draws and weighs every filter, if the proposal can be drawn from by rows.
    fn advance_by_rows(&mut self, measurement: &[f64]) -> Result<bool, FilterError> {
        let model = &*self.model;
        let proposal = match self.proposal.by_rows(model, self.time, measurement) {
            // A mixture of the transition with itself is no other.
            Ok(Some(proposal)) if self.defensive.is_none() || proposal.is_transition() => proposal,
            Ok(_) => return Ok(false),
            Err(source) => return Err(FilterError::Proposal { step: self.time, source }),
        };
        std::mem::swap(&mut self.states, &mut self.previous);
        let (settings, time, previous) = (self.settings, self.time, self.previous.as_slice());
        let step = Step { proposal, model, settings, time, measurement, previous };
        let filters = Filters {
            first: 0,
            streams: &mut self.streams,
            weights: &mut self.weights,
            resampled: &mut self.resampled,
            outcomes: &mut self.outcomes,
            ancestors: &mut self.ancestors,
            states: &mut self.states,
        };
        self.workers.step(|workers| step.advance(filters, workers));
        if self.resampled.contains(&true) {
            self.memory.resample(&self.ancestors);
        }
        Ok(true)
    }

    /// Draws ancestors where the rule says so, moves the memory of the whole bank by them, and makes `previous` the states that each
    /// particle descends from.
    fn resample(&mut self) {
        let mut filters = Filters {
            first: 0,
            streams: &mut self.streams,
            weights: &mut self.weights,
            resampled: &mut self.resampled,
            outcomes: &mut self.outcomes,
            ancestors: &mut self.ancestors,
            states: &mut self.previous,
        };
        // Before the first step there is nothing to resample.
        if self.time > 0 {
            filters.resample(&self.settings, &Workers::none());
        }
        if self.resampled.contains(&true) {
            self.memory.resample(&self.ancestors);
            let rows = Rows::picked(&self.states, self.model.state_dim(), &self.ancestors);
            rows.copy_to(&mut self.previous);
        } else {
            std::mem::swap(&mut self.states, &mut self.previous);
        }
    }

    /// Draws every particle and leaves `log p(y|x) + log p(x|x') − log q` in `increments`.
    fn draw(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        let (model, time) = (&*self.model, self.time);
        let past = Past {
            time,
            previous: (time > 0).then_some(self.previous.as_slice()),
            measurement,
            particles: self.increments.len(),
        };
        let mut conditional = self
            .proposal
            .condition(model, past, &mut self.memory)
            .map_err(|source| FilterError::Proposal { step: time, source })?;
        let (streams, states) = (self.streams.as_mut_slice(), self.states.as_mut_slice());
        if conditional.is_transition() {
            conditional.sample(streams, states, &mut self.increments);
            model.log_likelihoods(time, states, measurement, &mut self.increments);
            return Ok(());
        }
        let mut transition = Transition { model, past };
        let densities = Densities { proposal: &mut self.increments, transition: &mut self.log_transitions };
        match &mut self.defensive {
            Some(defensive) => defensive.draw(&mut conditional, &mut transition, streams, states, densities),
            None => {
                conditional.sample(streams, states, densities.proposal);
                transition.log_density(states, densities.transition);
            }
        }
        model.log_likelihoods(time, states, measurement, &mut self.log_likelihoods);
        let terms = self.log_likelihoods.iter().zip(&self.log_transitions);
        for (increment, (likelihood, transition)) in self.increments.iter_mut().zip(terms) {
            *increment = likelihood + transition - *increment;
        }
        Ok(())
    }

    fn weigh(&mut self) {
        let increments = self.increments.chunks_exact(self.settings.particles);
        for ((weights, increments), outcome) in
            self.weights.iter_mut().zip(increments).zip(&mut self.outcomes)
        {
            let ess_before = weights.effective_sample_size();
            *outcome = Outcome { ess_before, increment: weights.update(increments) };
        }
    }

    /// Adds up evidence, unless the weights of a filter could not be normalised.
    fn take_outcomes(
        &mut self,
        likelihoods: impl Fn(&D::Target, usize, &[f64], &mut [f64]),
    ) -> Result<(), FilterError> {
        let (k, n, step) = (self.settings.particles, self.model.state_dim(), self.time);
        for (filter, outcome) in self.outcomes.iter().enumerate() {
            match outcome.increment {
                Ok(increment) => self.log_evidence[filter] += increment,
                Err(WeightFault::NotANumber { particle, value }) => {
                    return Err(FilterError::NotANumber { step, filter, particle, value });
                }
                Err(WeightFault::AllZero) => {
                    // Not kept when particles are drawn by rows, and needed for no other purpose then.
                    let rows = filter * k..(filter + 1) * k;
                    let states = &self.states[rows.start * n..rows.end * n];
                    let log_likelihoods = &mut self.log_likelihoods[rows];
                    likelihoods(&self.model, step, states, log_likelihoods);
                    let largest_log_likelihood =
                        log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let ess_before = outcome.ess_before;
                    return Err(FilterError::Collapse { step, filter, ess_before, largest_log_likelihood });
                }
            }
        }
        Ok(())
    }
}

impl<D: Deref<Target: PartialLikelihood>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Advances every filter by a measurement of which some of the `M` entries may be missing: particles are then drawn from the
    /// transition, as a proposal knows whole measurements only, and weighed by the density of the entries that are there.
    ///
    /// # Errors
    /// As [`FilterBank::step`], and [`FilterError::Model`] if that density cannot be had (nothing has changed then).
    pub fn step_partial(&mut self, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        self.check_width(measurement.len())?;
        PartialMeasurements::check_row(self.time, measurement)?;
        // Of no particle: what is there of the measurement can be weighed, or nothing has changed.
        self.model.partial_log_likelihoods(self.time, &[], measurement, &mut [])?;
        if let Some(whole) = measurement.iter().copied().collect::<Option<Vec<f64>>>() {
            return self.step(&whole);
        }
        self.attempt(|bank| {
            bank.propagate(|model, time, states, out| {
                model.partial_log_likelihoods(time, states, measurement, out)
            })
        })
    }

    /// [`FilterBank::run`] over measurements with gaps. Times with gaps are worked on by one thread.
    ///
    /// # Errors
    /// As [`FilterBank::step_partial`]; measurements after one that led to an error are not looked at.
    pub fn run_partial(
        &mut self,
        measurements: &PartialMeasurements,
        observe: impl FnMut(&Self) + Send,
    ) -> Result<(), FilterError>
    where
        Self: Send,
    {
        self.over(measurements.rows(), Self::step_partial, observe)
    }
}
