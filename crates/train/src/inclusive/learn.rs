//! The loop: fresh simulations, a step, now and then a look at validation; the best weights are kept.

use std::ops::ControlFlow;
use std::sync::mpsc::sync_channel;
use std::time::Instant;

use motes_models::{ModelError, OwnModel, OwnSteps, PartialMeasurements, Seed};
use motes_proposals::{Amortised, Parametric, Stage, Times, Values, Workspace};

use super::recorded::add_recorded;
use super::rows::{Deck, Supply, drawn, for_training, for_validation};
use super::settings::LearnConfig;
use crate::{Adam, TrainError};

/// How many steps of the network for later times come to one of that for `t = 0`.
const STEPS_FOR_ONE_INITIAL: usize = 4;

/// Sequences that inputs are standardised by, and their times.
const STANDARDISING: usize = 64;

/// Of so many parts of all steps the first is learned from simulations alone.
const FIRST_BY_SIMULATIONS: usize = 4;

/// What came of learning.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// Steps that were taken.
    pub steps: usize,
    /// The gain on validation sequences, in nats for a step of a sequence, after so many steps; the first is that of the untrained proposal.
    pub validation: Vec<(usize, f64)>,
    /// After which step the weights that were kept had been reached.
    pub best_step: usize,
    /// The share of simulated sequences that overflowed before their end.
    pub overflowed: f64,
    /// Why it ended before its last step, where it diverged.
    pub diverged_at: Option<usize>,
    /// How long it took.
    pub seconds: f64,
}

impl Learned {
    /// The gain of the weights that were kept, on validation sequences.
    pub fn best_gain(&self) -> f64 {
        self.validation.iter().map(|(_, gain)| *gain).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Takes in what validation says of the present weights, which are kept if they are the best.
    fn look(&mut self, gain: f64, present: &Amortised, best: &mut (f64, Values)) {
        self.validation.push((self.steps, gain));
        if gain > best.0 {
            *best = (gain, present.parameters().values().clone());
            self.best_step = self.steps;
        }
    }
}

/// Weights are averaged over about the last step in so many (Shamir and Zhang 2013).
const AVERAGING: f64 = 8.0;

/// Learns `proposal` for `model` from steps that the model draws for itself, fresh ones in each gradient step.
///
/// It maximises `E log[(1 − α) q(x_t | x_{t−1}, y_t) + α p(x_t | x_{t−1})]`, which is the inclusive Kullback–Leibler divergence from
/// `p(x_t | x_{t−1}, y_t)` but for its sign and a constant. Validation sequences come from a seed of their own. The weights that were best on them
/// are kept. A step whose loss or gradient is not finite ends it, and the best weights so far are kept.
///
/// `recorded` measurements, any number of series of any lengths, add where a filter with the present weights says that the states were. Nobody's states are
/// seen: only measurements come in.
///
/// `observe` is shown the step and the last gain on validation sequences, and ends learning early by breaking.
///
/// The same seed gives the same weights, unless there is a budget in seconds.
///
/// # Errors
/// - [`TrainError::Setting`] or [`TrainError::Model`] for bad input, and for a model all of whose sequences overflow.
/// - [`TrainError::Proposal`] if the proposal fails.
pub fn learn(
    proposal: &mut Amortised,
    model: &(impl OwnModel + ?Sized),
    recorded: &[PartialMeasurements],
    config: &LearnConfig,
    seed: &Seed,
    mut observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Learned, TrainError> {
    config.check()?;
    check_recorded(recorded, model.measurement_dim())?;
    let mut adam = Adam::new(&config.adam)?;
    let started = Instant::now();
    standardise(proposal, model, config, &seed.child("inputs"))?;
    let validation = drawn(proposal, model, &validation_of(config), &for_validation(seed))?;
    let check = |supply: &Supply| match supply.examples.later.is_empty() {
        true => Err(TrainError::Setting {
            name: "the number of drawn sequences that reach a second time",
            value: "0".into(),
            expected: "at least 1: the model's simulation overflows, look at its transition and noise",
        }),
        false => Ok(()),
    };
    check(&validation)?;
    let gain_of = |proposal: &Amortised| -> Result<f64, TrainError> {
        let examples = &validation.examples;
        let later = proposal.gain(Times::Later, &examples.later, config.floor)?;
        let initial = proposal.gain(Times::Initial, &examples.initial, config.floor)?;
        // As they come in a sequence.
        Ok((initial + (config.horizon - 1) as f64 * later) / config.horizon as f64)
    };
    let encoder = proposal.clone();
    // What is judged and kept: weights averaged over the last steps, which have less of the noise of single ones.
    let mut averaged = proposal.clone();
    let mut best = (gain_of(proposal)?, proposal.parameters().values().clone());
    let mut learned = Learned {
        steps: 0,
        validation: vec![(0, best.0)],
        best_step: 0,
        overflowed: 0.0,
        diverged_at: None,
        seconds: 0.0,
    };
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
        let mut order = training.child("order").stream();
        let mut turn = 0;
        let (mut initial, mut later) = (Deck::default(), Deck::default());
        let (mut workspace, mut batch) = (Some(Workspace::new(proposal.parameters())), Stage::default());
        for step in 0..config.steps {
            let progress = match config.seconds {
                Some(seconds) => {
                    (step as f64 / config.steps as f64).max(started.elapsed().as_secs_f64() / seconds)
                }
                None => step as f64 / config.steps as f64,
            };
            if progress >= 1.0 {
                break;
            }
            adam.set_learning_rate(
                config.adam.learning_rate * 0.5 * (1.0 + (std::f64::consts::PI * progress).cos()),
            );
            let mut rows = config.rows;
            while !later.deal(rows, &mut batch) {
                let Ok(supply) = supplies.recv() else { break };
                let supply = supply?;
                check(&supply)?;
                lost += supply.lost;
                sequences += supply.sequences;
                let mut examples = supply.examples;
                if let Some(measurements) = recorded.get(turn % recorded.len().max(1)) {
                    // Of simulations alone at first: what a poor filter says is no good example.
                    if step >= config.steps / FIRST_BY_SIMULATIONS {
                        let seed = training.child("recorded").nth(turn as u64);
                        add_recorded(&averaged, model, measurements, &seed, &mut examples)?;
                    }
                    turn += 1;
                }
                // A supply that overflows early has few rows.
                rows = rows.min(examples.later.len());
                later = Deck::new(examples.later, &mut order);
                initial = Deck::new(examples.initial, &mut order);
            }
            let mut is_finite = update(proposal, &mut adam, config, Times::Later, &batch, &mut workspace)?;
            if step % STEPS_FOR_ONE_INITIAL == 0
                && initial.deal(config.rows.min(initial.left()), &mut batch)
                && !batch.is_empty()
            {
                is_finite &= update(proposal, &mut adam, config, Times::Initial, &batch, &mut workspace)?;
            }
            learned.steps = step + 1;
            if !is_finite {
                learned.diverged_at = Some(step);
                break;
            }
            let share = (AVERAGING + 1.0) / (learned.steps as f64 + AVERAGING);
            averaged.parameters_mut().values_mut().approach(proposal.parameters().values(), share);
            if learned.steps.is_multiple_of(config.validate_every) {
                learned.look(gain_of(&averaged)?, &averaged, &mut best);
            }
            let last = learned.validation.last().map_or(f64::NAN, |(_, gain)| *gain);
            if observe(step, last).is_break() {
                break;
            }
        }
        let is_judged = learned.validation.last().is_some_and(|(step, _)| *step == learned.steps);
        if !is_judged && learned.diverged_at.is_none() {
            learned.look(gain_of(&averaged)?, &averaged, &mut best);
        }
        Ok(())
    })?;
    *proposal.parameters_mut().values_mut() = best.1;
    learned.overflowed = lost as f64 / sequences as f64;
    learned.seconds = started.elapsed().as_secs_f64();
    Ok(learned)
}

