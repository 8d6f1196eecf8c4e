//! What a running filter is between two steps, in a form that serde writes down.

use motes_smc::{CheckSnapshot, FilterSettings, FilterSnapshot, SecondOpinion};
use serde::{Deserialize, Serialize};

/// What a filter is between two steps, and what runs beside it.
#[derive(Serialize, Deserialize)]
pub(crate) struct FilterState {
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
    pub(crate) before: f64,
}

impl RunningState {
    /// The settings of its filter.
    pub(crate) fn settings(&self) -> &FilterSettings {
        self.filter.filter.settings()
    }

    /// Whether small filters run beside it.
    pub(crate) fn is_checked(&self) -> bool {
        self.filter.check.is_some()
    }

    /// Whether the numbers of steps in it agree.
    pub(crate) fn is_of_one_time(&self) -> bool {
        self.time == self.filter.filter.time()
    }
}
