//! The inclusive objective: fresh simulations for each few steps, judged by the gain on others.

use std::ops::ControlFlow;
use std::sync::mpsc::sync_channel;
use std::time::Instant;

use motes_models::{ModelError, OwnModel, PartialMeasurements, Seed};
use motes_proposals::{Amortised, Times};

use super::by_rows::learn_by_rows;
use super::course::{Course, Learned};
use super::recorded::{Share, add_recorded};
use super::rows::{Supply, drawn, for_training, for_validation};
use super::settings::LearnConfig;
use crate::TrainError;

/// Of so many parts of all steps the first is learned from simulations alone.
const FIRST_BY_SIMULATIONS: usize = 4;

/// States that are drawn from the filter at each recorded time.
const DRAWS: usize = 4;

pub(super) fn learn(
    proposal: &mut Amortised,
    model: &(impl OwnModel + ?Sized),
    recorded: &[PartialMeasurements],
    config: &LearnConfig,
    seed: &Seed,
    started: Instant,
    observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Learned, TrainError> {
    let validation = drawn(proposal, model, &validation_of(config), &for_validation(seed))?;
    check(&validation)?;
    let judge = |proposal: &Amortised| -> Result<f64, TrainError> {
        let examples = &validation.examples;
        let later = proposal.gain(Times::Later, &examples.later, config.floor)?;
        let initial = proposal.gain(Times::Initial, &examples.initial, config.floor)?;
        // As they come in a sequence.
        Ok((initial + (config.horizon - 1) as f64 * later) / config.horizon as f64)
    };
    let encoder = proposal.clone();
    let mut course = Course::new(config, started, proposal, judge(proposal)?);
    let (mut lost, mut sequences) = (validation.lost, validation.sequences);
    let training = seed.child("training");
    std::thread::scope(|scope| -> Result<(), TrainError> {
        // One supply is used while the next is simulated; it is over when nobody takes supplies any more.
        let (sender, supplies) = sync_channel::<Result<Supply, ModelError>>(1);
        let simulations = for_training(seed);
        scope.spawn(move || {
            (0_u64..)
                .take_while(|&n| sender.send(drawn(&encoder, model, config, &simulations.nth(n))).is_ok())
                .count()
        });
        let mut turn = 0;
        let next = |step: usize, averaged: &Amortised| {
            let Ok(supply) = supplies.recv() else { return Ok(None) };
            let supply = supply?;
            check(&supply)?;
            lost += supply.lost;
            sequences += supply.sequences;
            let mut examples = supply.examples;
            if let Some(measurements) = recorded.get(turn % recorded.len().max(1)) {
                // Of simulations alone at first: what a poor filter says is no good example.
                if step >= config.steps / FIRST_BY_SIMULATIONS {
                    let seed = training.child("recorded").nth(turn as u64);
                    let share = Share { draws: DRAWS, times: measurements.len() };
                    add_recorded(averaged, model, measurements, share, &seed, &mut examples)?;
                }
                turn += 1;
            }
            Ok(Some(examples))
        };
        learn_by_rows(proposal, &mut course, config, &training, next, judge, observe)
    })?;
    let mut learned = course.finish(proposal, judge)?;
    learned.overflowed = lost as f64 / sequences as f64;
    Ok(learned)
}

/// Refuses a supply from which nothing can be learned.
fn check(supply: &Supply) -> Result<(), TrainError> {
    match supply.examples.later.is_empty() {
        true => Err(TrainError::Setting {
            name: "the number of drawn sequences that reach a second time",
            value: "0".into(),
            expected: "at least 1: the model's simulation overflows, look at its transition and noise",
        }),
        false => Ok(()),
    }
}

/// Validation takes a quarter of the sequences of a supply.
fn validation_of(config: &LearnConfig) -> LearnConfig {
    LearnConfig { sequences: (config.sequences / 4).max(1), ..*config }
}
