//! The loop of objectives that learn from rows: a batch, a step, now and then a look at validation.

use std::ops::ControlFlow;

use motes_models::Seed;
use motes_proposals::{Amortised, Examples, Stage, Times};

use super::course::Course;
use super::rows::Deck;
use super::settings::LearnConfig;
use super::step::Stepper;
use crate::TrainError;

/// How many steps of the network for later times come to one of that for `t = 0`.
const STEPS_FOR_ONE_INITIAL: usize = 4;

/// A batch is lost whose mean gain is below so much of that of a row at the floor.
const LOST: f64 = 0.5;

/// Takes the steps of `course`, with rows from `supply`, which is shown the step and the averaged weights; none ends learning.
pub(super) fn learn_by_rows(
    proposal: &mut Amortised,
    course: &mut Course,
    config: &LearnConfig,
    training: &Seed,
    mut supply: impl FnMut(usize, &Amortised) -> Result<Option<Examples>, TrainError>,
    judge: impl Fn(&Amortised) -> Result<f64, TrainError>,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<(), TrainError> {
    let mut stepper = Stepper::new(config, proposal, training)?;
    let mut order = training.child("order").stream();
    let (mut initial, mut later) = (Deck::default(), Deck::default());
    let mut batch = Stage::default();
    // Of the last batch of the network for `t = 0`, which not every step has.
    let mut gain_of_initial = 0.0;
    for step in 0..config.steps {
        let Some(progress) = course.progress(step) else { break };
        stepper.set_progress(progress);
        let mut rows = config.rows;
        while !later.deal(rows, &mut batch) {
            let found = match supply(step, course.averaged()) {
                // What filtered at first has become a proposal whose filters collapse.
                Err(TrainError::Recorded { .. }) if step > 0 => {
                    course.diverged(step);
                    return Ok(());
                }
                found => found?,
            };
            let Some(examples) = found else { break };
            // A supply that overflows early has few rows.
            rows = rows.min(examples.later.len());
            later = Deck::new(examples.later, &mut order);
            initial = Deck::new(examples.initial, &mut order);
        }
        let mut update = |proposal: &mut Amortised, times: Times, batch: &Stage| {
            stepper.begin(proposal);
            stepper.finish(proposal, |proposal, memory| {
                Ok(proposal.differentiate_gain(times, batch, config.floor, memory)?)
            })
        };
        let of_later = update(proposal, Times::Later, &batch)?;
        let mut of_initial = Some(gain_of_initial);
        if step % STEPS_FOR_ONE_INITIAL == 0
            && initial.deal(config.rows.min(initial.left()), &mut batch)
            && !batch.is_empty()
        {
            of_initial = update(proposal, Times::Initial, &batch)?;
        }
        let (Some(gain_of_later), Some(gain)) = (of_later, of_initial) else {
            course.diverged(step);
            break;
        };
        gain_of_initial = gain;
        let is_judged = course.took(step, proposal, &judge)?;
        if is_judged && is_lost(gain_of_later.min(gain_of_initial), config.floor) {
            course.go_back(proposal);
            stepper.begin_again()?;
            gain_of_initial = 0.0;
        }
        if observe(step, course.last()).is_break() {
            break;
        }
    }
    Ok(())
}

/// Whether most rows of a batch lie so far from the proposal that the floor is all of what the objective sees of them. It has no slope there.
///
/// Steps that are too long lead there, at once where there are many coordinates: each of their densities has its part in the loss of a row.
fn is_lost(gain: f64, floor: f64) -> bool {
    gain < LOST * floor.ln()
}
