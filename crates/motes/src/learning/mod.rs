//! Learning a proposal for a model, once.

mod choice;
mod learned;
mod worth;

use std::ops::ControlFlow;

use motes_models::{ModelShape, Seed};
use motes_proposals::{Amortised, Backend, Base, Family, HeadConfig};
use motes_train::{LearnConfig, Learned, learn as train};

pub use learned::{LearnedProposal, Notes};

use crate::error::MotesError;
use crate::model::Model;
use choice::{Choice, choose};
use learned::formulas_of;
use worth::worse_than;

/// How a proposal is learned. [`LearnOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnOptions {
    /// Gradient steps.
    pub updates: usize,
    /// Learning ends after so many seconds; its results then depend on the machine.
    pub seconds: Option<f64>,
    /// The number of times of a simulated sequence.
    pub steps: usize,
    /// The designed proposal that it is built around; chosen if none is given.
    pub base: Option<Base>,
    /// What its networks emit; chosen if none is given.
    pub head: Option<HeadConfig>,
    /// The widths of its networks' hidden layers.
    pub widths: Vec<usize>,
    /// All random numbers come from it.
    pub seed: u64,
}

/// The defensive share of a learned proposal where nothing else is said.
pub const DEFENSIVE_SHARE: f64 = 0.1;

impl Default for LearnOptions {
    fn default() -> Self {
        LearnOptions {
            updates: 5000,
            seconds: None,
            steps: 100,
            base: None,
            head: None,
            widths: vec![64, 64],
            seed: 1,
        }
    }
}

/// What came of learning.
#[derive(Debug, Clone)]
pub struct LearnOutcome {
    /// The proposal, with the best weights on validation sequences.
    pub proposal: LearnedProposal,
    /// The course of its training.
    pub history: Learned,
    /// How long it all took but for judging it: choosing and training.
    pub training_seconds: f64,
}

/// Learns a proposal for `model` from sequences that the model draws for itself; `proceed` is asked after each update, with how many of how many are done.
///
/// ```
/// use motes::{FilterOptions, LearnOptions, Model, ProposalName, learn};
/// use std::ops::ControlFlow;
///
/// let text = r#"
///     [initial]
///     x = "normal(0, 1)"
///     [transition]
///     x = "normal(0.9*x, 1)"
///     [measurement]
///     y = "normal(0, exp(x/2))"
/// "#;
/// let model = Model::parse(text, "volatility", &[])?;
/// let options = LearnOptions { updates: 100, ..LearnOptions::default() };
/// let learned = learn(&model, &options, |_, _| ControlFlow::Continue(()))?;
/// let filter = FilterOptions { proposal: ProposalName::Learned(learned.proposal), ..FilterOptions::default() };
/// # assert_eq!(filter.defensive_share(), 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MotesError`] for an option out of range, a model that has nothing to learn, and one whose simulations all overflow.
pub fn learn(
    model: &Model,
    options: &LearnOptions,
    mut proceed: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<LearnOutcome, MotesError> {
    let formulas = formulas_of(model)?;
    let started = std::time::Instant::now();
    let settings = LearnConfig {
        steps: options.updates,
        horizon: options.steps,
        seconds: options.seconds,
        ..LearnConfig::new()
    };
    let seed = Seed::from_u64(options.seed).child("learn");
    // A third of the bar is for choosing.
    let Choice { config, reason } =
        choose(formulas, options, &settings, &seed, |done, total| proceed(done, 3 * total))?;
    let shape = ModelShape::of(formulas);
    let mut proposal = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed.child("weights"))?;
    let mut is_stopped = false;
    let history = train(&mut proposal, formulas, &settings, &seed, |done, _| {
        let asked = proceed(settings.steps + 2 * done, 3 * settings.steps);
        is_stopped = asked.is_break();
        asked
    })?;
    if is_stopped {
        return Err(MotesError::Interrupted);
    }
    let notes = Notes { choice: reason, updates: history.steps, seconds: history.seconds, worse_than: None };
    let learned = LearnedProposal::new("learned".into(), proposal, notes);
    let worse_than = worse_than(model, &learned, options, &seed.child("worth"))?;
    let training_seconds = started.elapsed().as_secs_f64();
    let notes = Notes { worse_than, seconds: training_seconds, ..learned.notes().clone() };
    let proposal = LearnedProposal::new("learned".into(), learned.proposal().clone(), notes);
    Ok(LearnOutcome { proposal, history, training_seconds })
}
