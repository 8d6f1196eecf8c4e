//! The designed proposals that a model has.

use crate::engine::Running;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// The designed proposals that a model has; `filter` says what filters with them are made with beside.
pub fn designed(model: &Model, filter: &FilterOptions) -> Vec<ProposalName> {
    let is_there = |proposal: &ProposalName| {
        let options = FilterOptions { proposal: proposal.clone(), particles: 1, ..filter.clone() };
        Running::new(model, &options, 0).is_ok()
    };
    ProposalName::DESIGNED.into_iter().filter(is_there).collect()
}
