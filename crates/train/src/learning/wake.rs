//! The wake objective: rows of a running filter on recorded series, judged by the evidence of what is held out.

use std::ops::ControlFlow;
use std::time::Instant;

use motes_models::{OwnModel, Seed};
use motes_proposals::{Amortised, Examples};

use super::by_rows::learn_by_rows;
use super::course::{Course, Learned};
use super::held_out::HeldOut;
use super::recorded::{Share, add_recorded};
use super::settings::LearnConfig;
use crate::TrainError;

/// States that are drawn from the filter at each time: a filter costs more than the gradient of so many.
const DRAWS: usize = 32;

pub(super) fn learn(
    proposal: &mut Amortised,
    model: &(impl OwnModel + ?Sized),
    held_out: &HeldOut<'_>,
    config: &LearnConfig,
    seed: &Seed,
    started: Instant,
    observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Learned, TrainError> {
    let (validation, training) = (seed.child("validation"), seed.child("training"));
    let judge = |proposal: &Amortised| held_out.log_evidence(proposal, model, &validation);
    let mut course = Course::new(config, started, proposal, judge(proposal)?);
    let mut turn = 0_usize;
    let next = |_: usize, averaged: &Amortised| {
        let mut examples = Examples::default();
        // As many series as a step has rows for; the whole round if they are short.
        for _ in &held_out.learned {
            let (series, times) = held_out.learned[turn % held_out.learned.len()];
            let seed = training.child("recorded").nth(turn as u64);
            add_recorded(averaged, model, series, Share { draws: DRAWS, times }, &seed, &mut examples)?;
            turn += 1;
            if examples.later.len() >= config.rows {
                break;
            }
        }
        match examples.later.is_empty() {
            true => Err(TrainError::Recorded {
                reason: "no filter reaches a second time with a whole measurement".into(),
            }),
            false => Ok(Some(examples)),
        }
    };
    learn_by_rows(proposal, &mut course, config, &training, next, judge, observe)?;
    course.finish(proposal, judge)
}
