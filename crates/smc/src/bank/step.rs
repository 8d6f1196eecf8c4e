//! Steps of a bank: with a measurement, with gaps in it, without one, and whole sequences of them.

use std::mem::take;
use std::ops::Deref;

use motes_models::{Measurements, ModelError, PartialMeasurements, StateSpaceModel, Step, StepRecord};

use super::draw::{BankStep, Common};
use super::filter_bank::FilterBank;
use super::filters::{Fault, Filters};
use super::scratches::Scratches;
use crate::error::FilterError;
use crate::memory::ParticleMemory;
use crate::parallel;
use crate::proposal::Proposal;
use crate::proposal_error::ProposalError;
use crate::proposals::Bootstrap;
use crate::weights::WeightFault;

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Advances every filter by one measurement (`M` numbers): resample where due, draw, weigh. Rows are one unit of time apart ([`Step::of_index`]).
    ///
    /// # Errors
    /// [`FilterError::Model`] if the measurement has the wrong width or is not finite (nothing has changed then).
    /// Otherwise the bank has failed, all of its filters together: every later step returns the same error, and particles and
    /// weights mean nothing any more. [`FilterBank::previous_particles`] are still there, to say where a formula left its domain.
    pub fn step(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        self.check_width(measurement.len())?;
        if let Some(column) = measurement.iter().position(|value| !value.is_finite()) {
            let value = measurement[column];
            return Err(ModelError::NotFinite { row: self.time, column, value }.into());
        }
        let (step, mut entries) = (self.next_step(), take(&mut self.entries));
        entries.clear();
        entries.extend(measurement.iter().copied().map(Some));
        let done = self.step_of(&step.step(), &entries);
        self.entries = entries;
        done
    }

    /// The next step where nobody says more, apart from the bank.
    fn next_step(&self) -> StepRecord {
        StepRecord::of(&self.model.step_of_index(self.time))
    }

    /// A step with a measurement that was looked at.
    fn step_of(&mut self, step: &Step<'_>, entries: &[Option<f64>]) -> Result<(), FilterError> {
        let mut whole = take(&mut self.whole);
        whole.clear();
        whole.extend(entries.iter().flatten());
        let known = whole.len();
        // With gaps, nobody sees it as a whole.
        whole.truncate(if known == entries.len() { known } else { 0 });
        let done = self.attempt(step, |bank| {
            let (model, proposal) = (&*bank.model, &mut bank.proposal);
            let prepared = match known {
                _ if proposal.looks_ahead() => proposal.prepare(model, step, entries),
                0 => Ok(false),
                // Without a sub-step the state stays what it is.
                _ if step.sub_steps == 0 || !proposal.is_for_step(model, step) => Ok(false),
                _ => proposal.prepare(model, step, entries),
            };
            let drawn = match prepared.map_err(|source| bank.unprepared(source))? {
                true => DrawSource::FromProposal,
                false => DrawSource::FromTransition,
            };
            bank.advance(step, drawn, entries, &whole)
        });
        self.whole = whole;
        done
    }

    /// Takes in all measurements, one step after the other, and shows the bank to `observe` after each.
    ///
    /// The same as as many calls of [`FilterBank::step`], but threads stay awake between steps. Where there are several, all of this happens on
    /// one of theirs, `observe` too.
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
        parallel::sequence(|| {
            measurements.rows().try_for_each(|measurement| {
                self.step(measurement)?;
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
        step: &Step<'_>,
        advance: impl FnOnce(&mut Self) -> Result<(), FilterError>,
    ) -> Result<(), FilterError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if self.time == 0 {
            // The first step that resamples needs more than this one.
            parallel::reserve(self.scratch());
        }
        self.last.keep(step);
        // Before anything can fail, so that the states before are where they belong however the step ends.
        std::mem::swap(&mut self.states, &mut self.previous);
        advance(self).inspect_err(|failure| self.failure = Some(failure.clone()))?;
        self.time += 1;
        Ok(())
    }

    /// The error of a proposal that cannot be prepared, in which case nothing was resampled.
    fn unprepared(&mut self, source: ProposalError) -> FilterError {
        self.ancestors.iter_mut().enumerate().for_each(|(row, ancestor)| *ancestor = row);
        FilterError::Proposal { step: self.time, source }
    }

    /// Resamples where due, draws and weighs every filter, and adds up evidence. The measurement is given by its entries, and once more as a whole where nothing is
    /// missing.
    fn advance(
        &mut self,
        step: &Step<'_>,
        drawn: DrawSource,
        entries: &[Option<f64>],
        measurement: &[f64],
    ) -> Result<(), FilterError> {
        let (model, settings, step) = (&*self.model, self.settings, *step);
        let (particles, previous) = (self.ancestors.len(), self.previous.as_slice());
        let common = Common { model, settings, step, entries, measurement, previous };
        let mut filters = Filters {
            first: 0,
            streams: &mut self.streams,
            weights: &mut self.weights,
            resampled: &mut self.resampled,
            outcomes: &mut self.outcomes,
            ancestors: &mut self.ancestors,
            states: &mut self.states,
            memory: (),
        };
        // What particles carry is moved before any block of it is advanced; where they carry nothing, blocks are resampled one by one.
        let has_memory = size_of::<P::Memory>() > 0;
        if has_memory && step.index > 0 {
            parallel::step(particles, |threads| filters.resample_all(&settings, threads));
            if filters.resampled.contains(&true) {
                self.memory.resample(filters.ancestors);
            }
        }
        let resamples = step.index > 0 && !has_memory;
        match drawn {
            DrawSource::FromProposal => {
                let step = BankStep { proposal: &self.proposal, common, scratches: &self.scratches };
                let filters = filters.with_memory(self.memory.rows());
                parallel::step(particles, |threads| step.advance(filters, resamples, threads));
            }
            DrawSource::FromTransition => {
                let step = BankStep { proposal: &Bootstrap, common, scratches: &Scratches::default() };
                parallel::step(particles, |threads| step.advance(filters, resamples, threads));
            }
        }
        self.take_outcomes(&step, entries)
    }

    /// Adds up evidence, unless a filter failed.
    fn take_outcomes(&mut self, at: &Step<'_>, entries: &[Option<f64>]) -> Result<(), FilterError> {
        let (k, n, step) = (self.settings.particles, self.model.state_dim(), self.time);
        for (filter, outcome) in self.outcomes.iter().enumerate() {
            let fault = match &outcome.increment {
                Ok(increment) => {
                    self.log_evidence[filter] += increment;
                    continue;
                }
                // What becomes of a filter that has collapsed before is nobody's business.
                Err(fault)
                    if self.keeps_collapsed
                        && (matches!(fault, Fault::Weights(WeightFault::AllZero))
                            || (self.log_evidence[filter] == f64::NEG_INFINITY
                                && matches!(fault, Fault::Weights(_) | Fault::State { .. }))) =>
                {
                    self.log_evidence[filter] = f64::NEG_INFINITY;
                    // It stays where it was, with equal weights: a state that runs away would end the steps of those that share its block.
                    self.weights[filter].reset();
                    if step > 0 {
                        let own = filter * k * n..(filter + 1) * k * n;
                        self.states[own.clone()].copy_from_slice(&self.previous[own]);
                    }
                    continue;
                }
                Err(fault) => fault.clone(),
            };
            return Err(match fault {
                Fault::Proposal(source) => FilterError::Proposal { step, source },
                Fault::Model(error) => error.into(),
                Fault::State { row, coordinate, value } => {
                    FilterError::State { step, filter: row / k, particle: row % k, coordinate, value }
                }
                Fault::Weights(WeightFault::NotANumber { particle, value }) => {
                    FilterError::NotANumber { step, filter, particle, value }
                }
                Fault::Weights(WeightFault::AllZero) => {
                    let mut log_likelihoods = vec![f64::NEG_INFINITY; k];
                    let states = &self.states[filter * k * n..(filter + 1) * k * n];
                    // It did not fail for all of these states.
                    let _ = self.model.log_likelihoods(at, states, entries, &mut log_likelihoods);
                    let largest_log_likelihood =
                        log_likelihoods.into_iter().fold(f64::NEG_INFINITY, f64::max);
                    let ess_before = outcome.ess_before;
                    FilterError::Collapse { step, filter, ess_before, largest_log_likelihood }
                }
            });
        }
        Ok(())
    }
}

/// What the particles of a step are drawn from.
enum DrawSource {
    FromProposal,
    FromTransition,
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// Advances every filter by a step with its own time, length, inputs and parameters, to a measurement of which some or all of the `M` entries may be
    /// missing, and weighs particles by the density of the entries that are there.
    ///
    /// They are drawn from the proposal if it can take such a measurement ([`Proposal::prepare`]), else from the transition. Where nothing was measured, weights and
    /// evidence stay, and a proposal's memory, which only measurements advance, follows its particle. A model's own step is [`StateSpaceModel::step_of_index`].
    ///
    /// # Errors
    /// As [`FilterBank::step`]; [`FilterError::Model`] if that density cannot be had and [`FilterError::Setting`] if the step's index is not the number of steps
    /// before, or its times are not finite (nothing has changed then); [`FilterError::State`] if a state is drawn that is not finite.
    pub fn step_at(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        self.check_width(measurement.len())?;
        self.check_step(step)?;
        PartialMeasurements::check_row(self.time, measurement)?;
        // Of no particle: what is there of the measurement can be weighed, or nothing has changed.
        self.model.log_likelihoods(step, &[], measurement, &mut [])?;
        self.step_of(step, measurement)
    }

    /// Refuses a step that is not the next, or that ends nowhere.
    fn check_step(&self, step: &Step<'_>) -> Result<(), FilterError> {
        let refuse = |name, value: String, expected| Err(FilterError::Setting { name, value, expected });
        if step.index != self.time {
            return refuse("the index of a step", step.index.to_string(), "the number of steps before it");
        }
        if step.sub_steps != 1 && step.index == 0 {
            let found = step.sub_steps.to_string();
            return refuse("the number of sub-steps of a step", found, "1 at the start");
        }
        if step.sub_steps > 1 && self.model.density().is_some() {
            let found = step.sub_steps.to_string();
            let expected = "1 for a model with a density of states, which says of a whole step what it is";
            return refuse("the number of sub-steps of a step", found, expected);
        }
        let own = self.model.step_of_index(step.index);
        let inputs = self.model.input_dim();
        if step.inputs.len() != inputs && step.inputs.len() != inputs * (step.sub_steps + 1) {
            let expected = "as many as the model takes, or so many for each sub-step and for the measurement";
            return refuse("the number of inputs of a step", step.inputs.len().to_string(), expected);
        }
        if step.parameters.len() != own.parameters.len() {
            let found = step.parameters.len().to_string();
            return refuse("the number of parameters of a step", found, "as many as the model takes");
        }
        let numbers =
            [step.time, step.length].into_iter().chain(step.inputs.iter().chain(step.parameters).copied());
        match numbers.into_iter().find(|number| !number.is_finite()) {
            Some(number) => {
                refuse("a time, input or parameter of a step", number.to_string(), "a finite number")
            }
            None if step.length < 0.0 => {
                refuse("the length of a step", step.length.to_string(), "at least 0")
            }
            None => Ok(()),
        }
    }
}
