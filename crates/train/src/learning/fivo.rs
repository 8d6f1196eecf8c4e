//! The objective fivo: the filter's own log-evidence on recorded series, by reparametrised draws.

use std::ops::ControlFlow;
use std::time::Instant;

use motes_models::{OwnModel, Seed, StateGradients};
use motes_proposals::{Amortised, Draws, Parametric, Times};

use super::course::{Course, Learned};
use super::held_out::HeldOut;
use super::settings::LearnConfig;
use super::step::Stepper;
use super::stretches::Stretches;
use crate::TrainError;
use crate::gradient_sum::GradientSum;

pub(super) fn learn<M: OwnModel + StateGradients + ?Sized>(
    proposal: &mut Amortised,
    model: &M,
    held_out: &HeldOut<'_>,
    config: &LearnConfig,
    seed: &Seed,
    started: Instant,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Learned, TrainError> {
    let (validation, training) = (seed.child("validation"), seed.child("training"));
    let judge = |proposal: &Amortised| held_out.log_evidence(proposal, model, &validation);
    let mut course = Course::new(config, started, proposal, judge(proposal)?);
    let mut stepper = Stepper::new(config, proposal, &training)?;
    let mut stretches = Stretches::new(model, &held_out.learned, config.rows, training.child("filters"));
    let mut draws = Draws::default();
    let mut sum = GradientSum::none(proposal.parameters().len(), proposal.parameters().values().len());
    for step in 0..config.steps {
        let Some(progress) = course.progress(step) else { break };
        stepper.set_progress(progress);
        // Drawn from the proposal that is differentiated, with the units that it leaves out.
        stepper.begin(proposal);
        let stretch = stretches.next(proposal, &mut draws);
        let found = stepper.finish(proposal, |proposal, mut memory| {
            let log_evidence = stretch?;
            if !draws.initial.is_empty() {
                memory = proposal.differentiate_evidence(Times::Initial, &draws.initial, memory)?;
                sum.take(&mut memory);
            }
            memory = proposal.differentiate_evidence(Times::Later, &draws.later, memory)?;
            sum.mean_into(&mut memory, 1);
            Ok((log_evidence, memory))
        });
        let value = match found {
            // What filtered at first has become a proposal whose filters collapse.
            Err(TrainError::Recorded { .. }) if step > 0 => None,
            found => found?,
        };
        if value.is_none() {
            course.diverged(step);
            break;
        }
        course.took(step, proposal, judge)?;
        if observe(step, course.last()).is_break() {
            break;
        }
    }
    course.finish(proposal, judge)
}
