//! What a running filter is between two steps, in a form that serde writes down.

use motes_smc::{CheckSnapshot, FilterSettings, FilterSnapshot, SecondOpinion};
use serde::{Deserialize, Serialize};

use crate::timeline::Clock;

/// What a filter is between two steps.
#[derive(Serialize, Deserialize)]
pub(crate) enum FilterState {
    /// One of particles.
    Particles(Box<ParticleState>),
    /// A Kalman filter.
    Exact(ExactState),
    /// One of the probabilities of few states.
    Forward(ForwardState),
}

/// A filter of probabilities between two steps.
#[derive(Serialize, Deserialize)]
pub(crate) struct ForwardState {
    pub(crate) time: usize,
    pub(crate) log_evidence: f64,
    /// The states (`K×N`) and their probabilities (`K`), from the first step on.
    pub(crate) belief: Option<(Vec<f64>, Vec<f64>)>,
}

/// A Kalman filter between two steps.
#[derive(Serialize, Deserialize)]
pub(crate) struct ExactState {
    pub(crate) time: usize,
    pub(crate) log_evidence: f64,
    /// The mean (`N`) and the covariance (`N×N`), from the first step on.
    pub(crate) belief: Option<(Vec<f64>, Vec<f64>)>,
}

/// A filter of particles between two steps, and what runs beside it.
#[derive(Serialize, Deserialize)]
pub(crate) struct ParticleState {
    pub(crate) filter: FilterSnapshot<()>,
    pub(crate) check: Option<CheckSnapshot<()>>,
    pub(crate) second: Option<SecondState>,
}

/// The same of a bootstrap filter beside another, with its opinion.
#[derive(Serialize, Deserialize)]
pub(crate) struct SecondState {
    pub(crate) bootstrap: FilterSnapshot<()>,
    pub(crate) opinion: SecondOpinion,
}

/// What a [`Running`](crate::Running) is between two steps, but for its model and its proposal.
#[derive(Serialize, Deserialize)]
pub(crate) struct RunningState {
    pub(crate) filter: FilterState,
    pub(crate) time: usize,
    pub(crate) has_passed: bool,
    pub(crate) before: f64,
    pub(crate) clock: Clock,
}

impl RunningState {
    /// The settings of its filter, if it has particles.
    pub(crate) fn settings(&self) -> Option<&FilterSettings> {
        match &self.filter {
            FilterState::Particles(state) => Some(state.filter.settings()),
            FilterState::Exact(_) | FilterState::Forward(_) => None,
        }
    }

    /// Whether small filters run beside it, if it has particles.
    pub(crate) fn is_checked(&self) -> Option<bool> {
        match &self.filter {
            FilterState::Particles(state) => Some(state.check.is_some()),
            FilterState::Exact(_) | FilterState::Forward(_) => None,
        }
    }

    /// Whether the numbers of steps in it agree.
    pub(crate) fn is_of_one_time(&self) -> bool {
        self.time
            == match &self.filter {
                FilterState::Particles(state) => state.filter.time(),
                FilterState::Exact(state) => state.time,
                FilterState::Forward(state) => state.time,
            }
    }
}
