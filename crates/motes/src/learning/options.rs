//! How a proposal is learned.

use motes_proposals::{Base, HeadConfig, Sees};
use motes_train::LearnObjective;

use crate::learned::LearnedProposal;

/// How a proposal is learned. [`LearnOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnOptions {
    /// What is maximised; wake and fivo learn from data alone.
    pub objective: LearnObjective,
    /// A proposal to learn further, in the place of a new one; base, head and networks are then its own.
    pub start: Option<LearnedProposal>,
    /// The probability that an update leaves out a hidden unit.
    pub dropout: f64,
    /// `λ` of a penalty `λ/2 Σ w²` over the weights.
    pub weight_penalty: f64,
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
    /// What a unit of its networks' hidden layers sees.
    pub sees: Sees,
    /// The widths of its networks' hidden layers; along a graph, the features of each node. Chosen if none is given.
    pub widths: Option<Vec<usize>>,
    /// All random numbers come from it.
    pub seed: u64,
}

impl Default for LearnOptions {
    fn default() -> Self {
        LearnOptions {
            objective: LearnObjective::Inclusive,
            start: None,
            dropout: 0.0,
            weight_penalty: 0.0,
            updates: 5000,
            seconds: None,
            steps: 100,
            base: None,
            head: None,
            sees: Sees::All,
            widths: None,
            seed: 1,
        }
    }
}
