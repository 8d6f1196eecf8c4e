//! The likelihood of data as a function of a model's free parameters.

use std::ops::ControlFlow;
use std::sync::Mutex;

use motes_inference::{Estimator, EstimatorCost, Likelihood};
use motes_models::Seed;
use rand::Rng;

use super::free::FreeParameters;
use super::options::FitOptions;
use crate::comparing::designed;
use crate::data::Data;
use crate::error::MotesError;
use crate::evidence::log_evidence;
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

/// The work of a particle beside that of a bootstrap filter.
fn cost(proposal: &ProposalName) -> EstimatorCost {
    let per_particle = match proposal {
        ProposalName::Bootstrap | ProposalName::Exact => 1.0,
        ProposalName::Optimal => 2.0,
        ProposalName::Linearised => 3.0,
        ProposalName::Learned(_) => 10.0,
    };
    EstimatorCost { per_particle, is_exact: *proposal == ProposalName::Exact }
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
            None if model.linear_system().is_some() => vec![ProposalName::Exact],
            None => designed(model, &FilterOptions::default()),
        };
        let costs = proposals.iter().map(cost).collect();
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
        let options = FilterOptions {
            proposal: self.proposal(estimator).clone(),
            particles: estimator.particles,
            seed: seed.stream().next_u64(),
            check: false,
            ..FilterOptions::default()
        };
        match log_evidence(&model, self.data, &options, |_| (self.proceed)()) {
            Ok(found) if found.value.is_finite() => Ok(found.value),
            Ok(found) => Ok(self.impossible(|| {
                found.impossible.map_or("the log-evidence is no number".into(), |warning| warning.to_string())
            })),
            Err(MotesError::Interrupted) => Err(MotesError::Interrupted),
            Err(error) => Ok(self.impossible(|| error.to_string())),
        }
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
