//! Which proposal is worth its particles: small filters of each on the data themselves.

use motes_inference::{LogMean, map_on_threads};
use motes_models::Seed;
use motes_smc::{Linearised, LookAhead};

use super::options::EvidenceOptions;
use super::runs::variance;
use super::sequence::{Proceed, RecordedSequence};
use crate::cost::cost;
use crate::error::MotesError;
use crate::model::{Kind, Model};
use crate::options::ProposalName;
use crate::recorded::{has_look_ahead, of_recorded};

/// Particles of a pilot.
const PARTICLES: usize = 32;

/// Filters of a pilot, whose log-evidences have a variance.
const RUNS: usize = 4;

/// Pilots whose log-evidence is nearer than this (nats), noise aside, may be as good.
const AS_GOOD: f64 = 0.1;

/// A variance of log ẑ below this is as good as none.
const LEAST_VARIANCE: f64 = 1e-6;

/// A proposal that was tried by small filters.
#[derive(Debug, Clone, PartialEq)]
pub struct Pilot {
    /// What its particles are drawn from.
    pub proposal: ProposalName,
    /// Its log-evidence of all series; −∞ where it failed.
    pub log_evidence: f64,
}

/// A proposal for a series and, where it looks ahead, its potentials.
pub(super) struct Candidate {
    pub(super) proposal: ProposalName,
    pub(super) ahead: Option<LookAhead>,
}

impl Candidate {
    /// A proposal with all that it needs to know of a series.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if it looks ahead and cannot.
    pub(super) fn of(
        proposal: ProposalName,
        model: &Model,
        sequence: &RecordedSequence,
    ) -> Result<Self, MotesError> {
        let proposal = of_recorded(proposal, model)?;
        let ahead = sequence.look_ahead(&proposal, model)?;
        Ok(Candidate { proposal, ahead })
    }

    /// The log-evidence that one filter of so many particles estimates.
    ///
    /// # Errors
    /// As a filter.
    pub(super) fn log_evidence(
        &self,
        (model, sequence): (&Model, &RecordedSequence),
        (options, particles): (&EvidenceOptions, usize),
        seed: Seed,
        proceed: Proceed<'_>,
    ) -> Result<f64, MotesError> {
        let filter = options.of_filter(self.proposal.clone(), particles);
        sequence.log_evidence(model, &filter, seed, self.ahead.as_ref(), proceed)
    }

    /// Those of so many filters, one after the other.
    ///
    /// # Errors
    /// As a filter.
    pub(super) fn log_evidences(
        &self,
        runs: usize,
        of_series: (&Model, &RecordedSequence),
        with: (&EvidenceOptions, usize),
        seed: &Seed,
        proceed: Proceed<'_>,
    ) -> Result<Vec<f64>, MotesError> {
        let run = |number: usize| self.log_evidence(of_series, with, seed.nth(number as u64), proceed);
        (0..runs).map(run).collect()
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

/// What the pilots of a candidate say of a series.
struct Trial {
    candidate: Candidate,
    log_evidence: f64,
    variance: f64,
}

/// Tries each candidate on each series, with random numbers of its own, and keeps the one whose filters are the most precise for their work among those that miss nothing: `ẑ` is too small, as a
/// rule, the more it varies, so that no candidate whose log-evidence is below another's by more than noise is taken. What fails is not taken either.
///
/// # Errors
/// [`MotesError::Interrupted`]; the error of bootstrap, if no candidate comes through.
pub(super) fn choose(
    model: &Model,
    sequences: &[RecordedSequence],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<(Vec<Candidate>, Vec<Pilot>), MotesError> {
    let names = candidates(model);
    let chosen = map_on_threads(sequences, |number, sequence| {
        let seed = seed.nth(number as u64);
        choose_for(model, sequence, &names, options, &seed, proceed)
    });
    let (mut all, mut sums) = (Vec::with_capacity(sequences.len()), vec![0.0; names.len()]);
    for of_series in chosen {
        let (candidate, found) = of_series?;
        all.push(candidate);
        sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
    }
    let pilots = names.into_iter().zip(sums);
    Ok((all, pilots.map(|(proposal, log_evidence)| Pilot { proposal, log_evidence }).collect()))
}

/// The candidate for one series, and the log-evidence of the pilots of each; −∞ where they failed.
fn choose_for(
    model: &Model,
    sequence: &RecordedSequence,
    names: &[ProposalName],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<(Candidate, Vec<f64>), MotesError> {
    let (mut tried, mut failure, mut said) = (Vec::new(), None, Vec::new());
    for proposal in names {
        let seed = seed.child(proposal.kind());
        let found = Candidate::of(proposal.clone(), model, sequence).and_then(|candidate| {
            let (of_series, with) = ((model, sequence), (options, PARTICLES));
            let logs = candidate.log_evidences(RUNS, of_series, with, &seed, proceed)?;
            let variance = variance(&logs).filter(|variance| variance.is_finite()).unwrap_or(f64::MAX);
            Ok(Trial { candidate, log_evidence: LogMean::of(&logs).log(), variance })
        });
        said.push(found.as_ref().map_or(f64::NEG_INFINITY, |trial| trial.log_evidence));
        match found {
            Ok(trial) => tried.push(trial),
            Err(MotesError::Interrupted) => return Err(MotesError::Interrupted),
            Err(error) => {
                failure.get_or_insert(error);
            }
        }
    }
    let best = tried.iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
    let (most, its_variance) = best.map_or((0.0, 0.0), |best| (best.log_evidence, best.variance));
    let is_as_good = |trial: &Trial| {
        let noise = ((trial.variance + its_variance) / RUNS as f64).sqrt();
        trial.log_evidence >= most - AS_GOOD - 2.0 * noise
    };
    let step = sequence.typical_step();
    let inefficiency = |trial: &Trial| {
        let work = cost(&trial.candidate.proposal, model, &step).of(options.particles);
        trial.variance.max(LEAST_VARIANCE) * work
    };
    let as_good = tried.into_iter().filter(is_as_good);
    let chosen = as_good.min_by(|a, b| inefficiency(a).total_cmp(&inefficiency(b)));
    let none = || MotesError::Setting("no proposal can be had for this model".into());
    chosen.map(|trial| (trial.candidate, said)).ok_or_else(|| failure.unwrap_or_else(none))
}
