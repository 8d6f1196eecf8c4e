//! How far the log-evidence of recorded sequences is off with each of some proposals, on sequences that the model drew.

use motes_models::Seed;
use motes_smc::RecordedStep;
use serde::{Deserialize, Serialize};

use super::options::EvidenceOptions;
use super::pilot::{Candidate, cost, fixed_cost};
use super::sequence::{Proceed, Sequence};
use crate::error::MotesError;
use crate::model::Model;
use crate::options::ProposalName;

/// Particles of each run, and runs of each sequence.
const PARTICLES: usize = 100;
const RUNS: usize = 8;

/// The error of a run whose particles all died, in nats; no larger one counts.
const LARGEST: f64 = 1e4;

/// How well a proposal estimates the log-evidence of recorded sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvidenceWorth {
    /// The proposal.
    pub proposal: String,
    /// The root-mean-square error of `log ẑ` with 100 particles, in nats: against the mean of all runs of all proposals, which is dominated by the best.
    pub error: f64,
    /// The work of a time step, in particles of a bootstrap filter.
    pub work: f64,
}

impl EvidenceWorth {
    /// Squared error times work: what is the same for any number of particles, where errors are small.
    pub fn inefficiency(&self) -> f64 {
        self.error * self.error * self.work
    }
}

/// The worth of each proposal on these sequences; one that fails on a sequence has the largest error there.
///
/// # Errors
/// [`MotesError::Interrupted`].
pub(crate) fn judged(
    model: &Model,
    proposals: &[ProposalName],
    sequences: Vec<Vec<RecordedStep>>,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<Vec<EvidenceWorth>, MotesError> {
    let options = EvidenceOptions::default();
    let mut squares = vec![0.0; proposals.len()];
    let count = (sequences.len() * RUNS) as f64;
    for (number, steps) in sequences.into_iter().enumerate() {
        let sequence = [Sequence::of_steps(steps)];
        let seed = seed.nth(number as u64);
        let mut logs: Vec<Vec<f64>> = Vec::with_capacity(proposals.len());
        for proposal in proposals {
            logs.push(match runs(proposal, model, &sequence, &options, &seed, proceed) {
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
    let of_one = |(proposal, square): (&ProposalName, f64)| EvidenceWorth {
        proposal: proposal.to_string(),
        error: (square / count).sqrt(),
        work: fixed_cost(proposal, model) + cost(proposal) * PARTICLES as f64,
    };
    Ok(proposals.iter().zip(squares).map(of_one).collect())
}

fn runs(
    proposal: &ProposalName,
    model: &Model,
    sequence: &[Sequence; 1],
    options: &EvidenceOptions,
    seed: &Seed,
    proceed: Proceed<'_>,
) -> Result<Vec<f64>, MotesError> {
    let candidate = Candidate::of(proposal.clone(), model, sequence)?;
    let filter = options.of_filter(proposal.clone(), PARTICLES);
    let seed = seed.child(proposal.kind());
    let run = |run: u64| {
        sequence[0].log_evidence(model, &filter, seed.nth(run), candidate.ahead[0].as_ref(), proceed)
    };
    (0..RUNS as u64).map(run).collect()
}
