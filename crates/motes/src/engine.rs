//! One running filter, whatever its model and its proposal are.

use std::ops::ControlFlow;

use motes_models::{Seed, Step, StepRecord};
use motes_smc::{
    EvidenceWarning, FilterError, FilterHistory, LookAhead, Predictive, SmoothedPaths, SmoothingError,
    Verdict, WeightDiagnosis,
};

use crate::continuations::Continuations;
use crate::error::MotesError;
use crate::estimate::Estimate;
use crate::filter_choice::filter_of;
use crate::filtered::WeightedParticles;
use crate::known_inputs::{empty_unknown, without_unknown};
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::particles::Start;
use crate::prediction::{MOST, beside_prediction};
use crate::quantiles::Quantiles;
use crate::steps::Steps;
use crate::timeline::{Clock, RowTime};

/// A filter of one series, step by step.
pub struct Running<'m> {
    pub(crate) model: &'m Model,
    pub(crate) filter: Box<dyn Steps + 'm>,
    /// The kind of its proposal.
    pub(crate) kind: &'static str,
    pub(crate) time: usize,
    /// Whether time has passed since the first state.
    pub(crate) has_passed: bool,
    /// The log-evidence before the last step.
    pub(crate) before: f64,
    /// Where its series is, for who gives rows one by one.
    pub(crate) clock: Clock,
    /// Whether each measurement is predicted before it is used.
    pub(crate) is_predictive: bool,
    /// Which quantiles are given.
    pub(crate) asked: Quantiles,
    /// What was expected of the last measurement, where it is.
    pub(crate) predictive: Vec<Predictive>,
    /// Where forecasts have come to, of a model whose measurements are inputs.
    pub(crate) continuations: Option<Continuations>,
    /// What their random numbers come from.
    pub(crate) forecast_seed: Seed,
    /// An input that the last forecast of a measurement lacked.
    pub(crate) unknown: Option<String>,
}

/// Whether time passes in a step.
fn passes(step: &Step<'_>) -> bool {
    step.index > 0 && step.sub_steps > 0
}

impl<'m> Running<'m> {
    /// A filter for the series of that number; its random numbers do not depend on other series.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if the model has no such proposal, [`MotesError::Setting`] if an option is out of range.
    pub fn new(model: &'m Model, options: &FilterOptions, series: usize) -> Result<Self, MotesError> {
        Running::with_seed(model, options, Running::seed(options, series), None)
    }

    /// What the random numbers of a series come from.
    pub(crate) fn seed(options: &FilterOptions, series: usize) -> Seed {
        Seed::from_u64(options.seed).child("filter").nth(series as u64)
    }

    /// A filter whose random numbers come from `seed`; `ahead` are the potentials of what it will take in, for a proposal that looks ahead.
    ///
    /// # Errors
    /// As [`Running::new`].
    pub(crate) fn with_seed(
        model: &'m Model,
        options: &FilterOptions,
        seed: Seed,
        ahead: Option<&LookAhead>,
    ) -> Result<Self, MotesError> {
        Ok(Running::of(model, options, filter_of(model, options, Start::Seed(seed), ahead)?))
    }

    /// That of a filter before its first step.
    pub(crate) fn of(model: &'m Model, options: &FilterOptions, filter: Box<dyn Steps + 'm>) -> Self {
        Running {
            model,
            filter,
            kind: options.proposal.kind(),
            time: 0,
            has_passed: false,
            before: 0.0,
            clock: Clock::default(),
            is_predictive: options.predictive,
            asked: options.quantiles.clone(),
            predictive: vec![],
            continuations: None,
            forecast_seed: Seed::from_u64(options.seed).child("forecast"),
            unknown: None,
        }
    }

    /// Takes in the measurement of the next row, whose time follows from the rows before.
    ///
    /// # Errors
    /// As [`Running::step_row`].
    pub fn advance(&mut self, measurement: &[Option<f64>]) -> Result<(), MotesError> {
        let steps = self.steps_to(RowTime { label: None, columns: &[] }, measurement)?;
        self.advance_by(&steps, measurement)
    }

    /// Takes in the measurement of the next row by the steps that lead to it ([`Model::next_steps`]): all but the last have no measurement.
    ///
    /// # Errors
    /// [`MotesError::Filter`] if no particle explains it, or a formula leaves its domain.
    pub fn advance_by(
        &mut self,
        steps: &[StepRecord],
        measurement: &[Option<f64>],
    ) -> Result<(), MotesError> {
        let Some((last, before)) = steps.split_last() else {
            let reason = "a row has no steps; times and inputs alone are no data";
            return Err(MotesError::Setting(reason.into()));
        };
        let (last, nothing) = (last.step(), vec![None; measurement.len()]);
        before.iter().try_for_each(|step| self.take_step(&step.step(), &nothing))?;
        if self.is_predictive && self.filter.failure().is_none() {
            let known = without_unknown(&last);
            let known = known.as_ref().map_or(last, StepRecord::step);
            let ahead = self.filter.measurement_ahead(&known, measurement, self.asked.probabilities());
            self.predictive = ahead.map_err(|error| self.explain(&error, &known, &nothing))?;
            empty_unknown(self.model, &last, self.has_passed || passes(&last), &mut self.predictive);
        }
        self.take_step(&last, measurement)
    }

