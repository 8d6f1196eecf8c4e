//! The designed proposals that a model has.

use crate::engine::Running;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::recorded::has_look_ahead;

/// The designed proposals of filters that a model has; `filter` says what filters with them are made with beside.
pub fn designed(model: &Model, filter: &FilterOptions) -> Vec<ProposalName> {
    let is_there = |proposal: &ProposalName| {
        let options = FilterOptions { proposal: proposal.clone(), particles: 1, ..filter.clone() };
        Running::new(model, &options, 0).is_ok()
    };
    ProposalName::DESIGNED.into_iter().filter(is_there).collect()
}

/// The same, and `look-ahead` for recorded data, where the model has it.
pub fn designed_for_recorded(model: &Model, filter: &FilterOptions) -> Vec<ProposalName> {
    let mut proposals = designed(model, filter);
    proposals.extend(has_look_ahead(model).then_some(ProposalName::LookAhead));
    proposals
}
