//! The log-evidence of a sequence by filters that know all of it before they start.

use std::ops::ControlFlow;

use motes_inference::map_on_threads;
use motes_models::Seed;
use motes_smc::LookAhead;

use super::options::{CompareOptions, MOST_REFERENCE_FILTERS};
use super::sequence::Sequence;
use crate::contender::Contender;
use crate::evidence::RecordedSequence;
use crate::evidence_estimate::EvidenceEstimate;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::recorded::has_look_ahead;

/// The fewest filters that are averaged.
const FEWEST_FILTERS: usize = 8;

/// The particles of each of them.
fn particles_of_each(options: &CompareOptions) -> usize {
    (2 * options.reference_particles).div_ceil(FEWEST_FILTERS)
}

/// What they are, in a part of a sentence.
pub(super) fn about_look_ahead(options: &CompareOptions) -> String {
    format!(
        "the log-evidence of the whole sequence is that of {FEWEST_FILTERS} filters or more that look ahead with {} particles, where those know it better",
        particles_of_each(options)
    )
}

/// The particles of those that are run for each sequence.
pub(super) fn particles(model: &Model, options: &CompareOptions) -> usize {
    proposals(model, options).len() * FEWEST_FILTERS * particles_of_each(options)
}

/// The proposals that look ahead: those that are compared, and `look-ahead` where the model has it.
fn proposals(model: &Model, options: &CompareOptions) -> Vec<ProposalName> {
    let learned = Contender::of(&options.proposals)
        .into_iter()
        .filter(|contender| contender.looks_ahead() && contender.is_learned())
        .map(|contender| contender.proposal().clone());
    learned.chain(has_look_ahead(model).then_some(ProposalName::LookAhead)).collect()
}

/// The surest of those estimates that are to be believed rather than `plain`; of as many filters as it takes for the standard error that is wanted, if one is. `None` where no filter looks
/// ahead, none is to be believed, or none is as sure.
pub(super) fn by_look_ahead(
    model: &Model,
    sequence: &Sequence,
    options: &CompareOptions,
    plain: &EvidenceEstimate,
    seed: &Seed,
) -> Option<EvidenceEstimate> {
    let recorded = RecordedSequence::of_steps(sequence.recorded());
    let of_one = |proposal: ProposalName| {
        // Potentials that cannot be had for this sequence are no reason to stop: there are other filters.
        let potentials = recorded.look_ahead(&proposal, model).ok()??;
        let seed = seed.child(&proposal.to_string());
        let filter = FilterOptions {
            particles: particles_of_each(options),
            defensive: None,
            check: false,
            proposal,
            ..options.filter.clone()
        };
        let found = runs(model, &recorded, &filter, &potentials, &seed, [0, FEWEST_FILTERS])?;
        Some((EvidenceEstimate::of(&found), found, filter, potentials, seed))
    };
    let tried = proposals(model, options).into_iter().filter_map(of_one);
    // One that misses mass may well be the surest.
    let believed = tried.filter(|(estimate, ..)| estimate.is_better_than(plain));
    let (mut estimate, mut found, filter, potentials, seed) =
        believed.min_by(|(a, ..), (b, ..)| a.error.total_cmp(&b.error))?;
    while estimate.is_better_than(plain) {
        if options.reference_error.is_none_or(|wanted| estimate.error <= wanted) {
            return Some(estimate);
        }
        if found.len() >= MOST_REFERENCE_FILTERS {
            return None;
        }
        let more = [found.len(), found.len() + FEWEST_FILTERS];
        found.extend(runs(model, &recorded, &filter, &potentials, &seed, more)?);
        estimate = EvidenceEstimate::of(&found);
    }
    None
}

/// `log ẑ` of the filters of these numbers.
fn runs(
    model: &Model,
    recorded: &RecordedSequence,
    filter: &FilterOptions,
    potentials: &LookAhead,
    seed: &Seed,
    [from, to]: [usize; 2],
) -> Option<Vec<f64>> {
    let numbers: Vec<usize> = (from..to).collect();
    let found = map_on_threads(&numbers, |_, number| {
        let go_on = &|| ControlFlow::Continue(());
        recorded.log_evidence(model, filter, seed.nth(*number as u64), Some(potentials), go_on).ok()
    });
    found.into_iter().collect()
}
