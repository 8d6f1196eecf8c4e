//! Whether the evidence of data can be had exactly.

use std::ops::ControlFlow;

use super::log_evidence::log_evidence;
use crate::data::Data;
use crate::exact_system::ExactSystem;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// Whether a model has the exact evidence of data. Of one whose states are discrete it is tried: nobody knows before how many can be reached.
pub(crate) fn is_exact(model: &Model, data: &Data) -> bool {
    match model.exact_system() {
        None => false,
        Some(ExactSystem::Linear(_)) => true,
        Some(ExactSystem::Finite(_)) => {
            let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
            log_evidence(model, data, &options, |_| ControlFlow::Continue(())).is_ok()
        }
    }
}
