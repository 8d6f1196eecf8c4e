//! How far the log-evidence of recorded sequences is off with each of some proposals, on sequences that the model drew.

use motes_models::Seed;
use motes_smc::RecordedStep;

use super::options::EvidenceOptions;
use super::pilot::Candidate;
use super::sequence::{Proceed, Sequence};
use super::worth::EvidenceWorth;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::ProposalName;

/// Particles of each run, and runs of each sequence.
const PARTICLES: usize = 100;
const RUNS: usize = 8;

/// The error of a run whose particles all died, in nats; no larger one counts.
const LARGEST: f64 = 1e4;

/// What is judged.
pub(crate) struct Contender {
    /// What it is called.
    pub(crate) name: String,
    pub(crate) proposal: ProposalName,
    /// Whether it knows the whole sequence, if it can; else it filters.
    pub(crate) looks_ahead: bool,
    /// The work of a time step whatever the number of particles, and that of a particle.
    pub(crate) work: [f64; 2],
}

/// The worth of each contender on these sequences; one that fails on a sequence has the largest error there.
///
/// # Errors
/// [`MotesError::Interrupted`].
pub(crate) fn judged(
    model: &Model,
    contenders: &[Contender],
    sequences: Vec<Vec<RecordedStep>>,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<Vec<EvidenceWorth>, MotesError> {
    let options = EvidenceOptions::default();
    let mut squares = vec![0.0; contenders.len()];
    let count = (sequences.len() * RUNS) as f64;
    for (number, steps) in sequences.into_iter().enumerate() {
        let sequence = [Sequence::of_steps(steps)];
        let seed = seed.nth(number as u64);
        let mut logs: Vec<Vec<f64>> = Vec::with_capacity(contenders.len());
        for contender in contenders {
            logs.push(match runs(contender, model, &sequence, &options, &seed, proceed) {
                Ok(found) => found,
                Err(MotesError::Interrupted) => return Err(MotesError::Interrupted),
                Err(_) => vec![f64::NEG_INFINITY; RUNS],
            });
        }
        let all = || logs.iter().flatten().copied();
        let most = all().fold(f64::NEG_INFINITY, f64::max);
        let mean = all().map(|log| (log - most).exp()).sum::<f64>() / all().count() as f64;
        let reference = most + mean.ln();
        for (square, logs) in squares.iter_mut().zip(&logs) {
            let errors = logs.iter().map(|log| (log - reference).abs().min(LARGEST));
            *square += errors.map(|error| if error.is_nan() { LARGEST } else { error }.powi(2)).sum::<f64>();
        }
    }
    let of_one = |(contender, square): (&Contender, f64)| EvidenceWorth {
        proposal: contender.name.clone(),
        error: (square / count).sqrt(),
        work: contender.work[0] + contender.work[1] * PARTICLES as f64,
    };
    Ok(contenders.iter().zip(squares).map(of_one).collect())
}

fn runs(
    Contender { name, proposal, looks_ahead, .. }: &Contender,
    model: &Model,
    sequence: &[Sequence; 1],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<Vec<f64>, MotesError> {
    let ahead = match looks_ahead {
        true => Candidate::of(proposal.clone(), model, sequence)?.ahead.pop().flatten(),
        false => None,
    };
    let filter = options.of_filter(proposal.clone(), PARTICLES);
    let seed = seed.child(name);
    let run = |run: u64| sequence[0].log_evidence(model, &filter, seed.nth(run), ahead.as_ref(), proceed);
    (0..RUNS as u64).map(run).collect()
}
