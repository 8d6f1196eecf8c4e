//! Which proposal is worth its particles: a small filter of each on the data themselves.

use motes_models::Seed;
use motes_smc::{Linearised, LookAhead};

use super::options::EvidenceOptions;
use super::sequence::{Proceed, Sequence};
use crate::error::MotesError;
use crate::model::{Kind, Model};
use crate::options::ProposalName;

/// Particles of a pilot.
const PARTICLES: usize = 32;

/// Pilots whose log-evidence is nearer than this (nats) are as good: the one whose particles are cheaper is taken.
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
        sequences: &[Sequence],
    ) -> Result<Self, MotesError> {
        let proposal = match proposal {
            ProposalName::Learned(learned) if learned.hands_out_look_ahead() => {
                learned.check_model(model)?;
                ProposalName::LookAhead
            }
            proposal => proposal,
        };
        let ahead = sequences
            .iter()
            .map(|sequence| sequence.look_ahead(&proposal, model))
            .collect::<Result<_, _>>()?;
        Ok(Candidate { proposal, ahead })
    }
}

/// What a particle costs at a step, in those of a bootstrap filter: about, and the same on any machine.
pub(crate) fn cost(proposal: &ProposalName) -> f64 {
    match proposal {
        ProposalName::Exact => 0.0,
        ProposalName::Bootstrap => 1.0,
        ProposalName::Linearised | ProposalName::Optimal => 3.0,
        ProposalName::LookAhead => 4.0,
        ProposalName::Learned(learned) if learned.has_potentials() => 4.2,
        ProposalName::Learned(_) => 30.0,
    }
}

/// The work of a smoother for a time step, in particles of a bootstrap filter: at least, and for each coordinate of the state. Counted by
/// `experiments/look-ahead/smoother.py`: 355 to 502 in four models of 1 to 4 coordinates, 1233, 2096 and 4497 in Lorenz 96 with 6, 10 and 20.
const SMOOTHER: [f64; 2] = [450.0, 225.0];

/// The work of networks that emit potentials of a sequence, for each time step; counted on the growth model.
const NETWORKS: f64 = 330.0;

/// The work of a potential on-line: of its network for each time step, and of a particle.
pub(crate) const ON_LINE: [f64; 2] = [200.0, 3.2];

/// The work of a particle in counted instructions of filters that need nothing but the evidence, on the growth and Ricker models, in those of a bootstrap filter: what judgements of
/// proposals go by.
pub(crate) fn counted(proposal: &ProposalName) -> f64 {
    match proposal {
        ProposalName::Linearised | ProposalName::Optimal => 2.3,
        ProposalName::LookAhead => 1.8,
        other => cost(other),
    }
}

/// What potentials cost at a step, however few particles there are, in those of a bootstrap filter: about, and the same on any machine.
pub(crate) fn fixed_cost(proposal: &ProposalName, model: &Model) -> f64 {
    match proposal {
        ProposalName::LookAhead => SMOOTHER[0].max(SMOOTHER[1] * model.states().len() as f64),
        ProposalName::Learned(learned) if learned.has_potentials() => NETWORKS,
        _ => 0.0,
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
        if learnable.noise_space().is_some() {
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
    sequences: &[Sequence],
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
    let chosen = as_good.min_by(|(a, _), (b, _)| cost(&a.proposal).total_cmp(&cost(&b.proposal)));
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
    sequences: &[Sequence],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<f64, MotesError> {
    let filter = options.of_filter(candidate.proposal.clone(), PARTICLES);
    let seed = seed.child(candidate.proposal.kind());
    let of_series = |(number, sequence): (usize, &Sequence)| {
        let ahead = candidate.ahead.get(number).and_then(Option::as_ref);
        sequence.log_evidence(model, &filter, seed.nth(number as u64), ahead, proceed)
    };
    sequences.iter().enumerate().map(of_series).sum()
}
