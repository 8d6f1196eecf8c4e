//! One filter over one sequence, timed.

use std::ops::ControlFlow;
use std::time::Instant;

use super::card::Steps;
use super::reference::Reference;
use super::sequence::Sequence;
use crate::engine::Running;
use crate::error::MotesError;
use crate::evidence::RecordedSequence;
use crate::model::Model;
use crate::options::FilterOptions;

/// A filter that takes in one measurement after another; `estimates` says whether its estimates are of interest.
pub(super) fn run_on_line(
    model: &Model,
    sequence: &Sequence,
    reference: &Reference,
    options: &FilterOptions,
    number: usize,
    estimates: bool,
) -> Result<Steps, MotesError> {
    let mut running = Running::new(model, options, number)?;
    let mut steps = Steps::new(sequence.measurements.len());
    for (time, (of_row, measurement)) in sequence.steps.iter().zip(&sequence.measurements).enumerate() {
        let before = running.log_evidence();
        let start = Instant::now();
        let advanced = running.advance_by(of_row, measurement);
        steps.seconds += start.elapsed().as_secs_f64();
        match advanced {
            Ok(()) => {}
            Err(MotesError::Filter { .. }) => return Ok(steps.lost_at(time)),
            Err(error) => return Err(error),
        }
        steps.log_evidence += running.log_evidence() - before;
        if estimates {
            steps.add(&running, sequence, reference, time);
        }
    }
    steps.log_evidence_gap = Some(steps.log_evidence - reference.log_evidence);
    Ok(steps)
}

/// A filter that knows the whole sequence before it starts. Its time is that of potentials and particles together. Where no potentials can be had it counts as collapsed.
pub(super) fn run_ahead(
    model: &Model,
    sequence: &Sequence,
    reference: &Reference,
    options: &FilterOptions,
    number: usize,
) -> Result<Steps, MotesError> {
    let mut steps = Steps::new(sequence.measurements.len());
    let recorded = RecordedSequence::of_steps(sequence.recorded());
    let seed = Running::seed(options, number);
    let start = Instant::now();
    let found = recorded.log_evidence_alone(model, options, seed, &|| ControlFlow::Continue(()));
    steps.seconds = start.elapsed().as_secs_f64();
    match found {
        Ok(found) if found > f64::NEG_INFINITY => {
            steps.log_evidence = found;
            steps.log_evidence_gap = Some(found - reference.log_evidence);
        }
        Ok(_) | Err(MotesError::Filter { .. } | MotesError::Proposal { .. }) => {}
        Err(error) => return Err(error),
    }
    Ok(steps)
}