    /// The steps to the next row of who gives rows one by one.
    fn steps_to(
        &mut self,
        row: RowTime<'_>,
        measurement: &[Option<f64>],
    ) -> Result<Vec<StepRecord>, MotesError> {
        let mut clock = self.clock.clone();
        let steps = self.model.next_steps(&mut clock, row);
        let steps = steps.and_then(|steps| self.model.measured(&mut clock, measurement).map(|()| steps));
        let steps = steps.map_err(|error| MotesError::Timeline(Box::new(error)))?;
        if self.filter.failure().is_none() {
            self.clock = clock;
        }
        Ok(steps)
    }

    /// Takes in one step with its measurement.
    ///
    /// # Errors
    /// As [`Running::advance`].
    pub(crate) fn take_step(
        &mut self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<(), MotesError> {
        if let Some(failure) = self.filter.failure() {
            let place = format!("t = {}", step.time);
            return Err(MotesError::Filter {
                place,
                reason: format!("the filter failed in an earlier step: {failure}"),
            });
        }
        self.before = self.filter.log_evidence();
        self.continuations = None;
        let known = without_unknown(step);
        let step = &known.as_ref().map_or(*step, StepRecord::step);
        self.filter.step(step, measurement).map_err(|error| self.explain(&error, step, measurement))?;
        self.time += 1;
        self.has_passed |= passes(step);
        Ok(())
    }

    /// Takes in the measurement of the next row, whose time follows from the rows before, and says what is known then.
    ///
    /// # Errors
    /// As [`Running::step_row`].
    pub fn step(&mut self, measurement: &[Option<f64>]) -> Result<Estimate, MotesError> {
        self.step_row(RowTime { label: None, columns: &[] }, measurement)
    }

    /// The same by the steps that lead to the row.
    ///
    /// # Errors
    /// As [`Running::advance_by`].
    pub fn step_by(
        &mut self,
        steps: &[StepRecord],
        measurement: &[Option<f64>],
    ) -> Result<Estimate, MotesError> {
        self.advance_by(steps, measurement)?;
        Ok(self.estimate())
    }

    /// Takes in the next row, with its time and inputs, and says what is known then.
    ///
    /// # Errors
    /// As [`Running::advance_by`], and [`MotesError::Timeline`] if the row's time does not come next, or an input is missing; nothing has changed then.
    pub fn step_row(
        &mut self,
        row: RowTime<'_>,
        measurement: &[Option<f64>],
    ) -> Result<Estimate, MotesError> {
        let steps = self.steps_to(row, measurement)?;
        self.step_by(&steps, measurement)
    }

    /// [`Running::step`], and what its weights say about how far they can be trusted: at once, where there are many particles.
    ///
    /// # Errors
    /// As [`Running::advance`].
    pub fn step_and_diagnose(
        &mut self,
        steps: &[StepRecord],
        measurement: &[Option<f64>],
    ) -> Result<(Estimate, Option<WeightDiagnosis>), MotesError> {
        self.advance_by(steps, measurement)?;
        Ok(match self.filter.is_large() {
            true => rayon_core::join(|| self.estimate(), || self.diagnosis()),
            false => (self.estimate(), self.diagnosis()),
        })
    }

    /// What is known after the last step.
    fn estimate(&self) -> Estimate {
        Estimate {
            state: self.filter.state(self.asked.probabilities()),
            ess: self.effective_sample_size(),
            log_evidence: Some(self.last_increment()),
            predictive: self.predictive.clone(),
        }
    }

    /// The standard error of the log-evidence of all steps so far; none without [`FilterOptions::check`], or of too few particles to tell.
    pub fn standard_error(&self) -> Option<f64> {
        self.filter.standard_error()
    }

    /// What small filters beside it warn of after all steps so far ([`FilterOptions::check`]).
    pub fn evidence_warnings(&self) -> Vec<EvidenceWarning> {
        self.filter.evidence_warnings()
    }

    /// What a bootstrap filter beside it says of all steps so far, if there is one ([`FilterOptions::check`]).
    pub fn verdict(&self) -> Option<Verdict> {
        self.filter.verdict()
    }

    /// By how much the log-evidence of a bootstrap filter is larger than that of a filter that looks ahead, after the last step, where that is more than noise.
    pub fn missed(&self) -> Option<f64> {
        self.filter.missed()
    }

    /// By how much the log-evidence of a bootstrap filter beside it is above its own, if there is one.
    pub fn difference(&self) -> f64 {
        self.filter.difference()
    }

    /// The names of the coordinates of a state.
    pub fn states(&self) -> &'m [String] {
        self.model.states()
    }

