//! How a proposal is learned.

use motes_proposals::{Base, HeadConfig, Sees};

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
