//! A second opinion on the evidence of a series: one filter of each other proposal.
//!
//! `ẑ` is unbiased and positive, so that it is above the evidence by `c` nats with a probability of at most `e^{−c}`, while it may be below by any amount as long as no particle goes where
//! the mass is. All runs of one proposal can miss the same, and then agree. Hence only a *higher* log-evidence of another proposal counts.

use motes_inference::map_on_threads;
use motes_models::Seed;

use super::options::EvidenceOptions;
use super::pilot::{Candidate, candidates};
use super::runs::mean_of_runs;
use super::sequence::{Proceed, RecordedSequence};
use crate::error::MotesError;
use crate::missed_mass::{MISSED, noise, noise_of};
use crate::model::Model;
use crate::options::ProposalName;

/// How much higher one run of another proposal must be (nats), beside noise, for it to be run as often.
const MARGIN: f64 = 0.3;

/// How many times as many runs confirm that a little more is found.
const CONFIRMING: usize = 4;

/// What another proposal has found of a series.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SecondOpinion {
    pub(super) proposal: ProposalName,
    /// `log ẑ` of as many runs as there were, which are not those that it was found by.
    pub(super) logs: Vec<f64>,
    /// How much more log-evidence is found, by all runs that confirm it.
    pub(super) nats: f64,
}

/// The proposal whose runs find more evidence than `logs` of `own`, if there is one.
///
/// # Errors
/// [`MotesError::Interrupted`]. What cannot be run has no opinion.
pub(super) fn second_opinion(
    own: &ProposalName,
    logs: &[f64],
    (model, sequence): (&Model, &RecordedSequence),
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<Option<SecondOpinion>, MotesError> {
    let (log, error) = mean_of_runs(logs);
    let enough = log + MARGIN + noise(error);
    let mut best: Option<(f64, Candidate)> = None;
    for proposal in candidates(model).into_iter().filter(|name| name != own) {
        let seed = seed.child(proposal.kind());
        let found = Candidate::of(proposal, model, sequence).and_then(|candidate| {
            let log =
                candidate.log_evidence((model, sequence), (options, options.particles), seed, proceed)?;
            Ok((log, candidate))
        });
        match found {
            Ok((log, candidate)) if log > best.as_ref().map_or(enough, |(most, _)| *most) => {
                best = Some((log, candidate));
            }
            Err(MotesError::Interrupted) => return Err(MotesError::Interrupted),
            _ => {}
        }
    }
    let Some((_, candidate)) = best else { return Ok(None) };
    let (of_series, with) = ((model, sequence), (options, options.particles));
    let runs = |count, name| candidate.log_evidences(count, of_series, with, &seed.child(name), proceed);
    let higher = |found: &[f64]| {
        let (found, its_error) = mean_of_runs(found);
        let of_both = error.zip(its_error).map(|(error, other)| error.hypot(other));
        let nats = found - log;
        (nats > of_both.map_or(MISSED, noise_of)).then_some(nats)
    };
    let again = runs(logs.len(), "runs")?;
    let Some(nats) = higher(&again) else { return Ok(None) };
    let confirmed = if nats > MISSED {
        Some((again, nats))
    } else {
        // A few runs know their own error badly.
        let more = runs(CONFIRMING * logs.len(), "more runs")?;
        higher(&more).map(|nats| (more[..logs.len()].to_vec(), nats))
    };
    Ok(confirmed.map(|(logs, nats)| SecondOpinion { proposal: candidate.proposal, logs, nats }))
}

/// Particles and runs of the filters of [`missed`].
const OF_FIT: (usize, usize) = (1000, 4);

/// The proposal that finds more of some series than the one that all are filtered by, and how much more (nats); that of the series where it is most. None where nothing is missed.
///
/// # Errors
/// [`MotesError::Interrupted`]. What cannot be run has no opinion, and nothing is said of it.
pub(crate) fn missed(
    proposal: &ProposalName,
    model: &Model,
    sequences: &[RecordedSequence],
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<Option<(ProposalName, f64)>, MotesError> {
    if *proposal == ProposalName::Exact {
        return Ok(None);
    }
    let (particles, runs) = OF_FIT;
    let options = EvidenceOptions { particles, ..EvidenceOptions::default() };
    let of_series = map_on_threads(sequences, |number, sequence| {
        let (of_series, seed) = ((model, sequence), seed.nth(number as u64));
        let own = Candidate::of(proposal.clone(), model, sequence).and_then(|candidate| {
            candidate.log_evidences(runs, of_series, (&options, particles), &seed, proceed)
        });
        let logs = match own {
            Ok(logs) => logs,
            Err(MotesError::Interrupted) => return Err(MotesError::Interrupted),
            Err(_) => return Ok(None),
        };
        let opinion =
            second_opinion(proposal, &logs, of_series, &options, &seed.child("second opinion"), proceed)?;
        Ok(opinion.map(|opinion| (opinion.proposal, opinion.nats)))
    });
    let found = of_series.into_iter().collect::<Result<Vec<_>, MotesError>>()?;
    Ok(found.into_iter().flatten().max_by(|(_, a), (_, b)| a.total_cmp(b)))
}