    /// What the weights of the last step say about how far they can be trusted; none of an exact filter, which has none.
    pub fn diagnosis(&self) -> Option<WeightDiagnosis> {
        self.filter.diagnosis()
    }

    /// Keeps what the filter is after its last step.
    pub(crate) fn record(&self, history: &mut FilterHistory) -> Result<(), SmoothingError> {
        self.filter.record(history)
    }

    /// Draws trajectories backwards through what the filter was, as long as `proceed` says so; it hears at how many times they are drawn.
    pub(crate) fn backward(
        &self,
        history: &FilterHistory,
        paths: usize,
        seed: &Seed,
        proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<SmoothedPaths, SmoothingError> {
        self.filter.backward(history, paths, seed, proceed)
    }

    /// The effective sample size, in particles; none of an exact filter.
    pub fn effective_sample_size(&self) -> Option<f64> {
        self.filter.effective_sample_size()
    }

    /// The estimate of `log p(y_t | y_{0:t−1})` of the last step.
    pub fn last_increment(&self) -> f64 {
        self.filter.log_evidence() - self.before
    }

    /// The mean of each coordinate of the state.
    pub fn means(&self) -> &[f64] {
        self.filter.means()
    }

    /// Quantiles of a coordinate of the state.
    pub fn quantiles(&self, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        self.filter.quantiles(coordinate, probabilities)
    }

    /// The particles with their weights after the last step; none of an exact filter.
    pub(crate) fn weighted_particles(&self) -> Option<WeightedParticles> {
        let (states, weights) = self.filter.weighted()?;
        Some(WeightedParticles { states: states.to_vec(), weights: weights.to_vec() })
    }

    /// The estimate of `log p(y_{0:t})`.
    pub fn log_evidence(&self) -> f64 {
        self.filter.log_evidence()
    }

    /// What a failure means for who wrote the model and the data.
    pub(crate) fn explain(
        &self,
        error: &FilterError,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> MotesError {
        let place = format!("t = {}", step.time);
        let reason = match error {
            FilterError::Collapse { ess_before, .. } => self.explain_collapse(*ess_before, step, measurement),
            FilterError::NotANumber { particle, .. } | FilterError::State { particle, .. } => {
                self.explain_particle(*particle, step)
            }
            FilterError::Model(error) if self.kind == ProposalName::Exact.kind() => {
                self.explain_exact(step).unwrap_or_else(|| error.to_string())
            }
            other => other.to_string(),
        };
        MotesError::Filter { place, reason }
    }
}

impl Running<'_> {
    /// Why no particle has a weight: what was measured, beside what is predicted.
    fn explain_collapse(&self, ess_before: f64, step: &Step<'_>, measurement: &[Option<f64>]) -> String {
        let names = self.model.measurements();
        if let Some(impossible) = self.model.impossible(step, measurement) {
            return format!("{}: {impossible}", names[impossible.coordinate]);
        }
        let count = (self.filter.particles() / self.model.states().len()).min(MOST);
        let previous: Option<Vec<&[f64]>> = (0..count).map(|at| self.filter.of_particle(at).0).collect();
        let previous = previous.map(|rows| rows.concat());
        let previous = previous.as_deref();
        let distribution = |entry: usize, state: &[f64]| {
            self.model.formulas().and_then(|formulas| formulas.distribution_at(step, state, entry))
        };
        let beside = match self.model.kind() {
            Kind::Learnable(model) => {
                beside_prediction(model, step, previous, measurement, names, &distribution)
            }
            Kind::LinearGaussian(model) => {
                beside_prediction(model, step, previous, measurement, names, &distribution)
            }
        };
        beside.explained((self.kind != ProposalName::Exact.kind()).then_some(ess_before))
    }

    /// Which formula gives no number where answers are exact: at the means, which formulas of linear models do not depend on but as a whole.
    fn explain_exact(&self, step: &Step<'_>) -> Option<String> {
        let means = self.filter.means();
        let previous = (step.index > 0).then_some(means);
        let error = self.model.formulas()?.explain(step, previous, Some(means))?;
        Some(error.to_string())
    }

    /// Why the density of a particle, or its state, is not a number.
    fn explain_particle(&self, particle: usize, step: &Step<'_>) -> String {
        let (previous, state) = self.filter.of_particle(particle);
        let explained =
            self.model.formulas().and_then(|formulas| formulas.explain(step, previous, Some(state)));
        match explained {
            Some(error) => error.to_string(),
            None => format!("the state {state:?} of a particle, or its density, is not a finite number"),
        }
    }
}
