//! How far the log-evidence of recorded sequences is off with each of some proposals, on sequences that the model drew.

use std::ops::ControlFlow;

use motes_models::Seed;
use motes_smc::RecordedStep;

use super::options::EvidenceOptions;
use super::sequence::RecordedSequence;
use super::worth::EvidenceWorth;
use crate::contender::Contender;
use crate::error::MotesError;
use crate::evidence_estimate::EvidenceEstimate;
use crate::model::Model;

/// Particles of each run, and runs of each sequence.
const PARTICLES: usize = 100;
const RUNS: u64 = 8;

/// The error of a run whose particles all died, in nats; no larger one counts.
const LARGEST: f64 = 1e4;

/// A sequence, and the model that drew it.
pub(crate) struct JudgedSequence {
    pub(crate) model: Model,
    pub(crate) steps: Vec<RecordedStep>,
}

/// The worth of each contender on these sequences; one that fails on a sequence has the largest error there. `proceed` is asked before each contender takes each sequence.
///
/// # Errors
/// [`MotesError::Interrupted`].
pub(crate) fn judge(
    contenders: &[Contender],
    sequences: Vec<JudgedSequence>,
    seed: &Seed,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Vec<EvidenceWorth>, MotesError> {
    let mut squares = vec![0.0; contenders.len()];
    let work = |contender: &Contender| {
        let of_first = |first: &JudgedSequence| {
            let step = first.steps.get(first.steps.len() / 2)?;
            Some(contender.cost(&first.model, &step.step.step()).of(PARTICLES))
        };
        sequences.first().and_then(of_first).unwrap_or(f64::NAN)
    };
    let works: Vec<f64> = contenders.iter().map(work).collect();
    let count = sequences.len() as f64 * RUNS as f64;
    for (number, JudgedSequence { model, steps }) in sequences.into_iter().enumerate() {
        let (sequence, seed) = (RecordedSequence::of_steps(steps), seed.nth(number as u64));
        let mut logs: Vec<Vec<f64>> = Vec::with_capacity(contenders.len());
        for contender in contenders {
            if proceed().is_break() {
                return Err(MotesError::Interrupted);
            }
            let found = runs(contender, &model, &sequence, &seed);
            logs.push(found.unwrap_or_else(|_| vec![f64::NEG_INFINITY; RUNS as usize]));
        }
        let estimates: Vec<EvidenceEstimate> = logs.iter().map(|logs| EvidenceEstimate::of(logs)).collect();
        let reference =
            EvidenceEstimate::surest(&estimates).map_or(f64::NEG_INFINITY, |found| found.log_evidence);
        for (square, logs) in squares.iter_mut().zip(&logs) {
            let errors = logs.iter().map(|log| (log - reference).abs());
            let within = |error: f64| if error.is_nan() { LARGEST } else { error.min(LARGEST) };
            *square += errors.map(|error| within(error).powi(2)).sum::<f64>();
        }
    }
    let of_one = |((contender, work), square): ((&Contender, f64), f64)| EvidenceWorth {
        proposal: contender.name().to_string(),
        error: (square / count).sqrt(),
        work,
    };
    Ok(contenders.iter().zip(works).zip(squares).map(of_one).collect())
}

/// `log ẑ` of some runs on a sequence.
fn runs(
    contender: &Contender,
    model: &Model,
    sequence: &RecordedSequence,
    seed: &Seed,
) -> Result<Vec<f64>, MotesError> {
    let proposal = contender.proposal();
    let ahead = if contender.looks_ahead() { sequence.look_ahead(proposal, model)? } else { None };
    let filter = EvidenceOptions::default().of_filter(proposal.clone(), PARTICLES);
    let seed = seed.child(contender.name());
    let run = |run: u64| {
        let go_on = &|| ControlFlow::Continue(());
        sequence.log_evidence(model, &filter, seed.nth(run), ahead.as_ref(), go_on)
    };
    (0..RUNS).map(run).collect()
}
