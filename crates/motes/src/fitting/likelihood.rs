//! The likelihood of data as a function of a model's free parameters.

use std::ops::ControlFlow;

use motes_inference::{Estimator, EstimatorCost, Likelihood, PerturbedLikelihood, PriorDraw};
use motes_models::{Seed, Step};

use super::free::FreeParameters;
use super::options::FitOptions;
use super::perturbed_model::PerturbedModel;
use crate::cost::cost;
use crate::data::Data;
use crate::error::MotesError;
use crate::evidence::{RecordedSequence, candidates, is_exact, missed, sequences, share_for_evidence};
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::recorded::of_recorded;

/// The likelihood of data by filters of a model.
pub(super) struct ModelLikelihood<'a> {
    pub(super) model: &'a Model,
    pub(super) free: &'a FreeParameters,
    pub(super) names: Vec<String>,
    pub(super) sequences: Vec<RecordedSequence>,
    pub(super) proposals: Vec<ProposalName>,
    costs: Vec<EstimatorCost>,
    /// The model with parameters of particles, where iterated filtering was prepared.
    pub(super) perturbed: Option<PerturbedModel>,
    pub(super) proceed: &'a (dyn Fn() -> ControlFlow<()> + Sync),
}

impl<'a> ModelLikelihood<'a> {
    /// # Errors
    /// [`MotesError::Proposal`] if a proposal was learned for another model.
    pub(super) fn new(
        model: &'a Model,
        data: &Data,
        free: &'a FreeParameters,
        options: &FitOptions,
        proceed: &'a (dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Result<Self, MotesError> {
        let proposals = match &options.proposal {
            Some(proposal) => vec![of_recorded(proposal.clone(), model)?],
            None if is_exact(model, data) => vec![ProposalName::Exact],
            None => candidates(model),
        };
        let (names, sequences) = (free.names(), sequences(data));
        let step = sequences.first().map_or(Step::of_index(0), RecordedSequence::typical_step);
        let costs = proposals.iter().map(|proposal| cost(proposal, model, &step)).collect();
        Ok(ModelLikelihood { model, free, names, sequences, proposals, costs, perturbed: None, proceed })
    }

    /// The proposal of an estimator.
    pub(super) fn proposal(&self, estimator: Estimator) -> &ProposalName {
        &self.proposals[estimator.index]
    }

    /// The model at values of the free parameters; what it is not at some values, the data cannot come from.
    fn model_at(&self, values: &[f64]) -> Result<Model, MotesError> {
        let named: Vec<(String, f64)> = self.names.iter().cloned().zip(values.iter().copied()).collect();
        Ok(self.model.with_parameters(&named)?)
    }

    /// `log ẑ` at values of the free parameters.
    pub(super) fn at(&self, values: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, MotesError> {
        let Ok(model) = self.model_at(values) else { return Ok(f64::NEG_INFINITY) };
        let or_nothing = |found: Result<f64, MotesError>| match found {
            Ok(found) if !found.is_nan() => Ok(found),
            Err(MotesError::Interrupted) => Err(MotesError::Interrupted),
            _ => Ok(f64::NEG_INFINITY),
        };
        match self.by(&model, self.proposal(estimator), estimator.particles, seed) {
            // Where a proposal fails at some values, the transition gives an estimate that is unbiased, too.
            Err(error) if !matches!(error, MotesError::Interrupted) && self.is_guided(estimator) => {
                or_nothing(self.by(&model, &ProposalName::Bootstrap, estimator.particles, seed))
            }
            found => or_nothing(found),
        }
    }

    /// Whether there is another proposal to fall back on.
    fn is_guided(&self, estimator: Estimator) -> bool {
        *self.proposal(estimator) != ProposalName::Bootstrap
    }

    /// What filters of a model are run with, of some proposal and number of particles.
    fn filter(model: &Model, proposal: &ProposalName, particles: usize) -> Result<FilterOptions, MotesError> {
        let proposal = of_recorded(proposal.clone(), model)?;
        let defensive = share_for_evidence(&proposal);
        Ok(FilterOptions { proposal, particles, defensive, check: false, ..FilterOptions::default() })
    }

    /// `log ẑ` of a model by a proposal.
    fn by(
        &self,
        model: &Model,
        proposal: &ProposalName,
        particles: usize,
        seed: &Seed,
    ) -> Result<f64, MotesError> {
        let options = Self::filter(model, proposal, particles)?;
        let mut sum = 0.0;
        for (number, sequence) in self.sequences.iter().enumerate() {
            sum += sequence.log_evidence_alone(model, &options, seed.nth(number as u64), self.proceed)?;
            if sum == f64::NEG_INFINITY {
                break;
            }
        }
        Ok(sum)
    }

    /// What is to be said where filters of another proposal find more at these values.
    ///
    /// # Errors
    /// [`MotesError::Interrupted`].
    pub(super) fn missed(
        &self,
        values: &[f64],
        estimator: Estimator,
        seed: &Seed,
    ) -> Result<Option<String>, MotesError> {
        let Ok(model) = self.model_at(values) else { return Ok(None) };
        let proposal = self.proposal(estimator);
        let missed = missed(proposal, &model, &self.sequences, &seed.child("second opinion"), self.proceed)?;
        Ok(missed.map(|(other, nats)| {
            format!(
                "filters by {proposal} miss states that explain the data: --proposal {other} finds {nats:.1} more log-evidence there, and the likelihood of this fit is wrong; fit \
                 again with --proposal {other}"
            )
        }))
    }

    /// Why the likelihood is 0 at a draw from the prior; none where it is not.
    pub(super) fn reason(&self, draw: &PriorDraw) -> Option<String> {
        let PriorDraw { v, estimator, seed } = draw;
        let model = match self.model_at(&self.free.at(v)) {
            Ok(model) => model,
            Err(error) => return Some(error.to_string()),
        };
        let proposal = match self.by(&model, self.proposal(*estimator), estimator.particles, seed) {
            Err(_) if self.is_guided(*estimator) => &ProposalName::Bootstrap,
            _ => self.proposal(*estimator),
        };
        let options = match Self::filter(&model, proposal, estimator.particles) {
            Ok(options) => options,
            Err(error) => return Some(error.to_string()),
        };
        let of_series = |(number, sequence): (usize, &RecordedSequence)| {
            sequence.failure(&model, &options, seed.nth(number as u64))
        };
        self.sequences.iter().enumerate().find_map(of_series)
    }
}

impl Likelihood for ModelLikelihood<'_> {
    type Error = MotesError;

    fn dimension(&self) -> usize {
        self.names.len()
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn perturbed(&self) -> Option<&dyn PerturbedLikelihood<Error = MotesError>> {
        self.perturbed.is_some().then_some(self)
    }

    fn reported(&self, v: &[f64]) -> Vec<f64> {
        self.free.at(v)
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, MotesError> {
        self.at(&self.free.at(v), estimator, seed)
    }
}
