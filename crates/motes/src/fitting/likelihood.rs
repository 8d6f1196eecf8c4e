//! The likelihood of data as a function of a model's free parameters.

use std::ops::ControlFlow;
use std::sync::Mutex;

use motes_inference::{Estimator, EstimatorCost, Likelihood};
use motes_models::Seed;
use rand::Rng;

use super::free::FreeParameters;
use super::options::FitOptions;
use crate::data::Data;
use crate::error::MotesError;
use crate::evidence::{
    EvidenceEstimator, EvidenceOptions, candidates, cost, fixed_cost, is_exact, log_evidence,
};
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// The likelihood of data by filters of a model.
pub(super) struct ModelLikelihood<'a> {
    model: &'a Model,
    data: &'a Data,
    free: &'a FreeParameters,
    proposals: Vec<ProposalName>,
    costs: Vec<EstimatorCost>,
    proceed: &'a (dyn Fn() -> ControlFlow<()> + Sync),
    /// Why the likelihood was 0 when it first was.
    reason: Mutex<Option<String>>,
}

fn cost_of(proposal: &ProposalName, model: &Model) -> EstimatorCost {
    EstimatorCost {
        per_particle: cost(proposal),
        fixed: fixed_cost(proposal, model),
        is_exact: *proposal == ProposalName::Exact,
    }
}

impl<'a> ModelLikelihood<'a> {
    pub(super) fn new(
        model: &'a Model,
        data: &'a Data,
        free: &'a FreeParameters,
        options: &FitOptions,
        proceed: &'a (dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Self {
        let proposals = match &options.proposal {
            Some(proposal) => vec![proposal.clone()],
            None if is_exact(model, data) => vec![ProposalName::Exact],
            None => candidates(model),
        };
        let costs = proposals.iter().map(|proposal| cost_of(proposal, model)).collect();
        ModelLikelihood { model, data, free, proposals, costs, proceed, reason: Mutex::new(None) }
    }

    /// The proposal of an estimator.
    pub(super) fn proposal(&self, estimator: Estimator) -> &ProposalName {
        &self.proposals[estimator.index]
    }

    /// Why the likelihood was 0 when it first was; none where it never was.
    pub(super) fn reason(&self) -> Option<String> {
        self.reason.lock().map_or(None, |reason| reason.clone())
    }

    /// `log ẑ` at values of the free parameters.
    pub(super) fn at(&self, values: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, MotesError> {
        let named: Vec<(String, f64)> = self.free.names().into_iter().zip(values.iter().copied()).collect();
        // What a model is not at some values, the data cannot come from.
        let model = match self.model.with_parameters(&named) {
            Ok(model) => model,
            Err(error) => return Ok(self.impossible(|| error.to_string())),
        };
        match self.by(&model, self.proposal(estimator), estimator.particles, seed) {
            Ok(found) => Ok(found),
            Err(MotesError::Interrupted) => Err(MotesError::Interrupted),
            // Where a proposal fails at some values, the transition gives an estimate that is unbiased, too.
            Err(_) if *self.proposal(estimator) != ProposalName::Bootstrap => {
                match self.by(&model, &ProposalName::Bootstrap, estimator.particles, seed) {
                    Err(MotesError::Interrupted) => Err(MotesError::Interrupted),
                    found => Ok(found.unwrap_or_else(|error| self.impossible(|| error.to_string()))),
                }
            }
            Err(error) => Ok(self.impossible(|| error.to_string())),
        }
    }

    /// `log ẑ` of a model by a proposal.
    fn by(
        &self,
        model: &Model,
        proposal: &ProposalName,
        particles: usize,
        seed: &Seed,
    ) -> Result<f64, MotesError> {
        if *proposal == ProposalName::LookAhead {
            let options =
                EvidenceOptions { proposal: Some(proposal.clone()), particles, ..EvidenceOptions::default() };
            let estimator = EvidenceEstimator::while_proceeding(model, self.data, &options, self.proceed)?;
            let found: f64 = estimator.per_series_while(seed, self.proceed)?.into_iter().sum();
            return Ok(match found.is_finite() {
                true => found,
                false => self.impossible(|| "no particle explains some measurement".into()),
            });
        }
        let options = FilterOptions {
            proposal: proposal.clone(),
            particles,
            seed: seed.stream().next_u64(),
            check: false,
            ..FilterOptions::default()
        };
        let found = log_evidence(model, self.data, &options, |_| (self.proceed)())?;
        Ok(match found.value.is_finite() {
            true => found.value,
            false => self.impossible(|| {
                found.impossible.map_or("the log-evidence is no number".into(), |warning| warning.to_string())
            }),
        })
    }

    fn impossible(&self, reason: impl FnOnce() -> String) -> f64 {
        if let Ok(mut known) = self.reason.lock() {
            known.get_or_insert_with(reason);
        }
        f64::NEG_INFINITY
    }
}

impl Likelihood for ModelLikelihood<'_> {
    type Error = MotesError;

    fn dimension(&self) -> usize {
        self.free.len()
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, MotesError> {
        self.at(&self.free.at(v), estimator, seed)
    }
}
