//! The course of learning: how far it is, weights averaged over steps, and the best of them by validation.

use std::time::Instant;

use motes_proposals::{Amortised, Parametric, Values};

use super::objective::LearnObjective;
use super::settings::LearnConfig;
use crate::TrainError;

/// Weights are averaged over about the last step in so many (Shamir and Zhang 2013).
const AVERAGING: f64 = 8.0;

/// What came of learning.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// What was maximised.
    pub objective: LearnObjective,
    /// Steps that were taken.
    pub steps: usize,
    /// What validation said after so many steps, in nats for a step of a sequence; the first is that of the proposal before learning.
    ///
    /// It is the gain over the transition on simulated sequences where the objective is inclusive, else the log-evidence of a filter on held-out
    /// measurements (−∞ where it collapses).
    pub validation: Vec<(usize, f64)>,
    /// After which step the weights that were kept had been reached.
    pub best_step: usize,
    /// The share of simulated sequences that overflowed before their end.
    pub overflowed: f64,
    /// After which steps it went back to the best weights so far, to go on with steps a quarter as long: the proposal had gone where its objective has no
    /// slope.
    pub new_beginnings: Vec<usize>,
    /// Why it ended before its last step, where it diverged.
    pub diverged_at: Option<usize>,
    /// How long it took.
    pub seconds: f64,
}

impl Learned {
    /// What validation said of the weights that were kept.
    pub fn best_gain(&self) -> f64 {
        self.validation.iter().map(|(_, gain)| *gain).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A course in progress.
pub(super) struct Course {
    config: LearnConfig,
    started: Instant,
    /// What is judged and kept: weights averaged over the last steps, which have less of the noise of single ones.
    averaged: Amortised,
    best: (f64, Values),
    learned: Learned,
}

impl Course {
    /// Before the first step, with what validation says of the proposal as it is.
    pub(super) fn new(config: &LearnConfig, started: Instant, proposal: &Amortised, figure: f64) -> Self {
        let learned = Learned {
            objective: config.objective,
            steps: 0,
            validation: vec![(0, figure)],
            best_step: 0,
            overflowed: 0.0,
            new_beginnings: Vec::new(),
            diverged_at: None,
            seconds: 0.0,
        };
        let best = (figure, proposal.parameters().values().clone());
        Course { config: *config, started, averaged: proposal.clone(), best, learned }
    }

    /// The share of learning that is done before `step`; none at its end.
    pub(super) fn progress(&self, step: usize) -> Option<f64> {
        if self.is_without_gain() {
            return None;
        }
        let by_steps = step as f64 / self.config.steps as f64;
        let progress = match self.config.seconds {
            Some(seconds) => by_steps.max(self.started.elapsed().as_secs_f64() / seconds),
            None => by_steps,
        };
        (progress < 1.0).then_some(progress)
    }

    /// Whether so many steps were judged as the patience is long, and none beat the proposal that came in.
    fn is_without_gain(&self) -> bool {
        let judged = self.learned.validation.last().map_or(0, |(step, _)| *step);
        self.learned.best_step == 0 && self.config.patience.is_some_and(|patience| judged >= patience)
    }

    /// The averaged weights.
    pub(super) fn averaged(&self) -> &Amortised {
        &self.averaged
    }

    /// What validation said last.
    pub(super) fn last(&self) -> f64 {
        self.learned.validation.last().map_or(f64::NAN, |(_, figure)| *figure)
    }

    /// Takes note of a step that was taken, and now and then asks `judge` for what validation says; whether it was asked comes back.
    pub(super) fn took(
        &mut self,
        step: usize,
        proposal: &Amortised,
        judge: impl FnOnce(&Amortised) -> Result<f64, TrainError>,
    ) -> Result<bool, TrainError> {
        self.learned.steps = step + 1;
        let share = (AVERAGING + 1.0) / (self.learned.steps as f64 + AVERAGING);
        self.averaged.parameters_mut().values_mut().approach(proposal.parameters().values(), share);
        let is_due = self.learned.steps.is_multiple_of(self.config.validate_every);
        if is_due {
            self.look(judge)?;
        }
        Ok(is_due)
    }

    /// Gives the proposal the best weights so far, from which it goes on.
    pub(super) fn go_back(&mut self, proposal: &mut Amortised) {
        for proposal in [proposal, &mut self.averaged] {
            *proposal.parameters_mut().values_mut() = self.best.1.clone();
        }
        self.learned.new_beginnings.push(self.learned.steps);
    }

    /// Takes note of a step whose loss or gradient was not finite.
    pub(super) fn diverged(&mut self, step: usize) {
        (self.learned.steps, self.learned.diverged_at) = (step + 1, Some(step));
    }

    /// Takes in what validation says of the averaged weights, which are kept if they are the best.
    fn look(&mut self, judge: impl FnOnce(&Amortised) -> Result<f64, TrainError>) -> Result<(), TrainError> {
        let figure = judge(&self.averaged)?;
        self.learned.validation.push((self.learned.steps, figure));
        if figure > self.best.0 {
            self.best = (figure, self.averaged.parameters().values().clone());
            self.learned.best_step = self.learned.steps;
        }
        Ok(())
    }

    /// Ends the course: the proposal gets the best weights.
    pub(super) fn finish(
        mut self,
        proposal: &mut Amortised,
        judge: impl FnOnce(&Amortised) -> Result<f64, TrainError>,
    ) -> Result<Learned, TrainError> {
        let is_judged = self.learned.validation.last().is_some_and(|(step, _)| *step == self.learned.steps);
        if !is_judged && self.learned.diverged_at.is_none() {
            self.look(judge)?;
        }
        *proposal.parameters_mut().values_mut() = self.best.1;
        self.learned.seconds = self.started.elapsed().as_secs_f64();
        Ok(self.learned)
    }
}
