//! What a worker is asked to do and what it answers: JSON, a line each.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// A request.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Request {
    /// Get ready for a task.
    Prepare(Task),
    /// Show that the work is equal.
    Check(bool),
    /// Do it once, and time it.
    Run(bool),
    /// End.
    Quit(bool),
}

/// A piece of work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(crate) enum Task {
    /// Filters along all measurements.
    Filter(FilterTask),
    /// Steps of training.
    Train(TrainTask),
    /// Gradient steps of a proposal that is learned once.
    Learn(LearnTask),
    /// A filter with a proposal that is learned once.
    Learned(LearnedTask),
    /// Draws of a distribution.
    Draws(DrawsTask),
}

impl Task {
    /// How many threads may work.
    pub(crate) fn threads(&self) -> usize {
        match self {
            Task::Filter(task) => task.threads,
            Task::Train(task) => task.threads,
            Task::Learn(task) => task.threads,
            Task::Learned(task) => task.threads,
            Task::Draws(_) => 1,
        }
    }
}

/// Draws of a distribution whose parameters differ from one to the next, on one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct DrawsTask {
    /// Whose draws; nobody's if ours.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(crate) peer: Option<String>,
    /// `binomial`, `poisson` or `gamma`.
    pub(crate) distribution: String,
    /// What is expected of a count in the mean, or the shape of a gamma.
    pub(crate) size: f64,
    /// How many.
    pub(crate) draws: usize,
}

/// Gradient steps of a proposal that is learned once, on rows that were encoded before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct LearnTask {
    /// Of which model.
    pub(crate) model: String,
    /// Whose steps; nobody's if ours.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(crate) peer: Option<String>,
    /// Weights and rows.
    pub(crate) folder: PathBuf,
    /// How many steps.
    pub(crate) steps: usize,
    /// Whether rows are simulated on the way, and all else is done that learning takes; ours alone.
    pub(crate) simulates: bool,
    /// How densities are computed by others: in 64 bits, as ours, or in 32. Networks are in 32.
    pub(crate) bits: u8,
    /// How many threads may work.
    pub(crate) threads: usize,
}

/// A filter with a proposal that is learned once, along measurements of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct LearnedTask {
    /// Which one.
    pub(crate) model: String,
    /// Whose filter; nobody's if ours.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(crate) peer: Option<String>,
    /// Weights and measurements.
    pub(crate) folder: PathBuf,
    /// How many filters a check runs.
    pub(crate) check_passes: usize,
    /// How all but the networks is computed by others: in 64 bits, as ours, or in 32. Networks are in 32.
    pub(crate) bits: u8,
    /// `K`.
    pub(crate) particles: usize,
    /// How many threads may work.
    pub(crate) threads: usize,
}

/// Filters along all measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct FilterTask {
    /// Whose filter; nobody's if ours.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(crate) peer: Option<String>,
    /// The problem's file.
    pub(crate) problem: PathBuf,
    /// `bootstrap` or `min-degeneracy`.
    pub(crate) method: String,
    /// `K`.
    pub(crate) particles: usize,
    /// How many filters run side by side.
    pub(crate) filters: usize,
    /// `multinomial` or `systematic`.
    pub(crate) resampling: String,
    /// Where noise starts.
    pub(crate) seed: u64,
    /// How many threads may work.
    pub(crate) threads: usize,
}

/// Steps of training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TrainTask {
    /// Which family.
    pub(crate) family: String,
    /// Weights, problem and noise.
    pub(crate) folder: PathBuf,
    /// `K`.
    pub(crate) particles: usize,
    /// Whether the model is to be compiled first, where that means anything.
    pub(crate) compile: bool,
    /// How many steps.
    pub(crate) steps: usize,
    /// How many threads may work.
    pub(crate) threads: usize,
}

/// An answer; what does not belong to the question is absent.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Answer {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) ready: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
    /// What one run took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) seconds: Option<f64>,
    /// Of a check: the loss of the given weights and noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) loss: Option<f64>,
    /// Of a check: the norm of its gradient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) gradient_norm: Option<f64>,
    /// Of a check: the mean of `log Ẑ` over filters, and its standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mean_log_evidence: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) log_evidence_error: Option<f64>,
    /// Of a check: the mean of draws, and its standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mean_draw: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mean_draw_error: Option<f64>,
    /// Versions of what answers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) versions: Option<serde_json::Value>,
}
