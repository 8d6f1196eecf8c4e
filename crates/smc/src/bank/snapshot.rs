//! What a bank is between two steps, to be written down and gone on from.

use std::ops::Deref;

use motes_models::{StateSpaceModel, StepRecord, StreamPosition, check_model};
use serde::{Deserialize, Serialize};

use super::filter_bank::FilterBank;
use super::filters::{Fault, Outcome};
use super::scratches::Scratches;
use super::settings::FilterSettings;
use super::stored_failure::StoredFailure;
use crate::error::FilterError;
use crate::memory::ParticleMemory;
use crate::proposal::Proposal;
use crate::weights::{LogWeights, WeightFault};

/// What a [`FilterBank`] is between two steps, but for its model and its proposal: all that its later steps depend on.
///
/// It is written and read by any format of serde that has all numbers of 64 bits, −∞ and NaN too; JSON has not. What is read is checked by
/// [`FilterBank::restore`], not before.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BankSnapshot<Memory> {
    settings: FilterSettings,
    streams: Vec<StreamPosition>,
    time: usize,
    last: StepRecord,
    states: Vec<f64>,
    previous: Vec<f64>,
    memory: Memory,
    weights: Vec<LogWeights>,
    log_evidence: Vec<f64>,
    ancestors: Vec<usize>,
    resampled: Vec<bool>,
    /// What the log-evidence of each filter grew by in the last step; none where the filter failed in it.
    increments: Vec<Option<f64>>,
    failure: Option<StoredFailure>,
    keeps_collapsed: bool,
}

impl<Memory> BankSnapshot<Memory> {
    /// The settings of the filters.
    pub fn settings(&self) -> &FilterSettings {
        &self.settings
    }

    /// How many steps had been taken.
    pub fn time(&self) -> usize {
        self.time
    }
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target, Memory: Clone>> FilterBank<D, P> {
    /// What the bank is now, to be written down. It changes nothing.
    pub fn snapshot(&self) -> BankSnapshot<P::Memory> {
        let increment = |outcome: &Outcome| outcome.increment.as_ref().ok().copied();
        BankSnapshot {
            settings: self.settings,
            streams: self.streams.iter().map(StreamPosition::of).collect(),
            time: self.time,
            last: self.last.clone(),
            states: self.states.clone(),
            previous: self.previous.clone(),
            memory: self.memory.clone(),
            weights: self.weights.clone(),
            log_evidence: self.log_evidence.clone(),
            ancestors: self.ancestors.clone(),
            resampled: self.resampled.clone(),
            increments: self.outcomes.iter().map(increment).collect(),
            failure: self.failure.as_ref().map(StoredFailure::of),
            keeps_collapsed: self.keeps_collapsed,
        }
    }
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> FilterBank<D, P> {
    /// The bank that a snapshot was taken of, with the model and the proposal that it had: to the last bit it goes on as that one would have.
    ///
    /// A bank that had failed has failed: its steps return the same error, or [`FilterError::Earlier`] with its words.
    ///
    /// # Errors
    /// [`FilterError::Setting`] for a snapshot that is none of such a bank: its parts do not have the sizes that its settings and the model ask for, or
    /// hold what no filter can go on from.
    pub fn restore(model: D, proposal: P, snapshot: BankSnapshot<P::Memory>) -> Result<Self, FilterError> {
        check_model(&*model)?;
        let settings = snapshot.settings;
        let (filters, per_particle) = (snapshot.streams.len(), proposal.memory_per_particle());
        let (rows, values) = settings.check_bank(filters, model.state_dim(), per_particle)?;
        snapshot.check(rows, values)?;
        if !snapshot.memory.is_laid_out_as(&proposal.initial_memory(rows)) {
            return Err(unfit("the memory of particles", "another"));
        }
        let outcome = |increment: Option<f64>| Outcome {
            ess_before: 0.0,
            increment: increment.ok_or(Fault::Weights(WeightFault::AllZero)),
        };
        Ok(FilterBank {
            model,
            proposal,
            settings,
            streams: snapshot.streams.iter().map(StreamPosition::stream).collect(),
            time: snapshot.time,
            last: snapshot.last,
            states: snapshot.states,
            previous: snapshot.previous,
            memory: snapshot.memory,
            weights: snapshot.weights,
            log_evidence: snapshot.log_evidence,
            ancestors: snapshot.ancestors,
            resampled: snapshot.resampled,
            outcomes: snapshot.increments.into_iter().map(outcome).collect(),
            scratches: Scratches::default(),
            failure: snapshot.failure.map(FilterError::from),
            keeps_collapsed: snapshot.keeps_collapsed,
            entries: Vec::new(),
            whole: Vec::new(),
        })
    }
}

impl<Memory> BankSnapshot<Memory> {
    /// Whether its parts fit each other, for a bank of so many particles with so many coordinates together.
    fn check(&self, rows: usize, values: usize) -> Result<(), FilterError> {
        let (filters, k) = (self.streams.len(), self.settings.particles);
        let sizes = [
            ("the number of states", self.states.len(), values),
            ("the number of states before", self.previous.len(), values),
            ("the number of ancestors", self.ancestors.len(), rows),
            ("the number of sets of weights", self.weights.len(), filters),
            ("the number of log-evidences", self.log_evidence.len(), filters),
            ("the number of filters that say whether they resampled", self.resampled.len(), filters),
            ("the number of last increments", self.increments.len(), filters),
        ];
        if let Some((name, found, _)) = sizes.into_iter().find(|(_, found, expected)| found != expected) {
            return Err(unfit(name, &found.to_string()));
        }
        if let Some(weights) = self.weights.iter().find(|weights| weights.len() != k) {
            return Err(unfit("the number of weights", &weights.len().to_string()));
        }
        let of_filter = |(row, ancestor): (usize, &usize)| row / k == ancestor / k;
        if let Some(ancestor) = self.ancestors.iter().enumerate().find(|pair| !of_filter(*pair)) {
            return Err(unfit("an ancestor", &ancestor.1.to_string()));
        }
        // What those of a filter that failed are nobody asks.
        let has_failed = self.failure.is_some();
        if !has_failed && !self.weights.iter().all(LogWeights::can_be_gone_on_from) {
            return Err(unfit("a set of weights", "none that sums to 1"));
        }
        let is_within = |failure: &StoredFailure| failure.is_within(filters, k, values / rows);
        if !self.failure.iter().all(is_within) {
            return Err(unfit("the particle of a failure", "none of the bank's"));
        }
        let last = self.last.step().index;
        if self.time > 0 && last.checked_add(usize::from(!has_failed)) != Some(self.time) {
            return Err(unfit("the last step", &last.to_string()));
        }
        // So that the next steps can be counted.
        if self.time > usize::MAX / 2 {
            return Err(unfit("the number of steps", &self.time.to_string()));
        }
        Ok(())
    }
}

/// A part of a snapshot that does not fit.
fn unfit(name: &'static str, value: &str) -> FilterError {
    let expected = "what the settings of the filters and the model ask for";
    FilterError::Setting { name, value: format!("{value} in the snapshot"), expected }
}
