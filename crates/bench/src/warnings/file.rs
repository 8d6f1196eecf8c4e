//! What the study's file says.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::exact::Exact;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Study {
    pub(super) profile: BTreeMap<String, Profile>,
    pub(super) model: Vec<StudyModel>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Profile {
    pub(super) particles: Vec<usize>,
    pub(super) runs: usize,
    pub(super) proposals: Vec<StudyProposal>,
}

/// A proposal that filters are run with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum StudyProposal {
    Bootstrap,
    Linearised,
    /// Learned for each model by the defaults of `motes learn`.
    Learned,
}

impl StudyProposal {
    pub(super) fn name(self) -> &'static str {
        match self {
            StudyProposal::Bootstrap => "bootstrap",
            StudyProposal::Linearised => "linearised",
            StudyProposal::Learned => "learned",
        }
    }

    /// How long a step of a particle takes, in such steps of bootstrap, about: for the time that is left.
    pub(super) fn cost(self) -> f64 {
        match self {
            StudyProposal::Bootstrap => 1.0,
            StudyProposal::Linearised => 2.5,
            StudyProposal::Learned => 15.0,
        }
    }
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyModel {
    pub(super) name: String,
    /// The file that data are simulated from, if it is another.
    pub(super) truth: Option<String>,
    pub(super) half: String,
    pub(super) steps: usize,
    pub(super) exact: Exact,
}
