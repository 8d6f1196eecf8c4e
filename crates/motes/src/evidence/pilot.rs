//! Which proposal is worth its particles: a small filter of each on the data themselves.

use motes_models::{Seed, Step};
use motes_smc::{Linearised, LookAhead};

use super::options::EvidenceOptions;
use super::sequence::{Proceed, RecordedSequence};
use crate::cost::cost;
use crate::error::MotesError;
use crate::model::{Kind, Model};
use crate::options::ProposalName;
use crate::recorded::{has_look_ahead, of_recorded};

/// Particles of a pilot.
const PARTICLES: usize = 32;

/// Pilots whose log-evidence is nearer than this (nats) are as good: the one that costs less with as many particles as are asked for is taken.
const AS_GOOD: f64 = 0.1;

/// A small filter that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Pilot {
    /// What its particles are drawn from.
    pub proposal: ProposalName,
    /// Its log-evidence of all series; −∞ where it failed.
    pub log_evidence: f64,
}

/// A proposal and, where it looks ahead, its potentials of each series; an exact one has no series.
pub(super) struct Candidate {
    pub(super) proposal: ProposalName,
    pub(super) ahead: Vec<Option<LookAhead>>,
}

impl Candidate {
    /// A proposal with all that it needs to know of the data.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if it looks ahead and cannot.
    pub(super) fn of(
        proposal: ProposalName,
        model: &Model,
        sequences: &[RecordedSequence],
    ) -> Result<Self, MotesError> {
        let proposal = of_recorded(proposal, model)?;
        let ahead = sequences
            .iter()
            .map(|sequence| sequence.look_ahead(&proposal, model))
            .collect::<Result<_, _>>()?;
        Ok(Candidate { proposal, ahead })
    }
}

/// The proposals that are tried for a model that has no exact answers.
pub(crate) fn candidates(model: &Model) -> Vec<ProposalName> {
    let mut names = vec![ProposalName::Bootstrap];
    if let Kind::Learnable(learnable) = model.kind()
        && learnable.has_gradients()
    {
        if Linearised::new(learnable).is_ok_and(|linearised| linearised.sees_measurements()) {
            names.push(ProposalName::Linearised);
        }
        if has_look_ahead(model) {
            names.push(ProposalName::LookAhead);
        }
    }
    names
}

/// Tries each candidate over all series, with random numbers of its own, and keeps the one with the largest log-evidence: `ẑ` is too small, as a rule, the more it varies. What fails is not
/// taken.
///
/// # Errors
/// [`MotesError::Interrupted`]; the error of bootstrap, if no candidate comes through.
pub(super) fn choose(
    model: &Model,
    sequences: &[RecordedSequence],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<(Candidate, Vec<Pilot>), MotesError> {
    let (mut tried, mut failure) = (Vec::new(), None);
    for proposal in candidates(model) {
        let found = Candidate::of(proposal.clone(), model, sequences).and_then(|candidate| {
            let log_evidence = of_candidate(&candidate, model, sequences, options, seed, proceed)?;
            Ok((candidate, log_evidence))
        });
        match found {
            Ok((candidate, log_evidence)) => tried.push((candidate, log_evidence)),
            Err(MotesError::Interrupted) => return Err(MotesError::Interrupted),
            Err(error) => {
                failure.get_or_insert(error);
            }
        }
    }
    let pilots = tried.iter().map(|(candidate, log_evidence)| Pilot {
        proposal: candidate.proposal.clone(),
        log_evidence: *log_evidence,
    });
    let pilots: Vec<Pilot> = pilots.collect();
    let most = pilots.iter().map(|pilot| pilot.log_evidence).fold(f64::NEG_INFINITY, f64::max);
    let as_good = tried.into_iter().filter(|(_, log_evidence)| *log_evidence >= most - AS_GOOD);
    let step = sequences.first().map_or(Step::of_index(0), RecordedSequence::typical_step);
    let work = |candidate: &Candidate| cost(&candidate.proposal, model, &step).of(options.particles);
    let chosen = as_good.min_by(|(a, _), (b, _)| work(a).total_cmp(&work(b)));
    match (chosen, failure) {
        (Some((candidate, _)), _) => Ok((candidate, pilots)),
        (None, Some(failure)) => Err(failure),
        (None, None) => Err(MotesError::Setting("no proposal can be had for this model".into())),
    }
}

/// The log-evidence of a pilot.
fn of_candidate(
    candidate: &Candidate,
    model: &Model,
    sequences: &[RecordedSequence],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<f64, MotesError> {
    let filter = options.of_filter(candidate.proposal.clone(), PARTICLES);
    let seed = seed.child(candidate.proposal.kind());
    let of_series = |(number, sequence): (usize, &RecordedSequence)| {
        let ahead = candidate.ahead.get(number).and_then(Option::as_ref);
        sequence.log_evidence(model, &filter, seed.nth(number as u64), ahead, proceed)
    };
    sequences.iter().enumerate().map(of_series).sum()
}
