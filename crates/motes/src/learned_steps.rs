//! Steps that a learned proposal was not learned for.

use motes_proposals::Family;

use crate::data::Data;
use crate::filter_source::FilterSource;
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::warning::Warning;

/// What is to be said where some steps of the data have another number of sub-steps than those that the noise of was learned to propose.
pub(crate) fn of_sub_steps(model: &Model, data: &Data, options: &FilterOptions) -> Option<Warning> {
    let ProposalName::Learned(learned) = &options.proposal else { return None };
    let Kind::Learnable(learnable) = model.kind() else { return None };
    if learnable.density().is_some() || *learned.filters() != FilterSource::Network {
        return None;
    }
    let own = learned.proposal()?.config().sub_steps;
    let steps = data.rows.iter().flat_map(|row| &row.steps).map(|step| step.step());
    let counts: Vec<usize> =
        steps.filter(|step| step.index > 0 && step.sub_steps > 0).map(|step| step.sub_steps).collect();
    let others = counts.iter().filter(|count| **count != own).count();
    let word = if own == 1 { "sub-step" } else { "sub-steps" };
    let text = format!(
        "--proposal {} was learned for steps of {own} {word}, and {others} of {} have another number: there particles come from the transition",
        learned.name(),
        counts.len()
    );
    (others > 0).then_some(Warning { series: None, text })
}
