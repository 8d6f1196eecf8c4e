//! What evidence and means are held against.

use serde::{Deserialize, Serialize};

use crate::evidence_estimate::EvidenceEstimate;

/// The answers for one sequence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Reference {
    pub(super) name: String,
    /// The mean of the state at each time.
    pub(super) means: Vec<Vec<f64>>,
    /// `log p(y_t | y_{0:t−1})` at each time.
    pub(super) increments: Vec<f64>,
    /// `log p(y_{0:T−1})`: the sum of the increments, where nothing knows it better than they.
    pub(super) log_evidence: f64,
    /// The standard error of the log-evidence, where it is an estimate of several filters.
    pub(super) error: Option<f64>,
}

impl Reference {
    /// The same with another log-evidence of the whole sequence, where there is one that is surer.
    pub(super) fn or_surer(self, surer: Option<EvidenceEstimate>) -> Self {
        match surer {
            Some(EvidenceEstimate { log_evidence, error }) => {
                Reference { log_evidence, error: Some(error), ..self }
            }
            None => self,
        }
    }
}
