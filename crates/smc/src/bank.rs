//! Many independent particle filters on the same measurements, advanced as one batch.

use std::ops::Deref;

use motes_models::batch::Rows;
use motes_models::{Measurements, ModelError, Seed, StateSpaceModel, Stream};

use crate::blocks::{Filters, Outcome, Step};
use crate::weights::BLOCK;
use crate::workers::Workers;
use crate::{
    Conditional, FilterError, LogWeights, ParticleMemory, Past, Proposal, ResampleWhen, Resampling,
    WeightFault,
};

/// The settings of a filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterSettings {
    /// `K`, particles in each filter; at least 1.
    pub particles: usize,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// When they are drawn.
    pub resample_when: ResampleWhen,
}

impl FilterSettings {
    /// `K` particles, multinomial resampling when `K_eff < K/3`: the paper's filter.
    pub fn new(particles: usize) -> Self {
        FilterSettings { particles, resampling: Resampling::Multinomial, resample_when: ResampleWhen::PAPER }
    }

    fn check(&self) -> Result<(), FilterError> {
        if self.particles == 0 {
            return Err(FilterError::Setting {
                name: "the number of particles K",
                value: "0".into(),
                expected: "at least 1",
            });
        }
        self.resample_when.check()
    }
}

/// `B` independent filters of `K` particles each, with one model, one proposal and one sequence of measurements.
///
/// The model is held by anything that points to one: `&model` for a moment, `Arc<Model>` for a service that keeps filter and
/// model together. Each filter draws from its own stream, so a bank gives each of its filters what it would get alone.
/// Between two steps the bank shows particles and weights as they are before resampling, which is when estimates
/// are to be taken; resampling happens at the start of the next step.
pub struct FilterBank<D: Deref, P: Proposal<D::Target>> {
    model: D,
    proposal: P,
    settings: FilterSettings,
    streams: Vec<Stream>,
    time: usize,
    states: Vec<f64>,
    previous: Vec<f64>,
    memory: P::Memory,
    weights: Vec<LogWeights>,
    log_evidence: Vec<f64>,
    ancestors: Vec<usize>,
    resampled: Vec<bool>,
    outcomes: Vec<Outcome>,
    increments: Vec<f64>,
    log_likelihoods: Vec<f64>,
    log_transitions: Vec<f64>,
    workers: Workers,
    failure: Option<FilterError>,
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Prepares `filters` filters; filter `b` draws from the stream of `seed.nth(b)`.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is no filter or no particle, or a setting is out of range.
    pub fn new(
        model: D,
        proposal: P,
        settings: FilterSettings,
        filters: usize,
        seed: &Seed,
    ) -> Result<Self, FilterError> {
        FilterBank::with_streams(model, proposal, settings, seed.streams(filters))
    }

    /// Prepares one filter for each of the given streams.
    ///
    /// # Errors
    /// As [`FilterBank::new`].
    pub fn with_streams(
        model: D,
        proposal: P,
        settings: FilterSettings,
        streams: Vec<Stream>,
    ) -> Result<Self, FilterError> {
        settings.check()?;
        if streams.is_empty() {
            return Err(FilterError::Setting {
                name: "the number of filters in a bank",
                value: "0".into(),
                expected: "at least 1",
            });
        }
        let filters = streams.len();
        let n = model.state_dim();
        let sizes =
            filters.checked_mul(settings.particles).and_then(|rows| Some((rows, rows.checked_mul(n)?)));
        let (rows, values) = match sizes {
            Some((rows, values)) if values > 0 => (rows, values),
            _ => {
                return Err(FilterError::Setting {
                    name: "the number of values in a bank, filters × particles × N",
                    value: format!("{filters} × {} × {n}", settings.particles),
                    expected: "at least 1 and a number that can be stored",
                });
            }
        };
        Ok(FilterBank {
            memory: proposal.initial_memory(rows),
            model,
            proposal,
            settings,
            workers: Workers::none(),
            streams,
            time: 0,
            states: vec![0.0; values],
            previous: vec![0.0; values],
            weights: vec![LogWeights::uniform(settings.particles); filters],
            log_evidence: vec![0.0; filters],
            ancestors: (0..rows).collect(),
            resampled: vec![false; filters],
            outcomes: vec![Outcome { ess_before: 0.0, increment: Ok(0.0) }; filters],
            increments: vec![0.0; rows],
            log_likelihoods: vec![0.0; rows],
            log_transitions: vec![0.0; rows],
            failure: None,
        })
    }

