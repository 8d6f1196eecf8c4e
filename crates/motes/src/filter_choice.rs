//! Which filter options ask for, and why a model does not have it.

use motes_smc::{Bootstrap, Linearised, LookAhead, MinDegeneracy};

use crate::error::MotesError;
use crate::exact::{exact_filter, not_exact, restored};
use crate::exact_system::ExactSystem;
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::own_model::draws_transitions_alone;
use crate::particles::{Start, boxed, of_another_kind};
use crate::steps::Steps;

/// The filter that the options ask for.
pub(crate) fn filter_of<'m>(
    model: &'m Model,
    options: &FilterOptions,
    start: Start,
    ahead: Option<&LookAhead>,
) -> Result<Box<dyn Steps + 'm>, MotesError> {
    let refused =
        |proposal: &str, reason: String| Err(MotesError::Proposal { proposal: proposal.to_string(), reason });
    if options.proposal == ProposalName::Exact {
        return match start {
            Start::Seed(_) => exact_filter(model).ok_or_else(|| not_exact(model)),
            Start::State(state) => restored(model, *state).ok_or_else(of_another_kind),
        };
    }
    if let Some(reason) = model.measured_exactly() {
        return refused(options.proposal.as_str(), format!("{reason}; take --proposal exact"));
    }
    if let (Kind::Learnable(learnable), Some(ahead)) = (model.kind(), ahead) {
        // Whoever the potentials are of, it is they that draw.
        let options = FilterOptions { proposal: ProposalName::LookAhead, ..options.clone() };
        return boxed(learnable, ahead.clone(), &options, start);
    }
    match (model.kind(), &options.proposal) {
        (Kind::Learnable(learnable), ProposalName::Bootstrap) => boxed(learnable, Bootstrap, options, start),
        (Kind::Learnable(learnable), ProposalName::Learned(learned)) => {
            learned.check_model(model)?;
            if learned.designed_filter().is_some() {
                let options = FilterOptions { proposal: options.proposal.of_filter()?, ..options.clone() };
                return filter_of(model, &options, start, None);
            }
            match (learned.on_line(learnable)?, learned.proposal()) {
                (Some(potentials), _) => boxed(learnable, potentials, options, start),
                (None, Some(proposal)) => boxed(learnable, proposal.clone(), options, start),
                (None, None) => refused(learned.name(), "it has neither a network for each particle nor potentials of a step".into()),
            }
        }
        (Kind::Learnable(_), ProposalName::LookAhead) => refused(
            "look-ahead",
            "it knows all data before it starts, which a filter does not; take motes evidence or motes smooth, or --proposal linearised"
                .into(),
        ),
        (Kind::LinearGaussian(_), ProposalName::LookAhead) => {
            refused("look-ahead", "kind = \"linear-gaussian\" has exact answers; take --proposal exact".into())
        }
        (Kind::Learnable(learnable), name) => {
            if let Some(reason) = draws_transitions_alone(learnable) {
                return refused(name.as_str(), format!("{reason}; take --proposal bootstrap"));
            }
            if !learnable.has_gradients() {
                let reason =
                    "the model has no derivatives; take --proposal bootstrap, or one that is learned";
                return refused(name.as_str(), reason.into());
            }
            if *name == ProposalName::Optimal {
                let reason = match model.formulas().map(|formulas| formulas.closed_form()) {
                    Some(Ok(())) => None,
                    // Of the noise, what is linear and Gaussian has one.
                    Some(Err(_)) if matches!(model.exact_system(), Some(ExactSystem::Linear(_))) => None,
                    Some(Err(reason)) => Some(reason.to_string()),
                    None => Some("nobody knows whether functions have one".into()),
                };
                if let Some(reason) = reason {
                    return refused(name.as_str(), format!("{reason}; take --proposal linearised"));
                }
            }
            // Where there is a closed form, linearising gives it.
            boxed(learnable, Linearised::new(learnable)?, options, start)
        }
        (Kind::LinearGaussian(linear), ProposalName::Bootstrap) => boxed(linear, Bootstrap, options, start),
        (Kind::LinearGaussian(linear), ProposalName::Linearised | ProposalName::Optimal) => {
            boxed(linear, MinDegeneracy::new(linear)?, options, start)
        }
        (Kind::LinearGaussian(_), ProposalName::Learned(learned)) => {
            refused(learned.name(), "it was learned for a model of formulas".into())
        }
        (_, ProposalName::Exact) => Err(not_exact(model)),
    }
}
