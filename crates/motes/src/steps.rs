//! What a running filter can do, whatever its model and its proposal are.

use std::ops::ControlFlow;

use motes_models::{Seed, Step};
use motes_smc::{
    EvidenceWarning, FilterError, FilterHistory, Predictive, SmoothedPaths, SmoothingError, Verdict,
    WeightDiagnosis,
};

use crate::estimate::Coordinate;
use crate::running_state::FilterState;

/// A filter with the types of its model and proposal put aside. What has an answer here is that of an exact filter: it has no particles, and no error.
pub(crate) trait Steps: Send + Sync {
    fn step(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError>;
    /// What is expected of the measurement that a step would take in, with quantiles at these probabilities, and where it lies in that.
    fn measurement_ahead(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Result<Vec<Predictive>, FilterError>;
    /// What would be measured now, at the end of that step.
    fn measurement(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Vec<Predictive>;
    /// What a bootstrap filter beside it says so far, if there is one.
    fn verdict(&self) -> Option<Verdict> {
        None
    }

    /// By how much the log-evidence of a bootstrap filter is larger than that of a filter that looks ahead, where that is more than noise.
    fn missed(&self) -> Option<f64> {
        None
    }

    /// By how much that one's log-evidence is larger.
    fn difference(&self) -> f64 {
        0.0
    }

    /// The standard error of the log-evidence, if there are small filters beside it and particles enough.
    fn standard_error(&self) -> Option<f64> {
        Some(0.0)
    }

    /// What the small filters beside it warn of.
    fn evidence_warnings(&self) -> Vec<EvidenceWarning> {
        vec![]
    }

    /// Each coordinate, with quantiles at these probabilities.
    fn state(&self, probabilities: &[f64]) -> Vec<Coordinate>;
    /// The particles (`K×N`) with their normalised weights (`K`), if it has any.
    fn weighted(&self) -> Option<(&[f64], &[f64])> {
        None
    }

    /// How many numbers the states of all particles are.
    fn particles(&self) -> usize {
        0
    }

    /// Whether there is much to look at after a step.
    fn is_large(&self) -> bool {
        false
    }

    fn means(&self) -> &[f64];
    fn quantiles(&self, coordinate: usize, probabilities: &[f64]) -> Vec<f64>;
    /// What its weights say, if it has particles.
    fn diagnosis(&self) -> Option<WeightDiagnosis> {
        None
    }

    /// In particles, if it has any.
    fn effective_sample_size(&self) -> Option<f64> {
        None
    }

    fn log_evidence(&self) -> f64;
    /// Keeps its particles, if it has any.
    fn record(&self, _history: &mut FilterHistory) -> Result<(), SmoothingError> {
        Ok(())
    }

    /// Draws trajectories backwards through particles.
    fn backward(
        &self,
        _history: &FilterHistory,
        _paths: usize,
        _seed: &Seed,
        _proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<SmoothedPaths, SmoothingError> {
        Err(SmoothingError::Nothing { name: "the number of particles" })
    }

    /// Why it failed, if it has.
    fn failure(&self) -> Option<&FilterError> {
        None
    }

    /// All that later steps depend on.
    fn snapshot(&self) -> FilterState;
    /// The state of one particle, and the one that it was drawn from, in the step that failed.
    fn of_particle(&self, particle: usize) -> (Option<&[f64]>, &[f64]);
}