    /// Lets `threads` threads work on each step where the proposal allows it, as the designed ones do, and there are particles enough;
    /// [`FilterBank::run`] needs fewer of them for that. When the bank is dropped its threads sleep until another asks for as
    /// many. Results are the same bytes for any number.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if `threads` is 0 or more than the system can start.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, FilterError> {
        // Points and ranks of a filter's resampling, and a block of particles, are the largest there is.
        let scratch = 3 * self.settings.particles + BLOCK * self.model.state_dim();
        self.workers = Workers::new(threads, self.increments.len(), scratch)?;
        Ok(self)
    }

    /// Advances every filter by one measurement (`M` numbers): resample where due, draw, weigh.
    ///
    /// # Errors
    /// [`FilterError::Model`] if the measurement has the wrong width or is not finite (nothing has changed then).
    /// Otherwise the bank has failed, all of its filters together: every later step returns the same error, and particles and
    /// weights mean nothing any more.
    pub fn step(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        self.check_measurement(measurement)?;
        self.advance(measurement).inspect_err(|failure| self.failure = Some(failure.clone()))
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
        mut observe: impl FnMut(&Self) + Send,
    ) -> Result<(), FilterError>
    where
        Self: Send,
    {
        let workers = self.workers.clone();
        workers.together(|| {
            measurements.rows().try_for_each(|measurement| {
                self.step(measurement)?;
                observe(self);
                Ok(())
            })
        })
    }

    fn advance(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        if !self.advance_by_rows(measurement)? {
            self.resample();
            self.draw(measurement)?;
            self.weigh();
        }
        self.take_outcomes(measurement)?;
        self.time += 1;
        Ok(())
    }

    fn check_measurement(&self, measurement: &[f64]) -> Result<(), FilterError> {
        let (width, expected) = (measurement.len(), self.model.measurement_dim());
        if width != expected {
            return Err(ModelError::MeasurementWidth { width, expected }.into());
        }
        match measurement.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(column) => {
                let value = measurement[column];
                Err(ModelError::NotFinite { row: self.time, column, value }.into())
            }
        }
    }

    /// Resamples, draws and weighs every filter, if the proposal can be drawn from by rows.
    fn advance_by_rows(&mut self, measurement: &[f64]) -> Result<bool, FilterError> {
        let model = &*self.model;
        let proposal = match self.proposal.by_rows(model, self.time, measurement) {
            Ok(Some(proposal)) => proposal,
            Ok(None) => return Ok(false),
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
        let past = Past {
            time: self.time,
            previous: (self.time > 0).then_some(self.previous.as_slice()),
            measurement,
            particles: self.streams.len() * self.settings.particles,
        };
        let mut conditional = self
            .proposal
            .condition(&*self.model, past, &mut self.memory)
            .map_err(|source| FilterError::Proposal { step: self.time, source })?;
        conditional.sample(&mut self.streams, &mut self.states, &mut self.increments);
        self.model.log_likelihoods(self.time, &self.states, measurement, &mut self.log_likelihoods);
        if conditional.is_transition() {
            self.increments.copy_from_slice(&self.log_likelihoods);
            return Ok(());
        }
        match past.previous {
            None => self.model.log_initials(&self.states, &mut self.log_transitions),
            Some(previous) => {
                self.model.log_transitions(self.time, previous, &self.states, &mut self.log_transitions);
            }
        }
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
    fn take_outcomes(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
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
                    let likelihoods = &mut self.log_likelihoods[rows];
                    self.model.log_likelihoods(step, states, measurement, likelihoods);
                    let largest_log_likelihood =
                        likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let ess_before = outcome.ess_before;
                    return Err(FilterError::Collapse { step, filter, ess_before, largest_log_likelihood });
                }
            }
        }
        Ok(())
    }

    /// `B`, the number of filters.
    pub fn filters(&self) -> usize {
        self.streams.len()
    }

    /// How many measurements have been taken in.
    pub fn time(&self) -> usize {
        self.time
    }

    /// The particles of one filter, row-major `K×N`, as they are before resampling.
    pub fn particles(&self, filter: usize) -> &[f64] {
        let values = self.settings.particles * self.model.state_dim();
        &self.states[filter * values..(filter + 1) * values]
    }

    /// The weights of one filter's particles.
    pub fn weights(&self, filter: usize) -> &LogWeights {
        &self.weights[filter]
    }

    /// For each particle of the whole bank (`B·K`), the row it descends from in the step before; itself where its
    /// filter did not resample.
    pub fn ancestors(&self) -> &[usize] {
        &self.ancestors
    }

    /// What every particle of the bank carries beside its state.
    pub fn memory(&self) -> &P::Memory {
        &self.memory
    }

    /// The estimate of `log p(y_{0:t})` by one filter; its exponential is unbiased.
    pub fn log_evidence(&self, filter: usize) -> f64 {
        self.log_evidence[filter]
    }

    /// One filter's estimate of `E[x_t | y_{0:t}]`, `Σ_k W_k x_k`, into `mean` (`N`).
    ///
    /// # Panics
    /// If there is no such filter or `mean` has not `N` places.
    pub fn mean(&self, filter: usize, mean: &mut [f64]) {
        assert_eq!(mean.len(), self.model.state_dim(), "the mean has N coordinates");
        self.weights[filter].mean(self.particles(filter), mean);
    }
}
