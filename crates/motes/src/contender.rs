//! What proposals are held against each other as.

use std::fmt;

use motes_inference::EstimatorCost;
use motes_models::Step;

use crate::cost::{cost, on_line_cost};
use crate::model::Model;
use crate::options::ProposalName;

/// A proposal as it is held against others: in a filter that takes in one measurement after another, or in one that knows the whole sequence before it starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Contender {
    name: String,
    proposal: ProposalName,
    looks_ahead: bool,
}

impl Contender {
    /// A filter that takes in one measurement after another.
    pub(crate) fn on_line(proposal: ProposalName) -> Self {
        Contender { name: proposal.to_string(), proposal, looks_ahead: false }
    }

    /// A filter that knows the whole sequence.
    pub(crate) fn ahead(proposal: ProposalName) -> Self {
        let name = match &proposal {
            ProposalName::LookAhead => proposal.to_string(),
            other => format!("{other}, ahead"),
        };
        Contender { name, proposal, looks_ahead: true }
    }

    /// The same by another name.
    pub(crate) fn called(self, name: &str) -> Self {
        Contender { name: name.to_string(), ..self }
    }

    /// What these proposals are compared as, in the same order: a learned one that has potentials of whole sequences, and hands them out, is there twice.
    pub(crate) fn of(proposals: &[ProposalName]) -> Vec<Self> {
        let of_one = |proposal: &ProposalName| match proposal {
            ProposalName::LookAhead => vec![Contender::ahead(proposal.clone())],
            ProposalName::Learned(learned) if learned.has_potentials() && !learned.hands_out_look_ahead() => {
                vec![Contender::on_line(proposal.clone()), Contender::ahead(proposal.clone())]
            }
            other => vec![Contender::on_line(other.clone())],
        };
        proposals.iter().flat_map(of_one).collect()
    }

    /// What it is called: the name of the proposal, with `, ahead` behind that of a learned one that knows the whole sequence.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What particles are drawn from.
    pub fn proposal(&self) -> &ProposalName {
        &self.proposal
    }

    /// Whether it knows the whole sequence before it starts.
    pub fn looks_ahead(&self) -> bool {
        self.looks_ahead
    }

    /// Whether something was learned for it.
    pub fn is_learned(&self) -> bool {
        matches!(self.proposal, ProposalName::Learned(_))
    }

    /// The designed proposal that it filters by, where that is what a learned folder hands out.
    pub fn designed_filter(&self) -> Option<&str> {
        match &self.proposal {
            ProposalName::Learned(learned) if !self.looks_ahead => learned.designed_filter(),
            _ => None,
        }
    }

    /// What it costs at a time step like this one.
    pub(crate) fn cost(&self, model: &Model, step: &Step<'_>) -> EstimatorCost {
        match self.looks_ahead {
            true => cost(&self.proposal, model, step),
            false => on_line_cost(&self.proposal, model, step),
        }
    }
}

impl fmt::Display for Contender {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(&self.name)
    }
}