/// One step of one network; `false` if its loss or its gradient is not finite, and nothing has changed then.
fn update(
    proposal: &mut Amortised,
    adam: &mut Adam,
    config: &LearnConfig,
    times: Times,
    batch: &Stage,
    workspace: &mut Option<Workspace>,
) -> Result<bool, TrainError> {
    let memory = workspace.take().unwrap_or_else(|| Workspace::new(proposal.parameters()));
    let (gain, mut found) = proposal.differentiate_gain(times, batch, config.floor, memory)?;
    let gradients = found.gradients();
    let norm = gradients.norm();
    let is_finite = gain.is_finite() && norm.is_finite();
    if is_finite {
        if norm > config.clip_norm {
            gradients.scale(config.clip_norm / norm);
        }
        adam.step(proposal.parameters_mut(), &mut found)?;
    }
    *workspace = Some(found);
    Ok(is_finite)
}

/// Refuses series that no step can be learned from.
fn check_recorded(recorded: &[PartialMeasurements], width: usize) -> Result<(), TrainError> {
    for (number, series) in recorded.iter().enumerate() {
        if series.width() != width {
            let reason = format!("series {number} has {} columns instead of {width}", series.width());
            return Err(TrainError::Recorded { reason });
        }
        if series.len() < 2 {
            let reason = format!("series {number} has {} times; a step takes two", series.len());
            return Err(TrainError::Recorded { reason });
        }
        if series.rows().all(|row| row.iter().all(Option::is_none)) {
            let reason = format!("all measurements of series {number} are missing");
            return Err(TrainError::Recorded { reason });
        }
    }
    Ok(())
}

/// Brings the inputs of the networks to units in which the model's own steps are of size 1.
fn standardise(
    proposal: &mut Amortised,
    model: &(impl OwnModel + ?Sized),
    config: &LearnConfig,
    seed: &Seed,
) -> Result<(), TrainError> {
    let within = config.largest_state.unwrap_or(f64::INFINITY);
    let mut steps = OwnSteps::new(model, STANDARDISING, seed)?.within(within);
    proposal.fit_inputs(model, |add| {
        for _ in 0..config.horizon {
            match steps.advance() {
                Some(step) => add(&step)?,
                None => break,
            }
        }
        Ok(())
    })?;
    Ok(())
}

/// Validation takes a quarter of the sequences of a supply.
fn validation_of(config: &LearnConfig) -> LearnConfig {
    LearnConfig { sequences: (config.sequences / 4).max(1), ..*config }
}
